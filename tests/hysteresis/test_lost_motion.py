"""Lost motion, backlash and stiffness of held trains against closed forms, the linear analysis and slow motions."""

from typing import Any

import numpy as np
import pytest

import gearplay as gp
from planetary_sets import planetary_document

ARCMIN = 180.0 * 60.0 / np.pi
COS = np.cos(np.radians(20.0))
RUN = {"duration": 0.1}


def harmonic(mean: float) -> dict[str, Any]:
    return {"kind": "harmonic", "mean": mean}


def body(**more: Any) -> dict[str, Any]:
    return {"mass": 1.0, "inertia": 1e-2, **more}


def article(clearance: float, backlash: float, *, internal: bool = True, model: str = "coupled") -> gp.Case:
    """Return the article's gears, pinion held, the driven gear's centre free in its sleeve; no sleeve without a clearance."""
    sleeves = {"ring": {"radial_clearance": clearance, "stiffness": 1.52e11}} if clearance else {}
    mesh = {
        "driver": "pinion",
        "driven": "ring",
        "module": 4e-3,
        "backlash": backlash,
        "stiffness": harmonic(1.3e8),
    }
    rotors = {"pinion": body(teeth=20), "ring": body(teeth=60, internal=internal)}
    return gp.load_case(
        {"rotors": rotors, "sleeves": sleeves, "meshes": [mesh], "run": RUN, "backlash_model": model}
    )


def spring(stiffness: float, play: float, friction: float = 0.0) -> gp.Case:
    coupling = {"between": ["motor", "arm"], "torsional_stiffness": stiffness, "play": play}
    rotors = {"motor": body(), "arm": body(load={"friction": friction})}
    return gp.load_case({"rotors": rotors, "couplings": [coupling], "run": RUN})


def train(backlashes: tuple[float, float] = (60e-6, 80e-6)) -> gp.Case:
    """Two stages, m 2 18/54 and m 3 20/60, with a shaft of 5e4 N m/rad between them."""
    rotors = {
        "input": body(teeth=18),
        "wheel": body(teeth=54),
        "pinion": body(teeth=20),
        "output": body(teeth=60),
    }
    meshes = [
        {
            "driver": "input",
            "driven": "wheel",
            "module": 2e-3,
            "backlash": backlashes[0],
            "stiffness": harmonic(1.5e8),
        },
        {
            "driver": "pinion",
            "driven": "output",
            "module": 3e-3,
            "backlash": backlashes[1],
            "stiffness": harmonic(2e8),
        },
    ]
    shaft = {"between": ["wheel", "pinion"], "torsional_stiffness": 5e4}
    return gp.load_case({"rotors": rotors, "meshes": meshes, "couplings": [shaft], "run": RUN})


def of_article(case: gp.Case, torque: float = 50.0) -> Any:
    return gp.lost_motion(case, at="ring", hold="pinion", torque=torque).ds


def value(ds: Any, name: str) -> float:
    return float(ds[name])


def test_backlash_of_a_rigid_pair_is_b_over_the_base_radius() -> None:
    """5 arcmin on a base radius of 47 mm are 68.358729 um."""
    np.testing.assert_allclose(47e-3 * 5.0 / ARCMIN, 68.358729e-6, rtol=1e-8)
    r_b = 60 * 4e-3 * COS / 2
    for b in (1e-5, 1e-4):
        ds = of_article(article(0.0, b))
        assert value(ds, "backlash") == pytest.approx(b / r_b, rel=1e-9)
        assert value(ds, "lost_motion") == pytest.approx(
            b / r_b + 2 * 0.03 * 50.0 / (1.3e8 * r_b**2), rel=1e-9
        )
        assert value(ds, "backlash_arcmin") == pytest.approx(ARCMIN * b / r_b, rel=1e-9)


