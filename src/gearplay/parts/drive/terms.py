"""Harmonic terms of a torque, in time or in the rotation of a rotor."""

from collections.abc import Iterable
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from gearplay.schema.fields import Listed, Measure, Part, Problem, is_absent, refuse
from gearplay.schema.records import cubic_pieces, extremes
from gearplay.vocabulary import quantities as q


class Term(Part):
    """One term of a torque: ``amplitude sin(2 pi frequency t + phase)``, or ``amplitude sin(order theta + phase)``.

    t counts from the start of the integration, transient included; theta is the rotor's full angle.
    """

    frequency: Annotated[float, Measure(q.FREQUENCY, "frequency of a term in time", gt=0.0)] | None = None
    order: (
        Annotated[
            float, Measure(None, "periods per turn of the rotor, of a term in rotation", gt=0.0, le=1e4)
        ]
        | None
    ) = None
    amplitude: Annotated[float, Measure(q.TORQUE, "amplitude (half peak to peak)")]
    phase: Annotated[float, Measure(q.ANGLE, "phase at t = 0, or at rotation 0")] = 0.0

    @model_validator(mode="after")
    def _check(self) -> "Term":
        if (self.frequency is None) == (self.order is None):
            rule = "must have either a frequency or an order"
            refuse([Problem((), rule, "Give one of the two")])
        return self


class TorqueTable(Part):
    """Torque over time at a fixed sampling rate: cubic spline between its values, zero before and after."""

    values: Annotated[
        tuple[Annotated[float, Measure(q.TORQUE, "value of the torque")], ...],
        Listed(4, 200_000, "values of the torque"),
    ]
    sampling: Annotated[float, Measure(q.FREQUENCY, "values per second", gt=0.0)]
    start: Annotated[float, Measure(q.TIME, "when it begins, from the start of the integration", ge=0.0)] = (
        0.0
    )

    def largest(self) -> float:
        """Return the largest magnitude of the curve [N m], which may pass beyond its values."""
        return max(map(abs, extremes(cubic_pieces(np.array(self.values)))))


def largest_torque(constant: float, terms: Iterable[Term], table: TorqueTable | None) -> float:
    """Return a bound of the magnitude [N m] of a constant torque, its terms and its table together."""
    swing = sum(abs(term.amplitude) for term in terms)
    return abs(constant) + swing + (table.largest() if table is not None else 0.0)


Table = Annotated[TorqueTable | None, Field(exclude_if=is_absent)]

Terms = Annotated[
    tuple[Term, ...],
    Listed(0, 16, "terms of the torque, in time or in rotation"),
    Field(exclude_if=is_absent),
]
