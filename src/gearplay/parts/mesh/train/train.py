"""Train: the interface of a case to its parts, which need their neighbours for geometry, speeds and loads."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.part_fault import PartFault
from gearplay.parts.protocol import Holder, Joint
from gearplay.parts.rotor.schema import Rotor


class Train(Protocol):
    """Rotors with the parts that join and hold them, as a case has them."""

    @property
    def rotors(self) -> Mapping[str, Rotor]:
        """Rotors by name, in the order of the state."""

    @property
    def meshes(self) -> Sequence[Mesh]:
        """Pairs of gears in mesh."""

    @property
    def joints(self) -> Sequence[Joint]:
        """Other parts that connect rotors."""

    def named_joints(self) -> Iterator[tuple[str, str, Joint]]:
        """Yield them with their paths and their names in results."""

    def holders(self, rotor: str) -> Sequence[Holder]:
        """Return the parts that hold a rotor."""

    def every_holder(self) -> Iterator[tuple[str, str, Holder]]:
        """Yield every part that holds a rotor, with its table and its rotor."""

    @property
    def planetary(self) -> Mapping[str, Any]:
        """Planetary sets by name, whose members are among the rotors."""

    def settable_path(self, path: str) -> str:
        """Return the path of the field that a user sets for one of a part, which may be of a planetary set."""

    def field_path(self, rotor: str, *fields: str) -> str:
        """Return the path of a field of a rotor, which may be a member of a set."""

    @property
    def faults(self) -> Sequence[PartFault]:
        """Faults of parts."""

    @property
    def formulation(self) -> str:
        """``geometric`` or ``as_published``."""

    @property
    def backlash_model(self) -> str:
        """``coupled`` to the centre distance, or ``uncoupled``."""

    @property
    def mesh_phases(self) -> str:
        """``by_position`` or ``from_zero``."""

    @property
    def environment(self) -> Any:
        """Temperatures, or None."""

    @property
    def operating(self) -> "Train":
        """The train with its lengths at its temperatures."""

    def at_temperature(self, temperature: float) -> "Train":
        """Return the train with its lengths at a temperature [K] of its environment."""
