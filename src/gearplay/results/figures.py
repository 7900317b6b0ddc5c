"""Figures of one result: histories, orbits, spectra, overview."""

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.geometry import carrier_of
from gearplay.model.pack import pack
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.pictures.canvas import SMALL, make_figure, set_title
from gearplay.pictures.style import (
    COUPLED,
    STILL,
    UNCOUPLED,
    is_still,
    plot_curve,
    plot_orbit,
    plot_spectrum,
    say_still,
    tidy,
    widen_still,
)
from gearplay.pictures.words import axis_label, plain, shown_in, wrapped
from gearplay.results.choice import Chosen, cut, free_rotors, moves
from gearplay.results.lines import line_marks, mesh_lines, mesh_names
from gearplay.results.mechanism import orbit_of
from gearplay.results.output_shaft import scale_of, start_of
from gearplay.results.spectra import ensemble_spectrum
from gearplay.results.titles import case_words, window_words
from gearplay.solver.status import Status
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.results.result import Result

Floats = NDArray[np.float64]
Window = tuple[float, float]
PERIODS = 10.0
"""Mesh periods of a close-up."""
LONG = 3.0
"""Length of a window, in close-ups, from which it is drawn complete with the close-up next to it."""
ORDERS = 12.5
"""Mesh orders of a spectrum without a given upper frequency."""
MOST_ORBITS = 9


def history_figure(result: "Result", chosen: Chosen, window: Window, *, whole: bool = False) -> Any:
    """Return a figure of signals over time, one below the other; of a long window the close-up of its largest value too.

    The long one keeps the lowest and the highest value of each stretch, so that no impact is lost. ``whole`` leaves the close-up
    out.
    """
    close = None if whole else close_up(result, chosen[0], window)
    rows, columns = len(chosen), 1 if close is None else 2
    figure, axes = make_figure(rows, columns, 1.1 + 1.75 * rows, width=9.0)
    for row, (signal, label) in zip(axes, chosen, strict=True):
        unit, factor = _unit(result, signal, label, window)
        for ax, span in zip(row, (window, close), strict=False):
            if span is None:
                continue
            _curve(ax, result, signal, label, span, factor)
            ax.set_xlabel("time [s]" if (signal, label) == chosen[-1] else "", fontsize=SMALL)
            ax.locator_params(axis="y", nbins=5)
            ax.locator_params(axis="x", nbins=5 if columns == 2 else 9)
        _name(row[0], signal, label, unit)
        if close is not None:
            row[0].axvspan(*close, color=UNCOUPLED, alpha=0.25, linewidth=0)
            row[1].set_title(f"close-up, {window_words(close)}", fontsize=SMALL, loc="left")
    _title(figure, result, "histories" if rows > 1 else "history", window)
    return figure


def _curve(ax: Any, result: "Result", signal: str, label: str, window: Window, factor: float) -> None:
    """Draw a signal within a window; of one that is still its level, and that it is."""
    t, v = cut(result, signal, label, window)
    plot_curve(ax, t, factor * v, "", color=COUPLED)
    ax.set_xlim(*window)
    unit = RESULT_VARIABLES[signal].unit
    if is_still(v, unit):
        widen_still(ax, factor * v, factor * STILL[unit])
        say_still(ax, unit, "change")


def close_up(result: "Result", one: tuple[str, str], window: Window, member: int = 0) -> Window | None:
    """Return the stretch of some mesh periods about a signal's largest deviation; None where the window is not much longer."""
    lines = mesh_lines(result.case)
    length = PERIODS / max(lines.values()) if lines else 0.02 * (window[1] - window[0])
    if window[1] - window[0] < LONG * length:
        return None
    t, v = cut(result, *one, window, member)
    away = np.abs(v - np.median(v))
    at = float(t[int(np.argmax(np.where(np.isfinite(away), away, -1.0)))])
    low = min(max(at - 0.4 * length, window[0]), window[1] - length)
    return low, low + length


def _name(ax: Any, signal: str, label: str, unit: str) -> None:
    """Label a panel's signal: in full in the title, short with its unit at the axis."""
    ax.set_ylabel(axis_label(signal.replace("_", " "), unit), fontsize=SMALL)
    ax.set_title(
        plain(wrapped(f"{label}: {RESULT_VARIABLES[signal].long_name}", 64)), fontsize=SMALL, loc="left"
    )


