"""Verdict on each claim of the article: reproduced, explained, contradicted or open, with the numbers."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearplay.model.geometry import amplitude_bound
from gearplay.published import audit
from gearplay.published.article import LINE_WORDS, LINES, conditions, printed, printed_rows
from gearplay.published.calibrated import calibration, duel_of, fit_of
from gearplay.published.claims.floor import runs_needed
from gearplay.published.claims.summary import favoured_words, is_rare, rare_words
from gearplay.published.comparison import (
    LineDifference,
    amplitude_verdict,
    article_error,
    by_condition,
    lasting_shares,
    line_differences,
    model_amplitudes,
    radial_frequency_error,
    shaking,
    swing_lasts,
)
from gearplay.published.han2021 import LATER, ConditionResult
from gearplay.published.patterns import (
    CONTRADICTED,
    EXPLAINED,
    GROUPS,
    OPEN,
    REPRODUCED,
    grows_with_speed,
    largest_clearance,
    peak_at_120,
)

PROMINENT = 1.5  # a line counts as seen when it stands this far above its surroundings
GOOD_AMPLITUDES, GOOD_FREQUENCIES = 20.0, 8.0  # per cent: what counts as reproduced


@dataclass(frozen=True)
class Finding:
    """A claim, its group, the evidence in a few sentences, and the figure that shows it."""

    claim: str
    verdict: str
    evidence: str
    figure: str


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
        REPRODUCED if weakest >= PROMINENT else CONTRADICTED if weakest <= 1.0 else OPEN,
        f"Standing {PROMINENT} times above their surroundings: {', '.join(counts)};"
        f" the weakest stands at {weakest:.2g} times.",
        "spectrum-120rpm-100-100",
    )


def _amplitudes_met(results: Sequence[ConditionResult]) -> Finding:
    ours = model_amplitudes(results, "coupled").mean_error("unnormalised")
    theirs = article_error("coupled", "amplitude_as_printed")
    return Finding(
        "The coupled model meets the measured amplitudes.",
        REPRODUCED if ours <= GOOD_AMPLITUDES and swing_lasts(results, "coupled") else OPEN,
        f"Mean error of the 18 amplitudes with one common factor, on members that no fit has seen: {ours:.0f} %;"
        f" the article reports {theirs:.1f} % after a fit that it does not describe.{_lasting_words(results, 'coupled')}",
        "lead",
    )


def _lasting_words(results: Sequence[ConditionResult], model: str) -> str:
    shares = lasting_shares(results, model)
    if not shares:
        return ""
    low, high = (f"{100.0 * s:.2g}" if s < 0.1 else f"{100.0 * s:.0f}" for s in (min(shares), max(shares)))
    left = f"{LATER:g} s later it has {low} to {high} % of its amplitude"
    if not swing_lasts(results, model):
        return f" But the swing f_r does not last: {left}. It is what is left of the drawn starts."
    floor = shaking(results, model)
    if not floor:
        return ""
    return (
        f" The swing f_r lasts ({left}), since the fit lets the floor shake, by {floor:.2g} mm/s² rms;"
        " the article's equations have nothing that keeps it up."
    )


def _models_differ(differences: Sequence[LineDifference]) -> Finding:
    significant = [d for d in differences if d.significant]
    if significant:
        largest = max(significant, key=lambda d: abs(d.decades))
        words = (
            f"With the same parameters {len(significant)} of {len(differences)} lines differ (Welch's test on the members'"
            f" levels, Holm, 5 %); the largest by {20.0 * abs(largest.decades):.1f} dB at {largest.condition.label},"
            f" {LINE_WORDS[largest.line]}; the median of all is {20.0 * _median(differences):.1f} dB."
        )
    else:
        words = f"None of {len(differences)} lines differs beyond the ensemble's spread (Welch's test, Holm's correction, 5 %)."
    return Finding(
        "The two backlash models give different vibration.",
        REPRODUCED if significant else OPEN,
        words,
        "coupled-over-uncoupled",
    )


def _median(differences: Sequence[LineDifference]) -> float:
    return float(np.median([abs(d.decades) for d in differences]))


def _coupled_is_better(results: Sequence[ConditionResult], *, calibrated: bool) -> Finding:
    claim = "The coupled model is nearer to the test than the uncoupled one (conclusion 3)."
    verdict = amplitude_verdict(results)
    words = (
        f"Mean error of the 18 amplitudes, each model with its own parameters and one factor: coupled {verdict.coupled:.3f},"
        f" uncoupled {verdict.uncoupled:.3f} decades; difference {verdict.difference:+.3f}, 95 % interval of the members"
        f" {verdict.low:+.3f} to {verdict.high:+.3f}."
    )
    if not calibrated:
        return Finding(
            claim, OPEN, f"{words} The parameters are assumed: a fit decides, not this comparison.", "lead"
        )
    answer = {None: OPEN, "coupled": REPRODUCED}.get(calibration()["winner"], CONTRADICTED)
    duel = duel_of("coupled", "uncoupled")
    told = duel["winner"] in (duel["first"], duel["second"])
    better = f"the {duel['winner']} one is better" if told else "which is better cannot be told"
    said = (
        f"{better}; for the coupled one (against it where negative): ln odds {duel['log_odds']:+.1f} ±"
        f" {duel['log_odds_error']:.1f}, predictions of conditions left out {duel['predictive']:+.1f} ±"
        f" {duel['predictive_error']:.1f}."
    )
    fresh = " and ".join(f"{fit_of(model)['fresh'][0]:.0f} %" for model in ("coupled", "uncoupled"))
    fitted = f"The calibration, where both were fitted alike ({fresh} on fresh members): {said}"
    return Finding(claim, answer, f"{words} {fitted}", "lead")


def _impossible_amplitudes(results: Sequence[ConditionResult]) -> Finding:
    rows = [r for r in printed_rows() if r.quantity == "amplitude_as_printed"]
    over = []
    for row in rows:
        clearance = 1e-6 * row.condition.radial_clearance_um
        for source in audit.SOURCES:
            frequency = getattr(printed(row.condition, row.line, "frequency_hz"), source)
            over.append(getattr(row, source) / amplitude_bound(clearance, frequency))
    count = sum(v > 1.0 for v in over)
    a = model_amplitudes(results, "coupled")
    return Finding(
        "The amplitudes of Tables 4 and 6 are accelerations in m/s².",
        EXPLAINED,
        f"{count} of {len(over)} exceed what motion within the clearance allows, (4/π) c (2πf)², by up to a factor"
        f" {max(over):.0f}. As an FFT without its normalisation, with one common factor (here {a.factor:.4g}), they are met"
        f" to {a.mean_error('unnormalised'):.0f} %; as displacements in µm, without a factor, to"
        f" {a.mean_error('displacement'):.0f} %.",
        "lead",
    )


def _free_factor() -> Finding:
    coupled, uncoupled = audit.free_factor("coupled"), audit.free_factor("uncoupled")
    return Finding(
        "The coupled model's error is 7.3 %, the uncoupled model's 27.8 % (Tables 4 and 6).",
        EXPLAINED,
        f"With one free factor of the ordinate the uncoupled error falls from {uncoupled.as_printed:.1f} to"
        f" {uncoupled.with_factor:.1f} %, the coupled one from {coupled.as_printed:.1f} to {coupled.with_factor:.1f} %:"
        " most of the distance is one common factor.",
        "audit",
    )


def _frequency_readings() -> Finding:
    once, twice = (audit.reading_scatter(line) for line in audit.MESH_LINES)
    correlation, p = audit.harmonic_correlation()
    low, high = audit.error_of_readings()
    coupled, uncoupled = (audit.radial_error(model) for model in ("coupled", "uncoupled"))
    return Finding(
        "The models' errors of f_r, 16.2 and 17.1 %, say which model is right.",
        EXPLAINED,
        f"The 18 readings each of f_m and 2 f_m, which the speed sets, scatter by {once:.2f} and {twice:.2f} Hz rms,"
        f" uncorrelated (r = {correlation:.2f}, p = {p:.2f}), so they are reading errors; f_r is off by {coupled:.2f} and"
        f" {uncoupled:.2f} Hz. Two perfect readings with such errors would differ by {low:.0f} to {high:.0f} %: these errors"
        " carry no information on the model.",
        "audit",
    )


def _radial_frequency(results: Sequence[ConditionResult]) -> Finding:
    error, other = (radial_frequency_error(results, model) for model in ("coupled", "uncoupled"))
    theirs = article_error("coupled", "frequency_hz", "radial")
    ratios = [r.lines["radial"].frequency / r.swing_frequency for r in results]
    return Finding(
        "There is a radial frequency f_r that follows speed and clearance.",
        REPRODUCED if error < GOOD_FREQUENCIES else OPEN,
        f"Mean error over the six conditions: coupled {error:.1f} %, uncoupled {other:.1f} %; the article's coupled model"
        f" {theirs:.1f} %. It is the swing of the driven gear in its clearance under the force F of drag and tilt: f_r is"
        f" {min(ratios):.2f} to {max(ratios):.2f} times sqrt(F / (m c)) / 2π. Coupling is not needed for it.",
        "radial-frequency",
    )


def _slope() -> Finding:
    slope = 2.0 * math.sin(math.radians(20.0))
    return Finding(
        "Backlash changes about 1:1 with the centre distance (section 3), growing with it, (6).",
        CONTRADICTED,
        f"The slope at 20° is 2 sin α = {slope:.3f}, and for an internal pair it is negative:"
        " the printed (6) has the external sign.",
        "backlash",
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
        CONTRADICTED if wrong else REPRODUCED,
        f"{len(wrong)} of {2 * len(printed_rows())} do not: {'; '.join(wrong)}.",
        "printed-errors",
    )


def _artefact(claims: Mapping[str, Any]) -> Finding:
    return Finding(
        "Coupled clearances make the pair loudest at 200/100 µm (section 3.2).",
        EXPLAINED,
        favoured_words(claims)
        + " Only there does (6) leave a negative backlash, for which (19) makes the force jump.",
        "claims-shares",
    )


def _floor(claims: Mapping[str, Any]) -> Finding:
    floor = claims["floors"][-1]
    share = 100.0 * floor["within_limit"] / floor["pairs"]
    needed = runs_needed(floor, "free_per_condition")
    last = floor["draws"][-1]
    picked = (
        f"picking the best of {needed} runs for each condition would reach it"
        if needed is not None
        else f"even the best of {last} runs for each condition do not reach it"
    )
    search = fit_of("coupled")
    return Finding(
        "An error of 7.3 % shows that the coupled model is right.",
        CONTRADICTED,
        f"One run of a perfect model differs from another of its own runs, of {floor['record']:g} s, by"
        f" {floor['quantiles']['50']:.0f} % in the median, one factor free; {share:.1f} % of {floor['pairs']} pairs come within"
        f" {floor['limit']:g} %; {picked}. Such an error takes picked runs or more averaging than the article mentions."
        f" Our own search saw {search['in_sample'][0]:.0f} % at one of its trials; fresh runs at the point that was chosen have"
        f" {search['fresh'][0]:.0f} %.",
        "claims-floor",
    )


def findings(
    results: Sequence[ConditionResult], claims: Mapping[str, Any], *, calibrated: bool
) -> list[Finding]:
    """Return every claim with its verdict, by group; `conditions` and both models must all be in ``results``."""
    assert len(by_condition(results, "coupled")) == len(conditions())
    peak, growth = peak_at_120(results, "coupled"), grows_with_speed(results)
    found = [
        _lines_seen(results),
        _amplitudes_met(results),
        _radial_frequency(results),
        _models_differ(line_differences(results)),
        _impossible_amplitudes(results),
        _free_factor(),
        _frequency_readings(),
        _artefact(claims),
        _floor(claims),
        Finding(
            "Coupled: the vibration is largest at 120 rpm (section 3.1).",
            OPEN if peak[0] == CONTRADICTED and not is_rare(claims) else peak[0],
            f"{peak[1]} Over the parameters' ranges: {rare_words(claims)}",
            "claims-shares",
        ),
        Finding("Uncoupled: the amplitude grows with speed (section 3.1).", *growth, "lead"),
        Finding(
            "Coupled: largest at 200/100 µm of the three changed clearances (section 3.2).",
            *largest_clearance(results, "coupled", (200.0, 100.0)),
            "lead",
        ),
        Finding(
            "Uncoupled: largest at 200/200 µm (section 3.2).",
            *largest_clearance(results, "uncoupled", (200.0, 200.0)),
            "lead",
        ),
        _coupled_is_better(results, calibrated=calibrated),
        _slope(),
        _printed_errors(),
    ]
    return sorted(found, key=lambda each: GROUPS.index(each.verdict))
