"""Pictures of one result; each draws on a given ``ax`` and labels it with units."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.variables import RESULT_VARIABLES
from gearplay.pictures.extremes import extremes, thinned_path
from gearplay.pictures.words import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

COUPLED, UNCOUPLED, TEST, CLEARANCE = "#0b5fa5", "#c8641b", "#222222", "#8a8f98"
MOST_POINTS = 20_000


def new_axes(width: float = 7.0, height: float = 4.0) -> "Axes":
    """Return axes of a new figure [inches] in the house style, without touching matplotlib's global state."""
    ax: Axes = tidy(blank_figure(width, height).subplots())
    return ax


def blank_figure(width: float, height: float) -> Any:
    """Return an empty figure [inches] that PNG can be made of."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def tidy(ax: Any) -> Any:
    """Give axes the house style."""
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(True, color="#e4e6ea", linewidth=0.6)
    ax.set_axisbelow(True)
    ax.tick_params(labelsize=8)
    return ax


def plot_orbit(ax: "Axes", x: Floats, y: Floats, clearance: float, *, color: str = COUPLED) -> "Axes":
    """Draw the path of a shaft's centre x, y [m] in its clearance circle of radius ``clearance`` [m], in um."""
    x, y = thinned_path(np.asarray(x), np.asarray(y), MOST_POINTS)
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    ax.plot(1e6 * clearance * np.cos(angle), 1e6 * clearance * np.sin(angle), color=CLEARANCE, linewidth=1.0)
    ax.plot(1e6 * x, 1e6 * y, color=color, linewidth=0.6)
    ax.set_aspect("equal")
    ax.set_xlabel("x [µm]", fontsize=8)
    ax.set_ylabel("y [µm]", fontsize=8)
    return ax


def plot_history(
    ax: "Axes", time: Floats, values: Floats, signal: str, *, color: str = COUPLED, label: str | None = None
) -> "Axes":
    """Draw one signal over time [s] in its display unit."""
    quantity = RESULT_VARIABLES[signal]
    words = f"{quantity.long_name} [{quantity.display_unit}]".replace("um]", "µm]")
    return plot_curve(ax, time, quantity.display_factor * np.asarray(values), words, color=color, label=label)


def plot_curve(
    ax: "Axes", time: Floats, values: Floats, words: str, *, color: str = COUPLED, label: str | None = None
) -> "Axes":
    """Draw values over time [s]; of many the lowest and the highest of each stretch, so that no impact is lost."""
    t, v = extremes(np.asarray(time), np.asarray(values), MOST_POINTS // 2)
    ax.plot(t, v, color=color, linewidth=0.7, label=plain(label) if label else None)
    ax.set_xlabel("time [s]", fontsize=8)
    ax.set_ylabel(plain(words), fontsize=8)
    return ax


def plot_spectrum(
    ax: "Axes",
    frequency: Floats,
    amplitude: Floats,
    unit: str,
    *,
    color: str = COUPLED,
    label: str | None = None,
    highest: float | None = None,
) -> "Axes":
    """Draw an amplitude spectrum on a logarithmic ordinate; ``highest`` [Hz] ends the abscissa."""
    f, a = np.asarray(frequency)[1:], np.asarray(amplitude)[1:]
    if highest is not None:
        f, a = f[f <= highest], a[f <= highest]
    draw = ax.semilogy if np.any(a > 0.0) else ax.plot  # a rotor at rest has no decades
    draw(f, a, color=color, linewidth=0.7, label=plain(label) if label else None)
    ax.set_xlabel("frequency [Hz]", fontsize=8)
    ax.set_ylabel(f"amplitude [{unit}]", fontsize=8)
    return ax
