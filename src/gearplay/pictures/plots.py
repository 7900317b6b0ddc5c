"""Pictures of one result; each draws on a given ``ax`` and labels it with units."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.solver.trajectory import Trajectory
from gearplay.results.spectra import Spectrum, ensemble_spectrum
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

COUPLED, UNCOUPLED, TEST, CLEARANCE = "#0b5fa5", "#c8641b", "#222222", "#8a8f98"
MOST_POINTS = 20_000


def plain(text: str) -> str:
    """Return user text that matplotlib shows as it is: ``$`` starts no formula."""
    return text.replace("$", r"\$")


def new_axes(width: float = 7.0, height: float = 4.0) -> "Axes":
    """Return axes of a new figure [inches] in the house style, without touching matplotlib's global state."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    ax: Axes = tidy(figure.subplots())
    return ax


def tidy(ax: Any) -> Any:
    """Give axes the house style."""
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(True, color="#e4e6ea", linewidth=0.6)
    ax.set_axisbelow(True)
    ax.tick_params(labelsize=8)
    return ax


def thinned(*columns: Floats) -> list[Floats]:
    """Return every n-th point, so that a picture holds at most `MOST_POINTS`."""
    step = max(1, -(-len(columns[0]) // MOST_POINTS))
    return [column[::step] for column in columns]


def plot_orbit(ax: "Axes", x: Floats, y: Floats, clearance: float, *, color: str = COUPLED) -> "Axes":
    """Draw the path of a shaft's centre x, y [m] in its clearance circle of radius ``clearance`` [m], in um."""
    x, y = thinned(np.asarray(x), np.asarray(y))
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
    t, v = thinned(np.asarray(time), np.asarray(values))
    ax.plot(t, quantity.display_factor * v, color=color, linewidth=0.7, label=plain(label) if label else None)
    ax.set_xlabel("time [s]", fontsize=8)
    ax.set_ylabel(f"{quantity.long_name} [{quantity.display_unit}]".replace("um]", "µm]"), fontsize=8)
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


class Plotter:
    """Pictures of a result; every method returns the axes it drew on."""

    def __init__(self, case: Case, runs: Sequence[Trajectory]) -> None:
        self._case, self._runs = case, runs

    def _only(self, signal: str, label: str | None) -> str:
        held = [c.label for c in self._runs[0].columns if c.signal == signal]
        if label is None and len(held) == 1:
            return held[0]
        if label not in held:
            raise InputError(
                [
                    Fault(
                        "plot",
                        f"{label}.{signal}",
                        "must name a signal that was kept",
                        f"Choose one of: {', '.join(held) or 'none'}.",
                    )
                ]
            )
        return str(label)

    def history(
        self, signal: str, label: str | None = None, *, member: int = 0, ax: "Axes | None" = None
    ) -> "Axes":
        """Draw a signal over time for the member at place ``member``."""
        label = self._only(signal, label)
        run = self._runs[member]
        return plot_history(
            ax if ax is not None else new_axes(), run.time, run.signal(signal, label), signal, label=label
        )

    def orbit(self, rotor: str, *, member: int = 0, ax: "Axes | None" = None) -> "Axes":
        """Draw the path of a rotor's centre in its clearance circle."""
        self._only("x", rotor)
        run, sleeve = self._runs[member], self._case.sleeves.get(rotor)
        clearance = sleeve.radial_clearance if sleeve is not None else 0.0
        return plot_orbit(
            ax if ax is not None else new_axes(5.0, 5.0),
            run.signal("x", rotor),
            run.signal("y", rotor),
            clearance,
        )

    def spectrum(
        self, signal: str, label: str | None = None, *, highest: float | None = None, ax: "Axes | None" = None
    ) -> "Axes":
        """Draw the ensemble's amplitude spectrum of a signal."""
        label = self._only(signal, label)
        step = float(self._runs[0].time[1] - self._runs[0].time[0])
        s: Spectrum = ensemble_spectrum([r.signal(signal, label) for r in self._runs], 1.0 / step)
        unit = RESULT_VARIABLES[signal].unit
        return plot_spectrum(
            ax if ax is not None else new_axes(), s.frequency, s.amplitude, unit, label=label, highest=highest
        )
