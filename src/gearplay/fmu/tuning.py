"""Parameters of an FMU: fields of a case whose change is that of words of the packed arrays, and how these follow from it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.by_address import Group
from gearplay.model.case import Case
from gearplay.model.field_units import unit_at
from gearplay.model.initial import Starts
from gearplay.model.item_names import numbered
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import replace
from gearplay.vocabulary.errors import Fault, InputError, show_value

LOW, HIGH = 0.5, 2.0
"""Range of a parameter, in shares of its value in the case."""
EXACT, PLACED = 1e-12, 1e-9
"""How well words must follow a rule, relative to their size: rounding, and what the search of the start leaves in it."""
LINEAR, OF_INVERSE, INVERSE = range(3)


@dataclass(frozen=True)
class Word:
    """A word w that follows from a parameter p: w is linear in p (kind 0) or in 1/p (1), or 1/w is linear in p (2).

    ``value`` is that of w or 1/w in the case, ``slope`` its derivative by p or 1/p.
    """

    array: NDArray[Any]
    offset: int
    value: float
    slope: float
    kind: int


@dataclass(frozen=True)
class Tune:
    """A parameter: name, unit, value in the case, range, words."""

    name: str
    unit: str
    start: float
    low: float
    high: float
    words: tuple[Word, ...]


def arrays_of(packed: Packed, start: NDArray[np.float64]) -> Iterator[NDArray[Any]]:
    """Yield the arrays that a change may reach: of the system, the initial state, natural sizes, stops."""
    yield from _arrays(packed.system)
    yield from (start, packed.natural, packed.stops)


def _arrays(group: Group) -> Iterator[NDArray[Any]]:
    for name in type(group).shapes():
        value = getattr(group, name)
        for each in value if isinstance(value, tuple) else (value,):
            yield from _arrays(each) if isinstance(each, Group) else (each,)


def find_tunes(
    case: Case, packed: Packed, start: NDArray[np.float64], member: int, names: Sequence[str]
) -> tuple[Tune, ...]:
    """Return parameters by their paths in the case, ``meshes.0.backlash``.

    Raises `InputError` for a path that is no number, or whose change is more than that of words that follow it.
    """
    found: list[Tune] = []
    faults: list[Fault] = []
    for name in names:
        try:
            found.append(_find(case, packed, start, member, name))
        except InputError as error:
            faults += [each._replace(path="tune") if each.path == name else each for each in error.faults]
    if len(set(names)) < len(names):
        faults.append(Fault("tune", list(names), "must name each field once", "Remove the second"))
    if faults:
        raise InputError(faults)
    return tuple(found)


def _find(case: Case, packed: Packed, start: Any, member: int, name: str) -> Tune:
    value = _value_at(case, name)
    low, high = sorted((LOW * value, HIGH * value))
    seen = partial(_seen, case, name, member)
    tried = [low, high, value * (LOW * HIGH) ** 0.5 * 1.25, 0.8 * value, value * (1.0 + 1e-3)]
    try:
        changed = [seen(each) for each in tried]
    except InputError:
        rule = f"must be a field that may have every value from {low:g} to {high:g}, a half and twice that of the case"
        raise InputError.of("tune", name, rule, "Export one FMU for each value of it") from None
    words: list[Word] = []
    for n, array in enumerate(arrays_of(packed, start)):
        others = [list(each)[n] for each in changed]
        if any(other.shape != array.shape for other in others):
            raise _refused(name)
        own, rows = _as_words(array), [_as_words(other) for other in others]
        for k in np.flatnonzero(np.any([row != own for row in rows], axis=0)).tolist():
            exact = PLACED if array is start else EXACT
            word = _rule(array, k, value, tried, [_number(row[k]) for row in rows], _number(own[k]), exact)
            if word is None and array is start and member > 0:
                rule = "must not change where the flanks of a member with a drawn start are"
                raise InputError.of("tune", name, rule, "Start as member 0, drive flanks in touch")
            if (
                word is None
                or array is packed.natural
                or array is packed.stops
                or not _holds_floats(array, k)
            ):
                raise _refused(name)
            words.append(word)
    if not words:
        rule = "must be a field whose change is one of the motion"
        raise InputError.of("tune", name, rule, "Leave it out; of a planetary set name the field of the set")
    return Tune(name, unit_at(case, name), value, low, high, tuple(words))


def _seen(case: Case, name: str, member: int, value: float) -> list[NDArray[Any]]:
    changed = replace(case, {name: value})
    packed = pack(changed)
    return list(arrays_of(packed, Starts(changed, packed).of_member(member)))


def _rule(
    array: Any, k: int, at: float, tried: Sequence[float], found: Sequence[float], own: float, exact: float
) -> Word | None:
    """Return how a word follows the parameter; None where it follows neither of the rules."""
    for kind in LINEAR, OF_INVERSE, INVERSE:
        if kind == INVERSE and not all([own, *found]):
            break
        x = np.array([1.0 / p if kind == OF_INVERSE else p for p in [at, *tried]])
        w = np.array([1.0 / each if kind == INVERSE else each for each in [own, *found]])
        slope = (w[2] - w[1]) / (x[2] - x[1])
        if np.allclose(w[0] + slope * (x - x[0]), w, rtol=0.0, atol=exact * float(np.max(np.abs(w)))):
            return Word(array, k, float(w[0]), float(slope), kind)
    return None


def _as_words(array: NDArray[Any]) -> NDArray[np.uint64]:
    return np.frombuffer(array.tobytes(), dtype="<u8")


def _number(word: np.uint64) -> float:
    return float(np.uint64(word).view(np.float64))


def _holds_floats(array: NDArray[Any], k: int) -> bool:
    """Return whether word k of an array is a number, not an index."""
    if array.dtype.names is None:
        return array.dtype == np.float64
    fields = array.dtype.fields
    assert fields is not None
    at = 8 * k % array.dtype.itemsize
    return any(
        place <= at < place + kind.itemsize and kind.base == np.float64 for kind, place, *_ in fields.values()
    )


def _value_at(case: Case, name: str) -> float:
    value: Any = case.model_dump(mode="python")
    for part in numbered(case, name).split("."):
        try:
            value = value[int(part)] if isinstance(value, (list, tuple)) else value[part]
        except (KeyError, IndexError, ValueError, TypeError):
            rule = "must be the path of a field of this case"
            own = case.settable_path(name)
            cure = f"Give {own}" if own != name else "See gearplay check, or the case file's reference"
            raise InputError.of("tune", name, rule, cure) from None
    if isinstance(value, int) and not isinstance(value, bool):
        rule = f"must be a field that takes every value from half to twice that of the case; {value} is a whole number"
        raise InputError.of("tune", name, rule, "Export one FMU for each value of it")
    if isinstance(value, float) and value == 0.0:
        rule = "must not be 0 in the case: a parameter ranges from half to twice the value there"
        raise InputError.of("tune", name, rule, "Give it another value in the case, or leave it out")
    if value is None:
        rule = "must have a value in the case: a parameter ranges from half to twice that"
        raise InputError.of("tune", name, rule, "Give it a value in the case, or leave it out")
    if not isinstance(value, float) or not np.isfinite(value):
        rule = f"must be a field with a number; the case has {show_value(value)} there"
        raise InputError.of("tune", name, rule, "Name a number, for example meshes.0.backlash")
    return value


def _refused(name: str) -> InputError:
    rule = "must be a field that changes nothing but numbers in proportion, so that they can change without a new export"
    return InputError.of("tune", name, rule, "Export one FMU for each value of it")
