"""Couplings: against closed forms of the two-inertia system, and random ones for the tests of all elements."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Floats, Measured, case_of, simulate_one
from gearplay.model.pack import Packed
from gearplay.parts.coupling import law as coupling
from gearplay.parts.registry import COUPLING
from gearplay.solver.flow import Flow
from gearplay.vocabulary.errors import InputError

K, J_1, J_2 = 2e3, 2e-3, 5e-3  # N m/rad, kg m^2


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return two discs and a coupling, with or without play, of any ratio, with or without a lateral part."""
    damping = float(rng.choice([0.0, 0.05])) if damped else 0.0
    ratio = float(rng.choice([1.0, -2.0, 0.4]))
    if not plain and rng.random() < 0.3:  # a spring in stages, its play among them
        points = [(3e-4, 0.0), (8e-4, 0.1), (2e-3, 0.9)]
        spring: Document = {
            "torsional_stiffness": None,
            "torque": points,
            "rest_angle": float(rng.normal() * 1e-4),
        }
    else:
        stiffness = float(rng.uniform(50.0, 500.0))
        spring = {"torsional_stiffness": stiffness, "play": float(rng.choice([0.0, 4e-4, 2e-3]))}
    lateral = {"lateral_stiffness": float(rng.uniform(1e4, 1e6)), "lateral_damping": 400.0 * damping}
    document = shafts(
        torsional_damping=damping,
        ratio=ratio,
        **spring,
        **(lateral if ratio == 1.0 and rng.random() < 0.5 else {}),
    )
    for rotor in document["rotors"].values():
        rotor["floating"] = True
    if not plain:
        for rotor in document["rotors"].values():
            rotor["drive"] = {"kind": "torque", "torque": float(rng.uniform(-1.0, 1.0))}
    return document


def potential(packed: Packed, y: Floats) -> float:
    """Return the elastic energy [J] of all couplings."""
    total = 0.0
    for n, each in enumerate(packed.system.records[COUPLING]):
        phi, _ = coupling.twist(packed.system, n, 0.0, y)
        if each.stages:
            total += stored(packed.system.terms[each.first_stage :][: each.stages], phi - each.rest)
        else:
            total += 0.5 * each.stiffness * max(abs(phi) - each.half_play, 0.0) ** 2
        apart = [y[3 * each.a + axis] - y[3 * each.b + axis] for axis in range(2)]
        total += 0.5 * each.lateral_stiffness * (apart[0] ** 2 + apart[1] ** 2)
    return total


def stored(stages: Floats, twist: float) -> float:
    """Return the energy [J] of a spring in stages (twist, torque, stiffness at their start), counted from twist 0."""

    def integral(to: float) -> float:
        ends = [*stages[1:, 0], math.inf]
        total = 0.0
        for (start, torque, k), end in zip(stages, ends, strict=True):
            first = -math.inf if start == stages[0, 0] else start
            low, high = max(first, min(0.0, to)), min(end, max(0.0, to))
            if high > low:
                area = torque * (high - low) + 0.5 * k * ((high - start) ** 2 - (low - start) ** 2)
                total += area if to > 0.0 else -area
        return total

    return integral(twist)


def shafts(omega: tuple[float, float] = (0.0, 0.0), theta: float = 0.0, **fields: Any) -> Document:
    """Return two free discs and a coupling between them."""
    return {
        "rotors": {
            "one": {"mass": 1.0, "inertia": J_1, "initial": {"theta": theta, "omega": omega[0]}},
            "two": {"mass": 1.0, "inertia": J_2, "initial": {"theta": 0.0, "omega": omega[1]}},
        },
        "couplings": [{"between": ["one", "two"], "torsional_stiffness": K, **fields}],
        "run": {"duration": 0.05, "sampling": 1e5, "tolerance": 1e-12},
    }


