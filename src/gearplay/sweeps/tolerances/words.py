"""Conclusions of a tolerance study in sentences."""

import math
from collections.abc import Sequence

from gearplay.sweeps.plans.design import Random
from gearplay.sweeps.tolerances.allowable import ALL, NONE, UNKNOWN, Allowable, size_words
from gearplay.sweeps.tolerances.figures import Scale, percent
from gearplay.sweeps.tolerances.statistics import Cut, Exceedance
from gearplay.sweeps.variance import Indices, shares_words, spoken

KEPT, EXCEEDED, OPEN = "kept", "exceeded", "open"
CAPTION = {
    KEPT: "The limit is kept.",
    EXCEEDED: "The limit is not kept.",
    OPEN: "The sample does not decide whether the limit is kept: draw more points.",
}
STANDING = {KEPT: "kept", EXCEEDED: "not kept", OPEN: "cannot be told"}


def _counted(number: int, name: str) -> str:
    """Return a number of things.

    >>> _counted(1, "case"), _counted(2, "case")
    ('1 case', '2 cases')
    """
    return f"{number} {name}" + ("" if number == 1 else "s")


def verdict_of(found: Exceedance, wanted: float) -> str:
    """Return "kept" or "exceeded" where the whole interval lies on one side of ``wanted``, failed cases included; else "open".

    >>> from gearplay.sweeps.tolerances.statistics import exceedance
    >>> import numpy as np
    >>> verdict_of(exceedance(np.zeros(100), 1.0), 0.95), verdict_of(exceedance(np.zeros(10), 1.0), 0.95)
    ('kept', 'open')
    """
    allowed = 1.0 - wanted
    if found.bounds[1] <= allowed:
        return KEPT
    return EXCEEDED if found.bounds[0] > allowed else OPEN


def exceedance_words(found: Exceedance, measure: str, scale: Scale, wanted: float) -> list[str]:
    """Return the verdict, the probability with its interval, and the possible effect of failed cases."""
    cases = f"{_counted(found.cases, 'case')} of {_counted(found.samples, 'drawn point')}"
    if not found.cases:
        return [f"No case finished: nothing can be said of {measure}."]
    lines = [
        f"{CAPTION[verdict_of(found, wanted)]} {measure} exceeds {scale.words(found.limit, 4)} with probability "
        f"{percent(found.probability)} ({percent(found.confidence)} interval {percent(found.low)} to {percent(found.high)}, "
        f"{cases}); allowed: {percent(1.0 - wanted)}."
    ]
    if found.failed:
        lines.append(
            f"{_counted(found.failed, 'case')} failed and left out; whatever became of them, the probability lies between "
            f"{percent(found.bounds[0])} and {percent(found.bounds[1])}."
        )
    return lines


def indices_words(found: Indices) -> list[str]:
    """Return the most important parameter, the unexplained scatter, and the error of a polynomial as sentences."""
    if found.reason:
        return [f"No Sobol indices: {found.reason}."]
    top = found.ranking[0]
    made = "a saltelli design" if found.source == "sobol" else f"a polynomial of degree {found.degree}"
    noise = found.noise if found.source == "sobol" and math.isfinite(found.noise) else 0.0
    clear = found.total[top] - found.total_error[top] > noise
    who = (
        f"{spoken(found.names[top])} matters most"
        if clear
        else f"No parameter can be told to matter; first comes {spoken(found.names[top])}"
    )
    first = f"first order {found.first[top]:.2f} ± {found.first_error[top]:.2f}"
    total = f"total index {found.total[top]:.2f} ± {found.total_error[top]:.2f}, {first}"
    shown = total if found.source == "sobol" or found.degree > 1 else f"{first}, no interactions seen"
    lines = [f"{who[0].upper()}{who[1:]}: {shown} (from {made}, {found.used} points)."]
    lines.append(shares_words(found))
    if math.isfinite(found.unexplained):
        lines.append(
            f"The polynomial leaves {percent(found.unexplained)} of the variance unexplained when each point is predicted "
            f"from the others{'; a saltelli design would separate more' if found.unexplained > 0.2 else ''}."
        )
    if math.isfinite(found.noise):
        tail = ", contained in every total index" if found.source == "sobol" else ""
        share = percent(found.noise) if found.noise < 1.0 else "As much as all"
        lines.append(
            f"{share} of the variance of the members' mean is scatter among members, which no parameter explains{tail}"
            f"{': more members per point would reduce the noise' if found.noise > 0.5 else ''}."
        )
    return lines


