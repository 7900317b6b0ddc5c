"""Names of items in the lists of a case: ``meshes.pinion-ring.backlash`` for ``meshes.0.backlash``."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

LISTS: Final[Mapping[str, Sequence[str]]] = {"meshes": ("driver", "driven"), "couplings": ("between",)}
"""Lists whose items have names, and the fields that make them."""


def numbered(document: Any, path: str) -> str:
    """Return a dotted path into a raw case, or into a `Case`, with numbers for the names of items; others as they are.

    >>> case = {"meshes": [{"driver": "a", "driven": "b.wheel"}]}
    >>> numbered(case, "meshes.a-b.wheel.backlash"), numbered(case, "meshes.a-c.backlash")
    ('meshes.0.backlash', 'meshes.a-c.backlash')
    """
    head, _, rest = path.partition(".")
    if head.strip() not in LISTS:
        return path
    names = item_names(document, head.strip())
    for name in sorted(names, key=len, reverse=True):
        if rest == name or rest.startswith(f"{name}."):
            return f"{head}.{names.index(name)}{rest[len(name) :]}"
    return path


def item_names(document: Any, name: str) -> list[str]:
    """Return the names of the items of a list in a raw case or a `Case`."""
    items = document.get(name) if isinstance(document, Mapping) else getattr(document, name, None)
    if not isinstance(items, (list, tuple)):
        return []
    return distinct(_name(item, LISTS[name]) for item in items)


def distinct(names: Iterable[str]) -> list[str]:
    """Return names with the number of their occurrence from the second on; no name of a rotor begins with a digit.

    >>> distinct(["motor-pinion", "wheel-drum", "motor-pinion"])
    ['motor-pinion', 'wheel-drum', 'motor-pinion-2']
    """
    found, seen = [], Counter[str]()
    for name in names:
        seen[name] += 1
        found.append(name if seen[name] == 1 else f"{name}-{seen[name]}")
    return found


def _name(item: Any, fields: Sequence[str]) -> str:
    parts: list[str] = []
    for field in fields:
        value = item.get(field) if isinstance(item, Mapping) else getattr(item, field, None)
        parts += [str(each) for each in value] if isinstance(value, (list, tuple)) else [str(value)]
    return "-".join(parts)
