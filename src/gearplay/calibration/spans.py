"""Search ranges of the parameters, and labels and units of their axes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gearplay.calibration.observe import AMPLITUDE, FREQUENCY
from gearplay.calibration.plan import Parameter, Plan, StatisticTarget, to_value
from gearplay.calibration.procedure import Fit, Row
from gearplay.calibration.trials import Problem
from gearplay.model.case import Case
from gearplay.model.field_units import unit_at
from gearplay.model.plan_values import value_at
from gearplay.pictures.words import offset_in, plain, shown_in, shown_unit, wrapped
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import ACCELERATION, contact_unit

AMPLITUDE_UNITS = {"absolute": "m/s²", "unnormalised": "ordinate's unit", "displacement": "µm"}


@dataclass(frozen=True)
class Span:
    """The range in which one parameter was searched: its bounds (or factors) in a unit, log or linear.

    ``factor`` of the unit are one ``si``; ``drawn`` is what the case has there [SI], 1 of a factor.
    """

    name: str
    unit: str
    low: float
    high: float
    scale: str
    si: str = "1"
    factor: float = 1.0
    drawn: float = math.nan

    def words(self, value: float | None, digits: int = 3) -> str:
        """Return a value in SI as text in the unit shown, without it; a dash where there is none.

        >>> span_of("clearance", "m", 4e-5, 2.5e-4, "log").words(1.234e-4)
        '123'
        """
        return (
            "–"
            if value is None or not math.isfinite(value)
            else f"{self.factor * value + offset_in(self.unit):.{digits}g}"
        )

    def ticks(self, most: int) -> tuple[list[float], list[str]]:
        """Return places in the unit interval and their labels: decades, or round numbers; the bounds where none is inside.

        >>> Span("drag", "N m s/rad", 1e-4, 1e-2, "log").ticks(3)[0]
        [0.0, 0.5, 1.0]
        """
        if self.scale == "log":
            low, high = math.log10(self.low), math.log10(self.high)
            decades = range(math.floor(low), math.ceil(high) + 1)
            wide = high - low >= 2.0
            steps = (1,) if wide else (1, 3) if high - low >= 1.0 else (1, 2, 5)
            values = [float(f"{m}e{d}") for d in decades for m in steps]
            values = [v for v in values if self.low <= v * (1.0 + 1e-9) and v <= self.high * (1.0 + 1e-9)]
            values = values[:: max(1, math.ceil(len(values) / most))]
            places = [(math.log10(v) - low) / (high - low) for v in values]
            labels = [f"$10^{{{round(math.log10(v))}}}$" if wide else f"{v:.3g}" for v in values]
        else:
            from matplotlib.ticker import MaxNLocator

            found = MaxNLocator(max(2, most - 1)).tick_values(self.low, self.high)
            inside = [float(v) for v in found if self.low <= v <= self.high]
            places = [(v - self.low) / (self.high - self.low) for v in inside]
            labels = [f"{v:.4g}" for v in inside]
        if len(places) >= 2:
            return places, labels
        return [0.0, 1.0], [f"{to_value(u, self.low, self.high, self.scale):.3g}" for u in (0.0, 1.0)]


Spans = Mapping[str, Sequence[Span]]  # by model


def span_of(name: str, unit: str, low: float, high: float, scale: str, drawn: float = math.nan) -> Span:
    """Return a range in SI as engineers read it: short lengths in micrometres, angles in degrees.

    >>> span_of("clearance", "m", 4e-5, 2.5e-4, "log").ticks(5)[1]
    ['50', '100', '200']
    """
    shown, factor = shown_in(unit, max(abs(low), abs(high)))
    low, high = (factor * end + offset_in(shown) for end in (low, high))
    return Span(name, shown, low, high, scale, unit, factor, drawn)


def label_of(span: Span) -> str:
    """Return a parameter's name and unit for an axis, in lines of at most 15 characters."""
    return plain(wrapped(span.name, 15)) + f"\n[{plain(span.unit)}]"


def spans_of(plan: Plan, fits: Sequence[Fit]) -> Spans:
    """Return the range searched of every parameter, by model."""
    found = {}
    for model in plan.models:
        best = next((fit.best for fit in fits if fit.model == model.name), None)
        if best is None:
            continue
        problem = Problem(plan, model)
        case = problem.cases_at(best)[0]
        found[model.name] = tuple(
            span_of(
                p.name,
                unit_at(case, p.path) if p.mode == "set" else "1",
                *bounds,
                p.scale,
                _drawn(problem.cases[0], p),
            )
            for p, bounds in zip(problem.parameters, problem.bounds, strict=True)
        )
    return found


def _drawn(case: Case, parameter: Parameter) -> float:
    """Return the value of a free parameter in a case [SI], 1 for a scale factor; NaN where the case has no number there."""
    if parameter.mode == "scale":
        return 1.0
    try:
        value = value_at(case, parameter.path)
    except InputError:
        return math.nan
    return math.nan if isinstance(value, bool) or not isinstance(value, (int, float)) else float(value)


def datum_unit(plan: Plan, reading: str, row: Row) -> str:
    """Return the unit in which one datum is measured and simulated."""
    if row.key == FREQUENCY:
        return "Hz"
    if row.key == AMPLITUDE:
        return AMPLITUDE_UNITS[reading]
    target = next(t for t in plan.targets if t.name == row.target)
    if not isinstance(target, StatisticTarget):
        return "1"
    if target.statistic == "rms":
        return shown_unit(ACCELERATION.unit)
    if target.contact is None:
        return "1"
    return contact_unit(target.statistic, angular=target.contact.endswith((":forward", ":backward")))
