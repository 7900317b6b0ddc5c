"""The jam line of maps: wherever it is drawn, `geometry.jam_ratio` is 1, and above 1 on the side that it says."""

from typing import Any

import numpy as np
import pytest

from gearplay.model.reading import load_case, replace
from gearplay.parts.mesh.train import geometry
from gearplay.pictures import panels as figure_panels
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.report.curves import line_figure
from gearplay.sweeps.report.drawable import View
from gearplay.sweeps.report.figures import map_axes
from gearplay.sweeps.report.jam import jam_excess, jam_lines
from gearplay.sweeps.report.maps import JAM, map_figure
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.product import to_product

RMS = {"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}
UM = {"low": "20 um", "high": "400 um", "count": 5}
RING, PINION, BACKLASH, ANGLE = (
    "sleeves.ring.radial_clearance",
    "sleeves.pinion.radial_clearance",
    "meshes.0.backlash",
    "meshes.0.pressure_angle",
)


def sweep_of(*axes: dict[str, Any], **more: Any) -> Sweep:
    """Return a sweep of the article's rig with a second sleeve, of 30 um."""
    case = load_case("han2021").resolved()
    case["sleeves"]["pinion"] = {**case["sleeves"]["ring"], "radial_clearance": 30e-6}
    return Sweep(load_sweep({"case": case, "axes": list(axes), "reduce": [RMS], **more}))


def axis(name: str, path: str, **more: Any) -> dict[str, Any]:
    return {"name": name, "path": path, **UM, **more}


FACTOR = {"mode": "scale", "low": 0.2, "high": 4.0}
TILT = {"low": "14 deg", "high": "26 deg"}
SPEED = {"name": "y", "path": "rotors.pinion.drive.speed", "low": 5.0, "high": 30.0, "count": 3}
PAIRS = {
    "clearance and backlash": (axis("x", RING), axis("y", BACKLASH), (1, -1)),
    "the other way round": (axis("x", BACKLASH), axis("y", PINION), (-1, 1)),
    "logarithmic": (axis("x", RING, scale="log"), axis("y", BACKLASH, scale="log"), (1, -1)),
    "both clearances": (axis("x", RING), axis("y", PINION), (1, 1)),
    "both at once": (axis("x", RING, also=[PINION]), axis("y", BACKLASH), (1, -1)),
    "factors": (axis("x", RING, **FACTOR), axis("y", BACKLASH, **FACTOR), (1, -1)),
    "backlash alone": (axis("x", BACKLASH), SPEED, (-1, 0)),
    "clearance alone": ({**SPEED, "name": "x"}, axis("y", RING), (0, 1)),
    "angle and backlash": (axis("x", ANGLE, **TILT), axis("y", BACKLASH), (1, -1)),
    "backlash and angle": (axis("x", BACKLASH), axis("y", ANGLE, **TILT), (-1, 1)),
}


@pytest.mark.parametrize(("x", "y", "sides"), PAIRS.values(), ids=PAIRS.keys())
def test_on_the_line_the_jam_ratio_is_one(
    x: dict[str, Any], y: dict[str, Any], sides: tuple[int, int]
) -> None:
    sweep = sweep_of(x, y)
    (low, *_, high), (bottom, *_, top) = sweep.template.points.values
    (line,) = jam_lines(sweep, ("x", low, high), ("y", bottom, top), {})
    assert (line.mesh, line.sides) == ("pinion-ring", sides)
    assert np.ptp(line.across) + np.ptp(line.up) > 0.0
    inside = (line.across >= low) & (line.across <= high) & (line.up >= bottom) & (line.up <= top)
    assert inside.sum() > 20
    for at in np.flatnonzero(inside)[::40]:
        place = {"x": float(line.across[at]), "y": float(line.up[at])}
        case = replace(sweep.template.base, sweep.template.changes(place))
        assert geometry.jam_ratio(case, 0) == pytest.approx(1.0, abs=1e-9)
        beside = {"x": place["x"] * (1.0 + 0.01 * sides[0]), "y": place["y"] * (1.0 + 0.01 * sides[1])}
        assert geometry.jam_ratio(replace(case, sweep.template.changes(beside)), 0) > 1.005
        assert jam_excess(sweep, 0, beside) > 0.0


@pytest.mark.parametrize("path", ["meshes.0.center_distance", "rotors.pinion.profile_shift"])
def test_of_drawn_gears_the_jam_ratio_is_one_on_the_line(path: str) -> None:
    """Backlash and working angle follow from thicknesses, shifts and the centre distance."""
    changes = {
        "rotors.pinion.allowance": "c25",
        "rotors.ring.thickness": "6.2 mm",
        "meshes.0.center_distance": "80 mm",
    }
    document = replace(load_case("han2021"), changes).resolved()
    del document["meshes"][0]["backlash"]
    low, high = ("79.9 mm", "80.1 mm") if path.startswith("meshes") else (0.0, 0.02)
    axes = [{"name": "x", "path": path, "low": low, "high": high, "count": 3}, axis("y", RING)]
    sweep = Sweep(load_sweep({"case": document, "axes": axes, "reduce": [RMS]}))
    (left, *_, right), (bottom, *_, top) = sweep.template.points.values
    (line,) = jam_lines(sweep, ("x", left, right), ("y", bottom, top), {})
    assert len(line.up) > 5
    for at in range(0, len(line.up), 5):
        place = {"x": float(line.across[at]), "y": float(line.up[at])}
        found = replace(sweep.template.base, sweep.template.changes(place))
        assert geometry.jam_ratio(found, 0) == pytest.approx(1.0, abs=1e-6)


def test_the_line_follows_what_other_axes_are_held_at() -> None:
    sweep = sweep_of(axis("x", RING), axis("y", BACKLASH), axis("z", PINION))
    spans = ("x", 2e-5, 4e-4), ("y", 2e-5, 4e-4)
    near, far = (jam_lines(sweep, *spans, {"z": z})[0] for z in (0.0, 100e-6))
    assert far.up - near.up == pytest.approx(2.0 * np.sin(np.radians(20.0)) * 100e-6)


def test_tone_search__noise_and_silence_have_no_line() -> None:
    drawn = {"name": "z", "path": PINION, "low": "10 um", "high": "50 um"}
    random = sweep_of(axis("x", RING), axis("y", BACKLASH), design={"count": 4, "parameters": [drawn]})
    assert jam_lines(random, ("x", 2e-5, 4e-4), ("y", 2e-5, 4e-4), {}) == []
    other = axis("x", "sleeves.ring.restitution", low=0.5, high=0.9)
    assert jam_lines(sweep_of(other, SPEED), ("x", 0.5, 0.9), ("y", 5.0, 30.0), {}) == []
    angle = sweep_of(axis("x", ANGLE, **TILT), SPEED)  # the angle alone is neither backlash nor clearance
    assert jam_lines(angle, ("x", 0.2, 0.5), ("y", 5.0, 30.0), {}) == []


def test_over_temperature_the_line_is_crossed() -> None:
    """Steel in aluminium: heat closes the backlash of an internal pair; on the line found the jam ratio is 1, hotter above it."""
    axes = [
        {"name": "x", "path": "environment.temperature", "low": "-100 degC", "high": "120 degC", "count": 5},
        axis("y", RING),
    ]
    sweep = Sweep(load_sweep({"case": "space-drive", "axes": axes, "reduce": [RMS]}))
    span, clearances = ("x", 173.15, 393.15), ("y", 2e-5, 4e-4)
    (line,) = jam_lines(sweep, span, clearances, {})
    assert line.sides == (1, 1)
    assert line.across.size > 20
    assert np.all(np.diff(line.up) < 0.0), "the hotter, the less clearance jams"
    for at in (0, line.across.size // 2, line.across.size - 1):
        place = {"x": float(line.across[at]), "y": float(line.up[at])}
        case = replace(sweep.template.base, sweep.template.changes(place))
        assert geometry.jam_ratio(case.operating, 0) == pytest.approx(1.0, abs=1e-6)
    (upright,) = jam_lines(sweep, span, ("", 0.0, 1.0), {"y": 1e-4})
    assert np.ptp(upright.across) < 1e-9
    assert 293.15 < upright.across[0] < 393.15


@pytest.mark.slow
def test_the_map_shows_the_line_in_its_units(monkeypatch: pytest.MonkeyPatch) -> None:
    figures: list[Any] = []
    plain = figure_panels.to_png
    monkeypatch.setattr(figure_panels, "to_png", lambda figure: (figures.append(figure), plain(figure))[1])
    sweep = sweep_of(axis("play", RING), axis("b", BACKLASH, scale="log"), axis("z", PINION, count=3))
    count, size = len(sweep.template.points), sweep.reducer.size
    rows = {sweep.template.address_of(i): (0, "", np.full(size, 1.0 + i).tobytes()) for i in range(count)}
    view = View(sweep, to_product(sweep, rows))
    assert map_axes(view) == ("play", "b")
    assert map_figure(view, "rms", "play", "b") is not None
    panels = [ax for ax in figures[0].axes if ax.get_label() != "<colorbar>"]
    for ax, other in zip(panels, (20e-6, 210e-6, 400e-6), strict=True):
        (line,) = [line for line in ax.lines if line.get_color() == JAM]
        play, b = (1e-6 * np.asarray(values) for values in line.get_data())
        case = replace(sweep.template.base, {RING: float(play[200]), BACKLASH: float(b[200]), PINION: other})
        assert geometry.jam_ratio(case, 0) == pytest.approx(1.0)
        assert ax.get_ylim()[1] < 1000.0  # the line does not widen the picture
    assert any("can jam" in text.get_text() for ax in panels for text in ax.texts)
    assert "jam line 2 sin α₀ (c₁ + c₂) = b₀" in [
        text.get_text() for text in figures[0].legends[0].get_texts()
    ]


def test_curves__have_jam_lines_in_their_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    """Over backlash each clearance has its own limit; a curve whose clearance does not enter it shares the one of all."""
    figures: list[Any] = []
    plain = figure_panels.to_png
    monkeypatch.setattr(figure_panels, "to_png", lambda figure: (figures.append(figure), plain(figure))[1])

    def drawn(other: dict[str, Any]) -> tuple[Any, Sweep]:
        sweep = sweep_of(axis("b", BACKLASH), other)
        count, size = len(sweep.template.points), sweep.reducer.size
        rows = {sweep.template.address_of(i): (0, "", np.full(size, 1.0 + i).tobytes()) for i in range(count)}
        assert line_figure(View(sweep, to_product(sweep, rows)), ["rms"], "b") is not None
        return figures[-1], sweep

    figure, sweep = drawn(axis("play", RING, high="150 um", count=3))
    legend = {text.get_text(): line.get_color() for text, line in zip(
        figure.legends[0].get_texts(), figure.legends[0].get_lines(), strict=True)}  # fmt: skip
    dashed = [line for line in figure.axes[0].lines if line.is_dashed()]
    assert len(dashed) == 3
    for line, (words, color) in zip(dashed, legend.items(), strict=False):
        assert line.get_color() == color
        play = 1e-6 * float(words.split()[-2])
        case = replace(sweep.template.base, {RING: play, BACKLASH: 1e-6 * float(line.get_xdata()[0])})
        assert geometry.jam_ratio(case, 0) == pytest.approx(1.0, abs=0.02)
    assert "jam line of each curve" in legend
    figure, _ = drawn(axis("drag", "rotors.ring.load.drag", low=1e-4, high=1e-3, count=3))
    assert {line.get_color() for line in figure.axes[0].lines if line.is_dashed()} == {JAM}