def test_parts_of_clearances_in_parallel__overlap_and_their_sum_is_said() -> None:
    """The tighter of two couplings in parallel ends the play; without either play, there is none."""
    stiff = {"between": ["motor", "arm"], "torsional_stiffness": 1e5}
    couplings = [{**stiff, "play": 1e-3}, {**stiff, "play": 3e-3}]
    rotors = {"motor": body(), "arm": body()}
    case = gp.load_case({"rotors": rotors, "couplings": couplings, "run": RUN})
    found = gp.lost_motion(case, at="arm", hold="motor", torque="1 N m")
    shares = found.ds["lost_motion_share"].values
    np.testing.assert_allclose(shares, 1e-3 / value(found.ds, "lost_motion"), atol=0.02)
    text = dict(found.rows())["sum of these"]
    assert text.startswith(f"{100.0 * shares.sum():.0f} %: clearances in parallel overlap")
    assert "sum of these" not in dict(
        gp.lost_motion(train(), at="output", hold="input", torque="200 N m").rows()
    )


def test_part_of_a_bearing__is_its_clearance_along_the_line_of_action() -> None:
    """2 c / r_b, c half the internal clearance, between an element under the force and one either side: 1 / cos(pi / Z)."""
    bearing = {"rolling_elements": 24, "element_diameter": 8e-3, "pitch_diameter": 90e-3, "stiffness": 1e12}
    case = gp.replace(article(0.0, 1e-4), {"bearings.ring": bearing | {"internal_clearance": 60e-6}})
    part = float(of_article(case, 1.0)["lost_motion_part"].sel(clearance="bearing ring"))
    least = 60e-6 / (60 * 4e-3 * COS / 2)
    assert least * (1.0 - 1e-3) < part < least / np.cos(np.pi / 24) * (1.0 + 1e-3)


@pytest.mark.parametrize(
    ("c", "b", "arcmin"),
    [
        (0.0, 100.0, 3.048645), (100.0, 100.0, 9.145934), (200.0, 100.0, 15.243224), (100.0, 200.0, 12.194579),
        (200.0, 200.0, 18.291869),
    ],
)  # fmt: skip
@pytest.mark.parametrize("internal", [True, False])
@pytest.mark.parametrize("model", ["coupled", "uncoupled"])
def test_backlash_of_the_article_with_a_free_centre(
    c: float, b: float, arcmin: float, internal: bool, model: str
) -> None:
    """(b + 2 c) / r_b exactly, coupled or not: a gear that moves along its own line of action leaves that line where it is."""
    found = value(of_article(article(1e-6 * c, 1e-6 * b, internal=internal, model=model), 1.0), "backlash")
    assert ARCMIN * found == pytest.approx(arcmin, abs=6e-7)
    assert found == pytest.approx(1e-6 * (b + 2 * c) / (60 * 4e-3 * COS / 2), rel=1e-9)


@pytest.mark.parametrize(("torque", "arcmin"), [(1.0, 9.159266), (10.0, 9.230100), (50.0, 9.478385)])
def test_reversal_angle_with_elastic_teeth_and_sleeve(torque: float, arcmin: float) -> None:
    ds = of_article(article(1e-4, 1e-4), torque)
    angle = ds["angle"].values
    found = angle[0, -1] - angle[0, 0]
    r_b = 60 * 4e-3 * COS / 2
    force = torque / r_b
    closed = (1e-4 + 2 * (1e-4 + (force / 1.52e11) ** (2 / 3)) + 2 * force / 1.3e8) / r_b
    assert found * ARCMIN == pytest.approx(arcmin, abs=6e-7)
    assert found == pytest.approx(closed, rel=1e-9)


