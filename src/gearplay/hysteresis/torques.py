"""Arguments with units: rated torque, stages of the stiffness, temperatures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gearplay.schema.units import quantity_of
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import Quantity

STAGES = (0.14, 0.48)
"""Ends of the first two stages of the stiffness, of the rated torque, where none are given."""


def positive_of(field: str, value: Any, quantity: Quantity) -> float:
    """Return a positive quantity in SI, given as a number or with a unit; `InputError` for anything else."""
    number = quantity_of(field, value, quantity)
    if number <= 0.0:
        raise InputError.of(field, value, "must be greater than 0", "Correct the number and its unit")
    return number


def stages_of(stages: Sequence[float | str] | None, rated: float) -> tuple[float, float]:
    """Return the torques that end the first two stages [N m]."""
    if stages is None:
        return STAGES[0] * rated, STAGES[1] * rated
    ends = [positive_of(f"stages.{k}", each, q.TORQUE) for k, each in enumerate(stages)]
    if len(ends) != 2 or not ends[0] < ends[1] < rated:
        rule = f"must be two rising torques below the rated one, {rated:g} N m"
        raise InputError.of("stages", list(stages), rule, "Give the ends of K1 and K2")
    return ends[0], ends[1]