@pytest.mark.compiled
@pytest.mark.parametrize("ratio", [1.0, -2.0])
def test_two_inertias_swing_at_their_natural_frequency(ratio: float, measured: Measured) -> None:
    """w^2 = k (1/J_1 + ratio^2/J_2), by the run to 1e-6 and by the slopes to 1e-9."""
    exact = math.sqrt(K * (1.0 / J_1 + ratio**2 / J_2))
    document = shafts(theta=1e-3, ratio=ratio)
    run = simulate_one(document)
    twist = run.signal("coupling_twist", "one-two")
    assert np.max(np.abs(twist - 1e-3 * np.cos(exact * run.time))) < 1e-9
    down = np.flatnonzero((twist[:-1] > 0.0) & (twist[1:] <= 0.0))
    crossings = run.time[down] + 1e-5 * twist[down] / (twist[down] - twist[down + 1])
    frequency = 2.0 * math.pi * (len(crossings) - 1) / (crossings[-1] - crossings[0])
    measured(f"natural frequency by run, ratio {ratio:g}", abs(frequency / exact - 1.0), "1e-6")
    assert frequency == pytest.approx(exact, rel=1e-6)
    flow = Flow(case_of(document))
    span = 1e-4
    changes = np.eye(flow.size)
    found = flow.go(np.zeros(flow.size), span, changes=changes)
    matrix = found.changes[:, :].T
    free = [2, 5, 8, 11]
    eigenvalues = np.linalg.eigvals(matrix[np.ix_(free, free)])
    by_slopes = np.max(np.abs(np.angle(eigenvalues))) / span
    measured(f"natural frequency by slopes, ratio {ratio:g}", abs(by_slopes / exact - 1.0), "1e-9")
    assert by_slopes == pytest.approx(exact, rel=1e-9)


@pytest.mark.compiled
@pytest.mark.parametrize("play", [0.0, 1e-3])
def test_lateral_stiffness__free_centres_swing_at_their_natural_frequency(play: float) -> None:
    """x_1 - x_2 = v / w sin(w t), w^2 = k (1/m_1 + 1/m_2), without damping, and with play of the rotation too."""
    document = shafts(play=play, lateral_stiffness=1e5)
    document["rotors"]["one"] |= {"floating": True, "initial": {"theta": 0.0, "vx": 0.1}}
    document["rotors"]["two"] |= {"floating": True}
    run = simulate_one(document)
    w = math.sqrt(2e5)  # of two masses of 1 kg
    apart = run.signal("x", "one") - run.signal("x", "two")
    np.testing.assert_allclose(apart, 0.1 / w * np.sin(w * run.time), rtol=0.0, atol=1e-10)


def test_play_gives_free_motion_and_impacts_in_closed_form(measured: Measured) -> None:
    """Free within the play, then half a period of the spring: touch and release to 1e-9 s, the twist to 1e-9 rad."""
    play, speed = 2e-3, 4.0
    run = simulate_one(shafts(omega=(speed, 0.0), play=play))
    omega = math.sqrt(K * (1.0 / J_1 + 1.0 / J_2))
    flight, touch = play / speed, math.pi / omega
    times, end = [], 0.5 * flight
    while end < 0.05:
        times += [end, end + touch]
        end += touch + flight
    expected = np.array([t for t in times if t < 0.05])
    assert len(run.log) == len(expected) > 20
    worst = float(np.max(np.abs(run.log[:, 0] - expected)))
    measured("play: instants of touch and release [s]", worst, "1e-9")
    assert worst < 1e-9
    phase = (run.time - 0.5 * flight) % (2.0 * (touch + flight))
    inside = (run.time < 0.5 * flight) | ((phase % (touch + flight)) > touch)
    sign = np.where((phase < touch + flight), 1.0, -1.0)
    within = phase % (touch + flight)
    twist = np.where(
        run.time < 0.5 * flight,
        speed * run.time,
        sign
        * np.where(
            inside, 0.5 * play - speed * (within - touch), 0.5 * play + speed / omega * np.sin(omega * within)
        ),
    )
    difference = float(np.max(np.abs(run.signal("coupling_twist", "one-two") - twist)))
    measured("play: twist [rad]", difference, "1e-9")
    assert difference < 1e-9


