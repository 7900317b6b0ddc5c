"""Plotting methods of one result."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gearplay.model.variables import RESULT_VARIABLES
from gearplay.parts.mesh.train.geometry import carrier_of
from gearplay.pictures.canvas import SMALL, set_title
from gearplay.pictures.style import new_axes
from gearplay.results.choice import free_rotors, time_window
from gearplay.results.figures import Window, close_up, draw_history, draw_orbit, draw_spectrum, key_of
from gearplay.results.titles import case_words, window_words
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gearplay.results.result import Result


class Plotter:
    """Pictures of a result; every method returns the axes it drew on. Called itself it draws the default picture.

    A figure of its own is titled with the case, its changes, the signal and the time window; the axes with the element.

    Examples
    --------
    >>> import gearplay as gp
    >>> result = gp.simulate("han2021", duration=0.1, transient=0.0)
    >>> result.plot.history("backlash").get_xlabel(), result.plot().get_title(loc="left").split()[0]
    ('time [s]', 'ring')

    """

    def __init__(self, result: Result) -> None:
        self._result = result

    def __call__(self, *, ax: Axes | None = None) -> Axes:
        """Draw the orbit of the first rotor in a sleeve; without sleeves the first signal over time."""
        held = {label for signal, label in self._result.held("x")}
        free = set(free_rotors(self._result.case))
        rotor = next((name for name in self._result.case.sleeves if name in held & free), None)
        if rotor is None:
            return self.history(*self._result.held()[-1], ax=ax)
        return self.orbit(rotor, ax=ax)

    def history(
        self,
        signal: str,
        label: str | None = None,
        *,
        member: int = 0,
        window: tuple[float | None, float | None] | None = None,
        ax: Axes | None = None,
    ) -> Axes:
        """Draw a signal over time for one member; of many samples the lowest and highest, so that no impact is lost.

        Parameters
        ----------
        signal, label
            What to draw, and of which element where several have it.
        member
            Of an ensemble.
        window
            Its two ends [s], None for an open one; of a result that is long the ten mesh periods about the largest value if not
            given. ``(None, None)`` is the whole of it.
        ax
            Where to draw, its own figure if None.

        """
        signal, label = self._result.only(signal, label)
        whole = time_window(self._result, window)
        span = (close_up(self._result, (signal, label), whole, member) if window is None else None) or whole
        axes = ax if ax is not None else new_axes()
        draw_history(axes, self._result, signal, label, span, member)
        axes.set_xlabel("time [s]", fontsize=SMALL)
        more = f", of {window_words(whole)}" if span != whole else ""
        return self._titled(axes, RESULT_VARIABLES[signal].long_name, span, more, member, own=ax is None)

    def orbit(self, rotor: str, *, member: int = 0, ax: Axes | None = None) -> Axes:
        """Draw the path of a rotor's centre in its clearance circle; a path as small as a dot is magnified next to it.

        A carried rotor, such as a planet, is drawn relative to its pin, in axes that turn with the actual carrier. Raises
        `InputError` for a rotor whose centre cannot move.
        """
        free = free_rotors(self._result.case)
        if rotor not in free and carrier_of(self._result.case, rotor) is None:
            rule = "must be a rotor whose centre can move, for an orbit"
            cure = f"Choose from: {', '.join(free)}" if free else "Draw a history"
            raise InputError.of("rotor", rotor, rule, cure)
        axes, span = ax if ax is not None else new_axes(5.0, 5.4), time_window(self._result, None)
        draw_orbit(axes, self._result, rotor, span, member)
        return self._titled(axes, "path of the centre", span, "", member, own=ax is None)

    def spectrum(
        self, signal: str, label: str | None = None, *, highest: float | None = None, ax: Axes | None = None
    ) -> Axes:
        """Draw the amplitude spectrum of a signal, of the members that reached their end, mesh orders and shafts marked.

        It goes up to ``highest`` [Hz], if not given to a dozen mesh orders.
        """
        signal, label = self._result.only(signal, label)
        axes, span = ax if ax is not None else new_axes(), time_window(self._result, None)
        draw_spectrum(axes, self._result, signal, label, span, highest=highest)
        what = f"amplitude spectrum of the {RESULT_VARIABLES[signal].long_name}"
        return self._titled(axes, what, span, key_of(self._result.case), None, own=ax is None)

    def _titled(self, ax: Axes, what: str, span: Window, more: str, member: int | None, *, own: bool) -> Axes:
        """Write the case and the time over a figure of its own."""
        if own:
            of = f", member {member}" if member is not None and self._result.members > 1 else ""
            text = f"{case_words(self._result.case)}: {what}, {window_words(span)}{more}{of}"
            set_title(ax.figure, text)
        return ax
