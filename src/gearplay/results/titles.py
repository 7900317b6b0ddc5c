"""Titles of figures: case, changed fields, time window."""

import math
import tomllib
from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

from gearplay.model.bundled import bundled, bundled_text
from gearplay.model.case import Case
from gearplay.model.field_units import unit_at
from gearplay.model.reading import load_case
from gearplay.pictures.words import offset_in, shown_in
from gearplay.results.base import case_in

if TYPE_CHECKING:
    import xarray as xr

MOST_CHANGES = 4
"""Changes that a title names."""


def words_of(dataset: "xr.Dataset", otherwise: str) -> str:
    """Return the title of the case behind a dataset, with its changes; ``otherwise`` where it names no case."""
    if "case" not in dataset.attrs:
        return str(dataset.attrs.get("title") or otherwise)
    case = case_in(dataset)
    return case_words(case if case.title else case.model_copy(update={"title": otherwise}))


def case_words(case: Case) -> str:
    """Return the title of a case and its changes, except for those of the run, from the bundled case of that title or since read.

    >>> from gearplay.model.reading import load_case
    >>> case_words(load_case("han2021", ["meshes.0.backlash=200um", "run.duration=1s"]))
    'Han 2021, 120 rpm, 100/100 um; meshes.0.backlash = 200 µm'
    """
    changes = changes_of(case)
    more = f" and {len(changes) - MOST_CHANGES} more" if len(changes) > MOST_CHANGES else ""
    words = f"; {', '.join(changes[:MOST_CHANGES])}{more}" if changes else ""
    return (case.title or "untitled case") + words


def changes_of(case: Case) -> list[str]:
    """Return the changes of a bundled case, as ``path = value``; of any other those that were set since it was read."""
    name = _titles().get(case.title)
    if name is None:
        return _changed(case)
    before = dict(_leaves(load_case(name).resolved()))
    after = dict(_leaves(case.resolved()))
    paths = [path for path in {**before, **after} if before.get(path) != after.get(path)]
    return [
        f"{path} = {_shown(case, path, after.get(path))}"
        for path in paths
        if not path.startswith("run.") and path != "title"
    ]


def _changed(case: Case) -> list[str]:
    leaves = dict(_leaves(case.resolved()))
    found = []
    for path in case.changed:
        if path.startswith("run.") or path == "title":
            continue
        inner = [each for each in leaves if each.startswith(f"{path}.")]
        found.append(f"{path} changed" if inner else f"{path} = {_shown(case, path, leaves.get(path))}")
    return found


@cache
def _titles() -> dict[str, str]:
    """Return the names of the bundled cases by title."""
    places = ("gearplay.model", "cases")
    found = {name: tomllib.loads(bundled_text(*places, name)).get("title", "") for name in bundled(*places)}
    return {title: name for name, title in found.items() if title}


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict) and value:
        for key, item in value.items():
            yield from _leaves(item, f"{path}.{key}" if path else str(key))
    elif isinstance(value, (list, tuple)) and any(isinstance(item, (dict, list)) for item in value):
        for at, item in enumerate(value):
            yield from _leaves(item, f"{path}.{at}")
    else:
        yield path, value


def _shown(case: Case, path: str, value: Any) -> str:
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not math.isfinite(value):
        return "absent" if value is None else str(value)
    try:
        unit, factor = shown_in(unit_at(case, path), abs(value))
    except (KeyError, ValueError, AttributeError, IndexError, TypeError):
        return f"{value:.5g}"
    return f"{factor * value + offset_in(unit):.5g}" + ("" if unit == "1" else f" {unit}")


def window_words(window: tuple[float, float]) -> str:
    """Return a time window [s] as text, with the digits of its ends set by its length.

    >>> window_words((0.5, 0.6)), window_words((0.5, 0.50125))
    ('0.5 to 0.6 s', '0.5 to 0.50125 s')
    """
    low, high = window
    digits = max(0, 3 - math.floor(math.log10(high - low))) if high > low else 6
    return f"{round(low, digits):.12g} to {round(high, digits):.12g} s"