STAGES = [[0.0, 0.0], [1e-3, 2.0], [4e-3, 20.0]]  # 2000 N m/rad, then 6000
K_1, K_2, KINK = 2000.0, 6000.0, 1e-3


def test_stages_period_of_a_spring_of_two_stages(measured: Measured) -> None:
    """From rest at an amplitude A: a quarter of a period is the way through both stages, each a cosine of its own."""
    amplitude, inertia = 3e-3, 1.0 / (1.0 / J_1 + 1.0 / J_2)
    run = simulate_one(shafts(theta=amplitude, torsional_stiffness=None, torque=STAGES))
    w_1, w_2 = math.sqrt(K_1 / inertia), math.sqrt(K_2 / inertia)
    centre = KINK - K_1 * KINK / K_2  # where the second stage alone would have no torque
    outer = math.acos((KINK - centre) / (amplitude - centre)) / w_2
    speed = w_2 * math.sqrt((amplitude - centre) ** 2 - (KINK - centre) ** 2)
    quarter = outer + math.atan(w_1 * KINK / speed) / w_1
    kinks = [4.0 * quarter * n + sign * outer for n in range(20) for sign in (-1, 1)]
    kinks += [4.0 * quarter * (n + 0.5) + sign * outer for n in range(20) for sign in (-1, 1)]
    expected = np.sort([t for t in kinks if 0.0 < t < 0.05])
    phase = run.time % (4.0 * quarter)
    phase = np.minimum(phase, 4.0 * quarter - phase)
    sign = np.where(phase < quarter, 1.0, -1.0)
    phase = np.minimum(phase, 2.0 * quarter - phase)
    exact = sign * np.where(
        phase < outer,
        centre + (amplitude - centre) * np.cos(w_2 * phase),
        math.hypot(KINK, speed / w_1) * np.sin(w_1 * (quarter - phase)),
    )
    worst = float(np.max(np.abs(run.signal("coupling_twist", "one-two") - exact)))
    measured(f"spring in stages: twist over {len(expected)} kinks [rad]", worst, "1e-11")
    assert len(expected) > 30
    assert worst < 1e-11


def test_stages_play_among_them_is_a_coupling_with_play() -> None:
    """A stage without stiffness and a coupling with play are one motion."""
    play = 1e-3
    with_play = simulate_one(shafts(omega=(4.0, -1.0), play=play))
    points = [[0.5 * play, 0.0], [0.5 * play + 0.01, 0.01 * K]]
    staged = simulate_one(shafts(omega=(4.0, -1.0), torsional_stiffness=None, torque=points))
    difference = np.abs(staged.signal("theta", "one") - with_play.signal("theta", "one"))
    assert np.max(difference) < 1e-10


def test_stages_twist_alike_with_a_lateral_part() -> None:
    """The centres move apart and together by their own spring, the twist by the spring in stages."""
    plain = simulate_one(shafts(theta=3e-3, torsional_stiffness=None, torque=STAGES))
    document = shafts(theta=3e-3, torsional_stiffness=None, torque=STAGES, lateral_stiffness=1e5)
    for rotor in document["rotors"].values():
        rotor["floating"] = True
    document["rotors"]["one"]["initial"]["x"] = 1e-4
    run = simulate_one(document)
    twist = run.signal("coupling_twist", "one-two")
    assert np.max(np.abs(twist - plain.signal("coupling_twist", "one-two"))) < 1e-10
    apart = run.signal("x", "one") - run.signal("x", "two")
    assert np.max(np.abs(apart - 1e-4 * np.cos(math.sqrt(2e5) * run.time))) < 1e-11


