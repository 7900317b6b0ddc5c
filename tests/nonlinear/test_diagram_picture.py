"""The picture of a bifurcation diagram, of few points and of many."""

from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg

import gearplay as gp
from gearplay.nonlinear.figures import FEW_POINTS, bifurcation_drawing
from gearplay.pictures.canvas import PALETTE
from pictures import APART, BLIND, seen_as


def diagram(values: int, keep: int) -> xr.Dataset:
    """Return sections of two ways that fork, the lower half up, the upper half down."""
    x = np.linspace(10.0, 20.0, values)
    spread = np.linspace(0.0, 1.0, keep)[None, :] * (x[:, None] - 9.0)
    both = np.stack([1e-6 * (1.0 + spread), -1e-6 * (1.0 + spread)])
    words = {"units": "m", "long_name": "centre along x, ring"}
    axis = ("speed", x, {"units": "rad/s", "long_name": "speed of the pinion"})
    return xr.Dataset(
        {"ring.x": (("direction", "speed", "section"), both, words)},
        coords={"direction": ["up", "down"], "speed": axis},
        attrs={"title": "forks"},
    )


@pytest.mark.parametrize("keep", [30, 50, 60, 120])
def test_no_number_of_points_leaves_it_blank(keep: int) -> None:
    """From 3000 points on their marks were once drawn without faces, of no width: nothing was seen."""
    figure = bifurcation_drawing(diagram(60, keep), ["ring.x"])
    assert (60 * keep > FEW_POINTS) == (keep > 50)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    box = figure.axes[0].get_window_extent()
    pixels = (
        np.asarray(canvas.buffer_rgba())[::-1, :, :3][int(box.y0) : int(box.y1), int(box.x0) : int(box.x1)]
        / 255.0
    )
    for color in (np.array([11, 95, 165]) / 255.0, np.array([200, 100, 27]) / 255.0):
        near = np.abs(pixels - color).max(axis=2) < 0.25
        assert np.count_nonzero(near) > 300


def test_line_colours__are_distinct_for_the_colour_blind() -> None:
    for eyes in BLIND.values():
        seen = [seen_as(color, eyes) for color in PALETTE]
        assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > APART


@pytest.mark.parametrize(("values", "least", "most"), [(60, 2.5, 3.0), (1000, 1.2, 1.2)])
def test_size_of_dots_follows_the_number_of_values(values: int, least: float, most: float) -> None:
    """60 columns of dots of 1.2 points are all but invisible; 1000 columns of 3 points overlap."""
    axes = bifurcation_drawing(diagram(values, 60), ["ring.x"]).axes[0]
    assert all(least <= line.get_markersize() <= most for line in axes.lines)


def test_message__range_in_the_unit_of_the_axis() -> None:
    found = gp.bifurcation(
        "pulsating-pair", "rotors.pinion.drive.speed", ["600 rpm", "900 rpm"], ["gear.x"], settle=1, keep=1
    )
    assert "rotors.pinion.drive.speed from 600 to 900 rpm, 2 values" in found.message


def test_title__of_the_torsional_pair_has_no_frequency() -> None:
    """Over the frequency, the title named that of the first value only."""
    pair = gp.torsional_pair(0.45, force=0.05)
    found = gp.bifurcation(pair, "torsional_pair.frequency", [0.45, 0.5], ["x"], settle=1, keep=1)
    title = found.plot()._suptitle.get_text()
    assert title == "Torsional pair: sections over torsional_pair.frequency"