def test_a_train_adds_its_stages_over_the_ratios() -> None:
    ds = gp.lost_motion(train(), at="output", hold="input", torque="200 N m").ds
    radii = [18e-3 * COS, 54e-3 * COS, 30e-3 * COS, 90e-3 * COS]
    ratio = radii[3] / radii[2]
    play = 80e-6 / radii[3] + 60e-6 / radii[1] / ratio
    compliance = 1 / (2e8 * radii[3] ** 2) + 1 / (5e4 * ratio**2) + 1 / (1.5e8 * radii[1] ** 2 * ratio**2)
    assert play == pytest.approx(1.340076e-3, abs=6e-10)
    assert value(ds, "backlash") == pytest.approx(play, rel=1e-9)
    assert value(ds, "torsional_stiffness") == pytest.approx(1 / compliance, rel=1e-9)
    assert value(ds, "torsional_stiffness") == pytest.approx(311627.566, rel=1e-9)
    assert value(ds, "torsional_stiffness_arcmin") == pytest.approx(90.648784, abs=6e-7)
    assert value(ds, "backlash_arcmin") == pytest.approx(4.606841, abs=6e-7)
    assert value(ds, "lost_motion_arcmin") == pytest.approx(4.739220, abs=6e-7)
    np.testing.assert_allclose(ds["stiffness"].values, 1 / compliance, rtol=1e-9)
    parts = dict(zip(ds["clearance"].values.tolist(), ds["lost_motion_part"].values.tolist(), strict=True))
    assert parts["mesh input-wheel"] == pytest.approx(60e-6 / radii[1] / ratio, rel=1e-9)
    assert parts["mesh pinion-output"] == pytest.approx(80e-6 / radii[3], rel=1e-9)
    assert sum(parts.values()) == pytest.approx(play, rel=1e-9)


@pytest.mark.parametrize(
    ("k", "play", "friction", "rated", "up", "down", "lost", "loss"),
    [
        (2e4, 1e-3, 2.0, 100.0, 5.5e-4, 7.5e-4, 1.3e-3, 0.0432),
        (5e4, 2e-4, 5.0, 300.0, 1.8e-4, 3.8e-4, 5.6e-4, 0.12),
    ],
)
def test_friction_of_the_output_cancels_in_the_lost_motion(
    k: float, play: float, friction: float, rated: float, up: float, down: float, lost: float, loss: float
) -> None:
    """Rotation at +3 % on both branches, lost motion between their middles, 4 M_f times the reach as loss."""
    ds = gp.lost_motion(spring(k, play, friction), at="arm", hold="motor", torque=rated).ds
    at = ds["angle"].sel(torque=0.03 * rated, method="nearest")
    assert float(at[1]) == pytest.approx(up, rel=1e-9)
    assert float(at[0]) == pytest.approx(down, rel=1e-9)
    assert value(ds, "lost_motion") == pytest.approx(lost, rel=1e-9)
    assert value(ds, "backlash") == pytest.approx(play + 2 * friction / k, rel=1e-9)
    assert value(ds, "hysteresis_loss") == pytest.approx(loss, rel=1e-9)
    assert loss == pytest.approx(4 * friction * ((rated - friction) / k + 0.5 * play), rel=1e-9)
    np.testing.assert_allclose(ds["stiffness"].values, k, rtol=1e-9)


def test_friction_inside_a_train() -> None:
    """Two springs in series, friction between them: the inner one turns only once the torque exceeds its friction.

    Loading to T twists the outer spring by T / k_2 and the inner one by (T - M) / k_1, unloading leaves it there until T_r - 2 M.
    """
    k_1, k_2, M, rated = 1e4, 2e4, 3.0, 100.0
    rotors = {"motor": body(), "middle": body(load={"friction": M}), "arm": body()}
    couplings = [
        {"between": ["motor", "middle"], "torsional_stiffness": k_1},
        {"between": ["middle", "arm"], "torsional_stiffness": k_2},
    ]
    case = gp.load_case({"rotors": rotors, "couplings": couplings, "run": RUN})
    ds = gp.lost_motion(case, at="arm", hold="motor", torque=rated).ds
    T = ds["torque"].values
    inner = np.array([np.minimum(T + M, rated - M), np.maximum(T - M, M - rated)]) / k_1
    np.testing.assert_allclose(ds["angle"].values, T / k_2 + inner, rtol=1e-9, atol=1e-15)
    assert value(ds, "hysteresis_loss") == pytest.approx(4 * M * (rated - M) / k_1, rel=1e-9)
    assert value(ds, "backlash") == pytest.approx(2 * M / k_1, rel=1e-9)