def cut_words(cut: Cut, scale: Scale) -> str:
    """Return the effect of the best cut as a sentence."""
    side = "below" if cut.end == "low" else "above"
    return (
        f"Without draws of {spoken(cut.name)} {side} {scale.words(cut.bound)} (a fifth of them) the probability to exceed the "
        f"limit would be {percent(cut.probability)} ({percent(cut.low)} to {percent(cut.high)})."
    )


def search_words(found: Allowable, parameters: Sequence[Random], scaling: str = "size") -> list[str]:
    """Return the allowable sizes of the parameters as sentences, in the units of the plan, the safe factor first."""
    names = " and ".join(spoken(p.name) for p in parameters)
    low, high = found.steps[0].factor, found.steps[-1].factor
    failed = sum(step.failed for step in found.steps)
    note = [f"{_counted(failed, 'case')} of the search failed, counted as over the limit."] if failed else []
    if found.verdict == UNKNOWN:
        return ["No case of the search finished: nothing can be said of other sizes."]
    if found.verdict == NONE:
        best = max(found.steps, key=lambda step: step.meets)
        span = f"{names} from {low:.4g} to {high:.4g}"
        words = f"No factor of {span} keeps to the limit with probability {percent(found.wanted)}."
        if max(step.high for step in found.steps) >= found.wanted:
            words = (
                f"The sample does not decide whether a factor of {span} keeps to the limit with probability "
                f"{percent(found.wanted)}: draw more points."
            )
        return [
            words,
            f"The best is × {best.factor:.4g} with {percent(best.meets)} ({percent(best.low)} to {percent(best.high)}).",
            *note,
        ]
    if not found.single:
        warning = (
            "Smaller factors exceed the limit too often as well: see the figure before using the answer."
        )
        return [_advice(found, parameters, scaling), warning, *_check_words(found), *note]
    return [_advice(found, parameters, scaling), *_check_words(found), _estimate(found), *note]


def _advice(found: Allowable, parameters: Sequence[Random], scaling: str) -> str:
    sizes = " and ".join(
        f"{spoken(p.name)} of {size_words(p, scaling, found.advised)}" for p in parameters[:3]
    ) + (f" and {len(parameters) - 3} more" if len(parameters) > 3 else "")
    factor = f"× {found.advised:.3g}"
    if found.verdict == ALL and found.advised == found.factor:
        factor += ", the largest factor of the range"
    if found.safe:
        return (
            f"Safe with {percent(found.confidence)} confidence: {sizes} ({factor}); the limit is then kept with probability "
            f"{percent(found.wanted)} or more."
        )
    return (
        f"No factor can be called safe with {percent(found.confidence)} confidence: draw more points. By this sample alone: "
        f"{sizes} ({factor})."
    )


def _estimate(found: Allowable) -> str:
    """Return the estimated position of the limit as text, as far as the sample determines it."""
    _, high = found.span
    if found.verdict == ALL:
        return (
            "The true limit may lie beyond the range."
            if math.isinf(high)
            else f"The true limit lies below × {high:.3g}."
        )
    end = "may lie beyond the range" if math.isinf(high) else f"lies below × {high:.3g}"
    return (
        f"By the sample alone the limit is kept up to × {found.factor:.3g} and not at × {found.factor + found.resolution:.3g}; "
        f"with {percent(found.confidence)} confidence the true limit {end}."
    )


def _check_words(found: Allowable) -> list[str]:
    if found.check is None:
        return ["It was not checked by fresh points."]
    verdict = {
        True: "confirms it",
        False: "contradicts it: draw more points",
        None: "agrees within its uncertainty",
    }[found.confirmed]
    return [
        f"A fresh sample at × {found.check.factor:.3g} keeps to the limit with probability {percent(found.check.meets)} "
        f"({percent(found.check.low)} to {percent(found.check.high)}; wanted {percent(found.wanted)}): it {verdict}."
    ]
