"""Split of groups into training, validation and test."""

from collections.abc import Mapping

import numpy as np

from gearplay.vocabulary.errors import Fault, InputError


def split_groups(count: int, shares: Mapping[str, float], seed: int) -> list[str]:
    """Return the part of each of ``count`` groups, drawn with a seed: its share of them, rounded to whole groups.

    Raises `InputError` where a part with a share would get no group.

    >>> sorted(split_groups(5, {"train": 0.6, "validation": 0.2, "test": 0.2}, 0))
    ['test', 'train', 'train', 'train', 'validation']
    """
    exact = {name: count * share for name, share in shares.items()}
    sizes = {name: int(size) for name, size in exact.items()}
    rest = sorted(exact, key=lambda name: (sizes[name] - exact[name], list(exact).index(name)))
    for name in rest[: count - sum(sizes.values())]:
        sizes[name] += 1
    empty = [name for name, share in shares.items() if share > 0.0 and sizes[name] == 0]
    if empty:
        rule = f"must leave a group for it; the plan has {count} group{'s' if count != 1 else ''}"
        cure = "Draw more machines, vary an axis, or set its share to 0"
        raise InputError([Fault(f"split.{name}", shares[name], rule, cure) for name in empty])
    parts = [name for name, size in sizes.items() for _ in range(size)]
    return [parts[k] for k in np.random.default_rng([seed, count]).permutation(count)]
