"""Pictures of planetary sets against x, y, theta: a planet is drawn where it is in the frame of the actual carrier.

The reference is the definition, in complex numbers: with nominal places P = a exp(i beta), displacements d and the carrier's full
rotation theta, the planet's centre beside its pin is e = exp(-i theta) (P + d - d_carrier) - P (1 + (radial + i tangential) / a).
"""

import math
import tomllib
from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.path import Path
from numpy.typing import NDArray

import gearplay as gp
from building import Document, merged
from depth import some
from gearplay.model.bundled import bundled_text
from gearplay.model.pack import pack
from gearplay.pictures.gears import sides_of
from gearplay.pictures.style import COUPLED
from gearplay.results.figures import orbit_figure, overview_figure
from gearplay.results.mechanism import mechanism_of
from gearplay.results.staging import motion_in, stage_of
from gearplay.web.views import views_of
from planetary_sets import planetary_document

PIN: Document = {
    "pin": {"radial_clearance": 2e-5, "stiffness": 2e9, "restitution": 0.8},
    "planets": {"radial_damping": 200.0},
}
TORQUE = {"kind": "torque", "torque": 30.0}
SETS: dict[str, Document] = {
    "carrier loaded": PIN,
    "pin off its place": merged(PIN, {"pin_errors": [{"planet": 1, "tangential": 3e-5, "radial": -1e-5}]}),
    "floating carrier": merged(PIN, {"carrier": {"floating": True, "radial_damping": 2e3}}),
    "carrier in a sleeve": merged(
        PIN, {"carrier": {"sleeve": {"radial_clearance": 4e-5, "stiffness": 2e9}, "initial": {"x": 3e-5}}}
    ),
    "ring turns too": merged(PIN, {"ring": {"fixed": False, "drive": {"kind": "speed", "speed": -10.0}}}),
    "carrier driven by a torque, begins turned": merged(
        PIN, {"carrier": {"drive": TORQUE, "initial": {"theta": 0.7}}, "sun": {"load": {"drag": 0.02}}}
    ),
    "five planets on springs": {"planets": {"count": 5}},
}
FIGURES = [(name, kind) for name in SETS for kind in ("orbit", "overview", "mechanism")]


@cache
def result_of(name: str) -> gp.Result:
    document = planetary_document(**SETS[name])
    stage = document["planetary"]["stage"]
    if "pin" in stage:
        del stage["support"]
    if "drive" in stage["carrier"]:
        del stage["sun"]["drive"], stage["carrier"]["load"]
    document["run"] = {"duration": 0.02, "transient": 0.005, "sampling": 2e4}
    return gp.simulate(document)


def beside_pin(result: gp.Result, planet: str) -> NDArray[np.complex128]:
    """Return a planet's centre beside its pin [m], x + i y, in the carrier's axes."""
    number, stage = int(planet.removeprefix("stage.planet")), result.case.planetary["stage"]
    arm = 0.5 * stage.module * (stage.sun.teeth + stage.planets.teeth)
    place = arm * np.exp(2j * math.pi * (number - 1) / stage.planets.count)
    off = next(
        (each.radial + 1j * each.tangential for each in stage.pin_errors if each.planet == number), 0.0
    )
    pin = place * (1.0 + off / arm)
    own, hub = (
        result.signal("x", each) + 1j * result.signal("y", each) for each in (planet, "stage.carrier")
    )
    found: NDArray[np.complex128] = (
        np.exp(-1j * result.signal("theta", "stage.carrier")) * (place + own - hub) - pin
    )
    return found


def drawn_path(ax: Any) -> NDArray[np.complex128]:
    """Return the longest line in the colour of the motion, in m."""
    lines = [line for line in ax.get_lines() if to_hex(line.get_color()) == COUPLED]
    x, y = max(lines, key=lambda line: len(line.get_xdata())).get_data()
    return 1e-6 * (np.asarray(x) + 1j * np.asarray(y))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), some(FIGURES, 21))
