"""Supports: linear bearings and torsional springs between a rotor and the ground or a carrier."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated

from pydantic import Field, model_validator

from gearplay.kernels.elements import support
from gearplay.model.assembly import Assembly, blank
from gearplay.model.fields import Listed, Measure, Offset, Part, Problem, RotorName, refuse
from gearplay.model.joining import ROTATION
from gearplay.vocabulary import quantities as q

Stiffness = Annotated[float, Measure(q.STIFFNESS, "stiffness along this axis", ge=0.0)]
Damping = Annotated[float, Measure(q.DAMPING, "damping along this axis", ge=0.0)]


class Support(Part):
    """Springs and dampers on a rotor's centre, unstressed at its nominal place, and on its rotation, unstressed at theta = 0.

    ``stiffness`` frees the centre, as a sleeve does, and adds to one. On a carrier x and y are its axes at rotation 0 and turn
    with it; rates and the angle are relative to it. ``offset`` is its unstressed position relative to the nominal centre.
    """

    stiffness: (
        Annotated[tuple[Stiffness, Stiffness], Listed(2, 2, "stiffness of the centre along x and y")] | None
    ) = None
    damping: Annotated[tuple[Damping, Damping], Listed(2, 2, "damping of the centre along x and y")] = (
        0.0,
        0.0,
    )
    torsional_stiffness: Annotated[
        float, Measure(q.ROTATIONAL_STIFFNESS, "stiffness against rotation", ge=0.0)
    ] = 0.0
    torsional_damping: Annotated[float, Measure(q.ROTATIONAL_DRAG, "damping of the rotation", ge=0.0)] = 0.0
    on: Annotated[RotorName, Field(description="rotor that carries it; the ground if not given")] | None = (
        None
    )
    offset: Offset = (0.0, 0.0)

    @model_validator(mode="after")
    def _check(self) -> Support:
        if not any(
            (*(self.stiffness or ()), *self.damping, self.torsional_stiffness, self.torsional_damping)
        ):
            rule = "must have a stiffness or a damping that is not 0"
            refuse([Problem((), rule, "Give stiffness, damping, torsional_stiffness or torsional_damping")])
        return self

    def pack(
        self,
        name: str,
        assembly: Assembly,
        places: Mapping[str, int],
        centres: Mapping[str, tuple[float, float]],
        mass: float,
        inertia: float,
        *,
        beside: float,
    ) -> None:
        """Add its element to a mechanism: that of rotor ``name`` of ``mass`` [kg] and ``inertia`` [kg m^2].

        ``beside`` [N s/m] is added to its damping along both axes.
        """
        record = blank(support.RECORD)
        record.stiffness_x, record.stiffness_y = self.stiffness or (0.0, 0.0)
        record.damping_x, record.damping_y = (each + beside for each in self.damping)
        record.torsional_stiffness, record.torsional_damping = (
            self.torsional_stiffness,
            self.torsional_damping,
        )
        record.journal, record.carrier = places[name], -1 if self.on is None else places[self.on]
        if self.on is not None:
            record.offset_x, record.offset_y = (centres[name][k] - centres[self.on][k] for k in range(2))
        record.misplaced_x, record.misplaced_y = self.offset
        rate = math.sqrt(
            max(max(record.stiffness_x, record.stiffness_y) / mass, record.torsional_stiffness / inertia)
        )
        assembly.add(support.KIND, name, record, [record.journal, record.carrier], always=True, rate=rate)
        if self.on is None:
            alone = {record.journal: 1.0}
            for axis, k, c, rest in (
                (0, record.stiffness_x, record.damping_x, record.misplaced_x),
                (1, record.stiffness_y, record.damping_y, record.misplaced_y),
                (ROTATION, self.torsional_stiffness, self.torsional_damping, 0.0),
            ):
                assembly.join(axis, alone, k, c, rest=rest)
