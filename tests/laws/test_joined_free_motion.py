"""Rotors that springs join fly in closed form: it solves their equations, misses no touch, makes one rotor of two when stiff."""

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import gearplay as gp
from building import Document, Floats, Measured, case_of, merged, pair_document, run_of
from depth import sized
from free_motion import LOOKS, oversights
from gearplay.integrate import run as kernel
from gearplay.integrate import stepper
from gearplay.kernels.joined import bound_joined, find_rates, joined_accelerations, propagate_joined
from gearplay.kernels.layout import ACTIVE, FREE
from gearplay.model.pack import Packed, pack
from gearplay.solver.flow import Flow

FLIGHTS = sized(10_000)


def joined(rng: np.random.Generator) -> Document:
    """Return a pair in sleeves whose wheel drives one or two discs through couplings; supports, drag and ratios at random."""
    kind = str(rng.choice(["internal", "external"]))
    wheel = "ring" if kind == "internal" else "wheel"
    document = pair_document(kind)
    document["gravity"] = [float(g) for g in rng.choice([0.0, 9.81], 2)]
    document["meshes"][0]["backlash"] = float(10.0 ** rng.uniform(-4.5, -3.7))
    document["meshes"][0]["transmission_error"] = [{"order": 1, "amplitude": 1e-6}]
    names = [wheel, *[f"disc{k}" for k in range(rng.integers(1, 3))]]
    document["couplings"] = []
    for before, name in itertools.pairwise(names):
        document["rotors"][name] = {"mass": 1.0, "inertia": float(10.0 ** rng.uniform(-3.0, -1.7))}
        document["couplings"].append(
            {
                "between": [before, name],
                "torsional_stiffness": float(10.0 ** rng.uniform(2.0, 4.5)),
                "torsional_damping": float(rng.choice([0.0, 0.01, 0.3])),
                "play": float(rng.choice([0.0, 0.0, 1e-3])),
                "lateral_stiffness": float(rng.choice([0.0, 1e6])),
                "lateral_damping": float(rng.choice([0.0, 5.0])),
            }
        )
        if rng.random() < 0.5:
            document.setdefault("supports", {})[name] = {
                "stiffness": [1e6, 3e6],
                "damping": [float(rng.choice([0.0, 20.0])), 0.0],
                "torsional_damping": float(rng.choice([0.0, 0.02])),
                "offset": [1e-6, 0.0],
            }
        elif document["couplings"][-1]["lateral_stiffness"] > 0.0:
            document["rotors"][name]["floating"] = True
    for name in names:
        document["rotors"][name]["load"] = {"drag": float(rng.choice([0.0, 1e-3, 0.3]))}
        document["rotors"][name]["radial_damping"] = float(rng.choice([0.0, 3.0]))
    document["rotors"]["pinion"]["drive"] = {"kind": "speed", "speed": float(rng.uniform(-60.0, 60.0))}
    document["run"] = {
        "duration": 0.1,
        "sampling": 1e3,
        "tolerance": 1e-8,
        "seed": int(rng.integers(1e9)),
    }
    return document


def joining(rng: np.random.Generator) -> Document:
    """Return one of `joined` whose springs have a closed form."""
    while True:
        document = joined(rng)
        if pack(case_of(document)).system.joined.chains.size:
            return document


def exact(packed: Packed, y: Floats, c: int, tau: float) -> tuple[Any, Floats]:
    """Return the places of chain c's moving coordinates; their positions, velocities, accelerations after tau [s], by expm."""
    joined, speeds = packed.system.joined, 3 * packed.system.rotors.size
    chain: Any = joined.chains[c]
    n, m = int(chain.count), int(chain.count + chain.fixed)
    q = joined.coordinates[chain.first : chain.first + m]
    pull = joined.numbers[chain.pull : chain.pull + n * (2 * m + 1)].reshape(n, 2 * m + 1)
    rates = np.zeros((2 * m + 1, 2 * m + 1))
    rates[:m, m : 2 * m] = np.eye(m)
    rates[m : m + n] = pull
    end = expm(rates * tau) @ np.concatenate([y[q], y[q + speeds], [1.0]])
    return q[:n], np.concatenate([end[:n], end[m : m + n], pull @ end])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30))
