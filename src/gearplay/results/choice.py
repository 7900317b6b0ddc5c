"""Selection of signals for a figure: by name, by element, or the most significant."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.parts.mesh.train.geometry import is_held, rotor_of
from gearplay.pictures.style import is_still
from gearplay.results.output_shaft import output_of
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.suggestions import listed, nearest

if TYPE_CHECKING:
    from gearplay.results.result import Result

Floats = NDArray[np.float64]
Chosen = list[tuple[str, str]]
MOST_SIGNALS = 8
"""Signals in one picture."""
LISTED = 24

INFORMATIVE = {
    "history": ("x", "y", "ax", "ay", "backlash", "drive_force", "back_force", "coupling_torque"),
    "spectrum": ("ax", "ay", "drive_force", "back_force", "coupling_torque"),
}
"""Most informative signals of an element by the kind of picture; of a rotor that cannot move its speed."""


def elements_at(case: Case, at: str) -> list[str]:
    """Return the labels that belong to a place: a rotor with its sleeve, a gear's rotor and its meshes, a mesh, a coupling.

    Raises `InputError` for an unknown name.

    >>> from gearplay.model.reading import load_case
    >>> elements_at(load_case("two-stage-reducer"), "layshaft.wheel")
    ['layshaft', 'input-layshaft.wheel']
    """
    meshes = {mesh.label: mesh for mesh in case.meshes}
    couplings = [name for _, name, _ in case.named_joints()]
    if at in meshes or at in couplings:
        return [at]
    if at in case.rotors:
        return [at, *(name for name, mesh in meshes.items() if at in mesh.rotors)]
    gears = dict.fromkeys(name for mesh in case.meshes for name in (mesh.driver, mesh.driven))
    if at in gears:
        own = [name for name, mesh in meshes.items() if at in (mesh.driver, mesh.driven)]
        return [rotor_of(case, at), *own]
    known = list(dict.fromkeys([*case.rotors, *gears, *meshes, *couplings]))
    close = nearest(at, known)
    cure = f"Did you mean '{close}'?" if close else f"Choose from: {listed(known, LISTED)}"
    rule = "must be a rotor, a gear, a sleeve, a mesh or a coupling of the case"
    raise InputError.of("at", at, rule, cure)


def choose(result: "Result", names: list[str], at: str | None, *, kind: str = "history") -> Chosen:
    """Return the signals, as (signal, element), of a picture: by their ``names`` or, if empty, the most informative ones.

    ``at`` names an element, ``kind`` is "history" or "spectrum".

    Raises `InputError` for an unknown signal or element, with the nearest name.
    """
    labels = None if at is None else elements_at(result.case, at)
    found: Chosen = []
    for name in names:
        found += [each for each in _called(result, name, labels) if each not in found]
    if not names:
        found = _most_informative(result, labels, kind)
    return found[:MOST_SIGNALS]


def _called(result: "Result", name: str, labels: list[str] | None) -> Chosen:
    """Return the signals of one name: of several elements those that move."""
    label, _, signal = name.rpartition(".")
    held = [each for each in result.held(signal) if not label or each[1] == label]
    here = [each for each in held if labels is None or each[1] in labels]
    if not here:
        wanted = [each for each in result.held() if labels is None or each[1] in labels]
        bare = dict.fromkeys(each for each, _ in wanted)
        close = nearest(name, [*bare, *(f"{element}.{each}" for each, element in wanted)])
        cure = f"Did you mean '{close}'? " if close else ""
        rule = "must be a signal of the result" + ("" if labels is None else f" at {labels[0]}")
        raise InputError.of("signal", name, rule, f"{cure}Signals: {', '.join(bare)}")
    result.runs[0].compute(here)
    return [each for each in here if moves(result, *each)] or here[:1]


def _most_informative(result: "Result", labels: list[str] | None, kind: str) -> Chosen:
    held, order = result.held(), labels
    if order is None:
        output = output_of(result.case)
        meshes = [mesh.label for mesh in result.case.meshes if output in mesh.rotors]
        order = [output, *(meshes or [mesh.label for mesh in result.case.meshes])[:1]]
    found = [(signal, label) for label in order for signal in INFORMATIVE[kind] if (signal, label) in held]
    result.runs[0].compute(found)
    moving = [each for each in found if moves(result, *each)]
    speeds = [("omega", label) for label in order if ("omega", label) in held]
    speeds += [each for each in held if each[0] == "omega"] if labels is None else []
    return moving or speeds[:1] or found[:1] or held[:1]


def free_rotors(case: Case) -> list[str]:
    """Return the rotors whose centres can move, those in sleeves first."""
    free = [name for name in case.rotors if not is_held(case, name)]
    return sorted(free, key=lambda name: name not in case.sleeves)


def moves(result: "Result", signal: str, label: str) -> bool:
    """Return whether a signal of the first member changes by more than rounding leaves."""
    values = result.signal(signal, label)
    known = values[np.isfinite(values)]
    if not known.size or float(np.ptp(known)) == 0.0:
        return False
    return not is_still(known, RESULT_VARIABLES[signal].unit)


def time_window(result: "Result", window: tuple[float | None, float | None] | None) -> tuple[float, float]:
    """Return the two ends [s] of a window, by default those of the result.

    Raises `InputError` for a window that does not lie in the result.
    """
    time = result.time()
    if time.size < 2:
        rule = "must hold two samples or more"
        cure = "Simulate longer, or with a higher sampling"
        raise InputError.of("result", f"{time.size} samples", rule, cure)
    first, last = float(time[0]), float(time[-1])
    if window is None:
        return first, last
    low = first if window[0] is None else window[0]
    high = last if window[1] is None else window[1]
    step = 1.0 / result.sampling
    shown = f"{low:.9g}s:{high:.9g}s"
    if not all(first - step <= end <= last + 1.5 * step for end in (low, high)):
        rule = f"must lie within the result, {first:.6g} to {last:.6g} s"
        raise InputError.of("window", shown, rule, "Choose another, or simulate longer")
    if not low < high:
        raise InputError.of("window", shown, "must begin before it ends", "Write for example 0.5s:0.6s")
    if np.count_nonzero((time >= low - 0.5 * step) & (time <= high + 0.5 * step)) < 2:
        rule = f"must hold two samples or more; they are {step:.3g} s apart"
        raise InputError.of("window", shown, rule, "Choose a longer one")
    return low, high


def cut(
    result: "Result", signal: str, label: str, window: tuple[float, float], member: int = 0
) -> tuple[Floats, Floats]:
    """Return times [s] and values [SI] of a signal within a window, ends included."""
    time, values = result.time(member), result.signal(signal, label, member)
    n = min(time.size, values.size)
    half = 0.5 / result.sampling
    first, last = np.searchsorted(time[:n], [window[0] - half, window[1] + half])
    return time[first:last], values[first:last]
