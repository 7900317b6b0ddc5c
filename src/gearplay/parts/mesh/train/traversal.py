"""Traversal of a train outwards from its input, independent of the order of the tables."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from gearplay.parts.mesh.train.train import Train

Pair = tuple[str, str]
Key = tuple[tuple[bool, int, str], ...]


def natural_key(name: str) -> Key:
    """Return a key that sorts names by letters and numbers: ``planet2`` before ``planet10``.

    >>> sorted(["planet10", "planet2", "carrier"], key=natural_key)
    ['carrier', 'planet2', 'planet10']
    """
    return tuple(
        [(part.isdigit(), int(part) if part.isdigit() else 0, part) for part in re.split(r"([0-9]+)", name)]
    )


def mesh_order(case: Train) -> tuple[int, ...]:
    """Return the meshes breadth-first from the inputs of the trains.

    The input of a train is a driver that no mesh drives, the first by name if there are several. Joints connect without adding
    to the distance.
    """
    pairs = tuple([(mesh.driver, mesh.driven) for mesh in case.meshes])
    rotors = tuple([mesh.rotors for mesh in case.meshes])
    return _mesh_order(pairs, rotors, _joined_pairs(case))


def rotor_order(case: Train) -> list[str]:
    """Return the rotors as `mesh_order` meets them, those without a mesh after the others by name."""
    met = [name for j in mesh_order(case) for name in case.meshes[j].rotors]
    return list(dict.fromkeys([*met, *sorted(case.rotors, key=natural_key)]))


def _joined_pairs(case: Train) -> tuple[Pair, ...]:
    return tuple([(a, b) for joint in case.joints if len(pair := [*joint.rolling()]) == 2 for a, b in [pair]])


def _closure(names: Iterable[str], joints: tuple[Pair, ...]) -> set[str]:
    """Return rotors and all that joints connect to them."""
    found = set(names)
    pending = True
    while pending:
        more = {name for pair in joints if found & set(pair) for name in pair} - found
        found, pending = found | more, bool(more)
    return found


@lru_cache(maxsize=256)
def _mesh_order(
    pairs: tuple[Pair, ...], rotors: tuple[Pair, ...], joints: tuple[Pair, ...]
) -> tuple[int, ...]:
    driven = {pair[1] for pair in rotors}

    def key(j: int) -> tuple[bool, Key, Key]:
        return rotors[j][0] in driven, natural_key(pairs[j][0]), natural_key(pairs[j][1])

    left, order = sorted(range(len(pairs)), key=key), list[int]()
    reached: set[str] = set()
    while left:
        level = [j for j in left if reached & set(rotors[j])]
        if not level:
            reached = _closure([rotors[left[0]][0]], joints)
            level = [j for j in left if reached & set(rotors[j])]
        order += level
        left = [j for j in left if j not in level]
        reached = _closure([*reached, *(name for j in level for name in rotors[j])], joints)
    return tuple(order)
