"""Ensemble statistics under changed numbers of the method, compared by Welch's test."""

import math
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.reading import replace
from gearplay.nonlinear.record_length import velocities
from gearplay.solver.flow import Flow
from gearplay.solver.simulate import run_members
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.progress import Progress

Floats = NDArray[np.float64]
DOUBT = 1e-3  # chance of calling any statistic changed that is not
ROUNDING, SAMPLED, PLAIN = 1e-6, 1e-3, 0.02
"""Relative differences that mean nothing: of constant statistics, of samples farther apart, of plain steps, which notice
contacts late.
"""
DEVIATION = "standard deviation of "
PLAIN_STEP = 0.5  # of a plain method [steps after a located contact, which are 0.1 rad of the fastest one]
SPREADS = ("impacts_per_second", "share_of_time", "rms_impact_speed")


@dataclass(frozen=True)
class Comparison:
    """A statistic under a changed number of the method: means of the ensemble, and their difference over its standard error."""

    change: str
    statistic: str
    usual: float
    changed: float
    t: float


def compare_methods(
    flow: Flow, members: int, report: Progress, stop: threading.Event | None
) -> tuple[tuple[Comparison, ...], float]:
    """Compare the statistics of an ensemble with those under changed methods; return also the largest t due to chance.

    The ensemble, as long as the case's duration, is repeated with a hundredth of the tolerance, with a third of the output step,
    and by another method: plain steps of one length, 126 in a period of the fastest contact, that notice contacts at their ends
    (for a case with ``run.fixed_step``: half the step, and located contacts).
    """
    from scipy.special import stdtrit

    names = list(velocities(flow).values())
    free = dict(zip(flow.free_names, flow.natural[flow.free], strict=False))
    floors = {f"{DEVIATION}{name}": flow.case.run.tolerance * float(free[name]) for name in names}
    usual = _statistics(flow.case, names, members, "ensemble", report, stop)
    found = []
    for change, (values, least) in _changes(flow).items():
        changed = _statistics(replace(flow.case, values), names, members, change, report, stop)
        found += [
            Comparison(change, name, *_welch(usual[name], changed[name], least, floors.get(name, 0.0)))
            for name in usual
            if name in changed
        ]
    freedom = float(members - 1)  # the least that Welch's degrees of freedom can be
    return tuple(found), float(stdtrit(freedom, 1.0 - 0.5 * DOUBT / max(1, len(found))))


def _changes(flow: Flow) -> dict[str, tuple[Mapping[str, Any], float]]:
    """Return the changes of the method of a case, each with the insignificant relative difference of a statistic."""
    run = flow.case.run
    output: dict[str, tuple[Mapping[str, Any], float]] = {
        "a third of the output step": ({"run.sampling": 3.0 * run.sampling}, SAMPLED)
    }
    if run.fixed_step is not None:
        return output | {
            "half the step": ({"run.fixed_step": 0.5 * run.fixed_step}, PLAIN),
            "located contacts": ({"run.fixed_step": None, "run.fixed_step_contacts": "step"}, PLAIN),
        }
    plain = PLAIN_STEP * flow.packed.restart_step
    return output | {
        "a hundredth of the tolerance": ({"run.tolerance": 0.01 * run.tolerance}, ROUNDING),
        f"plain steps of {1e6 * plain:.3g} us": ({"run.fixed_step": plain}, PLAIN),
    }


def _statistics(
    case: Case, names: list[str], members: int, label: str, report: Progress, stop: threading.Event | None
) -> dict[str, Floats]:
    """Return statistics of each member, shape [member], by name; NaN for a member that did not finish."""
    runs = run_members(
        case,
        range(1, members + 1),
        signals=names,
        stop=stop,
        progress=lambda done, total: report(label, done, total),
    )
    if any(run.status == Status.INTERRUPTED for run in runs):
        raise KeyboardInterrupt
    labels = runs[0].statistics.labels
    found = {
        f"{name.replace('_', ' ')} of {contact}": np.array([_contact(run, name, at) for run in runs])
        for name in SPREADS
        for at, contact in enumerate(labels)
    }
    for at, column in enumerate(runs[0].columns):
        name = f"{DEVIATION}{column.label}.{column.signal}"
        found[name] = np.array(
            [float(np.std(run.values[:, at])) if run.success else math.nan for run in runs]
        )
    found["share of runs that finish"] = np.array([float(run.success) for run in runs])
    return found


def _contact(run: Trajectory, name: str, at: int) -> float:
    value = float(getattr(run.statistics, name)[at])
    return (value if math.isfinite(value) else 0.0) if run.success else math.nan


def _welch(usual: Floats, changed: Floats, relative: float, floor: float) -> tuple[float, float, float]:
    """Return both means and their difference over its standard error (Welch), 0 where neither varies nor differs.

    The error is at least ``relative`` times the larger mean; what differs by ``floor`` at most, the method's own error, does not.
    """
    a, b = usual[np.isfinite(usual)], changed[np.isfinite(changed)]
    if min(a.size, b.size) < 2:
        return math.nan, math.nan, 0.0
    error = math.sqrt(float(np.var(a, ddof=1)) / a.size + float(np.var(b, ddof=1)) / b.size)
    one, other = float(np.mean(a)), float(np.mean(b))
    least = relative * max(abs(one), abs(other))
    if abs(other - one) <= max(floor, ROUNDING * max(abs(one), abs(other))):
        return one, other, 0.0
    return one, other, (other - one) / max(error, least)
