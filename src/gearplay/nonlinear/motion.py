"""What kind of motion a case has: its section classified, its largest exponent, and whether numbers of the method decide it."""

import json
import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.reading import replace
from gearplay.nonlinear.kinds.classify import Response, classify
from gearplay.nonlinear.lyapunov import lyapunov_exponents
from gearplay.nonlinear.section_choice import AUTO, chosen_period, with_repetition
from gearplay.pictures.style import COUPLED, UNCOUPLED, new_axes
from gearplay.pictures.words import plain
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.provenance import provenance
from gearplay.solver.compiling import prepare
from gearplay.solver.flow import Flow
from gearplay.solver.limits import check_work
from gearplay.solver.simulate import run_members
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.progress import Progress

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

ARTEFACT = "numerical artefact"
TRUSTED = 1e4  # allowed local errors that a settled state may differ by at the section
LONGEST = 40.0  # s over which the exponent is measured
FEWEST = 20  # periods of it at least
SWINGS, PARTS = 8, 32  # periods, and instants in each, at which the motion within a period is evaluated
DOUBT = 1e-3  # chance of calling any statistic changed that is not
ROUNDING, SAMPLED, PLAIN = 1e-6, 1e-3, 0.02
"""Relative differences that mean nothing: of what does not scatter at all, of samples farther apart, of plain steps, which see
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


@dataclass(frozen=True, repr=False)
class Motion(AnalysisResult):
    """Kind of a motion, the reason for it, and the evidence.

    ``kind`` is the kind of ``response``, or "numerical artefact" where a statistic changes beyond its spread with the tolerance,
    the output step or the method; ``exponent`` is the largest Lyapunov exponent [1/s] with the half-width of its 95 % interval
    (NaN for a case with ``run.fixed_step``, whose motion has no exact derivative), ``period`` [s] that of the section. ``limit``
    is the t value above which a comparison counts as changed.
    """

    kind: str
    order: int | None
    reason: str
    response: Response
    exponent: tuple[float, float]
    period: float
    comparisons: tuple[Comparison, ...]
    limit: float
    case: Case

    result_kind = "motion"

    @property
    def ds(self) -> "xr.Dataset":
        """The comparisons as columns; kind, reason, exponent and evidence as attributes."""
        import xarray as xr

        words = {
            "change": "what of the method was changed",
            "statistic": "statistic of the ensemble",
            "usual": "mean of the ensemble, SI",
            "changed": "mean with the changed method, SI",
            "t": "their difference over its standard error",
        }
        columns = {
            name: (
                "comparison",
                _column([getattr(each, name) for each in self.comparisons]),
                {"long_name": about},
            )
            for name, about in words.items()
        }
        response = {"kind": self.response.kind, "reason": self.response.reason, "order": self.response.order,
                    "evidence": dict(self.response.evidence)}  # fmt: skip
        attributes: dict[str, Any] = {
            "kind": self.kind,
            "order": json.dumps(self.order),
            "reason": self.reason,
            "response": json.dumps(response),
            "exponent": np.array(self.exponent),
            "period": self.period,
            "limit": self.limit,
        }
        return xr.Dataset(columns, attrs=provenance(self.case, **attributes))

    @classmethod
    def from_dataset(cls, dataset: "xr.Dataset") -> Self:
        """Return the object whose ``ds`` it was."""
        check_kind(dataset, cls.result_kind)
        a = dataset.attrs
        names = ("change", "statistic", "usual", "changed", "t")
        rows = zip(*(dataset[name].values.tolist() for name in names), strict=True)
        return cls(
            kind=str(a["kind"]),
            order=json.loads(a["order"]),
            reason=str(a["reason"]),
            response=Response(**json.loads(a["response"])),
            exponent=(float(a["exponent"][0]), float(a["exponent"][1])),
            period=float(a["period"]),
            comparisons=tuple(Comparison(*row) for row in rows),
            limit=float(a["limit"]),
            case=case_in(dataset),
        )

    @property
    def message(self) -> str:
        """Kind and reason as text."""
        order = f" of order {self.order}" if self.order and self.kind == "periodic" else ""
        return f"{self.kind}{order}. {self.reason}"

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return exponent, period and the comparison that differs most."""
        found = [("section once per", f"{self.period:.4g} s")]
        if math.isfinite(self.exponent[0]):
            value, half = self.exponent
            found.append(("largest Lyapunov exponent", f"{value:.4g} ± {half:.2g} 1/s (95 %)"))
        for c in sorted(self.comparisons, key=lambda each: -abs(each.t))[:3]:
            words = f"{c.usual:.4g} to {c.changed:.4g}, t = {c.t:.2g} (chance up to {self.limit:.3g})"
            found.append((f"{c.statistic} with {c.change}", words))
        return found

    def plot(self, *, ax: "Axes | None" = None) -> "Axes":
        """Draw the change of each statistic with the numerical settings, in standard errors, and the limit of chance."""
        drawn = ax if ax is not None else new_axes(7.5, 1.2 + 0.16 * len(self.comparisons))
        shown = [c for c in self.comparisons if math.isfinite(c.t)][::-1]
        names = [plain(f"{c.statistic}, {c.change}") for c in shown]
        drawn.barh(range(len(shown)), [abs(c.t) for c in shown], color=COUPLED, height=0.6)
        drawn.set_yticks(range(len(shown)), names, fontsize=5.5)
        if math.isfinite(self.limit):
            drawn.axvline(self.limit, color=UNCOUPLED, linewidth=1.0)
        drawn.set_xlabel("difference [standard errors]; line: what is still chance", fontsize=8)
        drawn.set_title(self.kind, fontsize=9)
        return drawn


