"""Kind of motion of a case, from its section, its largest exponent and changes of the numerical method."""

import json
import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.reading import Source
from gearplay.nonlinear.kinds.classify import Response, classify
from gearplay.nonlinear.lyapunov import lyapunov_exponents
from gearplay.nonlinear.method_comparison import Comparison, compare_methods
from gearplay.nonlinear.orbits.period_map import sharp
from gearplay.nonlinear.record_length import check_span
from gearplay.nonlinear.section_choice import AUTO, chosen_period, with_repetition
from gearplay.pictures.style import COUPLED, UNCOUPLED, new_axes
from gearplay.pictures.words import plain, shown_in
from gearplay.results.base import AnalysisResult, case_in, check_kind
from gearplay.results.provenance import provenance
from gearplay.results.simulate import case_of
from gearplay.solver.deadline import limited
from gearplay.solver.flow import Flow
from gearplay.solver.limits import check_work
from gearplay.vocabulary.progress import Progress, ticking

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

ARTEFACT = "numerical artefact"
TRUSTED = 1e4  # allowed local errors that a settled state may differ by at the section
LONGEST = 40.0  # s over which the exponent is measured
FEWEST = 20  # periods of it at least
SWINGS, PARTS = 8, 32  # periods, and instants in each, at which the motion within a period is evaluated


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
        columns: dict[str, Any] = {}
        for name, about in words.items():
            kind = object if self.comparisons and name in ("change", "statistic") else np.float64
            values = np.array([getattr(each, name) for each in self.comparisons], dtype=kind)
            columns[name] = ("comparison", values, {"long_name": about})
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
        rows = zip(*(dataset[each.name].values.tolist() for each in fields(Comparison)), strict=True)
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
        unit, factor = shown_in("s", self.period)
        found = [("section once per", f"{factor * self.period:.4g} {unit}")]
        value, half = self.exponent
        known = math.isfinite(value)
        text = (
            f"{value:.4g} ± {half:.2g} 1/s (95 %)"
            if known
            else "not computed: no exact derivative with run.fixed_step"
        )
        found.append(("largest Lyapunov exponent", text))
        for c in sorted(self.comparisons, key=lambda each: -abs(each.t))[:3]:
            words = f"{c.statistic} {c.changed:.4g} instead of {c.usual:.4g}, {abs(c.t):.2g} standard errors apart"
            found.append((f"with {c.change}", f"{words} ({self.limit:.3g} may be chance)"))
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


def motion(
    case: Source,
    *,
    periods: int = 1000,
    settle: int = 300,
    period: str | float = AUTO,
    ensemble: int = 12,
    compare: bool = True,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Motion:
    """Classify the settled motion of a case: periodic, quasi-periodic, chaotic, at rest or a numerical artefact.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; computed at its tolerance, at 1e-9 if that is looser.
    periods
        Number of sections that are evaluated, 100 or more.
    settle
        Periods before.
    period
        Between sections: "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"),
        or a time [s]. "auto" is the common one up to 20 mesh periods, else, as with hunting teeth, that of the mesh.
    ensemble
        Members of each ensemble that is compared, 4 or more.
    compare
        Whether ensembles are repeated with other numbers of the method: what changes then beyond its spread is an artefact.
    progress
        Called with what is running, how much is done, and of how much.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.

    Returns
    -------
    Motion
        ``kind``, ``reason``, the largest exponent [1/s] with the half-width of its 95 % interval, and the comparisons.

    Raises
    ------
    InputError
        For a case without a period, and for invalid numbers.
    SimulationError
        Where the motion cannot be followed.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.motion(gp.torsional_pair(0.7, force=0.05), periods=200, compare=False)
    >>> found.kind, found.order
    ('periodic', 1)

    """
    base = sharp(case_of(case))
    if not isinstance(period, str):
        check_span(base, "period", period, periods * period, per=1.0 / periods)
    report = progress or (lambda what, done, total: None)
    with limited(base.run.max_wall_time) as time_left:
        flow = Flow(base)
        chosen = chosen_period(flow.packed, period)
        step, has_derivative = chosen.step, base.run.fixed_step is None
        seconds = (settle + periods) * step * (1 + ensemble)
        check_work("motion", flow.packed, seconds=seconds, numbers=20.0 * periods * (1 + ensemble))
        samples, swing = _section(flow, step, periods, settle, report, stop)
        resolution = TRUSTED * base.run.tolerance * flow.natural[flow.free]
        exponent, known = (math.nan, math.nan), None
        if has_derivative:
            exponent = lyapunov_exponents(
                base,
                count=1,
                duration=max(min(periods * step, LONGEST), FEWEST * step),
                transient=settle * step,
                progress=ticking(report, "exponent"),
            ).largest
            known = (exponent[0] * step, 0.5 * exponent[1] * step)
        response = classify(samples, resolution=resolution, exponent=known, swing=swing)
        response = with_repetition(response, samples, resolution, chosen)
        comparisons, limit = compare_methods(flow, ensemble, report, stop) if compare else ((), math.inf)
    kind: str = response.kind
    order, reason = response.order, response.reason
    worst = max(comparisons, key=lambda each: abs(each.t), default=None)
    if time_left.has_stopped:
        reason += " Within run.max_wall_time it was not compared with other numbers of the method."
        comparisons, limit = (), math.inf
    elif worst is not None and abs(worst.t) > limit:
        kind, order = ARTEFACT, None
        reason = (
            f"With {worst.change} the {worst.statistic} is {worst.changed:.4g} instead of {worst.usual:.4g}, "
            f"{abs(worst.t):.3g} standard errors apart where {limit:.3g} are chance: the numbers of the method decide it."
        )
    return Motion(kind, order, reason, response, exponent, step, comparisons, limit, base)


def _section(
    flow: Flow, step: float, periods: int, settle: int, report: Progress, stop: threading.Event | None
) -> tuple[Floats, Floats]:
    """Return the free states once per period, shape [period, state], and their peak-to-peak values within one, shape [state]."""
    integration = flow.begin(flow.start(), stop=stop)
    for at in range(1, settle + 1):
        integration.advance(at * step)
        report("settling", float(at), float(settle))
    samples = np.empty((periods, len(flow.free)))
    for at in range(periods):
        integration.advance((settle + at) * step)
        samples[at] = flow.seen(integration.time, integration.state)
        report("section", at + 1.0, float(periods))
    within = np.empty((SWINGS, PARTS, len(flow.free)))
    for at in range(SWINGS * PARTS):
        integration.advance((settle + periods - 1 + (at + 1) / PARTS) * step)
        within[at // PARTS, at % PARTS] = flow.seen(integration.time, integration.state)
    return samples, np.median(np.ptp(within, axis=1), axis=0)
