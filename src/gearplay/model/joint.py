"""Base class of parts that connect rotors, besides sleeves and meshes."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence

from gearplay.model.assembly import Assembly
from gearplay.model.fields import Part


class Joint(Part):
    """Base of parts that connect rotors: couplings. A new kind answers these and is listed in `model.case.JOINTS`."""

    @property
    @abstractmethod
    def label(self) -> str:
        """Name in results."""

    @abstractmethod
    def named_rotors(self) -> Mapping[str, str]:
        """Return the rotors that it names, by field."""

    def rolling(self) -> Mapping[str, float]:
        """Return factors c of rotors' rotations with sum c theta = 0 where nothing is strained; empty for none."""
        return {}

    def shared_axis(self) -> Sequence[str]:
        """Return the rotors whose nominal centres are one point; empty for none."""
        return ()

    @abstractmethod
    def pack(self, assembly: Assembly, places: Mapping[str, int], inertias: Mapping[str, float]) -> None:
        """Add its element to a mechanism; ``places`` and ``inertias`` [kg m^2] are those of the rotors by name."""
