"""The path of a shaft's centre in its clearance circle, as the pixels have it."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb

from gearplay.pictures.style import CLEARANCE, COUPLED, new_axes, plot_orbit

CIRCLE = 100e-6


def pixels(x: np.ndarray, y: np.ndarray, color: str) -> int:
    """Return how many pixels of a drawn orbit are near a colour."""
    figure, ax = plt.subplots(figsize=(3, 3), dpi=300)
    try:
        plot_orbit(ax, x, y, CIRCLE)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        shown = np.asarray(canvas.buffer_rgba())[..., :3] / 255.0
    finally:
        plt.close(figure)
    return int(np.count_nonzero(np.abs(shown - to_rgb(color)).max(axis=-1) < 0.12))


def test_a_path_that_lies_on_the_circle_is_seen() -> None:
    angle = np.linspace(0.4, 1.2, 200)
    assert pixels(CIRCLE * np.cos(angle), CIRCLE * np.sin(angle), COUPLED) > 40


def test_the_circle_is_seen_on_a_path_that_fills_it() -> None:
    angle = np.linspace(0.0, 600.0, 20_000)
    reach = 1.1 * CIRCLE * np.sqrt(np.linspace(0.0, 1.0, angle.size))
    assert pixels(reach * np.cos(angle), reach * np.sin(angle), CLEARANCE) > 40


@pytest.mark.parametrize("clearance", [0.0, CIRCLE])
def test_a_still_centre__is_drawn_without_a_warning(
    clearance: float, caplog: pytest.LogCaptureFixture
) -> None:
    """Limits around a dot are fixed, so that equal scales fit the box to them instead of moving them."""
    ax = new_axes(9.0, 3.0)
    plot_orbit(ax, np.zeros(100), np.zeros(100), clearance)
    limits = ax.get_xlim(), ax.get_ylim()
    ax.figure.canvas.draw()
    assert caplog.records == []
    assert (ax.get_xlim(), ax.get_ylim()) == limits
