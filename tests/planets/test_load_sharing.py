"""Load sharing: statics of a pin error with floating and held sun, along a motion, saved and drawn."""

import math
from pathlib import Path

import numpy as np
import pytest

import gearplay as gp
from gearplay.planets.sharing import LoadSharing
from pictures import faults_of
from planetary_sets import planetary_document

ERROR = [{"planet": 1, "tangential": 5e-5}]


def case(**changes: object) -> gp.Case:
    """Return a large set of three planets whose carrier is loaded, in the uncoupled model unless said."""
    stage = {
        "module": 8e-3,
        "planets": {"count": 3, "teeth": 21},
        "sun": {"teeth": 21, "floating": False},
        "ring": {"teeth": 63},
        "carrier": {"load": {"torque": 4000.0}},
    }
    document = planetary_document(**{**stage, **changes})
    return gp.load_case(document)


def test_a_held_sun_shares_as_statics_say() -> None:
    """Planets in line between sun, pin and ring: each path a spring, the late pin's path shortened by its error.

    Seen from the carrier, a pin that is e ahead pulls its planet with k_p (e - v), v how far the planet is ahead; the meshes with
    k_m times their penetrations. The carrier takes up what all pins have in common.
    """
    found = gp.load_sharing(gp.replace(case(pin_errors=ERROR), {"backlash_model": "uncoupled"})).ds
    alpha, k_m, k_p, A = math.radians(20.0), 3e8, 2e8, 0.168
    c, s = math.cos(alpha), math.sin(alpha)
    r_b = 0.084 * c

    def force(ahead: float) -> float:
        """Return the mesh force [N] of a planet whose pin is ahead [m]; unknowns are u (radial), v (ahead) and its turn."""
        sun, ring = np.array([-s, c, -r_b]), np.array([s, c, r_b])
        matrix = k_m * np.outer(sun, sun) + k_m * np.outer(ring, ring) + k_p * np.diag([1.0, 1.0, 0.0])
        u, v, turn = np.linalg.solve(matrix, [0.0, k_p * ahead, 0.0])
        return k_m * float(sun @ [u, v, turn])

    unit = force(1.0)
    total = 4000.0 / (2.0 * c * A)  # T = 2 F_n cos(alpha) A summed: sun and ring push with F each
    mean = total / 3.0
    expected = np.array([mean + unit * 5e-5 * share for share in (-2.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0)])
    np.testing.assert_allclose(found["sun_force"].values, expected, rtol=1e-6)
    np.testing.assert_allclose(found["share"].values, expected / expected.sum(), rtol=1e-6)
    assert found["sun_force"].values == pytest.approx(found["ring_force"].values, rel=1e-6)


def test_planets_at_one_place__are_drawn_as_one_and_no_minus_0_is_printed() -> None:
    """A set without errors: planets differ by rounding, and were drawn apart with ticks over each other."""
    found = gp.load_sharing(case())
    pins = found.plot().axes[2]
    places = 1e6 * found.ds["beside_pin"].values
    assert np.ptp(pins.get_xlim()) > 0.1 * np.hypot(*places[0]) > 1e3 * np.ptp(places, axis=0).max()
    assert faults_of(found.plot()) == []
    tiny = found.ds.copy(deep=True)
    tiny["beside_pin"].values[:, 0] = -3e-9
    assert "-0.00" not in str(LoadSharing(tiny).rows())


@pytest.mark.slow
def test_along_a_motion(tmp_path: Path) -> None:
    moving = gp.replace(gp.load_case("planetary-reducer"), {"run.duration": 0.05, "run.sampling": 20_000.0})
    found = gp.load_sharing(gp.simulate(moving))
    np.testing.assert_allclose(found.ds["load_sharing_factor"].values, 1.0, rtol=0.01)
    # Pressed against its pin beyond the clearance of 10 um, ahead of it: the planets drive the carrier.
    assert np.all(found.ds["beside_pin"].values[:, 1] > 1e-5)
    found.save(tmp_path / "sharing.nc")
    again = gp.read_result(tmp_path / "sharing.nc")
    assert again.message == found.message
    for answer in (again, gp.load_sharing("planetary-reducer")):
        figure = answer.plot()
        figure.canvas.draw()
        assert all(ax.get_xlabel() and ax.get_ylabel() for ax in figure.axes)