def test_stages_statics_and_modes_at_a_load() -> None:
    """The twist under a torque is on the curve, about the rest angle; the frequency is that of the stage's stiffness."""
    for torque, twist, k in ((1.0, 0.5e-3, K_1), (8.0, 2e-3, K_2), (-8.0, -2e-3, K_2), (50.0, 9e-3, K_2)):
        document = shafts(torsional_stiffness=None, torque=STAGES, rest_angle=2e-4)
        document["rotors"]["one"] = {
            "mass": 1.0, "inertia": J_1, "drive": {"kind": "torque", "torque": torque}
        }  # fmt: skip
        document["rotors"]["two"] = {
            "mass": 1.0, "inertia": J_2, "drive": {"kind": "speed", "speed": 0.0}
        }  # fmt: skip
        modes = gp.modes(document).ds
        assert modes["frequency"].values[-1] == pytest.approx(math.sqrt(k / J_1) / (2.0 * math.pi), rel=1e-9)
        document["couplings"][0]["torsional_damping"] = 2.0 * math.sqrt(k * J_1)
        settled = simulate_one(document)
        found = settled.signal("coupling_twist", "one-two")[-1]
        assert found == pytest.approx(twist + 2e-4, abs=1e-10)
        assert settled.signal("coupling_torque", "one-two")[-1] == pytest.approx(torque, rel=1e-7)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"torque": STAGES}, r"torsional_stiffness = 2000\.0: must not be given together with torque over the twist"),
        ({"torsional_stiffness": None}, r"torsional_stiffness: is required, or torque over the twist"),
        ({"torsional_stiffness": None, "torque": STAGES, "play": 1e-3}, r"play = 0\.001: must be 0 where torque"),
        ({"rest_angle": 1e-3}, r"rest_angle = 0\.001: must be 0 without torque"),
        ({"torsional_stiffness": None, "torque": [[1e-3, 1.0], [1e-3, 2.0]]}, r"torque\.1.*greater than that of the point"),
        ({"torsional_stiffness": None, "torque": [[0.0, 0.0], [1e-3, 2.0], [2e-3, 1.0]]}, r"torque\.2.*no less torque"),
        ({"torsional_stiffness": None, "torque": [[0.0, 1.0], [1e-3, 2.0]]}, r"torque.*must be 0 N m at a twist"),
        ({"torsional_stiffness": None, "torque": [[0.0, 0.0]]}, r"torque.*at least two points"),
    ],
)  # fmt: skip
def test_stages_contradictions_are_refused(fields: Document, message: str) -> None:
    document = shafts(**fields)
    document["couplings"][0] = {k: v for k, v in document["couplings"][0].items() if v is not None}
    with pytest.raises(InputError, match=message):
        gp.load_case(document)


def test_energy_and_momentum_are_kept_with_play() -> None:
    result = gp.simulate(case_of(shafts(omega=(4.0, -1.0), play=1e-3)))
    omega = result.ds.omega.values
    torque = result.ds.coupling_torque.values[:, 0]
    energy = 0.5 * (J_1 * omega[:, 0] ** 2 + J_2 * omega[:, 1] ** 2) + 0.5 * torque**2 / K
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 1e-9
    momentum = J_1 * omega[:, 0] + J_2 * omega[:, 1]
    assert np.max(np.abs(momentum / momentum[0] - 1.0)) < 1e-9


