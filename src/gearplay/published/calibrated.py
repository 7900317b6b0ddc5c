"""Stored results of the calibration against the article's test: provenance of the calibrated cases."""

import json
import math
from functools import lru_cache
from importlib.resources import files
from typing import Any

from gearplay.published.article import Condition, conditions

SHIPPED = "han2021_calibration.json"
KEYS = {"frequency_hz": "frequency", "amplitude_as_printed": "amplitude"}


@lru_cache(maxsize=1)
def calibration() -> dict[str, Any]:
    """Return the document: plan, seed and trials, and for each model its errors, best point and conditions left out."""
    document: dict[str, Any] = json.loads(
        files("gearplay.published").joinpath(SHIPPED).read_text(encoding="utf-8")
    )
    return document


def fit_of(model: str) -> dict[str, Any]:
    """Return what was found of one model.

    "coupled", "uncoupled", "coupled_as_published" or "uncoupled_as_published".
    """
    found: dict[str, Any] = calibration()["fits"][model]
    return found


def duel_of(first: str, second: str) -> dict[str, Any]:
    """Return how far the first of two models is ahead of the second, with standard errors; keys as in `Duel`."""
    found: dict[str, Any] = next(
        duel for duel in calibration()["duels"] if (duel["first"], duel["second"]) == (first, second)
    )
    return found


def left_out_error(model: str, condition: Condition, line: str, quantity: str) -> float:
    """Return the error [%] of one number where its whole condition was left out of the fit, on fresh members."""
    residual = float(fit_of(model)["left_out"][condition.label][f"{line}, {KEYS[quantity]}"])
    return 100.0 * abs(math.pow(10.0, residual) - 1.0)


def left_out_radial_error(model: str) -> float:
    """Return the mean error [%] of f_r where each condition in turn was left out of the fit, on fresh members."""
    errors = [left_out_error(model, condition, "radial", "frequency_hz") for condition in conditions()]
    return sum(errors) / len(errors)
