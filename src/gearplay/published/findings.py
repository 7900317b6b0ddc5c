"""Which of the article's claims hold in this simulation, which fail, and which cannot be told: with the numbers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gearplay.model.geometry import amplitude_bound
from gearplay.published.article import LINE_WORDS, LINES, Condition, conditions, printed, printed_rows
from gearplay.published.comparison import (
    LineDifference,
    amplitude_verdict,
    article_error,
    by_condition,
    line_differences,
    model_amplitudes,
    radial_frequency_error,
)
from gearplay.published.han2021 import ConditionResult

HOLDS, FAILS, OPEN = "holds", "fails", "cannot be told"
CLEAR = 2.0  # standard errors
PROMINENT = 1.5  # a line counts as seen when it stands this far above its surroundings


@dataclass(frozen=True)
class Finding:
    """A claim, what became of it, and the evidence in one sentence."""

    claim: str
    verdict: str
    evidence: str


def _log_level(result: ConditionResult, line: str) -> tuple[float, float]:
    """Return mean and standard error of log10(level) over the members [decades]."""
    values = np.log10(np.maximum(result.lines[line].levels, 1e-300))
    error = float(values.std(ddof=1) / math.sqrt(values.size)) if values.size > 1 else math.inf
    return float(values.mean()), error


def _is_largest(
    found: dict[Condition, ConditionResult], top: Condition, others: Sequence[Condition], line: str
) -> tuple[str, str]:
    """Return whether ``top`` has the highest level of a line by more than `CLEAR` standard errors, and the numbers."""
    level, error = _log_level(found[top], line)
    margins = []
    for other in others:
        rival, rival_error = _log_level(found[other], line)
        margins.append((level - rival) / math.hypot(error, rival_error))
    rivals = ", ".join(f"{10 ** _log_level(found[c], line)[0]:.3g}" for c in others)
    words = f"{LINE_WORDS[line]}: {10**level:.3g} against {rivals} m/s²"
    if min(margins) > CLEAR:
        return HOLDS, words
    return (FAILS if min(margins) < -CLEAR else OPEN), words


def _joined(parts: Sequence[tuple[str, str]]) -> tuple[str, str]:
    verdicts = {verdict for verdict, _ in parts}
    words = "; ".join(f"{text} ({verdict})" for verdict, text in parts)
    if verdicts == {HOLDS}:
        return HOLDS, words
    return (FAILS if FAILS in verdicts else OPEN), words


def _peak_at_120(results: Sequence[ConditionResult], model: str) -> tuple[str, str]:
    found = by_condition(results, model)
    slow, middle, fast = (Condition(v, 100.0, 100.0) for v in (60.0, 120.0, 180.0))
    return _joined([_is_largest(found, middle, (slow, fast), line) for line in LINES])


def _grows_with_speed(results: Sequence[ConditionResult]) -> tuple[str, str]:
    found = by_condition(results, "uncoupled")
    speeds = [Condition(v, 100.0, 100.0) for v in (60.0, 120.0, 180.0)]
    parts = []
    for line in LINES:
        levels = [_log_level(found[c], line) for c in speeds]
        steps = [(b[0] - a[0]) / math.hypot(a[1], b[1]) for a, b in pairwise(levels)]
        verdict = HOLDS if min(steps) > CLEAR else FAILS if min(steps) < -CLEAR else OPEN
        parts.append(
            (
                verdict,
                f"{LINE_WORDS[line]}: {', '.join(f'{10**v:.3g}' for v, _ in levels)} m/s² at 60, 120, 180 rpm",
            )
        )
    return _joined(parts)


def _largest_clearance(
    results: Sequence[ConditionResult], model: str, top: tuple[float, float]
) -> tuple[str, str]:
    found = by_condition(results, model)
    sets = [Condition(120.0, c, b) for c, b in ((200.0, 100.0), (100.0, 200.0), (200.0, 200.0))]
    first = Condition(120.0, *top)
    return _joined([_is_largest(found, first, [c for c in sets if c != first], line) for line in LINES])


def _lines_seen(results: Sequence[ConditionResult]) -> Finding:
    counts, weakest = [], math.inf
    for line in LINES:
        heights = [r.lines[line].prominence for r in results]
        counts.append(
            f"{LINE_WORDS[line]} in {sum(h >= PROMINENT for h in heights)} of {len(heights)} spectra"
        )
        weakest = min(weakest, *heights)
    return Finding(
        "Both models show f_r, f_m and 2 f_m in the spectrum (section 3.1).",
        HOLDS if weakest >= PROMINENT else FAILS,
        f"Standing {PROMINENT} times above their surroundings: {', '.join(counts)};"
        f" the weakest stands at {weakest:.2g} times.",
    )


def _models_differ(differences: Sequence[LineDifference]) -> Finding:
    significant = [d for d in differences if d.significant]
    if significant:
        largest = max(significant, key=lambda d: abs(d.decades))
        words = (
            f"{len(significant)} of {len(differences)} lines differ (Welch's test on the members' levels, Holm, 5 %);"
            f" the largest by a factor {10 ** abs(largest.decades):.2g} at {largest.condition.label}, {LINE_WORDS[largest.line]}."
        )
    else:
        words = f"None of {len(differences)} lines differs beyond the ensemble's spread (Welch's test, Holm's correction, 5 %)."
    return Finding("The two backlash models give different vibration.", HOLDS if significant else OPEN, words)


def _coupled_is_better(results: Sequence[ConditionResult]) -> Finding:
    verdict = amplitude_verdict(results)
    words = (
        f"Mean error of the 18 amplitudes, one fitted factor each: coupled {verdict.coupled:.3f},"
        f" uncoupled {verdict.uncoupled:.3f} decades; difference {verdict.difference:+.3f},"
        f" 95 % interval {verdict.low:+.3f} to {verdict.high:+.3f}."
        " Free parameters are assumed, not fitted to the amplitudes: calibration decides, not this table."
    )
    answer = {"coupled": HOLDS, "uncoupled": FAILS}.get(verdict.better, OPEN)
    return Finding(
        "The coupled model is nearer to the test than the uncoupled one (conclusion 3).", answer, words
    )


def _impossible_amplitudes() -> Finding:
    rows = [r for r in printed_rows() if r.quantity == "amplitude_as_printed"]
    over = []
    for row in rows:
        clearance = 1e-6 * row.condition.radial_clearance_um
        for source in ("test", "coupled", "uncoupled"):
            frequency = getattr(printed(row.condition, row.line, "frequency_hz"), source)
            over.append(getattr(row, source) / amplitude_bound(clearance, frequency))
    count = sum(v > 1.0 for v in over)
    return Finding(
        "The amplitudes of Tables 4 and 6 are accelerations in m/s².",
        FAILS,
        f"{count} of {len(over)} exceed what motion within the clearance allows, (4/π) c (2πf)², by up to a factor"
        f" {max(over):.0f}. An un-normalised FFT (one common factor) or displacement in µm would fit; both readings are shown.",
    )


def _readings(results: Sequence[ConditionResult]) -> Finding:
    a = model_amplitudes(results, "coupled")
    words = (
        f"Coupled, un-normalised FFT: factor {a.factor:.4g}, mean error {a.mean_error('unnormalised'):.0f} %;"
        f" displacement in µm: mean error {a.mean_error('displacement'):.0f} %, printed over simulated"
        f" {np.exp(np.mean(np.log(a.test / a.displacement))):.3g} in the mean."
    )
    better = a.mean_error("unnormalised") < a.mean_error("displacement")
    return Finding(
        "The ordinate is an un-normalised FFT rather than a displacement in µm (our reading).",
        HOLDS if better else OPEN,
        words,
    )


def _radial_frequency(results: Sequence[ConditionResult]) -> Finding:
    error = radial_frequency_error(results, "coupled")
    other = radial_frequency_error(results, "uncoupled")
    theirs, also_theirs = (
        article_error(model, "frequency_hz", "radial") for model in ("coupled", "uncoupled")
    )
    ratios = [r.lines["radial"].frequency / r.swing_frequency for r in results]
    words = (
        f"Mean error of f_r over the six conditions with the drag as the one fitted constant: coupled {error:.1f} %, uncoupled"
        f" {other:.1f} %; the article's coupled model {theirs:.1f} %, its uncoupled {also_theirs:.1f} %. Simulated f_r is"
        f" {min(ratios):.2f} to {max(ratios):.2f} times the small swing sqrt(F / (m c)) / 2π under the drag's mesh force F, in"
        " both models: the swing sets its law, sqrt(speed / clearance), bouncing raises it, coupling is not needed."
    )
    return Finding(
        "f_r is the swing of the driven gear in its clearance (our reading).",
        HOLDS if error < 10.0 else FAILS,
        words,
    )


def _slope() -> Finding:
    slope = 2.0 * math.sin(math.radians(20.0))
    return Finding(
        "Backlash changes about 1:1 with the centre distance (section 3), growing with it, (6).",
        FAILS,
        f"The slope at 20° is 2 sin α = {slope:.3f}, and for an internal pair it is negative:"
        " the printed (6) has the external sign.",
    )


def _printed_errors() -> Finding:
    wrong = [
        f"Table {r.table}, {r.condition.label}, {LINE_WORDS[r.line]}, {model}"
        for r in printed_rows()
        for model in ("coupled", "uncoupled")
        if not r.printed_error_follows(model)
    ]
    return Finding(
        "The printed errors follow from the printed values.",
        FAILS if wrong else HOLDS,
        f"{len(wrong)} of {2 * len(printed_rows())} do not: {'; '.join(wrong)}.",
    )


def findings(results: Sequence[ConditionResult]) -> list[Finding]:
    """Return every claim with its verdict; `conditions` and both models must all be in ``results``."""
    assert len(by_condition(results, "coupled")) == len(conditions())
    return [
        _lines_seen(results),
        _models_differ(line_differences(results)),
        _coupled_is_better(results),
        Finding(
            "Coupled: the vibration is largest at 120 rpm (section 3.1).", *_peak_at_120(results, "coupled")
        ),
        Finding("Uncoupled: the amplitude grows with speed (section 3.1).", *_grows_with_speed(results)),
        Finding(
            "Coupled: largest at 200/100 µm of the three changed clearances (section 3.2).",
            *_largest_clearance(results, "coupled", (200.0, 100.0)),
        ),
        Finding(
            "Uncoupled: largest at 200/200 µm (section 3.2).",
            *_largest_clearance(results, "uncoupled", (200.0, 200.0)),
        ),
        _radial_frequency(results),
        _impossible_amplitudes(),
        _readings(results),
        _slope(),
        _printed_errors(),
    ]
