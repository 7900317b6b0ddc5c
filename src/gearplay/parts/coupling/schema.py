"""Couplings between two rotors, elastic in torsion, with or without play."""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from gearplay.parts.assembly import ANGLE_SCALE, Contact, blank
from gearplay.parts.coupling import law
from gearplay.parts.joining import ROTATION
from gearplay.parts.protocol import Joint, Packing
from gearplay.schema.fields import Listed, Measure, Problem, RotorName, is_absent, refuse
from gearplay.schema.finding import Finding
from gearplay.vocabulary import quantities as q

Twist = Annotated[float, Measure(q.ANGLE, "twist")]
Torque = Annotated[float, Measure(q.TORQUE, "torque at this twist")]


class Coupling(Joint):
    """A torsional spring and damper on the twist phi = theta_1 - ratio theta_2, in full angles, unstressed at phi = 0.

    The torque on the first rotor is -T, on the second ratio T: T = k phi + c dphi/dt, or with play, for
    p = abs(phi) - play / 2 > 0, T = max(0, k p + c dp/dt) in the sense of phi, and nothing within the play. The lateral part acts
    between the displacements of both centres from their nominal ones; it frees no centre. With points ``torque`` the spring is
    piecewise linear over phi - rest_angle, its first and last slope going on beyond the points; the kinks are located.
    """

    kind: ClassVar[int] = law.KIND

    between: Annotated[tuple[RotorName, RotorName], Listed(2, 2, "the two rotors")]
    torsional_stiffness: (
        Annotated[float, Measure(q.ROTATIONAL_STIFFNESS, "torsional stiffness", gt=0.0)] | None
    ) = None
    torsional_damping: Annotated[float, Measure(q.ROTATIONAL_DRAG, "torsional damping", ge=0.0)] = 0.0
    play: Annotated[float, Measure(q.ANGLE, "total torsional play", ge=0.0, le=math.pi)] = 0.0
    ratio: Annotated[float, Measure(q.RATIO, "turns of the first per turn of the second rotor")] = 1.0
    lateral_stiffness: Annotated[
        float,
        Measure(
            q.STIFFNESS,
            "stiffness between the displacements of the two centres, of a shaft's bending",
            ge=0.0,
        ),
        Field(exclude_if=is_absent),
    ] = 0.0
    lateral_damping: Annotated[
        float,
        Measure(q.DAMPING, "damping between the displacements of the two centres, in fixed axes", ge=0.0),
        Field(exclude_if=is_absent),
    ] = 0.0

    torque: Annotated[
        tuple[Annotated[tuple[Twist, Torque], Listed(2, 2, "twist and torque")], ...],
        Listed(
            0,
            64,
            "spring in stages: points of the torque over the twist, piecewise linear; odd if no twist is negative",
        ),
        Field(exclude_if=is_absent),
    ] = ()
    rest_angle: Annotated[
        float,
        Measure(q.ANGLE, "twist from which those of torque are counted"),
        Field(exclude_if=lambda angle: angle == 0.0),
    ] = 0.0

    @model_validator(mode="after")
    def _check(self) -> "Coupling":
        refuse(self._problems())
        return self

    def _problems(self) -> Iterator[Problem]:
        if self.between[0] == self.between[1]:
            yield Problem(("between",), "must name two rotors", "Name the other one")
        if self.ratio == 0.0:
            yield Problem(("ratio",), "must not be 0", "Give the turns of the first per turn of the second")
        yield from self._spring_problems()
        if self.ratio != 1.0:
            for name in ("lateral_stiffness", "lateral_damping"):
                if getattr(self, name) > 0.0:
                    rule = "must be 0 with a ratio other than 1: the two axes need not coincide"
                    yield Problem((name,), rule, "Remove it, or use supports")

    def _spring_problems(self) -> Iterator[Problem]:
        if not self.torque:
            if self.torsional_stiffness is None:
                yield Problem(
                    ("torsional_stiffness",), "is required, or torque over the twist", "Give one of the two"
                )
            if self.rest_angle != 0.0:
                rule = "must be 0 without torque over the twist, whose rest it is"
                yield Problem(("rest_angle",), rule, "Remove it, or give torque")
            return
        if self.torsional_stiffness is not None:
            rule = "must not be given together with torque over the twist, which it would contradict"
            yield Problem(("torsional_stiffness",), rule, "Remove one of the two")
        if self.play > 0.0:
            rule = "must be 0 where torque gives a curve over the twist"
            yield Problem(
                ("play",), rule, "Write it into torque: two points of 0 N m at both ends of the play"
            )
        for k, ((x, y), (x_1, y_1)) in enumerate(pairwise(self.torque), start=1):
            if x_1 <= x:
                rule = "must have a twist greater than that of the point before"
                yield Problem(("torque", k), rule, "Order the points by twist")
            elif y_1 < y:
                rule = "must have no less torque than the point before, as a spring has"
                yield Problem(("torque", k), rule, "Correct the torque")
        (first, least), (_, most) = self.torque[0], self.torque[-1]
        if least > 0.0 or most < 0.0 or (first >= 0.0 and least != 0.0):
            rule = "must be 0 N m at a twist, that of the first point where all twists are of one sign"
            yield Problem(("torque",), rule, "Correct the points")
        elif len(self.torque) == 1:
            yield Problem(("torque",), "must have at least two points", "Add one")

    def points(self) -> tuple[tuple[float, float], ...]:
        """Return the points of the torque [N m] over the twist [rad], both signs."""
        if any(twist < 0.0 for twist, _ in self.torque):
            return self.torque
        one_sided = [(twist, torque) for twist, torque in self.torque if twist > 0.0]
        return (*((-twist, -torque) for twist, torque in reversed(one_sided)), *one_sided)

    def stages(self) -> list[tuple[float, float, float]]:
        """Return the stages of the spring: twist [rad] and torque [N m] at their start, stiffness [N m/rad]."""
        return [(x, y, (y_1 - y) / (x_1 - x)) for (x, y), (x_1, y_1) in pairwise(self.points())]

    @property
    def label(self) -> str:
        """Name of the coupling in results: ``first-second``."""
        return "-".join(self.between)

    @property
    def summary(self) -> str:
        """Stiffness, or number of stages."""
        if self.torsional_stiffness is None:
            return f"coupling in {len(self.stages())} stages"
        return f"coupling, {self.torsional_stiffness:.4g} N m/rad"

    def named_rotors(self) -> Mapping[str, str]:
        """Return the names of both rotors by their field paths."""
        return {f"between.{at}": name for at, name in enumerate(self.between)}

    def rolling(self) -> Mapping[str, float]:
        """Return the factors of both rotations in the twist, with play too."""
        return {self.between[0]: 1.0, self.between[1]: -self.ratio}

    def shared_axis(self) -> Sequence[str]:
        """Return both rotors for ratio 1; with another ratio their axes may differ."""
        return self.between if self.ratio == 1.0 else ()

    def pack(self, packing: Packing, name: str) -> None:
        """Add its element: two contacts with play, none and always acting without."""
        first, second = self.between
        record, assembly = blank(law.RECORD), packing.assembly
        record.a, record.b, record.ratio = packing.place(first), packing.place(second), self.ratio
        stages = self.stages()
        stiffness = self.torsional_stiffness or max((k for _, _, k in stages), default=0.0)
        record.stiffness, record.damping = stiffness, self.torsional_damping
        record.rest, (record.first_stage, record.stages) = self.rest_angle, packing.add_terms(stages)
        record.half_play = 0.5 * self.play
        record.lateral_stiffness, record.lateral_damping = self.lateral_stiffness, self.lateral_damping
        ends = [Contact(sense, size=ANGLE_SCALE, angular=True) for sense in ("forward", "backward")]
        inertias = [packing.bodies[rotor].inertia or math.inf for rotor in self.between]
        mobility = 1.0 / inertias[0] + self.ratio**2 / inertias[1]
        assembly.add(
            law,
            name,
            record,
            [record.a, record.b],
            ends if self.play > 0.0 else [],
            always=self.play == 0.0 or self.bends,
            rate=math.sqrt(stiffness * mobility),
            switches=1 if stages else 0,
            hides=self.torsional_damping > 0.0,
        )
        if stages:  # no closed form, nor one of its lateral part alone
            return
        if self.play == 0.0:
            twist = {record.a: 1.0, record.b: -self.ratio}
            assembly.join(ROTATION, twist, stiffness, self.torsional_damping)
        if self.bends:
            for axis in range(2):
                apart = {record.a: 1.0, record.b: -1.0}
                assembly.join(axis, apart, self.lateral_stiffness, self.lateral_damping)

    @property
    def bends(self) -> bool:
        """Whether it acts between the displacements of its centres."""
        return self.lateral_stiffness > 0.0 or self.lateral_damping > 0.0

    def findings(self, path: str, *, held: bool) -> Iterator[Finding]:
        """Yield a warning about a lateral stiffness between held centres."""
        if self.bends and held:
            text = "it does nothing, since both centres are held: give one a support with a stiffness or a sleeve"
            yield Finding("warning", f"{path}.lateral_stiffness", f"{text}.")
