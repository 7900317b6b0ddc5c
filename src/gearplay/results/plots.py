"""Pictures of one result."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gearplay.model.variables import RESULT_VARIABLES
from gearplay.pictures.style import new_axes, plot_history, plot_orbit, plot_spectrum

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gearplay.results.result import Result


class Plotter:
    """Pictures of a result; every method returns the axes it drew on. Called itself it draws the one that says most.

    Examples
    --------
    >>> import gearplay as gp
    >>> result = gp.simulate("han2021", duration=0.1, transient=0.0)
    >>> result.plot.history("backlash").get_xlabel(), result.plot().get_title()
    ('time [s]', 'ring')

    """

    def __init__(self, result: Result) -> None:
        self._result = result

    def __call__(self, *, ax: Axes | None = None) -> Axes:
        """Draw the orbit of the first rotor in a sleeve; without sleeves the first signal over time."""
        held = {label for signal, label in self._result.held("x")}
        rotor = next((name for name in self._result.case.sleeves if name in held), None)
        if rotor is None:
            return self.history(*self._result.held()[-1], ax=ax)
        drawn = self.orbit(rotor, ax=ax)
        drawn.set_title(rotor, fontsize=9)
        return drawn

    def history(
        self, signal: str, label: str | None = None, *, member: int = 0, ax: Axes | None = None
    ) -> Axes:
        """Draw a signal over time for one member; of many samples the lowest and highest, so that no impact is lost."""
        signal, label = self._result.only(signal, label)
        values = self._result.signal(signal, label, member)
        time = self._result.time(member)
        return plot_history(ax if ax is not None else new_axes(), time, values, signal, label=label)

    def orbit(self, rotor: str, *, member: int = 0, ax: Axes | None = None) -> Axes:
        """Draw the path of a rotor's centre in its clearance circle."""
        x, y = (self._result.signal(name, rotor, member) for name in ("x", "y"))
        sleeve = self._result.case.operating.sleeves.get(rotor)
        clearance = sleeve.radial_clearance if sleeve is not None else 0.0
        return plot_orbit(ax if ax is not None else new_axes(5.0, 5.0), x, y, clearance)

    def spectrum(
        self, signal: str, label: str | None = None, *, highest: float | None = None, ax: Axes | None = None
    ) -> Axes:
        """Draw the amplitude spectrum of a signal, of the members that reached their end, up to ``highest`` [Hz]."""
        signal, label = self._result.only(signal, label)
        s = self._result.spectrum(signal, label=label)
        unit = RESULT_VARIABLES[signal].unit
        axes = ax if ax is not None else new_axes()
        return plot_spectrum(axes, s.frequency, s.amplitude, unit, label=label, highest=highest)
