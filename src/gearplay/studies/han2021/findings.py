"""Verdict on each claim of the article: reproduced, explained, contradicted or open, with the numbers."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from gearplay.studies.han2021 import article, comparison, shares
from gearplay.studies.han2021.article import AMPLITUDE, FREQUENCY, MODELS
from gearplay.studies.han2021.comparison import CONTRADICTED, EXPLAINED, OPEN, REPRODUCED
from gearplay.studies.han2021.simulation import LATER

PROMINENT = 1.5  # a line counts as present when it stands this far above its surroundings
GOOD_AMPLITUDES, GOOD_FREQUENCIES = 20.0, 8.0  # per cent: limits of a claim that counts as reproduced


class Finding(NamedTuple):
    """A claim, its group, the evidence in a few sentences, and the figure that shows it."""

    claim: str
    verdict: str
    evidence: str
    figure: str


def amplitude_bound(radial_clearance: Any, frequency: Any) -> Any:
    """Return the highest line of acceleration [m/s^2] of a motion within a clearance [m], (4/pi) c (2 pi f)^2."""
    return 4.0 / math.pi * radial_clearance * (2.0 * math.pi * frequency) ** 2


def clearances() -> Any:
    """Return the radial clearances [m] of the conditions, shape [condition, 1]."""
    return 1e-6 * np.array([[c.radial_clearance_um] for c in article.conditions()])


def _lines_present(models: comparison.Models) -> Finding:
    heights = np.concatenate([model.table("prominence") for model in models.values()])
    counts = [
        f"{article.LINE_WORDS[line]} in {np.count_nonzero(each >= PROMINENT)} of {len(heights)} spectra"
        for line, each in zip(article.LINES, heights.T, strict=True)
    ]
    weakest = float(heights.min())
    return Finding(
        "Both models show f_r, f_m and 2 f_m in the spectrum (section 3.1).",
        REPRODUCED if weakest >= PROMINENT else CONTRADICTED if weakest <= 1.0 else OPEN,
        f"Standing {PROMINENT} times above their surroundings: {', '.join(counts)};"
        f" the weakest stands at {weakest:.2g} times.",
        "spectrum-120rpm-100-100",
    )


def _amplitudes_met(coupled: comparison.ModelResult) -> Finding:
    ours = coupled.amplitude_error()
    theirs = article.article_error("coupled", AMPLITUDE)
    return Finding(
        "The coupled model meets the measured amplitudes.",
        REPRODUCED if ours <= GOOD_AMPLITUDES and coupled.swing_lasts else OPEN,
        f"Mean error of the 18 amplitudes with one common factor, on members that no fit has seen: {ours:.0f} %;"
        f" the article reports {theirs:.1f} % after a fit that it does not describe.{_lasting_words(coupled)}",
        "lead",
    )


def _lasting_words(model: comparison.ModelResult) -> str:
    shares = model.lasting_shares
    if not shares:
        return ""
    low, high = (f"{100.0 * s:.2g}" if s < 0.1 else f"{100.0 * s:.0f}" for s in (min(shares), max(shares)))
    left = f"{LATER:g} s later it has {low} to {high} % of its amplitude"
    if not model.swing_lasts:
        return f" But the swing f_r does not last: {left}. It is what is left of the drawn starts."
    if not model.shaking:
        return ""
    return (
        f" The swing f_r lasts ({left}), since the fit lets the floor shake, by {model.shaking:.2g} mm/s² rms;"
        " the article's equations have nothing that keeps it up."
    )


def _models_differ(differences: Sequence[comparison.LineDifference]) -> Finding:
    significant = [d for d in differences if d.significant]
    words = f"None of {len(differences)} lines differs beyond the ensemble's spread (Welch's test, Holm's correction, 5 %)."
    if significant:
        largest = max(significant, key=lambda d: abs(d.decades))
        median = float(np.median([abs(d.decades) for d in differences]))
        words = (
            f"With the same parameters {len(significant)} of {len(differences)} lines differ (Welch's test on the members'"
            f" levels, Holm, 5 %); the largest by {20.0 * abs(largest.decades):.1f} dB at {largest.condition.label},"
            f" {article.LINE_WORDS[largest.line]}; the median of all is {20.0 * median:.1f} dB."
        )
    claim = "The two backlash models give different vibration."
    return Finding(claim, REPRODUCED if significant else OPEN, words, "coupled-over-uncoupled")


def _coupled_is_better(models: comparison.Models, *, calibrated: bool) -> Finding:
    claim = "The coupled model is nearer to the test than the uncoupled one (conclusion 3)."
    coupled, uncoupled, low, high = comparison.amplitude_difference(models)
    words = (
        f"Mean error of the 18 amplitudes, each model with its own parameters and one factor: coupled {coupled:.3f},"
        f" uncoupled {uncoupled:.3f} decades; difference {coupled - uncoupled:+.3f}, 95 % interval of the members"
        f" {low:+.3f} to {high:+.3f}."
    )
    if not calibrated:
        words += " The parameters are assumed: a fit decides, not this comparison."
        return Finding(claim, OPEN, words, "lead")
    calibration = article.stored("calibration")
    pair = next(each for each in calibration["duels"] if (each["first"], each["second"]) == MODELS)
    decided = pair["winner"] in MODELS
    better = f"the {pair['winner']} one is better" if decided else "which is better cannot be told"
    fresh = " and ".join(f"{article.fit_of(model)['fresh'][0]:.0f} %" for model in MODELS)
    words += (
        f" The calibration, where both were fitted alike ({fresh} on fresh members): {better}; for the coupled one (against it"
        f" where negative): ln odds {pair['log_odds']:+.1f} ± {pair['log_odds_error']:.1f}, predictions of conditions left out"
        f" {pair['predictive']:+.1f} ± {pair['predictive_error']:.1f}."
    )
    verdict = {None: OPEN, "coupled": REPRODUCED}.get(calibration["winner"], CONTRADICTED)
    return Finding(claim, verdict, words, "lead")


def _impossible_amplitudes(coupled: comparison.ModelResult) -> Finding:
    over = np.array(
        [
            article.printed(source, AMPLITUDE)
            / amplitude_bound(clearances(), article.printed(source, FREQUENCY))
            for source in article.SOURCES
        ]
    )
    return Finding(
        "The amplitudes of Tables 4 and 6 are accelerations in m/s².",
        EXPLAINED,
        f"{np.count_nonzero(over > 1.0)} of {over.size} exceed what motion within the clearance allows, (4/π) c (2πf)², by up to"
        f" a factor {over.max():.0f}. As an FFT without its normalisation, with one common factor (here {coupled.factor:.4g}),"
        f" they are met to {coupled.amplitude_error():.0f} %; as displacements in µm, without a factor, to"
        f" {coupled.amplitude_error(as_displacement=True):.0f} %.",
        "lead",
    )


def _free_factor() -> Finding:
    coupled, uncoupled = (article.free_factor(model) for model in MODELS)
    return Finding(
        "The coupled model's error is 7.3 %, the uncoupled model's 27.8 % (Tables 4 and 6).",
        EXPLAINED,
        f"With one free factor of the ordinate the uncoupled error falls from {uncoupled[0]:.1f} to"
        f" {uncoupled[1]:.1f} %, the coupled one from {coupled[0]:.1f} to {coupled[1]:.1f} %:"
        " most of the distance is one common factor.",
        "audit",
    )


def _frequency_readings() -> Finding:
    once, twice = (article.reading_scatter(harmonic) for harmonic in (1, 2))
    correlation, p = article.harmonic_correlation()
    low, high = article.error_of_readings()
    coupled, uncoupled = (article.radial_error(model) for model in MODELS)
    return Finding(
        "The models' errors of f_r, 16.2 and 17.1 %, say which model is right.",
        EXPLAINED,
        f"The 18 readings each of f_m and 2 f_m, which the speed sets, scatter by {once:.2f} and {twice:.2f} Hz rms,"
        f" uncorrelated (r = {correlation:.2f}, p = {p:.2f}), so they are reading errors; f_r is off by {coupled:.2f} and"
        f" {uncoupled:.2f} Hz. Two perfect readings with such errors would differ by {low:.0f} to {high:.0f} %: these errors"
        " carry no information on the model.",
        "audit",
    )


def _radial_frequency(models: comparison.Models) -> Finding:
    error, other = (models[model].radial_error() for model in MODELS)
    theirs = article.article_error("coupled", FREQUENCY, "radial")
    ratios = [r.lines[0].frequency / r.swing_frequency for m in models.values() for r in m.results]
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
        f"Table {row.table}, {row.condition.label}, {article.LINE_WORDS[row.line]}, {model}"
        for row in article.rows()
        for model in MODELS
        if not row.follows(model)
    ]
    return Finding(
        "The printed errors follow from the printed values.",
        CONTRADICTED if wrong else REPRODUCED,
        f"{len(wrong)} of {2 * len(article.rows())} do not: {'; '.join(wrong)}.",
        "printed-errors",
    )


def _artefact(claims: Mapping[str, Any]) -> Finding:
    return Finding(
        "Coupled clearances make the pair loudest at 200/100 µm (section 3.2).",
        EXPLAINED,
        shares.favoured_words(claims)
        + " Only there does (6) leave a negative backlash, for which (19) makes the force jump.",
        "claims-shares",
    )


def _floor(claims: Mapping[str, Any]) -> Finding:
    floor, search = claims["floors"][-1], article.fit_of("coupled")
    share, needed = (
        100.0 * floor["within_limit"] / floor["pairs"],
        shares.runs_needed(floor, "free_per_condition"),
    )
    picked = (
        f"picking the best of {needed} runs for each condition would reach it"
        if needed is not None
        else f"even the best of {floor['draws'][-1]} runs for each condition do not reach it"
    )
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


def findings(models: comparison.Models, claims: Mapping[str, Any], *, calibrated: bool) -> list[Finding]:
    """Return every claim with its verdict, by group."""
    coupled = models["coupled"]
    peak = comparison.peak_at_120(coupled)
    found = [
        _lines_present(models),
        _amplitudes_met(coupled),
        _radial_frequency(models),
        _models_differ(comparison.line_differences(models)),
        _impossible_amplitudes(coupled),
        _free_factor(),
        _frequency_readings(),
        _artefact(claims),
        _floor(claims),
        Finding(
            "Coupled: the vibration is largest at 120 rpm (section 3.1).",
            OPEN if peak[0] == CONTRADICTED and not shares.is_rare(claims) else peak[0],
            f"{peak[1]} Over the parameters' ranges: {shares.rare_words(claims)}",
            "claims-shares",
        ),
        Finding(
            "Uncoupled: the amplitude grows with speed (section 3.1).",
            *comparison.grows_with_speed(models),
            "lead",
        ),
        *(
            Finding(
                f"{name.capitalize()}: largest at {top[0]:g}/{top[1]:g} µm{of} (section 3.2).",
                *comparison.largest_clearance(models, name, top),
                "lead",
            )
            for name, top, of in (
                ("coupled", (200.0, 100.0), " of the three changed clearances"),
                ("uncoupled", (200.0, 200.0), ""),
            )
        ),
        _coupled_is_better(models, calibrated=calibrated),
        _slope(),
        _printed_errors(),
    ]
    return sorted(found, key=lambda each: comparison.GROUPS.index(each.verdict))
