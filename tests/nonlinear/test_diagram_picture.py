"""The picture of a bifurcation diagram, of few points and of many."""

from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg

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
