"""Base of the kinds of faults that parts of a case may have (`gearplay.parts.faults` lists the kinds)."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

from gearplay.schema.fields import Part, Problem
from gearplay.schema.finding import Finding


class PartFault(Part):
    """Base of faults of a part, the entry ``at`` in the ``table`` of the case."""

    table: ClassVar[str]
    at: str

    def part(self, parts: Mapping[str, Any]) -> Any:
        """Return the faulty part from its table; None for an unknown name."""
        return parts.get(self.at)

    @abstractmethod
    def misfits(self, part: Any, others: "Sequence[PartFault]") -> Iterator[Problem]:
        """Yield contradictions with the part, or with its other faults."""

    @abstractmethod
    def findings(self, path: str, part: Any, speed: float) -> Iterator[Finding]:
        """Yield findings; ``speed`` is the nominal one of the rotor relative to its carrier [rad/s]."""