def test_a_planet_is_drawn_in_the_frame_of_the_actual_carrier(name: str, kind: str) -> None:
    result = result_of(name)
    assert result.success
    window = (float(result.time()[0]), float(result.time()[-1]))
    if kind == "mechanism":
        check_mechanism(result, window)
        return
    figure = orbit_figure(result, [], window) if kind == "orbit" else overview_figure(result, window)
    drawn = {ax.get_title(loc="left").split()[0]: ax for ax in figure.axes if ax.get_xlabel() == "x [µm]"}
    planets = [each for each in drawn if "planet" in each]
    if kind == "orbit":
        assert len(planets) == sum("planet" in each for each in result.case.rotors)
    else:
        assert len(drawn) == 1
    for rotor, ax in drawn.items():
        own = result.signal("x", rotor) + 1j * result.signal("y", rotor)
        right = beside_pin(result, rotor) if rotor in planets else own
        for axes in (ax, result.plot.orbit(rotor)):
            assert np.allclose(drawn_path(axes), right, rtol=0.0, atol=1e-12)


def check_mechanism(result: gp.Result, window: tuple[float, float]) -> None:
    """Compare the shaft in its bush, magnified, at every frame of some."""
    planets = [each for each in result.case.sleeves if "planet" in each]
    for planet in planets:
        stage = stage_of(motion_in(result, window, at=planet, frames=8))
        at = np.searchsorted(result.time(), stage.start + stage.frames["t"] - 1e-9)
        pane = next(each for each in stage.panes if each.look.sleeve is not None)
        ring, _, radius, _ = next(each for each in pane.sleeves if each[1]["rotor"] == planet)
        disc = next(patch for patch, each in pane.shafts if each["rotor"] == planet)
        for i in range(len(at)):
            stage.show(i)
            bush = np.array([np.mean(each[:-1]) for each in ring.get_data()])
            corners = (disc.get_transform() - pane.ax.transData).transform(Path(disc.get_xy()).vertices)
            shaft = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
            assert np.allclose(bush, [np.mean(pane.ax.get_xlim()), np.mean(pane.ax.get_ylim())])
            e = complex(*(1e-3 * (shaft - bush))) / stage.factor
            assert abs(e - beside_pin(result, planet)[at[i]]) < 1e-10
            play = radius - pane.look.shaft
            assert math.isclose(play, stage.factor * result.case.sleeves[planet].radial_clearance)
    if not planets:
        frames = motion_in(result, window).frames
        index = list(result.case.rotors).index("stage.planet1")
        at = np.searchsorted(result.time() - result.time()[0], frames["t"] - 1e-9)
        assert np.allclose(
            frames["rotors"][index, 0] + 1j * frames["rotors"][index, 1],
            beside_pin(result, "stage.planet1")[at],
            atol=1e-12,
        )


@pytest.mark.slow
@pytest.mark.parametrize("name", list(SETS))
def test_the_page_has_the_same_paths(name: str) -> None:
    """The page's orbits are those of the pictures, and it marks what is on a carrier."""
    result = result_of(name)
    for orbit in views_of(result.case, pack(result.case), result.runs)["orbits"]:
        if orbit["on"] is None:
            assert "planet" not in orbit["name"]
            continue
        assert orbit["on"] == "stage.carrier"
        assert np.allclose(
            orbit["x"] + 1j * orbit["y"], beside_pin(result, orbit["name"]), rtol=0.0, atol=1e-12
        )


@pytest.mark.parametrize("name", ["planetary-reducer", "two-stage-reducer", "pinion-idler-ring"])
def test_drawing__gears_in_mesh_differ_in_colour(name: str) -> None:
    mechanism = mechanism_of(gp.load_case(name))
    sides = sides_of(mechanism)
    assert set(sides) == {gear["name"] for gear in mechanism["gears"]}
    assert all(sides[mesh["driver"]] != sides[mesh["driven"]] for mesh in mechanism["meshes"])


def test_close_ups__have_the_whole_names_of_planets_meshes() -> None:
    table = tomllib.loads(bundled_text("gearplay.model", "cases", "planetary-reducer"))
    table["planetary"] = {"reduction": table["planetary"]["stage"]}
    case = gp.replace(table, {"run.duration": 0.005, "run.transient": 0.0})
    stage = stage_of(motion_in(gp.simulate(case), (0.0, 0.004), frames=2))
    (title,) = [pane.ax.get_title() for pane in stage.panes if "backlash" in pane.ax.get_title()]
    first = case.meshes[0].label
    assert f"mesh {first}, backlash " in title