def test_stages_of_a_spring() -> None:
    points = [[0.0, 0.0], [1e-3, 10.0], [2e-3, 40.0], [3e-3, 100.0]]
    coupling = {"between": ["motor", "arm"], "torque": points}
    case = gp.load_case({"rotors": {"motor": body(), "arm": body()}, "couplings": [coupling], "run": RUN})
    ds = gp.lost_motion(case, at="arm", hold="motor", torque=100.0, stages=["10 N m", "40 N m"]).ds
    np.testing.assert_allclose(ds["stiffness"].values, [1e4, 3e4, 6e4], rtol=1e-9)
    assert value(ds, "backlash") == pytest.approx(0.0, abs=1e-15)


def test_a_preloaded_pair_has_its_elastic_value_only() -> None:
    """A split gear: a spring turns its halves onto both flanks of the pinion. No play is left, and both halves carry."""
    k, K, r_b = 2e4, 1.3e8, 60 * 4e-3 * COS / 2
    mesh = {"driver": "pinion", "module": 4e-3, "backlash": 1e-4, "stiffness": harmonic(K)}
    twist = 0.01  # the spring's, beyond the play
    coupling = {"between": ["gear", "half"], "torque": [[-1.0, -k], [1.0, k]], "rest_angle": twist}
    case = gp.load_case(
        {
            "rotors": {"pinion": body(teeth=20), "gear": body(teeth=60), "half": body(teeth=60)},
            "meshes": [{**mesh, "driven": "gear"}, {**mesh, "driven": "half"}],
            "couplings": [coupling], "run": RUN,
        }
    )  # fmt: skip
    rated = 50.0
    ds = gp.lost_motion(case, at="gear", hold="pinion", torque=rated).ds
    tooth = K * r_b**2
    stiffness = tooth + 1.0 / (1.0 / k + 1.0 / tooth)
    assert value(ds, "backlash") == pytest.approx(0.0, abs=1e-12)
    assert value(ds, "lost_motion") == pytest.approx(2 * 0.03 * rated / stiffness, rel=1e-9)
    assert value(ds, "torsional_stiffness") == pytest.approx(stiffness, rel=1e-9)
    slack = {**case.resolved(), "couplings": []}
    del slack["rotors"]["half"]
    slack["meshes"] = slack["meshes"][:1]
    assert value(gp.lost_motion(slack, at="gear", hold="pinion", torque=rated).ds, "backlash") > 8e-4


@pytest.mark.parametrize(
    ("name", "at", "hold"), [("two-stage-reducer", "output", "input"), ("han2021", "ring", "pinion")]
)
def test_slope_of_the_curve_is_the_static_stiffness(name: str, at: str, hold: str) -> None:
    """Central differences of the curve, the tangent of the equilibrium, and the frequency response at 0 Hz (mean stiffness)."""
    rated, step = 40.0, 0.4
    stages = (20.0 - step, 20.0 + step)
    ds = gp.lost_motion(name, at=at, hold=hold, torque=rated, stages=stages).ds
    there = int(np.argmin(np.abs(ds["torque"].values - 20.0)))
    assert ds["torque"].values[there] == pytest.approx(20.0)
    slopes = ds["tangent_stiffness"].values[0]
    tangent = 2.0 / (1.0 / slopes[there] + 1.0 / slopes[-1 - there])  # the secants are means over both signs
    finer = (20.0 - 0.1 * step, 20.0 + 0.1 * step)
    secant = float(gp.lost_motion(name, at=at, hold=hold, torque=rated, stages=finer).ds["stiffness"][1])
    assert secant == pytest.approx(tangent, rel=1e-6)
    plain = gp.load_case(name).resolved()
    for rotor in plain["rotors"].values():
        rotor |= {"load": {}, "drive": None, "runout": {"amplitude": 0.0}}
        for gear in rotor.get("gears", {}).values():
            gear["runout"] = {"amplitude": 0.0}
    plain["rotors"][hold]["drive"] = {"kind": "speed", "speed": 0.0}
    for mesh in plain["meshes"]:
        mesh |= {"stiffness": harmonic(2e8), "transmission_error": []}
    ds = gp.lost_motion(plain, at=at, hold=hold, torque=rated).ds
    plain["rotors"][at]["drive"] = {"kind": "torque", "torque": 20.0}
    response = gp.frequency_response(plain, force=f"{at}.torque", at=f"{at}.theta", frequencies=[0.0])
    assert 1.0 / float(response.ds["amplitude"].values.ravel()[0]) == pytest.approx(
        float(ds["tangent_stiffness"].sel(torque=20.0, method="nearest")[0]), rel=1e-9
    )


