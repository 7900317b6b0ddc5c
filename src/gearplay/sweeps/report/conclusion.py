"""Conclusion of a sweep in a few sentences: jam, range of a number, strongest parameter."""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.report.drawable import MEMBER, SAMPLE, View
from gearplay.sweeps.report.jam_words import jam_sentences
from gearplay.sweeps.variance.sobol_indices import Indices, grid_indices, indices_of
from gearplay.sweeps.variance.words import shares_words
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]


def conclusion_of(view: View) -> list[str]:
    """Return the sentences of a sweep: of the meshes whose jamming is kept, of its measure or else its first number."""
    lines, jams = jam_sentences(view), {each.name for each in view.sweep.plan.reduce if each.kind == "jam"}
    plan = view.sweep.plan
    measure = plan.tolerance.measure if plan.tolerance is not None else ""
    told = [measure] if measure in view.scalars else [each for each in view.scalars if each not in jams]
    if not told:
        return lines
    name = told[0]
    table, names, words = table_of(view, name)
    lines.append(range_words(view, name, table[np.isfinite(table)]))
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
    """Return between what a number lies, and where half of the cases are: at one end where most are there."""
    unit = "" if view.unit(name) == "1" else f" {view.unit(name)}"
    words = str(view.dataset[name].attrs.get("long_name", name))
    low, high, count = float(values.min()), float(values.max()), values.size
    said = f"{words[:1].upper()}{words[1:]} lies between {low:.3g} and {high:.3g}{unit}"
    for end in (low, high):
        at = int(np.count_nonzero(values == end))
        if 2 * at >= count and count > 2:
            return f"{said}; it is {end:.3g}{unit} in {at} of the {count} cases."
    return f"{said}; the median of the {count} cases is {np.median(values):.3g}{unit}."


def table_of(view: View, name: str) -> tuple[Floats, tuple[str, ...], tuple[str, ...]]:
    """Return a number over all axes, drawn points and members (last), the names of what varies, and their words."""
    dims = [*view.axes, *((SAMPLE,) if view.samples > 1 else ())]
    table = view.values(name, [*dims, *((MEMBER,) if view.members > 1 else ())], {})
    words = [view.axes[dim].words if dim in view.axes else "the drawn parameters together" for dim in dims]
    return table if view.members > 1 else table[..., None], tuple(dims), tuple(words)


def shares_of(view: View, name: str, table: Floats, names: tuple[str, ...]) -> Indices:
    """Return the Sobol indices of what varies: of a design's parameters as on the page of tolerances, else of the grid."""
    plan = view.sweep.plan
    if plan.design is not None and names == (SAMPLE,):
        return indices_of(plan.design, table, seed=plan.design.seed)
    return grid_indices(names, table)