@pytest.mark.slow
def test_reduction_of_a_sweep__is_the_load_sharing_of_its_motion() -> None:
    """Over the error of a pin; at rest under the load the most loaded planet has the same factor."""
    run = {"run.duration": 0.02, "run.transient": 0.02, "run.sampling": 20_000.0}
    path, base = "planetary.stage.pin_errors.0.tangential", gp.replace(case(pin_errors=ERROR), run)
    kept = [{"kind": "load_sharing", "name": name, "statistic": name} for name in ("factor", "peak")]
    axis = {"name": "error", "path": path, "values": [0.0, 5e-5]}
    found = gp.sweep(base, axes=[axis], reduce=kept).ds
    moving = gp.load_sharing(gp.simulate(base)).ds
    assert float(found["factor"][1]) == float(moving["load_sharing_factor"].max())
    assert float(found["peak"][1]) == float(moving["factor_peak"].max())
    still = float(gp.load_sharing(base).ds["load_sharing_factor"].max())
    assert float(found["factor"][0]) == pytest.approx(1.0, abs=0.02)
    assert float(found["factor"][1]) == pytest.approx(still, rel=0.02)
    assert still > 1.1


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(gp.InputError, match=r'reduce.share.planetary = "other": must be a planetary set'):
        gp.sweep(
            "planetary-reducer",
            axes=[{"name": "load", "path": "planetary.stage.carrier.load.torque", "values": [50.0, 100.0]}],
            reduce=[{"kind": "load_sharing", "name": "share", "planetary": "other"}],
        )
    with pytest.raises(gp.InputError, match="must have a set"):
        gp.load_sharing("han2021")
    with pytest.raises(gp.InputError, match="must be a planetary set of the case"):
        gp.load_sharing("planetary-reducer", name="other")
    with pytest.raises(gp.InputError, match="must carry a load"):
        gp.load_sharing(gp.replace(case(), {"planetary.stage.carrier.load.torque": 0.0}))


def test_sharing_of_a_motion_without_floating_members() -> None:
    case = gp.replace(
        "planetary-reducer",
        {"planetary.stage.sun.floating": False, "run.duration": 2e-3, "run.transient": 0.0},
    )
    found = gp.load_sharing(gp.simulate(case))
    assert found.ds["floating_history"].shape[:2] == (0, 2)
    assert float(found.ds["share"].sum()) == pytest.approx(1.0, rel=1e-12)


def test_planets_beside_their_pins_at_temperature() -> None:
    """The pins move with the carrier's expansion, 0.16 mm here: what is left beside them is clearance and penetration."""
    steel = {"expansion": 11.5e-6}
    changes: dict[str, object] = {
        f"planetary.stage.{name}.material": steel for name in ("sun", "planets", "ring", "carrier")
    }
    changes |= {
        "environment": {"temperature": "120 degC", "housing": steel},
        "planetary.stage.pin.shaft_radius": "20 mm",
    }
    changes |= {"run.duration": 0.06, "run.transient": 0.0}
    result = gp.simulate(gp.replace("planetary-reducer", changes))
    assert np.ptp(result.signal("stage.carrier.theta")) > 0.7
    found = gp.load_sharing(result)
    deepest = max(float(np.max(result.signal("sleeve_penetration", f"stage.planet{k}"))) for k in (1, 2, 3))
    beside = np.hypot(*found.ds["beside_pin_history"].transpose("direction", ...).values)
    clearance = found.ds.attrs["pin_clearance"]
    assert clearance == pytest.approx(10e-6 * (1.0 + 11.5e-6 * 100.0), rel=1e-9)
    assert float(beside.max()) == pytest.approx(clearance + deepest, rel=1e-6)
    still = gp.load_sharing(result.case)
    arm, stiffness = 0.135 * (1.0 + 11.5e-6 * 100.0), result.case.sleeves["stage.planet1"].contact_stiffness()
    pressed = clearance + (500.0 / (3.0 * arm) / stiffness) ** (2.0 / 3.0)
    assert still.ds["beside_pin"].sel(direction="tangential").values == pytest.approx([pressed] * 3, rel=1e-4)