def test_equilibria_agree_with_a_slow_motion() -> None:
    mesh = {"driver": "motor", "driven": "arm", "module": 3e-3, "backlash": 1e-4, "stiffness": harmonic(1.3e8),
            "damping": {"law": "constant", "ratio": 0.1}}  # fmt: skip
    case = gp.load_case(
        {
            "rotors": {"motor": body(teeth=20), "arm": body(teeth=60)},
            "meshes": [mesh],
            "run": {**RUN, "tolerance": 1e-9},
        }
    )
    given = {"at": "arm", "hold": "motor", "torque": 50.0}
    slow = gp.lost_motion(case, **given, quasi_static=False, period="100 s", cycles=1).ds
    still = gp.lost_motion(case, **given).ds
    T, r_b = slow["torque"].values, 90e-3 * COS
    exact = T / (1.3e8 * r_b**2) + np.where(T > 0.0, 0.0, -1e-4 / r_b)
    exact += still["angle"].values[0, -1] - 50.0 / (1.3e8 * r_b**2)
    loaded = np.abs(T) > 0.5
    np.testing.assert_allclose(
        slow["angle"].values[:, loaded], np.array([exact, exact])[:, loaded], rtol=0.0, atol=1e-6 * 1.2e-3
    )
    for name in ("lost_motion", "backlash"):
        assert value(slow, name) == pytest.approx(value(still, name), rel=1e-6)


def test_backlash_grows_with_temperature() -> None:
    """Aluminium housing, steel gears at 80 mm, +100 K: centres +92.8 um beyond the gears, backlash +63.5 um at first order."""
    steel = {"expansion": 11.5e-6}
    mesh = {
        "driver": "pinion",
        "driven": "gear",
        "module": 2e-3,
        "backlash": 1e-4,
        "stiffness": harmonic(1.3e8),
    }
    rotors = {"pinion": body(teeth=20, material=steel), "gear": body(teeth=60, material=steel)}
    housing = {"temperature": "20 degC", "housing": {"expansion": 23.1e-6}}
    case = gp.load_case({"rotors": rotors, "meshes": [mesh], "environment": housing, "run": RUN})
    found = gp.lost_motion(case, at="gear", hold="pinion", torque=10.0, temperatures=["20 degC", 393.15]).ds
    cold, hot = found["backlash_by_temperature"].values * 60e-3 * COS
    assert cold == pytest.approx(1e-4, rel=1e-9)
    grown = 1.0 + 11.5e-6 * 100.0
    A, A_0 = 80e-3 * (1.0 + 23.1e-6 * 100.0), 80e-3 * grown
    alpha = np.arccos(A_0 * COS / A)
    opened = 2 * A_0 * COS * (np.tan(alpha) - alpha - np.tan(np.radians(20.0)) + np.radians(20.0))
    np.testing.assert_allclose(A - A_0, 92.8e-6, rtol=1e-3)
    assert opened == pytest.approx(63.5e-6, rel=5e-3)
    assert hot * grown == pytest.approx(1e-4 * grown + opened, rel=1e-9)


def test_positions_over_a_turn_show_the_runout() -> None:
    """Uncoupled from the centres an eccentric toothing shifts both flanks alike; coupled it opens and closes the pair."""
    case = gp.replace(article(0.0, 1e-4), {"rotors.ring.runout": {"amplitude": 1e-5}})
    found = gp.lost_motion(case, at="ring", hold="pinion", torque=50.0, positions=24).ds
    play = found["backlash_by_position"].values * 60 * 4e-3 * COS / 2
    expected = 1e-4 + 2e-5 * np.sin(np.radians(20.0)) * np.array([-1.0, 1.0])
    np.testing.assert_allclose([play.min(), play.max()], expected, rtol=2e-3)
    assert float(found["position"][12]) == pytest.approx(np.pi)


