"""Pictures of one result."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gearplay.model.case import Case
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.pictures.style import new_axes, plot_history, plot_orbit, plot_spectrum
from gearplay.results.spectra import Spectrum, ensemble_spectrum
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