def test_the_closed_form_is_the_exponential_of_the_equations(seed: int) -> None:
    """Positions, velocities and accelerations of every chain after 1 us to 0.3 s, to 1e-10 of the largest; the bound holds."""
    rng = np.random.default_rng([47, seed])
    packed = pack(case_of(joining(rng)))
    system, joined = packed.system, packed.system.joined
    speeds = 3 * system.rotors.size
    y = packed.natural * rng.uniform(-1.0, 1.0, packed.state_size)
    for chain in joined.chains:  # what is fixed has no speed
        fixed = joined.coordinates[chain.first + chain.count : chain.first + chain.count + chain.fixed]
        y[fixed + speeds] = 0.0
    swing = np.zeros(2 * int(joined.chains["count"].sum()))
    first, bends = np.zeros(speeds), np.zeros(speeds)
    for c in range(joined.chains.size):
        find_rates(system, c, y, 1.0, swing)
        for i in range(system.rotors.size):
            bound_joined(system, i, 0.0, swing, first)
        for tau in (1e-6, 1e-4, 0.01, 0.3):
            end, bend = y.copy(), np.zeros(speeds)
            for i in range(system.rotors.size):
                propagate_joined(system, i, tau, y, swing, end)
                joined_accelerations(system, i, tau, swing, bend[3 * i : 3 * i + 3])
                bound_joined(system, i, tau, swing, bends)
            q, expected = exact(packed, y, c, tau)
            bend_now = bend[q]
            parts = zip((end[q], end[q + speeds], bend_now), np.split(expected, 3), strict=True)
            for found, wanted in parts:
                noise = (
                    1e-9 * first[q].max() if found is bend_now else 0.0
                )  # of stiffness times angles that cancel
                assert np.allclose(found, wanted, rtol=0.0, atol=1e-10 * abs(wanted).max() + noise)
            assert np.all(np.abs(bend[q]) <= bends[q] * (1.0 + 1e-12) + 1e-12 * first[q].max())
            assert np.all(bends[q] <= first[q])


@pytest.mark.slow
def test_no_contact_is_missed_by_joined_rotors(measured: Measured) -> None:
    """Ten thousand flights of pairs with elastic shafts, couplings with play, supports: no touch before the one found."""
    rng = np.random.default_rng(22)
    worst, grazing = oversights((joining(rng) for _ in itertools.count()), FLIGHTS)
    measured(
        f"deepest touch that {FLIGHTS} flights of joined rotors overlooked, {LOOKS} looks each [m]",
        worst,
        "3e-14",
    )
    assert worst < 3e-14, "rounding of the closed form"
    assert grazing > FLIGHTS // 20, "the dense looks come near to the touches"


def rattling(**coupling: Any) -> Document:
    """Return the article's kind of pair, its ring of half the inertia with a flywheel of the other half behind a coupling."""
    return {
        "rotors": {
            "pinion": {
                "teeth": 20,
                "mass": 0.235,
                "inertia": 1.88e-4,
                "drive": {"kind": "speed", "speed": 12.0},
            },
            "ring": {
                "teeth": 60,
                "internal": True,
                "mass": 0.8,
                "inertia": 0.0306,
                "load": {"drag": 1e-3},
                "initial": {"vx": 0.02, "vy": 0.01},
            },
            "wheel": {"mass": 0.8, "inertia": 0.0306},
        },
        "sleeves": {"ring": {"radial_clearance": 1e-4, "stiffness": 1.5e11, "restitution": 0.9}},
        "couplings": [{"between": ["ring", "wheel"], **coupling}],
        "meshes": [
            {
                "driver": "pinion",
                "driven": "ring",
                "module": 4e-3,
                "pressure_angle": "20 deg",
                "backlash": 1e-4,
                "stiffness": {"kind": "harmonic", "mean": 1.3e8, "amplitude": 6.5e6},
                "transmission_error": [{"order": 1, "amplitude": 5e-6}],
            }
        ],
        "run": {"duration": 0.5, "sampling": 1e4, "tolerance": 1e-9},
    }


def test_joined_rotors_fly_between_their_contacts() -> None:
    """Both fly at once or neither; some steps per contact change, however long the flights."""
    document = rattling(torsional_stiffness=2e3, torsional_damping=0.1)
    case = case_of(document)
    packed = pack(case)
    motion = run_of(case, packed)
    motion.clock[kernel.T_END] = 2.0
    seen = set()
    while stepper.advance(packed.system, motion, 1) == kernel.PAUSED:
        seen.add((int(motion.active_set.body_states[1]), int(motion.active_set.body_states[2])))
    assert motion.clock[kernel.T] == 2.0
    assert seen == {(FREE, FREE), (ACTIVE, ACTIVE)}
    assert motion.counts[kernel.EVENTS] > 50
    assert motion.counts[kernel.STEPS] < 20 * motion.counts[kernel.EVENTS]