@pytest.mark.parametrize("fields", [{}, {"play": 1e-3}, {"ratio": -2.0}])
def test_parallel__two_couplings_are_one_of_their_sums(fields: Document, measured: Measured) -> None:
    """Stiffness, damping and lateral part add up, with play too; so do the torques of the two."""
    lateral = {} if "ratio" in fields else {"lateral_stiffness": 3e5, "lateral_damping": 20.0}
    sums = {"torsional_stiffness": K, "torsional_damping": 0.02, **lateral}
    together = shafts(omega=(4.0, -1.0), **sums, **fields)
    parallel = shafts(omega=(4.0, -1.0), **{key: 0.25 * value for key, value in sums.items()}, **fields)
    rest = {key: 0.75 * value for key, value in sums.items()}
    parallel["couplings"] = [*parallel["couplings"], {"between": ["one", "two"], **rest, **fields}]
    for document in (together, parallel):
        for name in ("one", "two"):
            document["rotors"][name]["floating"] = True
        document["rotors"]["one"]["initial"] |= {"x": 1e-5, "y": -2e-5}
        document["run"]["duration"] = 0.02
    one, both = simulate_one(together), simulate_one(parallel)
    worst = 0.0
    for rotor in ("one", "two"):
        for signal in ("x", "y", "theta", "omega"):
            expected = one.signal(signal, rotor)
            scale = float(np.max(np.abs(expected))) or 1.0
            worst = max(worst, float(np.max(np.abs(both.signal(signal, rotor) - expected))) / scale)
    measured(f"couplings in parallel, {fields}: motion, relative", worst, "1e-12")
    assert worst < 1e-12
    torques = [both.signal("coupling_torque", label) for label in ("one-two", "one-two-2")]
    expected = one.signal("coupling_torque", "one-two")
    assert np.allclose(sum(torques), expected, rtol=1e-9, atol=1e-9 * np.max(np.abs(expected)))
    assert np.allclose(3.0 * torques[0], torques[1], rtol=1e-9, atol=1e-9 * np.max(np.abs(expected)))


def test_parallel__each_has_its_name() -> None:
    """The second one's ends in 2, in paths of changes as in results; two ratios between the same rotors hold the train."""
    document = shafts()
    document["couplings"] = [
        *document["couplings"],
        {"between": ["one", "two"], "torsional_stiffness": 500.0},
    ]
    case = gp.replace(document, {"couplings.one-two-2.torsional_stiffness": 700.0})
    assert [each.torsional_stiffness for each in case.couplings] == [K, 700.0]
    assert [name for _, name, _ in case.named_joints()] == ["one-two", "one-two-2"]
    assert gp.modes(case).ds["frequency"].values[-1] == pytest.approx(
        math.sqrt((K + 700.0) * (1.0 / J_1 + 1.0 / J_2)) / (2.0 * math.pi), rel=1e-9
    )
    document["couplings"][1]["ratio"] = 2.0
    document["rotors"]["one"] |= {"initial": {}, "drive": {"kind": "speed", "speed": 1.0}}
    with pytest.raises(InputError, match="a loop of meshes or couplings holds it fast"):
        gp.simulate(document)


def test_speeds_and_senses_pass_through_couplings() -> None:
    document = shafts(ratio=-2.0)
    document["rotors"]["one"] |= {"drive": {"kind": "speed", "speed": 10.0}, "initial": {}}
    document["rotors"]["two"]["initial"] = {}
    run = simulate_one(document)
    assert np.max(np.abs(run.signal("omega", "two") + 5.0)) < 1e-9
    assert np.max(np.abs(run.signal("coupling_torque", "one-two"))) < 1e-6


def test_a_rotor_behind_a_coupling_starts_unstrained() -> None:
    """A given rotation passes on, and flanks are put into touch with both ends turned."""
    document = shafts(theta=0.3)
    document["rotors"]["two"]["initial"] = {}
    assert Flow(case_of(document)).start()[5] == pytest.approx(0.3)


def test_two_rotors_on_one_axis_share_their_centre() -> None:
    document = shafts()
    document["rotors"]["one"]["position"], document["rotors"]["two"]["position"] = [0.0, 0.0], [0.01, 0.0]
    with pytest.raises(InputError, match=r"one axis.* or place it at \[0 mm, 0 mm\]"):
        gp.simulate(gp.load_case(document))
    document["rotors"]["two"]["position"] = [0.9e-7, 0.0]
    assert gp.simulate(gp.load_case(document), duration=1e-4).success