def test_members_scatter_as_their_tolerances() -> None:
    given = {"at": "ring", "hold": "pinion", "torque": 50.0}
    r_b = 60 * 4e-3 * COS / 2
    ds = gp.lost_motion(article(0.0, 1e-4), members=40, **given).ds
    play = ds["backlash_by_member"].values * r_b
    assert 79.9e-6 < play.min() < 82e-6
    assert 118e-6 < play.max() < 120.1e-6
    assert "within 20 %" in ds.attrs["scatter"]
    drawn = {
        "name": "b",
        "path": "meshes.0.backlash",
        "distribution": "normal",
        "mean": "90 um",
        "deviation": "5 um",
    }
    ds = gp.lost_motion(article(0.0, 1e-4), tolerances={"parameters": [drawn]}, members=200, **given).ds
    play = ds["backlash_by_member"].values * r_b
    assert play.mean() == pytest.approx(90e-6, rel=1e-3)
    assert play.std() == pytest.approx(5e-6, rel=0.03)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"at": "rim"}, 'at = "rim": must be a rotor of the case'),
        ({"hold": "ring"}, "must name a rotor other than"),
        ({"hold": ["pinion", "rim"]}, 'hold = "rim"'),
        ({"torque": "5 kg"}, "torque"),
        ({"torque": None}, "is required of a case"),
        ({"stages": [10.0]}, "two rising torques"),
        ({"stages": [10.0, "60 N m"]}, "below the rated one"),
        ({"temperatures": ["20 um"]}, "temperatures.0"),
        ({"tolerances": "han2021-map", "members": 3}, "must be a plan with drawn parameters"),
    ],
)
def test_refusals(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(gp.InputError, match=words):
        gp.lost_motion(article(0.0, 1e-4), **{"at": "ring", "hold": "pinion", "torque": 50.0} | changes)


def test_lost_motion__a_free_train_or_excessive_friction_is_refused() -> None:
    with pytest.raises(gp.InputError, match=r"must keep stage\.carrier from turning"):
        gp.lost_motion(gp.replace("planetary-reducer", {"planetary.stage.ring.fixed": False}), at="stage.carrier",
                       hold="stage.sun", torque=5.0)  # fmt: skip
    with pytest.raises(gp.InputError, match=r"above the friction of the train at arm, 20 N m"):
        gp.lost_motion(spring(1e4, 1e-3, 20.0), at="arm", hold="motor", torque=100.0)


@pytest.mark.parametrize("torque", [1e-300, 1e-9, 1e-6])
def test_torques_that_drown_in_rounding_are_refused(torque: float) -> None:
    """Such a torque would leave the flanks apart, and the play be 0."""
    with pytest.raises(gp.SimulationError, match="is within rounding"):
        of_article(article(1e-4, 1e-4), torque)


def test_floating_sun_and_classes_of_teeth__have_equilibria() -> None:
    """Four planets in bushes, a sun that nothing holds: with either contact of the teeth one pair of each mesh decides."""
    teeth = {"kind": "teeth", "method": "iso6336"}
    found = []
    for contact in ("pairs", "mesh"):
        wide = {"facewidth": 0.05, "quality": 7}
        changes = {
            "sun": {**wide, "drive": None, "floating": True},
            "planets": wide,
            "ring": wide,
            "pin": {"radial_clearance": 2e-5, "stiffness": 1e9, "law": "hunt-crossley", "restitution": 0.9},
        }
        document = planetary_document(contact=contact, sun_planet=teeth, planet_ring=teeth, **changes)
        stage = document["planetary"]["stage"]
        stage.pop("support"), stage.pop("stiffness")
        answer = gp.lost_motion(document, at="stage.carrier", hold="stage.sun", torque="2 kN m")
        found.append(float(answer.ds["lost_motion_arcmin"]))
    assert 3.0 < found[0] < 20.0
    assert found[1] == pytest.approx(found[0], rel=0.05)