def test_a_stiff_coupling_makes_one_rotor_of_two(measured: Measured) -> None:
    """Over the first impacts both are one rotor of the summed inertia, the closer the stiffer: the difference falls like 1/k."""
    document = rattling(torsional_stiffness=1e4, torsional_damping=0.0)
    document["run"] |= {"duration": 0.02, "tolerance": 1e-11}
    one = merged(document, {"rotors": {"wheel": None, "ring": {"inertia": 0.0612}}, "couplings": None})
    ends = {}
    for stiffness in (1e8, 1e9):
        stiff = merged(document, {})
        stiff["couplings"][0]["torsional_stiffness"] = stiffness
        ends[stiffness] = gp.simulate(case_of(stiff)).ds.theta.sel(rotor="ring").to_numpy()
    expected = gp.simulate(case_of(one)).ds.theta.sel(rotor="ring").to_numpy()
    errors = [float(np.max(np.abs(ends[k] - expected))) for k in (1e8, 1e9)]
    measured(
        "ring with its flywheel behind 1e9 N m/rad beside one rotor, 20 ms, 4 impacts [rad]",
        errors[1],
        "1e-8",
    )
    assert errors[1] < 1e-8
    assert 0.03 * errors[0] < errors[1] < 0.3 * errors[0]


def test_free_motion_signals__satisfy_newtons_law() -> None:
    """Samples of flights: the flywheel's acceleration is that of the coupling's torque, k phi + c phi', to rounding."""
    k, c = 2e3, 0.1
    result = gp.simulate(case_of(rattling(torsional_stiffness=k, torsional_damping=c)))
    ds = result.ds
    phi = ds.coupling_twist.to_numpy()[:, 0]
    spin = ds.omega.sel(rotor="ring").to_numpy() - ds.omega.sel(rotor="wheel").to_numpy()
    torque = ds.coupling_torque.to_numpy()[:, 0]
    assert np.allclose(torque, k * phi + c * spin, rtol=0.0, atol=1e-9 * np.abs(torque).max())
    finer = result.signal("wheel.omega", sampling=1e6, window=(0.1, 0.11))
    alpha = np.gradient(finer, 1e-6)
    felt = result.signal("ring-wheel.coupling_torque", sampling=1e6, window=(0.1, 0.11)) / 0.0306
    assert np.allclose(alpha[1:-1], felt[1:-1], rtol=0.0, atol=1e-4 * np.abs(felt).max())


def test_drive_torque__equals_that_of_the_coupling() -> None:
    """A motor of prescribed speed behind an elastic coupling: its torque is the coupling's, in flight as in contact."""
    document = rattling(torsional_stiffness=2e3, torsional_damping=0.1)
    document["rotors"]["motor"] = {"mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": 12.0}}
    document["rotors"]["pinion"].pop("drive")
    document["couplings"].append({"between": ["motor", "pinion"], "torsional_stiffness": 500.0})
    ds = gp.simulate(case_of(document)).ds
    torque = ds.coupling_torque.sel(coupling="motor-pinion").to_numpy()
    assert np.allclose(ds.drive_torque.sel(rotor="motor"), torque, rtol=0.0, atol=1e-9 * np.abs(torque).max())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_the_tangent_goes_along(seed: int, measured: Measured) -> None:
    """The derivative over flights and contacts, from a state off every edge: differences, and the volume by the divergence.

    A touch in flight is found 1e-15 m deep; of a slow one, here 0.5 mm/s, the force that begins with it shows: 2e-6.
    """
    rng = np.random.default_rng([48, seed])
    flow = Flow(case_of(merged(joining(rng), {"run": {"tolerance": 1e-12}})))
    lead, size, span = flow.go(flow.start(), 5e-4), len(flow.free), 2e-3
    changes = np.zeros((size, flow.size + flow.impact_count))
    changes[np.arange(size), flow.free] = 1.0
    moved = flow.go(lead.state, span, impact_speeds=lead.impact_speeds, changes=changes, divergence=True)
    sizes = flow.natural[flow.free]
    exact = moved.changes[:, flow.free].T * sizes[None, :] / sizes[:, None]
    errors = []
    for step in (1e-5, 1e-6, 1e-7, 1e-8):
        columns = []
        for at in flow.free:
            ends = []
            for side in (1.0, -1.0, 0.5, -0.5):
                start = lead.state.copy()
                start[at] += side * step * flow.natural[at]
                ends.append(flow.go(start, span, impact_speeds=lead.impact_speeds).state[flow.free])
            columns.append((8.0 * (ends[2] - ends[3]) - (ends[0] - ends[1])) / (6.0 * step * sizes))
        errors.append(float(np.max(np.abs(np.array(columns).T - exact)) / np.max(np.abs(exact))))
    measured("derivative of the flow of joined rotors against differences", min(errors), "5e-6")
    assert min(errors) < 5e-6
    sign, logarithm = np.linalg.slogdet(exact)
    assert sign == 1.0
    assert abs(logarithm - moved.divergence) < 1e-6
