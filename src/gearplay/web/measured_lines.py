"""Measured spectral lines of the bundled calibration plans, at the condition of a case."""

import math
from functools import cache
from typing import Any

from gearplay.calibration.plan import Condition, Plan
from gearplay.calibration.reading import PACKAGE, load_plan
from gearplay.model.bundled import bundled
from gearplay.model.case import Case
from gearplay.model.plan_values import number_in_si, value_at
from gearplay.model.reading import load_case
from gearplay.vocabulary.errors import InputError

CLOSE = 1e-6
"""Relative difference up to which a field of the case has the value of a condition."""


@cache
def _plans() -> tuple[tuple[Plan, dict[str, int | None]], ...]:
    """Return the bundled plans with measured values, each with the teeth of its case's rotors."""
    plans = [load_plan(name) for name in bundled(PACKAGE, "plans")]
    return tuple(
        (plan, _teeth(load_case(plan.case))) for plan in plans if any(c.measured for c in plan.conditions)
    )


def _teeth(case: Case) -> dict[str, int | None]:
    return {name: rotor.teeth for name, rotor in case.rotors.items()}


def _is_at(case: Case, condition: Condition) -> bool:
    """Return whether a case has the values that a condition sets."""
    try:
        return all(
            math.isclose(value_at(case, path), number_in_si(case, (path,), raw, path), rel_tol=CLOSE)
            for path, raw in condition.set.items()
        )
    except (InputError, TypeError):  # a field that the case lacks or that is no number
        return False


def measured_lines(case: Case) -> list[dict[str, Any]]:
    """Return the lines that a bundled plan has as measured for the condition of a case: name and frequency [Hz].

    Empty for a case of other rotors, or at no condition of a plan.
    """
    for plan, teeth in _plans():
        for condition in plan.conditions if teeth == _teeth(case) else ():
            if condition.measured and _is_at(case, condition):
                return [
                    {"line": name, "frequency": measured.frequency}
                    for name, measured in condition.measured.items()
                    if measured.frequency is not None
                ]
    return []
