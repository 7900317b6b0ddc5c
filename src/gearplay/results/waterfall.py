"""Waterfall of spectra over successive time windows of a run."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model.variables import RESULT_VARIABLES
from gearplay.pictures.canvas import SMALL, make_figure, set_title
from gearplay.pictures.extremes import extremes
from gearplay.pictures.style import COUPLED, mark_lines
from gearplay.pictures.words import plain, shown_in
from gearplay.results.choice import cut
from gearplay.results.figures import Window, key_of
from gearplay.results.lines import line_marks, mesh_lines
from gearplay.results.spectra import amplitude_spectrum
from gearplay.results.titles import case_words, window_words
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.results.result import Result

ORDERS = 6.5
"""Mesh orders that are drawn."""
STRETCHES = 20
"""At most."""
PERIODS = 12.0
"""Mesh periods of a stretch, at least, so that its lines stand apart."""
LEAST = 64
"""Samples of a stretch, at least."""
HEIGHT = 2.5
"""The highest line, in distances between two spectra."""
POINTS = 1500


def waterfall_figure(result: "Result", signal: str, label: str, window: Window) -> Any:
    """Return a figure of the amplitude spectra of successive stretches of a signal, the time of each at the ordinate.

    Raises `InputError` for a window that is too short for two stretches.
    """
    t, v = cut(result, signal, label, window)
    lines = mesh_lines(result.case)
    least = max(LEAST, round(PERIODS / min(lines.values()) * result.sampling)) if lines else LEAST
    count = min(STRETCHES, t.size // least)
    if count < 2:
        rule = f"must hold two stretches of {least / result.sampling:.3g} s for a waterfall"
        raise InputError(Fault("window", f"{window[1] - window[0]:.4g} s", rule, "Choose more of the run"))
    quantity = RESULT_VARIABLES[signal]
    size = t.size // count
    spectra = [
        amplitude_spectrum(v[k * size : (k + 1) * size], result.sampling, unit=quantity.unit)
        for k in range(count)
    ]
    frequency = spectra[0].frequency
    highest = ORDERS * max(lines.values()) if lines else float(frequency[-1])
    kept = (frequency > 0.0) & (frequency <= max(highest, 40.0 * spectra[0].resolution))
    peak = max(float(np.max(each.amplitude[kept], initial=0.0)) for each in spectra)
    unit, factor = shown_in(quantity.unit, peak)
    figure, axes = make_figure(1, 1, 5.6)
    ax, between = axes[0, 0], size / result.sampling
    for k, each in reversed(list(enumerate(spectra))):
        base = float(t[k * size]) + 0.5 * between
        height = HEIGHT * between / peak if peak > 0.0 else 0.0
        f, a = extremes(frequency[kept], base + height * each.amplitude[kept], POINTS)
        ax.fill_between(f, base, a, color="white", zorder=2.0 - 0.01 * k, linewidth=0)
        ax.plot(f, a, color=COUPLED, linewidth=0.7, zorder=2.0 - 0.01 * k + 0.005)
    ax.set_xlim(0.0, float(frequency[kept][-1]))
    ax.set_ylim(float(t[0]), float(t[0]) + (count + HEIGHT + 0.5) * between)
    mark_lines(ax, line_marks(result.case))
    ax.set_xlabel("frequency [Hz]", fontsize=SMALL)
    ax.set_ylabel("middle of the stretch [s]", fontsize=SMALL)
    high = f"the highest line is {factor * peak:.3g} {unit}"
    ax.set_title(plain(f"{label}: {quantity.long_name}; {high}"), fontsize=SMALL, loc="left")
    member = f", the first of {result.members} members" if result.members > 1 else ""
    words = f"{case_words(result.case)}: amplitude spectra of {between:.3g} s each, {window_words(window)}"
    set_title(figure, (words + member + key_of(result.case)).replace(" um", " µm"))
    return figure
