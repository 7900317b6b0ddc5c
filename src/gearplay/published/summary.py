"""Summary of the study in five sentences."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gearplay.published import audit
from gearplay.published.article import LINE_WORDS, conditions, printed_rows
from gearplay.published.calibrated import calibration, fit_of
from gearplay.published.comparison import (
    article_error,
    by_condition,
    model_amplitudes,
    radial_frequency_error,
    shaking,
    swing_lasts,
)
from gearplay.published.han2021 import MESH, ConditionResult
from gearplay.published.settings import CALIBRATED, Settings

LOOSE = 0.95  # share of time in touch of the driving flank: with more it does not rattle
QUESTIONS = (
    "What was simulated?",
    "Does it agree?",
    "Where not?",
    "Why not?",
    "What should I believe?",
)


def story(
    results: Sequence[ConditionResult], settings: Settings, claims: Mapping[str, Any]
) -> list[tuple[str, str]]:
    """Return each question with its answer in one sentence, from the numbers of this run."""
    answers = (
        _simulated(settings),
        _agrees(results, settings),
        _worst(results),
        _why(results, claims),
        _believe(results, settings),
    )
    return list(zip(QUESTIONS, answers, strict=True))


def _simulated(settings: Settings) -> str:
    parameters = (
        "with parameters fitted to the test, which the article does not give"
        if settings.parameters == CALIBRATED
        else "with assumed parameters, which the article does not give"
    )
    return (
        f"The article's internal gear pair, its driven shaft loose in a sleeve: {len(conditions())} test conditions, coupled"
        f" and uncoupled backlash, {settings.members} runs of {settings.duration:g} s each, {parameters}."
    )


def _agrees(results: Sequence[ConditionResult], settings: Settings) -> str:
    amplitude = model_amplitudes(results, "coupled").mean_error("unnormalised")
    frequency = radial_frequency_error(results, "coupled")
    left_out = ""
    if settings.parameters == CALIBRATED:
        left_out = f", {fit_of('coupled')['held_out'][0]:.0f} % under conditions that had no part in the choice of the parameters"
    return (
        f"With one common factor the coupled model meets the 18 amplitudes to {amplitude:.0f} % and f_r to {frequency:.0f} % on"
        f" runs that no fit has seen{left_out}; the article reports"
        f" {article_error('coupled', 'amplitude_as_printed'):.1f} and"
        f" {article_error('coupled', 'frequency_hz', 'radial'):.1f} %."
    )


def _worst(results: Sequence[ConditionResult]) -> str:
    amplitudes = model_amplitudes(results, "coupled")
    ratio = amplitudes.factor * amplitudes.acceleration / amplitudes.test
    rows = [r for r in printed_rows() if r.quantity == "amplitude_as_printed"]
    order = np.argsort(-np.abs(np.log(ratio)))[:2]
    parts = [
        f"{LINE_WORDS[rows[k].line]} at {rows[k].condition.label.replace('um', 'µm')} is"
        f" {max(ratio[k], 1.0 / ratio[k]):.1f} times too {'high' if ratio[k] > 1.0 else 'low'}"
        for k in order
    ]
    return f"The amplitude of {parts[0]} and that of {parts[1]}, the worst of the 18."


def _why(results: Sequence[ConditionResult], claims: Mapping[str, Any]) -> str:
    floor = claims["floors"][-1]
    found = by_condition(results, "coupled").values()
    rattling = sum(r.statistics[f"{MESH}:drive"]["share_of_time"] < LOOSE for r in found)
    where = "" if rattling == len(found) else f" under {rattling} of {len(found)} conditions"
    return (
        f"The motion is chaotic{where}, so that single runs even of a perfect model differ from each other by"
        f" {floor['quantiles']['50']:.0f} % in the median, and the article's frequencies are read no better than to"
        f" {audit.reading_scatter('mesh_1x'):.1f} Hz: one record cannot tell a right model from a wrong one more finely."
    )


def _kept_up(results: Sequence[ConditionResult]) -> str:
    if not swing_lasts(results, "coupled"):
        return " but, with these parameters, does not keep up"
    floor = shaking(results, "coupled")
    return f" where something like a floor that shakes by {floor:.2g} mm/s² rms keeps it up" if floor else ""


def _believe(results: Sequence[ConditionResult], settings: Settings) -> str:
    swing = f"That f_r is the swing of the driven gear in its clearance, which either model has{_kept_up(results)}"
    if settings.parameters != CALIBRATED:
        errors = [model_amplitudes(results, m).mean_error("unnormalised") for m in ("coupled", "uncoupled")]
        return (
            f"{swing}; which model is better these assumed parameters cannot say (mean errors {errors[0]:.0f} and"
            f" {errors[1]:.0f} %), a fit decides."
        )
    errors = [fit_of(model)["held_out"][0] for model in ("coupled", "uncoupled")]
    where = f"({errors[0]:.0f} against {errors[1]:.0f} % under left-out conditions)"
    winner = calibration()["winner"]
    if winner is None:
        return f"{swing}; whether coupling explains the test better cannot be told from these data {where}."
    return f"{swing}, and that the {winner.replace('_', ' ')} model explains the test best {where}."
