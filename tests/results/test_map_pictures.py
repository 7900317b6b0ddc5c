"""Maps keep the largest of each pixel: a line one cell wide is seen at its height, wherever it lies."""

import io
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm
from matplotlib.image import imread

from gearplay.files.record import Channel
from gearplay.pictures import panels as figure_panels
from gearplay.pictures.canvas import make_figure, to_png
from gearplay.pictures.style import new_axes
from gearplay.signals.figures import plot_order_map, plot_spectrogram
from gearplay.signals.orders import order_map
from gearplay.signals.spectrograms import spectrogram
from gearplay.sweeps.report.drawable import View
from gearplay.sweeps.report.maps import draw_cells, map_figure
from gearplay.sweeps.report.spectra import _over_orders
from sweep_products import RMS, SPEED, made, plan_of

BRIGHT = np.array([253, 231, 37]) / 255.0  # the top of viridis
RATE = 51_200.0


def bright_pixels(figure: Any, bar: bool = True) -> int:
    """Return how many pixels have the colour of the largest value, left of the bar of colour."""
    picture = imread(io.BytesIO(to_png(figure)))[..., :3]
    picture = picture[:, : int(0.82 * picture.shape[1])] if bar else picture
    return int(np.count_nonzero(np.abs(picture - BRIGHT).max(axis=-1) < 0.02))


@pytest.mark.slow
@pytest.mark.parametrize("order", [23.0, 23.37, 141.02])
def test_a_single_order_is_seen_at_its_height(order: float) -> None:
    """An order of 1.99 over noise, in a map of thousands of orders, as the highest of all pixels."""
    time = np.arange(int(8.0 * RATE)) / RATE
    noise = 1e-3 * np.random.default_rng(3).standard_normal(time.size)
    channel = Channel("case", 1.99 * np.cos(2.0 * np.pi * 25.0 * order * time) + noise, RATE, "g")
    found = order_map(channel, 2.0 * np.pi * 25.0, highest=300.0, revolutions=20.0)
    assert found.order.size > 4000
    ax = plot_order_map(new_axes(), found)
    assert np.max(ax.collections[0].get_array()) == pytest.approx(found.amplitude.max())
    assert bright_pixels(ax.figure) > 30


def test_cells_of_few_values_stand_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Over two backlashes: a tick at each and a white line between, none along the 12 speeds."""
    drawn: list[Any] = []
    monkeypatch.setattr(figure_panels, "to_png", drawn.append)
    two = {"name": "b", "path": "meshes.0.backlash", "values": ["20 um", "200 um"]}
    product = made(plan_of({**SPEED, "count": 12}, two, reduce=[RMS]))
    map_figure(View(*product), "rms", "speed", "b")
    ax = drawn[0].axes[0]
    assert ax.get_yticks().tolist() == pytest.approx([20.0, 200.0])
    assert [label.get_text() for label in ax.get_yticklabels()] == ["20", "200"]
    (between,) = [each for each in ax.collections if isinstance(each, LineCollection)]
    assert np.array(between.get_segments())[:, :, 1] == pytest.approx(110.0)
    assert len(ax.get_xticks()) != 12


@pytest.mark.slow
def test_a_shock_is_seen_in_a_spectrogram() -> None:
    values = 1e-3 * np.random.default_rng(4).standard_normal(int(30.0 * RATE))
    values[1_234_567] = 50.0
    found = spectrogram(Channel("shock", values, RATE, "m/s^2"), segment=512)
    assert found.time.size > 5000
    assert bright_pixels(plot_spectrogram(new_axes(), found).figure) > 30


@pytest.mark.slow
@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize("place", [(1234, 17), (2979, 2979)])
def test_a_cell_of_a_sweep_is_seen(place: tuple[int, int], log: bool) -> None:
    """One cell of nine millions, on axes that are linear or logarithmic."""
    table = np.full((3000, 3000), 1.0)
    table[place] = 1e3
    table[7, 7:9] = np.nan
    edges = np.geomspace(1.0, 1e3, 3001) if log else np.linspace(0.0, 1.0, 3001)
    figure, axes = make_figure(1, 1, 4.0)
    picture = draw_cells(axes[0, 0], edges, edges, table, LogNorm(1.0, 1e3), log=(log, log))
    if log:
        axes[0, 0].set_xscale("log")
        axes[0, 0].set_yscale("log")
    axes[0, 0].set(xlim=(edges[0], edges[-1]), ylim=(edges[0], edges[-1]))
    assert np.nanmax(picture.get_array()) == 1e3
    axes[0, 0].set(xlabel="speed [rpm]", ylabel="backlash [µm]")
    assert bright_pixels(figure, bar=False) >= 1


def test_orders_of_a_sweep_keep_the_largest_band() -> None:
    """Cells of orders that hold many bands have the largest of them; cells within one band have that."""
    table = np.array([[1.0, 5.0, 2.0, 1.0], [3.0, 3.0, 3.0, 9.0]])
    edges = np.arange(5.0)
    found = _over_orders(table, np.array([1.0, 2.0]), edges, np.array([0.0, 2.0, 4.0]))
    assert np.array_equal(found, [[5.0, 2.0], [9.0, np.nan]], equal_nan=True)
    fine = _over_orders(table[:1], np.array([1.0]), edges, np.array([1.0, 1.25, 1.5]))
    assert np.array_equal(fine, [[5.0, 5.0]])