def _column(values: Sequence[Any]) -> NDArray[Any]:
    text = any(isinstance(value, str) for value in values)
    return np.array(values, dtype=object if text else np.float64)


def identify_motion(
    case: Case,
    *,
    periods: int = 1000,
    settle: int = 300,
    period: str | float = AUTO,
    ensemble: int = 12,
    compare: bool = True,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Motion:
    """Return what kind of motion a case settles to, from ``periods`` sections after ``settle`` periods.

    With ``compare`` an ensemble of ``ensemble`` runs, as long as the case's duration, is repeated with a hundredth of the
    tolerance, with a third of the output step, and by another method: plain steps of one length, 126 in a period of the fastest
    contact, that notice contacts at their ends (for a case with ``run.fixed_step``: half the step, and located contacts). What
    changes then beyond its spread is no property of the mechanism.

    Raises `InputError` for a case without a period or numbers that cannot be, `SimulationError` where the motion cannot be
    followed.
    """
    for name, number, least in (("periods", periods, 100), ("settle", settle, 0), ("ensemble", ensemble, 4)):
        if number < least:
            raise InputError(Fault(name, number, f"must be {least} or more", "Raise it"))
    tell = progress or (lambda what, done, total: None)
    flow = Flow(case)
    chosen = chosen_period(flow.packed, period)
    step = chosen.step
    seconds = (settle + periods) * step * (1 + ensemble)
    check_work("motion", flow.packed, seconds=seconds, numbers=20.0 * periods * (1 + ensemble))
    prepare(case, derivative=case.run.fixed_step is None)
    samples, swing = _section(flow, step, periods, settle, tell, stop)
    resolution = TRUSTED * case.run.tolerance * flow.natural[flow.free]
    value, half, known = math.nan, math.nan, None
    if case.run.fixed_step is None:
        span = max(min(periods * step, LONGEST), FEWEST * step)
        found = lyapunov_exponents(
            case,
            count=1,
            duration=span,
            transient=settle * step,
            progress=lambda done, total: tell("exponent", done, total),
        )
        value, half = found.largest
        known = (value * step, 0.5 * half * step)
    response = classify(samples, resolution=resolution, exponent=known, swing=swing)
    response = with_repetition(response, samples, resolution, chosen)
    comparisons, limit = _compare(flow, ensemble, tell, stop) if compare else ((), math.inf)
    worst = max(comparisons, key=lambda each: abs(each.t), default=None)
    if worst is not None and abs(worst.t) > limit:
        reason = (
            f"With {worst.change} the {worst.statistic} is {worst.changed:.4g} instead of {worst.usual:.4g}, "
            f"{abs(worst.t):.3g} standard errors apart where {limit:.3g} are chance: the numbers of the method decide it."
        )
        return Motion(ARTEFACT, None, reason, response, (value, half), step, comparisons, limit, case)
    r = response
    return Motion(r.kind, r.order, r.reason, r, (value, half), step, comparisons, limit, case)


def _section(
    flow: Flow, step: float, periods: int, settle: int, tell: Progress, stop: threading.Event | None
) -> tuple[Floats, Floats]:
    """Return the free states once per period, shape [period, state], and their swing within a period, shape [state]."""
    course = flow.begin(flow.start(), stop=stop)
    for at in range(1, settle + 1):
        course.advance(at * step)
        tell("settling", float(at), float(settle))
    samples = np.empty((periods, len(flow.free)))
    for at in range(periods):
        course.advance((settle + at) * step)
        samples[at] = flow.seen(course.time, course.state)
        tell("section", at + 1.0, float(periods))
    within = np.empty((SWINGS, PARTS, len(flow.free)))
    for at in range(SWINGS * PARTS):
        course.advance((settle + periods - 1 + (at + 1) / PARTS) * step)
        within[at // PARTS, at % PARTS] = flow.seen(course.time, course.state)
    return samples, np.median(np.ptp(within, axis=1), axis=0)


def _changes(flow: Flow) -> dict[str, tuple[Mapping[str, Any], float]]:
    """Return how the method of a case is changed, and which relative difference of a statistic means nothing then."""
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


def _compare(
    flow: Flow, members: int, tell: Progress, stop: threading.Event | None
) -> tuple[tuple[Comparison, ...], float]:
    """Return the statistics of an ensemble against those of changed methods, and the t that is still chance."""
    from scipy.special import stdtrit

    names = _moving(flow)
    free = dict(zip(flow.free_names, flow.natural[flow.free], strict=False))
    floors = {f"{DEVIATION}{name}": flow.case.run.tolerance * float(free[name]) for name in names}
    usual = _statistics(flow.case, names, members, "ensemble", tell, stop)
    found = []
    for change, (values, least) in _changes(flow).items():
        changed = _statistics(replace(flow.case, values), names, members, change, tell, stop)
        found += [
            Comparison(change, name, *_welch(usual[name], changed[name], least, floors.get(name, 0.0)))
            for name in usual
            if name in changed
        ]
    freedom = float(members - 1)  # the least that Welch's degrees of freedom can be
    return tuple(found), float(stdtrit(freedom, 1.0 - 0.5 * DOUBT / max(1, len(found))))


def _moving(flow: Flow) -> list[str]:
    """Return the signals of velocities that are not prescribed, ``rotor.signal``."""
    return [name for name in flow.free_names if name.rpartition(".")[2] in ("vx", "vy", "omega")]


def _statistics(
    case: Case, names: list[str], members: int, label: str, tell: Progress, stop: threading.Event | None
) -> dict[str, Floats]:
    """Return statistics of each member, shape [member], by name; NaN for a member that did not finish."""
    runs = run_members(
        case,
        range(1, members + 1),
        signals=names,
        stop=stop,
        progress=lambda done, total: tell(label, done, total),
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
