"""Faults of rolling bearings: dents of a ring or of an element."""

import math
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from gearplay.parts.bearing.law.surface import RING_A, RING_B
from gearplay.parts.part_fault import PartFault
from gearplay.schema.fields import Measure, Problem, RotorName
from gearplay.schema.finding import Finding
from gearplay.vocabulary import quantities as q

WIDEST = 0.8
"""Largest arc of a dent over the angle between passing elements: one element at a time is in it."""
NO_CAGE = "must be inner, outer or element: the cage's motion is imposed, a defect of the cage has no force"


class Dent(PartFault):
    """Base of dents: a half sine of material that is missing."""

    table: ClassVar[str] = "bearings"

    at: Annotated[RotorName, Field(description="bearing, by the name of the rotor that it holds")]
    depth: Annotated[float, Measure(q.LENGTH, "depth in the middle", gt=0.0, le=1e-3)]
    arc: Annotated[float, Measure(q.ANGLE, "angle over which it extends", gt=0.0, le=math.pi)]
    angle: Annotated[float, Measure(q.ANGLE, "angle of its middle on the part, at rotation 0 from +x")] = 0.0

    def misfits(self, part: Any) -> Iterator[Problem]:
        """Yield faults against the bearing: an arc with room for two elements."""
        if self.arc > WIDEST * self._period(part):
            most = math.degrees(WIDEST * self._period(part))
            rule = f"must be at most {most:.4g} deg, {WIDEST:g} of the angle between two passages"
            yield Problem(("arc",), rule, "Shorten it; for a long-wave error use waviness")

    def rows(self, bearing: Any) -> Sequence[Sequence[float]]:
        """Return its rows of terms (`gearplay.parts.bearing.law.surface`)."""
        rate, phase = self._motion(bearing)
        return (rate, phase, self.arc), (self.depth, float(self._place(bearing)), self._period(bearing))

    def findings(self, path: str, part: Any, speed: float) -> Iterator[Finding]:
        """Yield its frequency; ``speed`` is that of the rotor against the bearing's other ring [rad/s]."""
        turns = abs(self._motion(part)[0]) / self._period(part)
        often = f"per turn of the rings against each other it is passed {2.0 * math.pi * turns:.6g} times"
        at = f", {abs(speed) * turns:.6g} Hz at the nominal speed" if speed else ""
        yield Finding("note", path, f"{often}{at}.")

    def _period(self, bearing: Any) -> float:
        """Return the angle on its part between two passages [rad]."""
        return float(2.0 * math.pi / bearing.elements)

    @abstractmethod
    def _place(self, bearing: Any) -> int:
        """Return the ring, `RING_A` or `RING_B`, or the number of the element."""

    def _motion(self, bearing: Any) -> tuple[float, float]:
        """Return the rate of its angle by the relative rotation of the rings, and the angle at rotation 0 [rad]."""
        share_a, share_b = bearing.shares
        rate = -share_b if self._place(bearing) == RING_A else share_a
        return rate, bearing.cage_phase - self.angle


class InnerDent(Dent):
    """A dent of the inner ring's raceway."""

    kind: Literal["inner"] = "inner"

    def _place(self, bearing: Any) -> int:
        return RING_A if bearing.rotor_ring == "inner" else RING_B


class OuterDent(Dent):
    """A dent of the outer ring's raceway."""

    kind: Literal["outer"] = "outer"

    def _place(self, bearing: Any) -> int:
        return RING_A if bearing.rotor_ring == "outer" else RING_B


class ElementDent(Dent):
    """A dent of one ball or roller, which meets both rings: twice per turn of the element.

    ``arc`` and ``angle`` are of the element; at angle 0 it meets the outer ring at rotation 0.
    """

    kind: Literal["element"] = "element"
    element: Annotated[int, Field(ge=0, le=999, description="number of the element, from 0")] = 0

    def misfits(self, part: Any) -> Iterator[Problem]:
        """Yield faults against the bearing, also an element that it does not have."""
        yield from super().misfits(part)
        if self.element >= part.elements:
            rule = f"must be less than {part.elements}, the number of elements, counted from 0"
            yield Problem(("element",), rule, "Choose one of them")

    def _period(self, bearing: Any) -> float:
        return math.pi

    def _place(self, bearing: Any) -> int:
        return self.element

    def _motion(self, bearing: Any) -> tuple[float, float]:
        backwards = -1.0 if bearing.rotor_ring == "inner" else 1.0
        return backwards * bearing.orders.spin, self.angle
