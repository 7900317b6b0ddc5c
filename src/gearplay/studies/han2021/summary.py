"""Summary of the study in five sentences."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gearplay.studies.han2021 import article
from gearplay.studies.han2021.article import (
    AMPLITUDE,
    FREQUENCY,
    LINE_WORDS,
    LINES,
    MODELS,
    conditions,
    printed,
)
from gearplay.studies.han2021.comparison import ModelResult, Models
from gearplay.studies.han2021.simulation import CALIBRATED, MESH, Settings

LOOSE = 0.95  # share of time in contact of the driving flank: with more it does not rattle
QUESTIONS = (
    "What was simulated?",
    "Does it agree?",
    "Where not?",
    "Why not?",
    "What should I believe?",
)


def story(models: Models, settings: Settings, claims: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return each question with its answer in one sentence, from the numbers of this run."""
    coupled = models["coupled"]
    answers = (
        _simulated(settings),
        _agrees(coupled, settings),
        _worst(coupled),
        _why(coupled, claims),
        _believe(models, settings),
    )
    return list(zip(QUESTIONS, answers, strict=True))


def _simulated(settings: Settings) -> str:
    kind = "parameters fitted to the test" if settings.parameters == CALIBRATED else "assumed parameters"
    return (
        f"The article's internal gear pair, its driven shaft loose in a sleeve: {len(conditions())} test conditions, coupled"
        f" and uncoupled backlash, {settings.members} runs of {settings.duration:g} s each, with {kind}, which the article does"
        " not give."
    )


def _agrees(coupled: ModelResult, settings: Settings) -> str:
    left_out = ""
    if settings.parameters == CALIBRATED:
        error = article.fit_of("coupled")["held_out"][0]
        left_out = f", {error:.0f} % under conditions that had no part in the choice of the parameters"
    return (
        f"With one common factor the coupled model meets the 18 amplitudes to {coupled.amplitude_error():.0f} % and f_r to"
        f" {coupled.radial_error():.0f} % on runs that no fit has seen{left_out}; the article reports"
        f" {article.article_error('coupled', AMPLITUDE):.1f} and {article.article_error('coupled', FREQUENCY, 'radial'):.1f} %."
    )


def _worst(coupled: ModelResult) -> str:
    ratio = (coupled.factor * coupled.amplitude / printed("test", AMPLITUDE)).ravel()
    parts = [
        f"{LINE_WORDS[LINES[k % len(LINES)]]} at {article.shown(conditions()[k // len(LINES)].label)} is"
        f" {max(ratio[k], 1.0 / ratio[k]):.1f} times too {'high' if ratio[k] > 1.0 else 'low'}"
        for k in np.argsort(-np.abs(np.log(ratio)))[:2]
    ]
    return f"The amplitude of {parts[0]} and that of {parts[1]}, the worst of the 18."


def _why(coupled: ModelResult, claims: Mapping[str, Any]) -> str:
    rattling = sum(r.statistics[f"{MESH}:drive"]["share_of_time"] < LOOSE for r in coupled.results)
    where = (
        "" if rattling == len(coupled.results) else f" under {rattling} of {len(coupled.results)} conditions"
    )
    median = claims["floors"][-1]["quantiles"]["50"]
    return (
        f"The motion is chaotic{where}, so that single runs even of a perfect model differ from each other by"
        f" {median:.0f} % in the median, and the article's frequencies are read no better than to"
        f" {article.reading_scatter(1):.1f} Hz: one record cannot tell a right model from a wrong one more finely."
    )


def _kept_up(coupled: ModelResult) -> str:
    if not coupled.swing_lasts:
        return " but, with these parameters, does not keep up"
    if not coupled.shaking:
        return ""
    return f" where something like a floor that shakes by {coupled.shaking:.2g} mm/s² rms keeps it up"


def _believe(models: Models, settings: Settings) -> str:
    kept = _kept_up(models["coupled"])
    swing = f"That f_r is the swing of the driven gear in its clearance, which either model has{kept}"
    if settings.parameters != CALIBRATED:
        errors = [models[model].amplitude_error() for model in MODELS]
        return (
            f"{swing}; which model is better these assumed parameters cannot say (mean errors {errors[0]:.0f} and"
            f" {errors[1]:.0f} %), a fit decides."
        )
    errors = [article.fit_of(model)["held_out"][0] for model in MODELS]
    where = f"({errors[0]:.0f} against {errors[1]:.0f} % under left-out conditions)"
    winner = article.stored("calibration")["winner"]
    if winner is None:
        return f"{swing}; whether coupling explains the test better cannot be told from these data {where}."
    return f"{swing}, and that the {winner.replace('_', ' ')} model explains the test best {where}."
