"""Figures of one result and their panels: histories, orbits, spectra, waterfall, overview."""

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model.pack import pack
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.parts.mesh.train.geometry import carrier_of, clearance_of
from gearplay.pictures.canvas import SMALL, make_figure, set_title
from gearplay.pictures.extremes import extremes
from gearplay.pictures.style import (
    COUPLED,
    MOST_POINTS,
    STILL,
    UNCOUPLED,
    is_still,
    mark_lines,
    note_still,
    plot_curve,
    plot_orbit,
    tidy,
    widen_still,
)
from gearplay.pictures.words import axis_label, plain, shown_in, wrapped
from gearplay.results.choice import Chosen, cut, free_rotors, moves
from gearplay.results.lines import line_marks, mesh_lines, mesh_names
from gearplay.results.mechanism import orbit_of
from gearplay.results.output_shaft import scale_of
from gearplay.results.spectra import amplitude_spectrum, ensemble_spectrum
from gearplay.results.titles import case_words, window_words
from gearplay.solver.frames import CarrierFrames
from gearplay.solver.status import Status
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.results.result import Result

Window = tuple[float, float]
PERIODS = 10.0
"""Mesh periods of a close-up."""
LONG = 3.0
"""Length of a window, in close-ups, from which it is drawn complete with the close-up next to it."""
ORDERS = 12.5
"""Mesh orders of a spectrum without a given upper frequency."""
MOST_ORBITS = 9

WATERFALL_ORDERS = 6.5
"""Mesh orders of a waterfall."""
MOST_SEGMENTS = 20
SEGMENT_PERIODS = 12.0
"""Least mesh periods of a segment, so that its lines stand apart."""
LEAST_SAMPLES = 64
"""Least samples of a segment."""
HEIGHT = 2.5
"""Height of the highest line, in distances between two spectra."""
WATERFALL_POINTS = 1500


def draw_history(
    ax: Any,
    result: "Result",
    signal: str,
    label: str,
    window: Window,
    member: int = 0,
    *,
    scale: Window | None = None,
) -> None:
    """Draw a signal within a window as minimum and maximum of segments, in a unit chosen by its maximum within ``scale``."""
    t, v = cut(result, signal, label, window, member)
    quantity = RESULT_VARIABLES[signal]
    scaled = v if scale is None else cut(result, signal, label, scale, member)[1]
    unit, factor = shown_in(quantity.unit, float(np.nanmax(np.abs(scaled), initial=0.0)))
    plot_curve(ax, t, factor * v, "", color=COUPLED)
    ax.set_xlim(*window)
    if is_still(v, quantity.unit):
        widen_still(ax, factor * v, factor * STILL[quantity.unit])
        note_still(ax, quantity.unit, "change")
    _name(ax, signal, label, unit)
    ax.locator_params(axis="x", nbins=5)


def _name(ax: Any, signal: str, label: str, unit: str) -> None:
    """Label a panel's signal: in full in the title, short with its unit at the axis."""
    ax.set_ylabel(axis_label(signal.replace("_", " "), unit), fontsize=SMALL)
    _heading(ax, wrapped(f"{label}: {RESULT_VARIABLES[signal].long_name}", 64))


def _heading(ax: Any, text: str) -> None:
    ax.set_title(plain(text), fontsize=SMALL, loc="left")


def history_figure(result: "Result", chosen: Chosen, window: Window, *, whole: bool = False) -> Any:
    """Return a figure of signals over time, one below the other; of a long window the close-up of its largest value too.

    ``whole`` leaves the close-up out.
    """
    close = None if whole else close_up(result, chosen[0], window)
    spans = [window] if close is None else [window, close]
    figure, axes = make_figure(len(chosen), len(spans), 1.1 + 1.75 * len(chosen))
    for row, (signal, label) in zip(axes, chosen, strict=True):
        for ax, span in zip(row, spans, strict=True):
            draw_history(ax, result, signal, label, span, scale=window)
            ax.set_xlabel("time [s]" if (signal, label) == chosen[-1] else "", fontsize=SMALL)
            ax.locator_params(axis="y", nbins=5)
            ax.locator_params(axis="x", nbins=5 if close is not None else 9)
        if close is not None:
            row[0].axvspan(*close, color=UNCOUPLED, alpha=0.25, linewidth=0)
            row[1].set_ylabel("")
            _heading(row[1], f"close-up, {window_words(close)}")
    title_figure(figure, result, "histories" if len(chosen) > 1 else "history", window)
    return figure


