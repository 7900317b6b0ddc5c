"""What a sweep says in two sentences: between what its first number lies, and what it goes with."""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.report.drawable import MEMBER, SAMPLE, View

Floats = NDArray[np.float64]
BINS = 8  # of equal count, of a drawn parameter
LEAST = 0.05  # share of the variance from which on a quantity is named
MOST = 3


def conclusion_of(view: View) -> list[str]:
    """Return two sentences of a sweep's first number; none where no number differs between cases."""
    if not view.scalars:
        return []
    name = view.scalars[0]
    table, groups = tables_of(view, name)
    values = table.ravel()
    values = values[np.isfinite(values)]
    unit = "" if view.unit(name) == "1" else f" {view.unit(name)}"
    words = str(view.dataset[name].attrs.get("long_name", name))
    lines = [
        f"{words[:1].upper()}{words[1:]} lies between {values.min():.3g} and {values.max():.3g}{unit}, "
        f"in half of the {values.size} cases above {np.median(values):.3g}{unit}."
    ]
    shares = {axis: explained(table, labels) for axis, labels in groups.items() if axis != MEMBER}
    told = sorted((axis for axis in shares if shares[axis] > LEAST), key=lambda axis: -shares[axis])
    names = {each: axis.words for each, axis in {**view.axes, **view.drawn}.items()}
    ranked = ", ".join(f"{names[axis]} {100.0 * shares[axis]:.0f} %" for axis in told[:MOST])
    lines.append(
        f"Of its variance one quantity alone explains: {ranked}" if told else "No quantity explains it alone"
    )
    if view.members > 1:
        lines[-1] += f"; scatter among members is {100.0 * scatter_share(table):.0f} %"
    lines[-1] += "."
    return lines


def scatter_share(table: Floats) -> float:
    """Return the share of the variance of a table that lies within its last dimension, that of the members.

    >>> scatter_share(np.array([[1.0, -1.0], [1.0, -1.0]])), scatter_share(np.array([[1.0, 1.0], [2.0, 2.0]]))
    (1.0, 0.0)
    """
    rows = table.reshape(-1, table.shape[-1])
    rows = rows[np.isfinite(rows).all(axis=1)]
    total = float(rows.var()) if rows.size else 0.0
    return float(rows.var(axis=1).mean()) / total if total > 0.0 else 0.0


def explained(table: Floats, labels: NDArray[np.int64]) -> float:
    """Return the share of the variance of a table that its groups explain, at most 1, without what chance would explain.

    The correlation ratio adjusted for the number of groups (epsilon squared, Kelley 1935). ``labels`` gives each entry's group
    and broadcasts with the table; what is not finite is left out.

    >>> explained(np.array([1.0, 1.0, 2.0, 2.0]), np.array([0, 0, 1, 1]))
    1.0
    """
    known = np.isfinite(table)
    values, groups = table[known], np.broadcast_to(labels, table.shape)[known]
    counts = np.bincount(groups)
    used = counts > 0
    n, k = values.size, int(used.sum())
    total = float(np.sum((values - values.mean()) ** 2)) if n else 0.0
    if n <= k or k < 2 or total == 0.0:
        return math.nan if n <= k else 0.0
    means = np.bincount(groups, weights=values)[used] / counts[used]
    within = total - float(np.sum(counts[used] * (means - values.mean()) ** 2))
    return max(0.0, 1.0 - within / (n - k) * (n - 1) / total)


def groups_of(values: Floats) -> NDArray[np.int64]:
    """Return the group of each value, `BINS` of equal count.

    >>> groups_of(np.arange(16.0)).tolist()
    [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7]
    """
    ranks = np.argsort(np.argsort(values, kind="stable"), kind="stable")
    return np.asarray(ranks * BINS // len(values), dtype=np.int64)


def tables_of(view: View, name: str) -> tuple[Floats, dict[str, NDArray[np.int64]]]:
    """Return a number over all cases, and by axis or drawn parameter the group of each entry."""
    dims = [*view.axes, *(d for d in (SAMPLE, MEMBER) if d in view.dataset[name].dims)]
    table = view.values(name, dims, {})
    groups: dict[str, NDArray[np.int64]] = {}
    for at, dim in enumerate(dims):
        shape = [1] * table.ndim
        shape[at] = table.shape[at]
        if dim == SAMPLE:
            groups |= {each: groups_of(axis.values).reshape(shape) for each, axis in view.drawn.items()}
        else:
            groups[dim] = np.arange(table.shape[at]).reshape(shape)
    return table, groups