def _unit(result: "Result", signal: str, label: str, window: Window) -> tuple[str, float]:
    values = cut(result, signal, label, window)[1]
    return shown_in(RESULT_VARIABLES[signal].unit, float(np.nanmax(np.abs(values), initial=0.0)))


def _title(figure: Any, result: "Result", what: str, window: Window, beside: str = "") -> None:
    member = (
        f", the first of {result.members} members" if result.members > 1 and "members" not in beside else ""
    )
    text = f"{case_words(result.case)}: {what}, {window_words(window)}{member}{beside}"
    set_title(figure, text.replace(" um", " µm"))


def key_of(case: Any) -> str:
    """Return which mesh is which where several frequencies are marked."""
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
        raise InputError(Fault("at", ", ".join(rotors) or "none", rule, cure))
    columns = min(3, len(drawn))
    rows = -(-len(drawn) // columns)
    width = 5.2 if columns == 1 else 9.0
    figure, axes = make_figure(rows, columns, 0.6 + 9.0 / (columns + (columns == 1)) * rows, width=width)
    for ax in axes.flat[len(drawn) :]:
        ax.set_visible(False)
    for ax, name in zip(axes.flat, drawn, strict=False):
        draw_orbit(ax, result, name, window)
    _title(figure, result, "path of the centre" if len(drawn) == 1 else "paths of centres", window)
    return figure


def draw_orbit(ax: Any, result: "Result", rotor: str, window: Window, member: int = 0) -> None:
    """Draw the path of one centre with a title; of a carried rotor relative to its pin, in the carrier's axes."""
    sleeve = result.case.operating.sleeves.get(rotor)
    clearance = sleeve.radial_clearance if sleeve is not None else 0.0
    x, y = orbit_of(result.case, rotor, lambda signal, label: cut(result, signal, label, window, member)[1])
    plot_orbit(ax, x, y, clearance)
    on = carrier_of(result.case, rotor)
    seen = "\nbeside its pin, axes of the carrier" if on else ""
    circle = f"\nclearance circle {1e6 * clearance:.4g} µm" if clearance > 0.0 else ""
    ax.set_title(plain(f"{rotor}{seen}{circle}"), fontsize=SMALL, loc="left")


def spectrum_figure(result: "Result", chosen: Chosen, window: Window, *, highest: float | None = None) -> Any:
    """Return a figure of amplitude spectra, one below the other, mesh orders and shafts marked; ``highest`` [Hz] ends them."""
    figure, axes = make_figure(len(chosen), 1, 0.9 + 2.5 * len(chosen))
    for ax, (signal, label) in zip(axes[:, 0], chosen, strict=True):
        draw_spectrum(ax, result, signal, label, window, highest=highest)
    for ax in axes[:-1, 0]:
        ax.set_xlabel("")
    beside = f", rms average of {result.members} members" if result.members > 1 else ""
    what = "amplitude spectra" if len(chosen) > 1 else "amplitude spectrum"
    _title(figure, result, what, window, beside + key_of(result.case))
    return figure


def draw_spectrum(
    ax: Any, result: "Result", signal: str, label: str, window: Window, *, highest: float | None = None
) -> None:
    """Draw one spectrum with its lines, in six decades at most."""
    whole = [at for at, status in enumerate(result.statuses) if status == Status.DONE] or [0]
    records = [cut(result, signal, label, window, member)[1] for member in whole]
    quantity = RESULT_VARIABLES[signal]
    found = ensemble_spectrum(records, result.sampling, unit=quantity.unit)
    lines = mesh_lines(result.case)
    if highest is None and lines:
        highest = max(ORDERS * max(lines.values()), 40.0 * found.resolution)
    unit, factor = shown_in(quantity.unit, float(np.max(found.amplitude[1:], initial=0.0)))
    plot_spectrum(
        ax, found.frequency, factor * found.amplitude, unit, highest=highest, marks=line_marks(result.case)
    )
    top = float(factor * np.max(found.amplitude[1:], initial=0.0))
    if top <= factor * STILL.get(quantity.unit, 0.0):
        for line in list(ax.get_lines()):
            if line.get_linestyle() == "-":
                line.remove()
        ax.set_yscale("linear")
        ax.set_ylim(0.0, 1.0)
        say_still(ax, quantity.unit, "line") if top > 0.0 else None
        top = 0.0
    low, high = ax.get_ylim()
    if top > 0.0:
        ax.set_ylim(max(low, 1e-6 * top), high * 6.0)  # room for the names of lines
    _name(ax, signal, label, unit)
    ax.set_xlabel("frequency [Hz]", fontsize=SMALL)


def overview_figure(result: "Result", window: Window) -> Any:
    """Return one figure: transmission error of the output shaft, an orbit, forces in mesh closely, backlash, a spectrum."""
    case, held, shaft = result.case, result.held(), result.output
    free = [name for name in free_rotors(case) if moves(result, "x", name) or moves(result, "y", name)]
    free.sort(key=lambda name: name != shaft.rotor)
    rotor = free[0] if free else shaft.rotor
    mesh = next((each for each in case.meshes if rotor in each.rotors), None) or next(iter(case.meshes), None)
    fast = next(
        each for each in [("ax", rotor), ("coupling_torque", ""), ("omega", rotor), held[0]] if each in held
    )
    figure, axes = make_figure(3, 2, 8.6, width=10.0)
    _output_panel(figure, axes[0], result, window)
    axes = axes[1:]
    if free:
        draw_orbit(axes[0, 0], result, rotor, window)
    else:
        _one_history(axes[0, 0], result, "omega", _turning(result), window)
    if mesh is not None and ("drive_force", mesh.label) in held:
        loud = "drive_force" if moves(result, "drive_force", mesh.label) else "backlash"
        span = close_up(result, (loud, mesh.label), window) or window
        for signal, color in (("drive_force", COUPLED), ("back_force", UNCOUPLED)):
            t, v = cut(result, signal, mesh.label, span)
            plot_curve(
                axes[0, 1],
                t,
                v,
                "normal force of the flanks [N]",
                color=color,
                label=signal.replace("_", " "),
            )
        axes[0, 1].set_xlim(*span)
        axes[0, 1].legend(fontsize=6.5, loc="best", framealpha=0.9)
        axes[0, 1].locator_params(axis="x", nbins=5)
        axes[0, 1].set_title(plain(f"mesh {mesh.label}, {window_words(span)}"), fontsize=SMALL, loc="left")
    else:
        _one_history(axes[0, 1], result, *held[-1], window)
    second = ("backlash", mesh.label) if mesh is not None and ("backlash", mesh.label) in held else fast
    _one_history(axes[1, 0], result, *(second if moves(result, *second) else fast), window)
    heard = fast if moves(result, *fast) or mesh is None else ("drive_force", mesh.label)
    draw_spectrum(axes[1, 1], result, *heard, window)
    _title(figure, result, "overview", window, key_of(case))
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
        error -= start_of(result.case.operating, pack(result.case), shaft.rotor, shaft.input, shaft.ratio)
        unit, factor = scale_of("rad", float(np.nanmax(np.abs(error), initial=0.0)))
        plot_curve(ax, t, factor * error, "", color=COUPLED)
        ax.set_ylabel(f"transmission error [{unit}]", fontsize=SMALL)
        ax.set_xlim(*window)
    else:
        held = [each for each in (("omega", shaft.rotor), *result.held()) if each in result.held()]
        _one_history(ax, result, *held[0], window)
    ax.tick_params(labelsize=SMALL)
    ax.set_xlabel("time [s]", fontsize=SMALL)
    numbers = ", ".join(f"{name.split(',')[0]} {text}" for name, text in shaft.rows()).replace(" uW", " µW")
    ax.set_title(
        plain("\n".join(textwrap.wrap(f"{shaft.title}: {numbers}", 150))), fontsize=SMALL, loc="left"
    )


def _turning(result: "Result") -> str:
    names = list(result.case.rotors)
    return next((name for name in reversed(names) if moves(result, "omega", name)), names[-1])


def _one_history(ax: Any, result: "Result", signal: str, label: str, window: Window) -> None:
    unit, factor = _unit(result, signal, label, window)
    _curve(ax, result, signal, label, window, factor)
    _name(ax, signal, label, unit)
    ax.locator_params(axis="x", nbins=5)