def close_up(result: "Result", one: tuple[str, str], window: Window, member: int = 0) -> Window | None:
    """Return a window of some mesh periods about a signal's largest deviation; None where the given one is not much longer."""
    lines = mesh_lines(result.case)
    length = PERIODS / max(lines.values()) if lines else 0.02 * (window[1] - window[0])
    if window[1] - window[0] < LONG * length:
        return None
    t, v = cut(result, *one, window, member)
    away = np.abs(v - np.median(v))
    at = float(t[int(np.argmax(np.where(np.isfinite(away), away, -1.0)))])
    low = min(max(at - 0.4 * length, window[0]), window[1] - length)
    return low, low + length


def title_figure(figure: Any, result: "Result", what: str, window: Window, more: str = "") -> None:
    """Set the title of a figure: the case, its changes, the content, the time window."""
    if result.members > 1 and "member" not in more:
        more = f", the first of {result.members} members{more}"
    set_title(figure, f"{case_words(result.case)}: {what}, {window_words(window)}{more}")


def key_of(case: Any) -> str:
    """Return the legend of the marked mesh frequencies; empty for a single one."""
    names = mesh_names(case)
    return "; " + ", ".join(f"{short} of {mesh}" for short, mesh in names.items()) if len(names) > 1 else ""


def orbit_figure(result: "Result", rotors: list[str], window: Window) -> Any:
    """Return a figure of the paths of centres in their clearance circles; a path as small as a dot is magnified next to it.

    A rotor on a carrier is drawn in the carrier's frame. Raises `InputError` for rotors that cannot move.
    """
    case = result.case
    free = free_rotors(case)
    drawn = [name for name in rotors or free if name in free][:MOST_ORBITS]
    if not drawn:
        rule = "must have a rotor whose centre can move, for an orbit"
        cure = f"Choose from: {', '.join(free)}" if free else "Draw a history"
        raise InputError.of("at", ", ".join(rotors) or "none", rule, cure)
    columns = min(3, len(drawn))
    rows = -(-len(drawn) // columns)
    width = 5.2 if columns == 1 else 9.0
    figure, axes = make_figure(rows, columns, 0.6 + 9.0 / (columns + (columns == 1)) * rows, width=width)
    for ax in axes.flat[len(drawn) :]:
        ax.set_visible(False)
    for ax, name in zip(axes.flat, drawn, strict=False):
        draw_orbit(ax, result, name, window)
    title_figure(figure, result, "path of the centre" if len(drawn) == 1 else "paths of centres", window)
    return figure


def draw_orbit(ax: Any, result: "Result", rotor: str, window: Window, member: int = 0) -> None:
    """Draw the path of one centre with a title; of a carried rotor relative to its pin, in the carrier's axes."""
    clearance = clearance_of(result.case.operating, rotor) or 0.0
    frames = CarrierFrames(pack(result.case).system)
    x, y = orbit_of(
        result.case, frames, rotor, lambda name, label: cut(result, name, label, window, member)[1]
    )
    plot_orbit(ax, x, y, clearance)
    on = carrier_of(result.case, rotor)
    frame = "\nrelative to its pin, axes of the carrier" if on else ""
    circle = f"\nclearance circle {1e6 * clearance:.4g} µm" if clearance > 0.0 else ""
    _heading(ax, f"{rotor}{frame}{circle}")


def spectrum_figure(result: "Result", chosen: Chosen, window: Window) -> Any:
    """Return a figure of amplitude spectra, one below the other, mesh orders and shafts marked."""
    figure, axes = make_figure(len(chosen), 1, 0.9 + 2.5 * len(chosen))
    for ax, (signal, label) in zip(axes[:, 0], chosen, strict=True):
        draw_spectrum(ax, result, signal, label, window)
    for ax in axes[:-1, 0]:
        ax.set_xlabel("")
    average = f", rms average of {result.members} members" if result.members > 1 else ""
    what = "amplitude spectra" if len(chosen) > 1 else "amplitude spectrum"
    title_figure(figure, result, what, window, average + key_of(result.case))
    return figure


def draw_spectrum(
    ax: Any, result: "Result", signal: str, label: str, window: Window, *, highest: float | None = None
) -> None:
    """Draw the amplitude spectrum of a signal on a logarithmic ordinate of at most six decades, with its lines named.

    It is that of the members that reached their end, up to ``highest`` [Hz], by default a dozen mesh orders.
    """
    complete = [at for at, status in enumerate(result.statuses) if status == Status.DONE] or [0]
    records = [cut(result, signal, label, window, member)[1] for member in complete]
    quantity = RESULT_VARIABLES[signal]
    found = ensemble_spectrum(records, result.sampling, unit=quantity.unit)
    lines = mesh_lines(result.case)
    if highest is None and lines:
        highest = max(ORDERS * max(lines.values()), 40.0 * found.resolution)
    largest = float(np.max(found.amplitude[1:], initial=0.0))
    unit, factor = shown_in(quantity.unit, largest)
    kept = found.frequency[1:] <= (math.inf if highest is None else highest)
    f, a = found.frequency[1:][kept], factor * found.amplitude[1:][kept]
    still = largest <= STILL.get(quantity.unit, 0.0)
    if still:
        ax.set_ylim(0.0, 1.0)
        if quantity.unit in STILL:
            note_still(ax, quantity.unit, "line")
    else:
        ax.semilogy(*extremes(f, a, MOST_POINTS // 2), color=COUPLED, linewidth=0.7)
        low, high = ax.get_ylim()
        ax.set_ylim(max(low, 1e-6 * factor * largest), high * 6.0)  # room for the names of lines
    if f.size:
        ax.set_xlim(0.0, float(f[-1]))
    mark_lines(ax, line_marks(result.case))
    _name(ax, signal, label, unit)
    ax.set_xlabel("frequency [Hz]", fontsize=SMALL)


def waterfall_figure(result: "Result", signal: str, label: str, window: Window) -> Any:
    """Return a figure of the amplitude spectra of successive segments of a signal, each at its time on the ordinate.

    Raises `InputError` for a window that is too short for two segments.
    """
    t, v = cut(result, signal, label, window)
    lines, quantity = mesh_lines(result.case), RESULT_VARIABLES[signal]
    least = LEAST_SAMPLES
    if lines:
        least = max(least, round(SEGMENT_PERIODS / min(lines.values()) * result.sampling))
    count = min(MOST_SEGMENTS, t.size // least)
    if count < 2:
        rule = f"must hold two segments of {least / result.sampling:.3g} s for a waterfall"
        raise InputError.of("window", f"{window[1] - window[0]:.4g} s", rule, "Choose more of the run")
    size = t.size // count
    parts = [v[k * size : (k + 1) * size] for k in range(count)]
    spectra = [amplitude_spectrum(part, result.sampling, unit=quantity.unit) for part in parts]
    frequency = spectra[0].frequency
    highest = WATERFALL_ORDERS * max(lines.values()) if lines else float(frequency[-1])
    kept = (frequency > 0.0) & (frequency <= max(highest, 40.0 * spectra[0].resolution))
    peak = max(float(np.max(each.amplitude[kept], initial=0.0)) for each in spectra)
    unit, factor = shown_in(quantity.unit, peak)
    figure, axes = make_figure(1, 1, 5.6)
    ax, between = axes[0, 0], size / result.sampling
    height = HEIGHT * between / peak if peak > 0.0 else 0.0
    for k, each in reversed(list(enumerate(spectra))):
        base = float(t[k * size]) + 0.5 * between
        f, a = extremes(frequency[kept], base + height * each.amplitude[kept], WATERFALL_POINTS)
        ax.fill_between(f, base, a, color="white", zorder=2.0 - 0.01 * k, linewidth=0)
        ax.plot(f, a, color=COUPLED, linewidth=0.7, zorder=2.0 - 0.01 * k + 0.005)
    ax.set_xlim(0.0, float(frequency[kept][-1]))
    ax.set_ylim(float(t[0]), float(t[0]) + (count + HEIGHT + 0.5) * between)
    mark_lines(ax, line_marks(result.case))
    ax.set_xlabel("frequency [Hz]", fontsize=SMALL)
    ax.set_ylabel("middle of the segment [s]", fontsize=SMALL)
    _heading(ax, f"{label}: {quantity.long_name}; the highest line is {factor * peak:.3g} {unit}")
    title_figure(figure, result, f"amplitude spectra of {between:.3g} s each", window, key_of(result.case))
    return figure


def overview_figure(result: "Result", window: Window) -> Any:
    """Return one figure: transmission error of the output shaft, an orbit, a close-up of mesh forces, backlash, a spectrum."""
    case, held, shaft = result.case, result.held(), result.output
    result.runs[0].compute(
        [("theta", shaft.rotor), ("theta", shaft.input), *((s, n) for n in free_rotors(case) for s in "xy")]
    )
    free = [name for name in free_rotors(case) if moves(result, "x", name) or moves(result, "y", name)]
    free.sort(key=lambda name: name != shaft.rotor)
    rotor = free[0] if free else shaft.rotor
    mesh = next((each for each in case.meshes if rotor in each.rotors), None) or next(iter(case.meshes), None)
    couplings = (each for each in held if each[0] == "coupling_torque")
    first = ("ax" if free else "omega" if shaft.turns else "theta", rotor)
    fast = next(each for each in (first, *couplings, ("omega", rotor), held[0]) if each in held)
    flanks = ("drive_force", "back_force", "backlash")
    result.runs[0].compute([fast, *((signal, mesh.label) for signal in flanks if mesh is not None)])
    figure, axes = make_figure(3, 2, 8.6, width=10.0)
    _output_panel(figure, axes[0], result, window)
    (orbit, forces), (history, spectrum) = axes[1:]
    if free:
        draw_orbit(orbit, result, rotor, window)
    else:
        names = list(case.rotors)
        turning = next((name for name in reversed(names) if moves(result, "omega", name)), names[-1])
        draw_history(orbit, result, "omega", turning, window)
    if mesh is not None and ("drive_force", mesh.label) in held:
        loud = "drive_force" if moves(result, "drive_force", mesh.label) else "backlash"
        span = close_up(result, (loud, mesh.label), window) or window
        for signal, color in (("drive_force", COUPLED), ("back_force", UNCOUPLED)):
            t, v = cut(result, signal, mesh.label, span)
            name = signal.replace("_", " ")
            plot_curve(forces, t, v, "force along the line of action [N]", color=color, label=name)
        forces.set_xlim(*span)
        forces.legend(fontsize=6.5, loc="best", framealpha=0.9)
        forces.locator_params(axis="x", nbins=5)
        _heading(forces, f"mesh {mesh.label}, {window_words(span)}")
    else:
        loads = [each for each in held if each[0] in ("bearing_element_load", "coupling_torque")]
        shown = next((each for each in (*loads, *reversed(held)) if moves(result, *each)), held[-1])
        draw_history(forces, result, *shown, window)
    second = ("backlash", mesh.label) if mesh is not None and ("backlash", mesh.label) in held else fast
    draw_history(history, result, *(second if moves(result, *second) else fast), window)
    force = (
        ("drive_force", mesh.label) if mesh is not None and (not free or not moves(result, *fast)) else fast
    )
    heard = force if force in held else fast
    draw_spectrum(spectrum, result, *heard, window)
    title_figure(figure, result, "overview", window, key_of(case))
    return figure


def _output_panel(figure: Any, row: Any, result: "Result", window: Window) -> None:
    """Draw the transmission error of the output shaft, or its speed, over both columns of a row, key numbers above."""
    grid = row[0].get_gridspec()
    for ax in row:
        ax.remove()
    ax, shaft = tidy(figure.add_subplot(grid[0, :])), result.output
    known = set(result.held("theta")) >= {("theta", shaft.rotor), ("theta", shaft.input)}
    if known and math.isfinite(shaft.ratio) and shaft.rotor != shaft.input:
        t, turn = cut(result, "theta", shaft.rotor, window)
        error = turn - shaft.ratio * cut(result, "theta", shaft.input, window)[1]
        error -= shaft.start
        unit, factor = scale_of("rad", float(np.nanmax(np.abs(error), initial=0.0)))
        plot_curve(ax, t, factor * error, "", color=COUPLED)
        ax.set_ylabel(f"transmission error [{unit}]", fontsize=SMALL)
        ax.set_xlim(*window)
    else:
        held = [each for each in (("omega", shaft.rotor), *result.held()) if each in result.held()]
        draw_history(ax, result, *held[0], window)
    ax.tick_params(labelsize=SMALL)
    ax.set_xlabel("time [s]", fontsize=SMALL)
    numbers = ", ".join(f"{name.split(',')[0]} {text}" for name, text in shaft.rows()).replace(" uW", " µW")
    _heading(ax, "\n".join(textwrap.wrap(f"{shaft.title}: {numbers}", 150)))
