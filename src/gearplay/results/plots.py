"""Plotting methods of one result."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gearplay.model.geometry import carrier_of
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.pictures.canvas import set_title
from gearplay.pictures.style import new_axes, plot_history, plot_spectrum
from gearplay.pictures.words import plain
from gearplay.results.choice import cut, free_rotors, stretch
from gearplay.results.figures import ORDERS, close_up, draw_orbit, key_of
from gearplay.results.lines import line_marks, mesh_lines
from gearplay.results.titles import case_words, window_words
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gearplay.results.result import Result


class Plotter:
    """Pictures of a result; every method returns the axes it drew on. Called itself it draws the default picture.

    A figure of its own is titled with the case, what was changed of it, the element and the stretch of time; axes that are
    given get a title of the element alone.

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
        whole = stretch(self._result, window)
        span = (close_up(self._result, (signal, label), whole, member) if window is None else None) or whole
        time, values = cut(self._result, signal, label, span, member)
        axes = plot_history(ax if ax is not None else new_axes(), time, values, signal, label=label)
        axes.set_xlim(*span)
        what = RESULT_VARIABLES[signal].long_name
        beside = f", of {window_words(whole)}" if span != whole else ""
        return self._titled(axes, label, what, window_words(span) + beside, member, own=ax is None)

    def orbit(self, rotor: str, *, member: int = 0, ax: Axes | None = None) -> Axes:
        """Draw the path of a rotor's centre in its clearance circle; a path as small as a dot is magnified next to it.

        A carried rotor, such as a planet, is drawn relative to its pin, in axes that turn with the actual carrier. Raises
        `InputError` for a rotor whose centre cannot move.
        """
        free = free_rotors(self._result.case)
        if rotor not in free and carrier_of(self._result.case, rotor) is None:
            rule = "must be a rotor whose centre can move, for an orbit"
            cure = f"Choose from: {', '.join(free)}" if free else "Draw a history"
            raise InputError(Fault("rotor", rotor, rule, cure))
        axes, span = ax if ax is not None else new_axes(5.0, 5.4), stretch(self._result, None)
        draw_orbit(axes, self._result, rotor, span, member)
        return self._headed(axes, "path of the centre", window_words(span), member, own=ax is None)

    def spectrum(
        self, signal: str, label: str | None = None, *, highest: float | None = None, ax: Axes | None = None
    ) -> Axes:
        """Draw the amplitude spectrum of a signal, of the members that reached their end, mesh orders and shafts marked.

        It goes up to ``highest`` [Hz], if not given to a dozen mesh orders.
        """
        signal, label = self._result.only(signal, label)
        s = self._result.spectrum(signal, label=label)
        lines, marks = mesh_lines(self._result.case), line_marks(self._result.case)
        if highest is None and lines:
            highest = max(ORDERS * max(lines.values()), 40.0 * s.resolution)
        unit = RESULT_VARIABLES[signal].unit
        axes = ax if ax is not None else new_axes()
        plot_spectrum(axes, s.frequency, s.amplitude, unit, label=label, highest=highest, marks=marks)
        if np.any(s.amplitude[1:] > 0.0):
            axes.set_ylim(top=6.0 * axes.get_ylim()[1])  # room for the names of lines
        what = f"amplitude spectrum of the {RESULT_VARIABLES[signal].long_name}"
        span = window_words(stretch(self._result, None)) + key_of(self._result.case)
        return self._titled(axes, label, what, span, None, own=ax is None)

    def _titled(self, ax: Axes, label: str, what: str, span: str, member: int | None, *, own: bool) -> Axes:
        """Name the element over its axes, and where the figure is ours the case and the time over all."""
        ax.set_title(plain(label), fontsize=9, loc="left")
        return self._headed(ax, what, span, member, own=own)

    def _headed(self, ax: Axes, what: str, span: str, member: int | None, *, own: bool) -> Axes:
        """Write the case and the time over a figure of ours."""
        if own:
            of = f", member {member}" if member is not None and self._result.members > 1 else ""
            set_title(ax.figure, f"{case_words(self._result.case)}: {what}, {span}{of}".replace(" um", " µm"))
        return ax
