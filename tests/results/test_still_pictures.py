"""A symmetric set whose sun stays in place but for rounding: the pictures say so and draw no noise."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.nonlinear.portrait import stored_portrait
from gearplay.results.choice import moves, time_window
from gearplay.results.figures import history_figure, orbit_figure, overview_figure, spectrum_figure
from planetary_sets import planetary_document

SUN = "stage.sun"
Window = tuple[float, float]


@cache
def still() -> tuple[gp.Result, Window]:
    """Four planets in phase: 20 + 60 teeth and 4 planets, so that radial forces on the sun cancel at every instant."""
    document = planetary_document(sun={"floating": True, "radial_damping": 200.0}, planets={"count": 4})
    document["run"] = {"duration": 0.02, "transient": 0.01, "sampling": 2e4}
    result = gp.simulate(document)
    return result, (float(result.time()[0]), float(result.time()[-1]))


def words_of(figure: object) -> list[str]:
    return [text.get_text() for ax in figure.axes for text in ax.texts]  # type: ignore[attr-defined]


def test_rounding_is_there() -> None:
    """Else the tests below would compare nothing."""
    result, _ = still()
    assert 0.0 < np.ptp(result.signal("x", SUN)) < 1e-12
    assert not moves(result, "x", SUN)
    assert moves(result, "x", "stage.planet1")


def test_orbit_figure__a_path_of_rounding_is_labelled_at_rest() -> None:
    result, window = still()
    for figure in (orbit_figure(result, [SUN], window), result.plot.orbit(SUN).figure):
        assert "no motion above 1e-9 m" in words_of(figure)
        assert np.ptp(figure.axes[0].get_xlim()) > 1.0
        assert not figure.axes[0].child_axes


@pytest.mark.parametrize(("signal", "words"), [("x", "1e-9 m"), ("vx", "1e-9 m/s"), ("ax", "1e-6 m/s²")])
def test_a_history_of_rounding_is_said_to_be_still(signal: str, words: str) -> None:
    result, window = still()
    figure = history_figure(result, [(signal, SUN)], window, whole=True)
    assert f"no change above {words}" in words_of(figure)
    assert f"no change above {words}" in words_of(
        result.plot.history(signal, SUN, window=(None, None)).figure
    )
    assert np.ptp(figure.axes[0].get_ylim()) > 0.1


def test_a_spectrum_of_rounding_has_no_lines() -> None:
    result, window = still()
    figure = spectrum_figure(result, [("ax", SUN)], window)
    assert "no line above 1e-6 m/s²" in words_of(figure)


def test_portrait_figure__a_path_of_rounding_is_labelled_at_rest() -> None:
    result, window = still()
    assert "no motion above 1e-9 m" in words_of(stored_portrait(result, [SUN], window).plot())


def test_what_moves_is_drawn_as_before() -> None:
    result = gp.simulate("han2021", duration=0.02, transient=0.0)
    assert words_of(orbit_figure(result, ["ring"], (0.0, 0.0199))) == []
    assert words_of(history_figure(result, [("ax", "ring")], (0.0, 0.0199))) == []


BEARING = {
    "gravity": [0.0, -100.0],
    "rotors": {"shaft": {"mass": 3.0, "inertia": 2e-3, "drive": {"kind": "speed", "speed": "2400 rpm"}}},
    "bearings": {
        "shaft": {
            "rolling_elements": 11,
            "pitch_diameter": "46 mm",
            "element_diameter": "8.5 mm",
            "bore": "30 mm",
            "internal_clearance": "CN",
            "groove_ratio": 0.52,
            "damping": {"kind": "hunt-crossley", "value": "50 s/m"},
        }
    },
    "run": {"duration": 0.02, "sampling": "20 kHz"},
}


HUNTING: dict[str, Any] = {
    "rotors": {
        "load": {"mass": 2.0, "inertia": 6e-3, "load": {"drag": 4e-3}, "initial": {"theta": "0.5 deg"}},
        "motor": {
            "mass": 0.3,
            "inertia": 6e-5,
            "load": {"drag": 5e-5},
            "initial": {"theta": "2 deg"},
            "drive": {
                "kind": "position",
                "angle": 0.0,
                "proportional_gain": 0.7,
                "integral_gain": 2.5,
                "derivative_gain": 5e-3,
                "torque_limit": 2.0,
                "sensor": "load",
                "speed_sensor": "motor",
            },
        },
    },
    "couplings": [{"between": ["load", "motor"], "ratio": 0.25, "torsional_stiffness": 20.0, "play": 6e-3}],
    "run": {"duration": 1.0, "sampling": 2e3},
}


def test_overview_of_an_axis_that_hunts__angle_and_its_spectrum_no_efficiency() -> None:
    """Its centres cannot move: panels of acceleration were empty. The power into a load that stays in place is no output."""
    result = gp.simulate(HUNTING)
    figure = overview_figure(result, time_window(result, None))
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert titles.count("load: rotation of the rotor") == 2
    assert all(len(ax.lines[0].get_xdata()) > 100 for ax in figure.axes)
    assert not any("no change" in words or "no line" in words for words in words_of(figure))
    assert not result.output.turns
    assert math.isnan(result.output.values["efficiency"])
    assert "efficiency" not in " ".join(titles)
    drive = {
        **HUNTING["rotors"]["motor"]["drive"],
        "over_time": {"sine": {"amplitude": 0.5, "frequency": 2.0}},
    }
    del drive["angle"]
    moved = gp.simulate(gp.replace(gp.load_case(HUNTING), {"rotors.motor.drive": drive}))
    assert not moved.output.turns
    assert 0.0 < moved.output.values["efficiency"] < 1.0


def test_spectrum_of_a_signal_that_is_zero__says_so() -> None:
    result = gp.simulate(HUNTING, duration=0.1)
    assert "no line above 1e-6 m/s²" in words_of(
        spectrum_figure(result, [("ax", "load")], time_window(result, None))
    )


def test_overview_of_a_bearing__shows_the_load_of_its_elements_not_a_constant() -> None:
    result = gp.simulate(BEARING)
    figure = overview_figure(result, time_window(result, None))
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert any("largest load of an element of the bearing" in title for title in titles)
    assert not any("cage" in title for title in titles)


def test_overview_of_a_file_without_accelerations__shows_the_torque_of_its_coupling() -> None:
    case = {
        "rotors": {
            "motor": {"mass": 1.0, "inertia": 1e-3, "initial": {"omega": 5.0}},
            "fan": {"mass": 1.0, "inertia": 2e-3},
        },
        "couplings": [{"between": ["motor", "fan"], "torsional_stiffness": 50.0}],
        "run": {"duration": 0.05, "sampling": "5 kHz"},
    }
    result = gp.simulate(case, signals=["omega", "coupling_torque"])
    figure = overview_figure(result, time_window(result, None))
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert sum("motor-fan: torque of the coupling" in title for title in titles) == 3
