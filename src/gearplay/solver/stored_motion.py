"""Checkpoints as tables of integers and floats, for files; every number of a table is checked before a kernel uses it.

A table has only what a step depends on. Index lists are made anew from the states of bodies and elements, settings are taken from
the case, and whatever serves as an index or a count has bounds here, so that a damaged or a crafted file is refused.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import implicit
from gearplay.integrate import run as kernel
from gearplay.integrate.active_set import fill_lists
from gearplay.integrate.implicit import find_unknowns
from gearplay.integrate.radau import HIGH, MOST
from gearplay.integrate.restart import FURTHEST
from gearplay.kernels.layout import ACTING, KNOWN, SEPARATING
from gearplay.kernels.library import SOURCES
from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.parts.registry import COUPLING
from gearplay.solver.checkpoints import KeptMotion, Mark, states
from gearplay.solver.integration import Course

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LISTS: Final = tuple(
    f"active_set.{name}"
    for name in ("active", "states", "acting", "watched", "near", "switches", "hiding", "joining")
)
UNKNOWNS: Final = ("implicit.places", "implicit.first", "implicit.unknowns")
MADE: Final = (*LISTS, *UNKNOWNS, "active_set.integrated_groups", "active_set.forced", "modes_0")
"""Arrays of integers that follow from the others or from the case, or are written before they are read."""
SETTINGS: Final = (kernel.H_RESTART, kernel.FIXED, kernel.TOLERANCE)
ASKED: Final = (kernel.T_END, kernel.SAMPLE_START, kernel.SAMPLE_INTERVAL)
"""Slots of the clock that the case or a request sets."""
LARGEST: Final = 1 << 53
MOST_BYTES, FEWEST = 2_000_000, 16
"""Size [bytes] of the checkpoints of all members in a file, about, before compression; least number of each member."""


class MotionError(ValueError):
    """Tables that do not fit a motion of the case; the message is a predicate."""


def kernels_digest() -> str:
    """Return the digest of the sources that a replay depends on, by which a file names the kernels that wrote it."""
    return SOURCES


def tables_of(motions: Sequence[KeptMotion]) -> tuple[list[int], Ints, Floats]:
    """Return the number of checkpoints of each motion, and all of them as tables, shapes [checkpoint, integer], [.., float].

    Of many, evenly chosen ones: the replay from one to the next is the same however far apart they are.
    """
    chosen: list[Mark] = []
    counts = []
    for motion in motions:
        most = max(FEWEST, int(MOST_BYTES / len(motions) / max(1, motion.bytes_each)))
        stride = -(-len(motion.marks) // most)
        counts.append(len(motion.marks[::stride]))
        chosen += motion.marks[::stride]
    names = list(states(_course(motions[0]).run))
    rows = [dict(zip(names, mark.arrays, strict=True)) for mark in chosen]
    tables = [np.array([_row(arrays, kind) for arrays in rows]) for kind in "if"]
    return counts, tables[0], tables[1]


def _row(arrays: dict[str, NDArray[Any]], kind: str) -> NDArray[Any]:
    return np.concatenate([arrays[name].ravel() for name in _stored(arrays, kind)])


def _stored(arrays: dict[str, NDArray[Any]], kind: str) -> list[str]:
    return [name for name, array in arrays.items() if array.dtype.kind == kind and name not in MADE]


def _course(motion: KeptMotion) -> Course:
    return Course(motion.case, motion.packed, np.zeros(motion.packed.state_size))


def widths_of(case: Case, packed: Packed) -> tuple[int, int]:
    """Return the numbers of integers and of floats of a checkpoint."""
    arrays = states(_course(KeptMotion(case, packed, (0.0, 0.0))).run)
    integers, floats = (sum(arrays[name].size for name in _stored(arrays, kind)) for kind in "if")
    return integers, floats


def motion_of(
    case: Case,
    packed: Packed,
    ends: tuple[float, float],
    reached: float,
    integers: Ints,
    floats: Floats,
    source: str,
) -> KeptMotion:
    """Return the motion whose checkpoints are the rows of two tables; ``source`` is the file that they are from.

    Raises `MotionError` where a number is not one that a run of the case can have.
    """
    motion = KeptMotion(case, packed, ends, source=source)
    motion.reached = reached
    course = _course(motion)
    arrays = states(course.run)
    blank = {name: array.copy() for name, array in arrays.items()}
    bounds = _bounds(arrays, course)
    for at in range(len(integers)):
        for kind, table in (("i", integers), ("f", floats)):
            start = 0
            for name in _stored(arrays, kind):
                array = arrays[name]
                array[...] = table[at, start : start + array.size].reshape(array.shape)
                start += array.size
        _check(arrays, blank, bounds, FURTHEST * np.asarray(packed.natural), min(reached, ends[-1]))
        _set_up(arrays, blank, course)
        motion._marks.append(Mark.of(course, arrays.values()))
    order = [(mark.time, mark.steps) for mark in motion.marks]
    begun = [dict(zip(arrays, mark.arrays, strict=True))["counts"][kernel.BEGUN] for mark in motion.marks[:1]]
    if order[:1] != [(0.0, 0)] or begun != [0] or order != sorted(order):
        raise MotionError("its checkpoints do not begin at the start of a run and rise")
    return motion


def _bounds(arrays: dict[str, NDArray[Any]], course: Course) -> dict[str, tuple[Any, Any]]:
    """Return the least and the largest value of each integer that is stored."""
    system, modes = course.system, arrays["branch.modes"]
    low, high = np.full(modes.size, -LARGEST), np.full(modes.size, LARGEST)
    contacts, rotors = system.contacts.size, system.rotors.size
    low[:contacts], high[:contacts] = 0, SEPARATING
    low[modes.size - rotors :], high[modes.size - rotors :] = 0, 1
    for coupling in system.records[COUPLING]:  # the stage is a row of a table
        low[coupling.mode], high[coupling.mode] = 0, max(int(coupling.stages) - 1, 0)
    numbers = np.full(arrays["implicit.numbers"].size, LARGEST)
    numbers[implicit.IN_USE], numbers[implicit.TRACED] = 1, 2
    numbers[[implicit.METHOD, implicit.LAST_METHOD, implicit.OLDER_METHOD]] = HIGH
    numbers[implicit.COLLOCATED] = MOST
    counts = np.full(arrays["counts"].size, LARGEST)
    counts[kernel.BEGUN] = 1
    return {
        "active_set.body_states": (0, KNOWN),
        "active_set.element_states": (0, ACTING),
        "branch.modes": (low, high),
        "implicit.numbers": (0, numbers),
        "counts": (-1, counts),
    }


def _check(
    arrays: dict[str, NDArray[Any]],
    blank: dict[str, NDArray[Any]],
    bounds: dict[str, tuple[Any, Any]],
    largest: Floats,
    end: float,
) -> None:
    """Raise `MotionError` where a number of the checkpoint in ``arrays`` has no place in a run that came to ``end`` [s].

    ``largest`` are the limits of the states.
    """
    for name in _stored(arrays, "i"):
        low, high = bounds[name]
        if (arrays[name] < low).any() or (arrays[name] > high).any():
            raise MotionError(f"a number of {name} is none that a run of its case has")
    for name in _stored(arrays, "f"):
        fine = np.isfinite(arrays[name])
        if name == "branch.memory":  # nothing noted yet
            fine |= arrays[name].view(np.int64) == blank[name].view(np.int64)
        elif name == "active_set.due":
            fine = arrays[name] >= 0.0
        elif name == "clock":
            fine[list(ASKED)] = True
        if not fine.all():
            raise MotionError(f"a number of {name} is not finite")
    clock = arrays["clock"]
    t = clock[kernel.T]
    inside = (
        0.0 <= t <= end
        and clock[kernel.H] >= 0.0
        and clock[kernel.H_BEGIN] > 0.0
        and 0.0 <= clock[kernel.BURST_START] <= t
        and 0.0 < clock[kernel.ERROR_SHARE] <= 1.0
        and 0.0 <= clock[kernel.INSIDE] <= 1.0
        and (arrays["active_set.since"] >= 0.0).all()
        and (arrays["active_set.since"] <= t).all()
    )
    if not inside:
        raise MotionError("a time of its checkpoints lies outside the run")
    for name in ("y", "y_new", "y_try", "active_set.origin"):
        if (np.abs(arrays[name]) > largest).any():
            raise MotionError(f"a state of {name} is beyond all reason")


def _set_up(arrays: dict[str, NDArray[Any]], blank: dict[str, NDArray[Any]], course: Course) -> None:
    """Fill the arrays that a checkpoint does not store: settings, index lists, fields of a request."""
    for name in MADE:
        arrays[name][...] = blank[name]
    clock = arrays["clock"]
    for slot in (*SETTINGS, *ASKED):
        clock[slot] = blank["clock"][slot]
    if arrays["counts"][kernel.BEGUN] == 1:
        fill_lists(course.system, course.run.active_set, course.run.y)
        find_unknowns(course.system, course.run.active_set, course.run.implicit)
