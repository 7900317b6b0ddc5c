"""Faults of rolling bearings: dents of a ring or of an element, elements that the cage holds off their places."""

import math
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from gearplay.parts.bearing.law.surface import RING_A, RING_B
from gearplay.parts.part_fault import PartFault
from gearplay.schema.fields import Measure, Problem, RotorName
from gearplay.schema.finding import Finding
from gearplay.vocabulary import quantities as q

At = Annotated[RotorName, Field(description="bearing, by the name of the rotor that it holds")]
Element = Annotated[int, Field(ge=0, le=999, description="number of the element, from 0")]
WIDEST = 0.8
"""Largest arc of a dent over the angle between passing elements: one element at a time is in it."""


def offsets_of(faults: Iterable[PartFault], bearing: Any) -> list[float]:
    """Return the angle [rad] of each element from its even place, by the faults of the cage."""
    found = [0.0] * bearing.elements
    for fault in faults:
        if isinstance(fault, CageFault) and fault.element < bearing.elements:
            found[fault.element] = fault.angle
    return found


def gaps_of(offsets: Sequence[float]) -> list[float]:
    """Return the angles [rad] from each element to the next one, from their angles from their even places."""
    pitch = 2.0 * math.pi / len(offsets)
    return [pitch + after - own for own, after in zip(offsets, [*offsets[1:], offsets[0]], strict=True)]


def touching(bearing: Any) -> float:
    """Return the angle between two elements that touch each other [rad]."""
    return 2.0 * math.asin(bearing.element_size / bearing.pitch_size)


def _of_no_element(element: int, bearing: Any) -> Iterator[Problem]:
    if element >= bearing.elements:
        rule = f"must be less than {bearing.elements}, the number of elements, counted from 0"
        yield Problem(("element",), rule, "Choose one of them")


class Dent(PartFault):
    """Base of dents: a half sine of material that is missing."""

    table: ClassVar[str] = "bearings"

    at: At
    depth: Annotated[float, Measure(q.LENGTH, "depth in the middle", gt=0.0, le=1e-3)]
    arc: Annotated[float, Measure(q.ANGLE, "angle over which it extends", gt=0.0, le=math.pi)]
    angle: Annotated[float, Measure(q.ANGLE, "angle of its middle on the part, at rotation 0 from +x")] = 0.0

    def misfits(self, part: Any, others: Sequence[PartFault]) -> Iterator[Problem]:
        """Yield faults against the bearing: an arc with room for two elements."""
        least = self._least(min(gaps_of(offsets_of(others, part))))
        if self.arc > WIDEST * least:
            most = math.degrees(WIDEST * least)
            rule = f"must be at most {most:.4g} deg, {WIDEST:g} of the angle between two passages"
            yield Problem(("arc",), rule, "Shorten it; for a long-wave error use waviness")

    def rows(self, bearing: Any, gap: float) -> Sequence[Sequence[float]]:
        """Return its rows of terms (`gearplay.parts.bearing.law.surface`); ``gap`` is the least between elements [rad]."""
        rate, phase = self._motion(bearing)
        return (rate, phase, self.arc), (self.depth, float(self._place(bearing)), self._least(gap))

    def findings(self, path: str, part: Any, speed: float) -> Iterator[Finding]:
        """Yield its frequency; ``speed`` is that of the rotor against the bearing's other ring [rad/s]."""
        turns = abs(self._motion(part)[0]) / self._period(part)
        often = f"per turn of the rings against each other it is passed {2.0 * math.pi * turns:.6g} times"
        at = f", {abs(speed) * turns:.6g} Hz at the nominal speed" if speed else ""
        yield Finding("note", path, f"{often}{at}.")

    def _period(self, bearing: Any) -> float:
        """Return the mean angle on its part between two passages [rad]."""
        return float(2.0 * math.pi / bearing.elements)

    def _least(self, gap: float) -> float:
        """Return the least angle on its part between two passages [rad]; ``gap`` is the least between elements."""
        return gap

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
    element: Element = 0

    def misfits(self, part: Any, others: Sequence[PartFault]) -> Iterator[Problem]:
        """Yield faults against the bearing, also an element that it does not have."""
        yield from super().misfits(part, others)
        yield from _of_no_element(self.element, part)

    def _period(self, bearing: Any) -> float:
        return math.pi

    def _least(self, gap: float) -> float:
        return math.pi

    def _place(self, bearing: Any) -> int:
        return self.element

    def _motion(self, bearing: Any) -> tuple[float, float]:
        backwards = -1.0 if bearing.rotor_ring == "inner" else 1.0
        return backwards * bearing.orders.spin, self.angle


class CageFault(PartFault):
    """A worn or broken pocket of the cage: its element runs ahead of its even place, or behind it.

    The motion of the cage is imposed; the element stays ``angle`` off, so that its passages recur with the cage's turns.
    """

    table: ClassVar[str] = "bearings"

    kind: Literal["cage"] = "cage"
    at: At
    element: Element = 0
    angle: Annotated[
        float,
        Measure(q.ANGLE, "from the even place of the element, counter-clockwise", ge=-math.pi, le=math.pi),
    ]

    def misfits(self, part: Any, others: Sequence[PartFault]) -> Iterator[Problem]:
        """Yield an element that the bearing lacks, that another fault places too, or that would run into its neighbour."""
        lacks = list(_of_no_element(self.element, part))
        if lacks:
            yield from lacks
            return
        placed = {other.element for other in others if isinstance(other, CageFault)}
        if self.element in placed:
            rule = "must not be that of another fault of this cage"
            yield Problem(("element",), rule, "Keep one of the two")
            return
        offsets, least = offsets_of((self, *others), part), touching(part)
        gaps, before = gaps_of(offsets), (self.element - 1) % part.elements
        low = offsets[self.element] - gaps[before] + least
        high = offsets[self.element] + gaps[self.element] - least
        if not low < self.angle < high:
            rule = (
                f"must be between {math.degrees(low):.4g} and {math.degrees(high):.4g} deg, "
                "where the element touches its neighbours"
            )
            yield Problem(("angle",), rule, "Correct it, or the element")

    def findings(self, path: str, part: Any, speed: float) -> Iterator[Finding]:
        """Yield its frequency; ``speed`` is that of the rotor against the bearing's other ring [rad/s]."""
        turns = part.shares[0]
        text = f"per turn of the rotor against the other ring the cage turns {turns:.6g} times"
        at = f", {abs(speed) * turns / (2.0 * math.pi):.6g} Hz at the nominal speed" if speed else ""
        yield Finding("note", path, f"{text}{at}.")
