"""Conclusion of a sweep in a few sentences: jam, range of a number, strongest parameter."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.report.drawable import MEMBER, SAMPLE, Along, View
from gearplay.sweeps.variance import Indices, grid_indices, independent_rows, indices_of, shares_words
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
MOST_NAMED = 6
"""Combinations of the other axes that are named."""


def conclusion_of(view: View) -> list[str]:
    """Return the sentences of a sweep: of the meshes whose jamming is kept, of its measure or else its first number."""
    plan, lines = view.sweep.plan, jam_sentences(view)
    jams = {each.name for each in plan.reduce if each.kind == "jam"}
    measure = plan.tolerance.measure if plan.tolerance is not None else ""
    if measure in view.scalars:
        name = measure
    elif (name := next((each for each in view.scalars if each not in jams), "")) == "":
        return lines
    table, names, words = table_of(view, name)
    alone = table
    if plan.design is not None and SAMPLE in names:
        alone = table.take(independent_rows(plan.design), axis=names.index(SAMPLE))
    lines.append(range_words(view, name, alone[np.isfinite(alone)]))
    try:
        found = shares_of(view, name, table, names)
    except InputError as error:  # a package is not installed
        lines.append(f"No Sobol indices: {error.faults[0].rule}.")
        return lines
    lines.append(shares_words(found, words if found.source == "grid" else ()))
    if math.isfinite(found.noise):
        lines.append(f"Scatter among members is {100.0 * found.noise:.3g} % of the variance of their means.")
    return lines


def range_words(view: View, name: str, values: Floats) -> str:
    """Return the range of a number and its median as text; an end of the range instead where half of the runs are there.

    Runs are cases where each has one member.
    """
    unit = "" if view.unit(name) == "1" else f" {view.unit(name)}"
    words = str(view.dataset[name].attrs.get("long_name", name))
    runs = "runs" if view.members > 1 else "cases"
    low, high, count = float(values.min()), float(values.max()), values.size
    said = f"{words[:1].upper()}{words[1:]} lies between {low:.3g} and {high:.3g}{unit}"
    for end in (low, high):
        at = int(np.count_nonzero(values == end))
        if 2 * at >= count and count > 2:
            return f"{said}; it is {end:.3g}{unit} in {at} of the {count} {runs}."
    median = np.quantile(values, 0.5, method="inverted_cdf")  # as the quantiles of a tolerance
    return f"{said}; the median of the {count} {runs} is {median:.3g}{unit}."


def table_of(view: View, name: str) -> tuple[Floats, tuple[str, ...], tuple[str, ...]]:
    """Return a number over all axes, drawn points and members (last), with the names and texts of the dimensions."""
    dims = [*view.axes, *((SAMPLE,) if view.samples > 1 else ())]
    table = view.values(name, [*dims, *((MEMBER,) if view.members > 1 else ())], {})
    words = [view.axes[dim].words if dim in view.axes else "the drawn parameters together" for dim in dims]
    return table if view.members > 1 else table[..., None], tuple(dims), tuple(words)


def shares_of(view: View, name: str, table: Floats, names: tuple[str, ...]) -> Indices:
    """Return the Sobol indices of a design's parameters, as on the page of tolerances, or of the axes of a grid."""
    plan = view.sweep.plan
    if plan.design is not None and names == (SAMPLE,):
        return indices_of(plan.design, table, seed=plan.design.seed)
    return grid_indices(names, table)


def jam_sentences(view: View) -> list[str]:
    """Return a sentence for each mesh whose jamming a sweep keeps, the share of time in which both its flanks are pressed."""
    return [
        _jam_sentence(view, str(each.name), str(each.mesh))
        for each in view.sweep.plan.reduce
        if each.kind == "jam" and each.name in view.dataset
    ]


def _jam_sentence(view: View, name: str, mesh: str) -> str:
    variable, axes = view.dataset[name], list(view.axes)
    values = variable.transpose(*axes, ...).values
    values = values.reshape(*(len(view.axes[axis].values) for axis in axes), -1)
    known: Flags = np.asarray(np.isfinite(values).any(axis=-1))
    jams: Flags = np.asarray((values > 0.0).any(axis=-1))
    failed = int(np.count_nonzero(~known))
    end = f"; {failed} of {known.size} cases have no number." if failed else "."
    if not known.any():
        return f"Mesh {mesh}: no case has a number."
    if not jams.any():
        return f"Mesh {mesh} jams in none of the {np.count_nonzero(known)} cases{end}"
    longest = f", up to {100.0 * float(np.nanmax(values)):.3g} % of the time"
    if jams[known].all():
        return f"Mesh {mesh} jams in all of the {np.count_nonzero(known)} cases{longest}{end}"
    inner = max(axes, key=lambda axis: (not view.axes[axis].labels, len(view.axes[axis].values)))
    others = [axis for axis in axes if axis != inner]
    order = [axes.index(axis) for axis in (*others, inner)]
    jams, known = jams.transpose(order), known.transpose(order)
    places = list(itertools.product(*(range(size) for size in jams.shape[:-1])))
    if len(places) > MOST_NAMED:
        return f"Mesh {mesh} jams in {np.count_nonzero(jams)} of the {np.count_nonzero(known)} cases{longest}{end}"
    where, never = [], []
    for place in places:
        words = " and ".join(view.axes[axis].text(at) for axis, at in zip(others, place, strict=True))
        if not known[place].any():
            continue
        if not jams[place].any():
            never.append(words)
        else:
            where.append(_along(view.axes[inner], jams[place]) + (f" with {words}" if words else ""))
    parts = [f"Mesh {mesh} jams {', '.join(where)}{longest}"]
    if never:
        parts.append(f"not with {', '.join(never)}")
    return "; ".join(parts) + end


def _along(axis: Along, jams: Flags) -> str:
    """Return where along an axis a mesh jams: single values, and ranges of neighbours."""
    if jams.all():
        return f"at every {axis.words}"
    runs: list[list[int]] = []
    for at in np.flatnonzero(jams).tolist():
        if runs and runs[-1][-1] == at - 1 and not axis.labels:
            runs[-1].append(at)
        else:
            runs.append([at])
    return f"at {axis.words} " + " and ".join(_run(axis, run) for run in runs)


def _run(axis: Along, run: Sequence[int]) -> str:
    first, last = axis.value(run[0]), axis.value(run[-1])
    return first if len(run) == 1 else f"from {first} to {last}"
