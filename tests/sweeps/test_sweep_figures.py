"""The pictures of a sweep: which ones a plan gets, in which units, and what they show of made-up numbers."""

import io
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from gearplay.pictures import panels as panels_module
from gearplay.sweeps.report.figures import pictures_of
from gearplay.sweeps.report.page import write_sweep_report
from sweep_products import (
    BACKLASH,
    BOUNCE,
    DESIGN,
    HISTORY,
    MODEL,
    PLAY,
    RMS,
    SHORT,
    SPECTRUM,
    SPEED,
    made,
    plan_of,
    smooth,
)


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Keep every matplotlib figure that is turned into a PNG."""
    kept: list[Any] = []
    plain = panels_module.to_png
    monkeypatch.setattr(panels_module, "to_png", lambda figure: (kept.append(figure), plain(figure))[1])
    return kept


def panels(figure: Any) -> list[Any]:
    return [ax for ax in figure.axes if ax.get_label() != "<colorbar>"]


SHAPES = {
    "one axis": (plan_of(SPEED), ["lines-speed-1"]),
    "members": (plan_of(SPEED, members=3), ["lines-speed-1"]),
    "a category": (plan_of(MODEL, members=3), ["lines-model-1"]),
    "categories": (plan_of(MODEL, {**MODEL, "name": "law", "path": "sleeves.ring.law", "values": ["flores", "gonthier"]}),
                   ["lines-model-1"]),
    "two axes": (plan_of(MODEL, PLAY, BACKLASH), ["map-rms", "map-hits", "lines-play-1", "lines-b-1"]),
    "five axes": (plan_of(MODEL, SPEED, PLAY, BACKLASH, BOUNCE, reduce=[RMS]),
                  ["map-rms", "parallel-rms", "lines-speed-1", "lines-play-1", "lines-b-1"]),
    "a design": (plan_of(design=DESIGN), ["parallel-rms", "parallel-hits", "scatter-rms", "scatter-hits"]),
    "a design on axes": (plan_of(MODEL, BOUNCE, design=DESIGN, members=2, reduce=[RMS]),
                         ["parallel-rms", "scatter-rms", "lines-bounce-1"]),
    "spectra": (plan_of(MODEL, SPEED, reduce=[SPECTRUM]), ["waterfall-s", "orders-s"]),
    "spectra over no speed": (plan_of(PLAY, reduce=[SPECTRUM]), ["waterfall-s"]),
    "spectra of categories": (plan_of(MODEL, reduce=[SPECTRUM, HISTORY], members=2), ["spectrum-s", "history-raw"]),
    "one value per axis": (plan_of({**MODEL, "values": ["coupled"]}, {**BOUNCE, "values": [0.7]}), []),
    "not in order": (plan_of({**BOUNCE, "values": [0.9, 0.5, 0.7]}, {**MODEL, "values": ["coupled"]}), ["lines-bounce-1"]),
    "up and down": (plan_of(MODEL, SPEED, carry={"axis": "speed"}, members=4, set={**SHORT, "run.transient": 0.2}),
                    ["hysteresis-1-1", "hysteresis-1-2"]),
    "up only": (plan_of(SPEED, carry={"axis": "speed", "directions": ["up"]}, set={**SHORT, "run.transient": 0.2}),
                ["lines-speed-1"]),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize(("plan", "names"), SHAPES.values(), ids=SHAPES.keys())
def test_a_plan_of_any_shape_gets_the_pictures_that_make_sense(
    plan: dict[str, Any], names: list[str], tmp_path: Path
) -> None:
    from matplotlib.image import imread

    sweep, dataset = made(plan)
    write_sweep_report(sweep, dataset, tmp_path)
    found = sorted(path.stem for path in tmp_path.glob("figures/*.png"))
    assert found == sorted(names)
    for name in names:
        pixels = imread(io.BytesIO((tmp_path / "figures" / f"{name}.png").read_bytes()))
        assert min(pixels.shape[:2]) > 300
        assert len(np.unique(pixels[..., :3] @ np.array([1.0, 7.0, 49.0]))) > 50
        edge = np.concatenate(
            [pixels[:3].ravel(), pixels[-3:].ravel(), pixels[:, :3].ravel(), pixels[:, -3:].ravel()]
        )
        assert edge.min() == 1.0, "something is cut off at the edge"
    page = (tmp_path / "report.html").read_text()
    assert page.count('src="data:image/png;base64,') == len(names)
    assert not re.search(r"\bnan\b", re.sub(r"base64,[^\"]*", "", page))
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.many
@pytest.mark.parametrize("spread", ["everywhere", "one panel", "one model", "no number"])
def test_failed_cases_leave_holes_and_no_trouble(spread: str, figures: list[Any]) -> None:
    def value(kept: Any, values: Mapping[str, Any], member: int) -> Any:
        lost = {
            "everywhere": True,
            "one panel": values["speed"] < 7.0,
            "one model": values["model"] == "coupled",
            "no number": False,
        }[spread]
        if lost:
            return "too fast"
        unknown = spread == "no number" and values["play"] < 1.5e-4
        return np.full(kept.size, math.nan) if unknown else smooth(kept, values, member)

    few = {**SPECTRUM, "count": 5}
    plan = plan_of(MODEL, {**SPEED, "count": 2}, {**PLAY, "count": 3}, BACKLASH, reduce=[RMS, few])
    sweep, dataset = made(plan, value)
    pictures = {each.name: each.png for each in pictures_of(sweep, dataset)}
    assert bool(pictures) == (spread != "everywhere")
    if spread == "everywhere":
        return
    maps = panels(figures[0])
    hatched = sum(bool(c.get_hatch()) for ax in maps for c in ax.collections)
    assert (
        hatched == {"one panel": 2 * 3, "one model": 2 * 3, "no number": 0}[spread]
    )  # bars, a row of cells each
    grey = sum(
        int(np.ma.getmaskarray(c.get_array()).sum())
        for ax in maps
        for c in ax.collections
        if c.get_array() is not None
    )
    assert grey == {"one panel": 2 * 9, "one model": 2 * 9, "no number": 4 * 3}[spread]


@pytest.mark.slow
def test_maps_share_one_scale_of_colour_that_is_logarithmic_for_decades(figures: list[Any]) -> None:
    def value(kept: Any, values: Mapping[str, Any], member: int) -> float:
        top = 1.0 if values["model"] == "coupled" else 3.0
        return top * (values["b"] / 4e-4) ** (2 if kept.name == "rms" else 0.1)

    pictures_of(*made(plan_of(MODEL, PLAY, BACKLASH), value))
    for figure, low in ((figures[0], 0.0025), (figures[1], 0.05**0.1)):
        norms = {
            id(c.norm): c.norm for ax in panels(figure) for c in ax.collections if c.get_array() is not None
        }
        assert len(norms) == 1
        (norm,) = norms.values()
        assert (norm.vmin, norm.vmax) == (pytest.approx(low), pytest.approx(3.0))
        assert (type(norm).__name__ == "LogNorm") == (figure is figures[0])


@pytest.mark.slow
def test_axes_are_in_units_that_engineers_read_and_cells_lie_around_their_values(figures: list[Any]) -> None:
    angle = {
        "name": "angle",
        "path": "meshes.0.pressure_angle",
        "low": "14.5 deg",
        "high": "25 deg",
        "count": 3,
    }
    pictures_of(*made(plan_of(SPEED, angle, reduce=[RMS])))
    pictures_of(*made(plan_of(MODEL, PLAY, BACKLASH, reduce=[RMS])))
    speed, play = (panels(figure)[0] for figure in (figures[0], figures[3]))
    assert (speed.get_xlabel(), speed.get_ylabel()) == ("speed [rpm]", "angle [deg]")
    assert (play.get_xlabel(), play.get_ylabel()) == ("play [µm]", "b [µm]")
    assert figures[0].axes[-1].get_ylabel().replace("\n", " ").endswith("along x, ring [m/s²]")
    assert play.get_yscale() == "log"
    assert play.get_xlim() == pytest.approx((0.0, 300.0 + 290.0 / 6.0))  # not below 0
    assert play.get_ylim() == pytest.approx((20.0 / 20.0**0.25, 400.0 * 20.0**0.25))
    corners = next(c for c in speed.collections if c.get_array() is not None).get_coordinates()
    assert corners[0, :, 0].tolist() == pytest.approx([30.0, 90.0, 150.0, 210.0, 270.0, 330.0])


@pytest.mark.slow
def test_order_map__the_mesh_line_is_at_its_order(figures: list[Any]) -> None:
    def value(kept: Any, values: Mapping[str, Any], member: int) -> Any:
        mesh = 20.0 * values["speed"] / (2.0 * math.pi)
        return 1e-3 + (np.abs(np.array(kept.grid) - 2.0 * mesh) <= 0.51)

    pictures_of(*made(plan_of(SPEED, reduce=[SPECTRUM]), value))
    waterfall, orders = (
        next(c for c in panels(f)[0].collections if c.get_array() is not None) for f in figures
    )
    for mesh, row in zip((20.0, 40.0, 60.0, 80.0, 100.0), waterfall.get_array(), strict=True):
        assert 0.5 + int(np.argmax(row)) == pytest.approx(2.0 * mesh, abs=1.0)
    edges = orders.get_coordinates()[0, :, 0]
    for mesh, row in zip((20.0, 40.0, 60.0, 80.0, 100.0), orders.get_array(), strict=True):
        bright = 0.5 * (edges[1:] + edges[:-1])[row > 0.5]
        assert np.abs(bright - 2.0).max() <= 0.5 / mesh + np.diff(edges).max()
    lines = {float(np.ptp(line.get_ydata() / line.get_xdata())) for line in panels(figures[0])[0].lines}
    assert len(panels(figures[0])[0].lines) == 3
    assert max(lines) < 1e-9  # straight through the origin: order k is k times 20 teeth
    assert [line.get_xdata()[0] for line in panels(figures[1])[0].lines] == [1, 2, 3]


@pytest.mark.slow
def test_up_and_down_differ_where_it_is_more_than_the_spread(figures: list[Any]) -> None:
    def value(kept: Any, values: Mapping[str, Any], member: int) -> float:
        apart = 1.0 if 15.0 < values["speed"] < 20.0 else 0.1
        return values["speed"] + apart * (values["direction"] == "up") + 0.1 * (member - 1.5)

    plan = plan_of(
        SPEED, carry={"axis": "speed"}, members=4, reduce=[RMS], set={**SHORT, "run.transient": 0.2}
    )
    sweep, dataset = made(plan, value)
    assert [each.name for each in pictures_of(sweep, dataset)] == ["hysteresis-1"]
    pictures_of(sweep, dataset.isel(member=0))
    with_spread, without = (panels(figure)[0] for figure in figures)
    bars = [c for c in with_spread.collections if type(c).__name__ == "LineCollection"]
    ((low, high),) = bars[0].get_segments()
    assert (low[0], high[0], low[1] - high[1]) == (
        pytest.approx(180.0),
        pytest.approx(180.0),
        pytest.approx(1.0),
    )
    assert [text.get_text() for text in figures[0].legends[0].get_texts()] == [
        "up →", "← down", "differ (95 %)",
    ]  # fmt: skip
    assert not any(len(c.get_segments()) for c in without.collections if type(c).__name__ == "LineCollection")


@pytest.mark.slow
def test_a_dataset_put_together_by_hand_has_its_directions_drawn() -> None:
    sweep, up = made(plan_of(MODEL, SPEED, reduce=[RMS]))
    both = xr.concat([up, up.assign(rms=2.0 * up.rms)], dim="direction")
    dataset = both.assign_coords(direction=["up", "down"])
    assert [each.name for each in pictures_of(sweep, dataset)] == ["hysteresis-1-1", "hysteresis-1-2"]


@pytest.mark.slow
def test_parallel_coordinates_draw_some_of_many_cases_and_always_the_same(figures: list[Any]) -> None:
    plan = plan_of(design={**DESIGN, "count": 2500}, reduce=[RMS])
    sweep, dataset = made(plan, lambda k, values, member: values["speed"])
    first, again = (pictures_of(sweep, dataset) for _ in range(2))
    assert first == again
    ax = panels(figures[1])[0]
    rest, low, high = (np.array(each.get_segments()) for each in ax.collections)
    assert (len(rest), len(low), len(high)) == (400, 150, 150)
    assert rest.shape[1:] == (4, 2)
    assert min(part[..., 1].min() for part in (rest, low, high)) >= 0.0
    assert max(part[..., 1].max() for part in (rest, low, high)) <= 1.0
    assert high[:, 0, 1].min() > low[:, 0, 1].max()  # the numbers rise with the first axis
    told = [text.get_text() for text in figures[1].legends[0].get_texts()]
    assert told[0].startswith("lowest tenth: ")
    assert told[1].startswith("highest tenth: ")
    assert "2000 of 2500 cases" in figures[1].get_suptitle()


def test_the_band_of_a_curve_is_the_range_of_its_members(figures: list[Any]) -> None:
    pictures_of(
        *made(plan_of(SPEED, members=3, reduce=[RMS]), lambda k, v, member: v["speed"] * (1.0 + member))
    )
    ax = panels(figures[0])[0]
    assert ax.lines[0].get_ydata() == pytest.approx(2.0 * ax.lines[0].get_xdata() * math.pi / 30.0)
    corners = ax.collections[0].get_paths()[0].vertices
    ratio = corners[:, 1] / (corners[:, 0] * math.pi / 30.0)
    assert (ratio.min(), ratio.max()) == (pytest.approx(1.0), pytest.approx(3.0))
