"""Jam condition of a mesh over a sweep, in one sentence."""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.report.drawable import Along, View

Flags = NDArray[np.bool_]
MOST = 6
"""Combinations of the other axes that are named."""


def jam_sentences(view: View) -> list[str]:
    """Return a sentence for each mesh whose jamming a sweep keeps, the share of time in which both its flanks are pressed."""
    return [
        _sentence(view, str(each.name), str(each.mesh))
        for each in view.sweep.plan.reduce
        if each.kind == "jam" and each.name in view.dataset
    ]


def _sentence(view: View, name: str, mesh: str) -> str:
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
    if len(places) > MOST:
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
