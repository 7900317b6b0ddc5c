"""Protocol of the parts of a case that hold or connect rotors: their methods, each with a default.

A kind of part is a folder: its fields and the answers to these questions (``schema``), its law (`gearplay.integrate.dispatch` has
the questions of the kernels). `gearplay.parts.tables` lists the tables and lists of a case that hold parts.
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final, Self

from gearplay.parts.assembly import Assembly, Floats
from gearplay.schema.fields import Part
from gearplay.schema.finding import Finding

SLOT: Final = re.compile(r":\w+-\d+$")
"""End of the label of a slot."""


def slot_of(contact: str, number: int) -> str:
    """Return the name of slot ``number`` of a contact: pairs of teeth that share a contact, which represents them in tables."""
    return f"{contact}-{number}"


def without_slots(labels: Iterable[str]) -> tuple[str, ...]:
    """Return the labels of contacts, ``element:contact``, without those of slots.

    >>> without_slots(["ring-1", "pinion-ring:drive", "pinion-ring:drive-0", "pinion-ring:drive-1"])
    ('ring-1', 'pinion-ring:drive')
    """
    return tuple(label for label in labels if not SLOT.search(label))


@dataclass
class Packing:
    """State of packing: the train, the elements and records packed so far.

    Parameters
    ----------
    train
        The case, as `gearplay.parts.mesh.train.train.Train`.
    turning
        The case whose motion determines which flanks drive and how deep teeth are pressed.
    assembly
        Elements, in the order of their kinds.
    records
        Packed records of the rotors, in the order of the state.
    centres
        Nominal centres [m], by rotor.
    moving
        Speeds of the rotors in their senses of rotation [rad/s], shape [rotor].
    ratio
        Function of two rotors: turns of the second per turn of the first.
    member
        Seed of the run and number of the member, by which anything random is drawn.
    record
        Rows of four coefficients: pieces of the motion of the housing, then of tables and set-points over time.
    terms
        Rows of three numbers that records refer to by the number of their first row.
    spline
        Rows of five numbers, start and coefficients of cubic pieces, in the same way.
    involutes
        Series of the involute, one by mesh.
    half_backlashes
        By a signal in half backlashes: the signal that it is, and half the backlash [m].
    stops
        Times [s] where the right-hand side jumps.
    later
        What is to be called once all elements are there.

    """

    train: Any
    turning: Any
    assembly: Assembly
    records: Sequence[Any]
    centres: Mapping[str, tuple[float, float]]
    moving: Floats
    ratio: Callable[[str, str], float]
    member: tuple[int, int]
    record: Floats
    terms: list[Sequence[float]] = field(default_factory=list)
    spline: list[list[float]] = field(default_factory=list)
    involutes: list[Floats] = field(default_factory=list)
    half_backlashes: dict[str, tuple[str, float]] = field(default_factory=dict)
    stops: set[float] = field(default_factory=set)
    later: list[Callable[[], None]] = field(default_factory=list)

    @property
    def bodies(self) -> Mapping[str, Any]:
        """Rotors by name, in the order of the state."""
        return self.train.rotors

    @property
    def as_published(self) -> bool:
        """Whether the equations are those of Han et al. 2021 as printed."""
        return bool(self.train.formulation == "as_published")

    def faults_of(self, table: str, name: str) -> list[Any]:
        """Return the faults of the part of a name in a table of the case."""
        return [fault for fault in self.train.faults if fault.table == table and fault.at == name]

    def add_terms(self, rows: Iterable[Sequence[float]]) -> tuple[int, int]:
        """Add rows of terms; return the number of the first and how many there are."""
        first = len(self.terms)
        self.terms += rows
        return first, len(self.terms) - first

    def place(self, name: str | None) -> int:
        """Return the index of a rotor, -1 for the ground."""
        return -1 if name is None else self._places[name]

    @cached_property
    def _places(self) -> dict[str, int]:
        return {name: place for place, name in enumerate(self.bodies)}

    def arm(self, name: str, on: str | None) -> tuple[float, float]:
        """Return the vector [m] from the centre of a carrier to that of a rotor; 0 on the ground."""
        if on is None:
            return 0.0, 0.0
        (x, y), (x_0, y_0) = self.centres[name], self.centres[on]
        return x - x_0, y - y_0


class Actuator(Part):
    """Base of drives, which turn a rotor.

    ``prescribes`` is whether the rotation is prescribed, ``positions`` whether a loop brings a rotor to an angle.
    """

    prescribes: ClassVar[bool] = False
    positions: ClassVar[bool] = False

    def nominal_speed(self) -> float | None:
        """Return the nominal speed of its rotor [rad/s], 0 of one that is brought to an angle; None for none."""
        return None

    def starting_speed(self) -> float | None:
        """Return the speed that it gives its rotor at t = 0 [rad/s]; None for none."""
        return None

    def run_up(self) -> tuple[float, float]:
        """Return the change of the nominal speed [rad/s] in a ramp, and the time [s] that it takes; 0, 0 without one."""
        return 0.0, 0.0

    def holds_rotation(self) -> bool:
        """Return whether it keeps its rotor from turning, as a brake does."""
        return False

    def push(self, name: str) -> tuple[str, float]:
        """Return a rotor and the torque on it [N m] by which it moves a train at rest; ``name`` is its own."""
        return name, 0.0

    def constant_torque(self) -> float:
        """Return the constant torque on its rotor [N m]."""
        return 0.0

    def largest_torque(self) -> float:
        """Return a bound of the magnitude of a given torque [N m]; 0 where the motion determines it."""
        return 0.0

    def excites(self) -> bool:
        """Return whether it makes a train do more than roll at constant speed."""
        return True

    def speed_gains(self) -> tuple[float, float] | None:
        """Return the gains of a speed loop on its error [N m s/rad] and the integral [N m/rad]; None for no such loop."""
        return None

    def time_invariant(self) -> Actuator | None:
        """Return the drive of a linear system, without its constant torque; None where that has none."""
        return None

    def findings(self, path: str, span: float) -> Iterator[Finding]:
        """Yield findings for a run of ``span`` [s], transient included."""
        return iter(())


class Holder(Part):
    """Base of parts that hold one rotor each, whose name is theirs: plain bearings (sleeves), supports.

    ``kind`` is that of its elements, ``noun`` what a carrier carries, ``has_clearance`` whether the centre moves in a clearance.
    """

    kind: ClassVar[int]
    noun: ClassVar[str]
    has_clearance: ClassVar[bool] = False
    if TYPE_CHECKING:
        on: str | None
        offset: tuple[float, float]

    def frees_centre(self) -> bool:
        """Return whether the part leaves the rotor's centre free to move."""
        return True

    def clearance(self) -> float | None:
        """Return the radius [m] of the circle in which the centre moves freely; None for a part that is no bush."""
        return None

    def holds_rotation(self) -> bool:
        """Return whether a spring holds the rotation."""
        return False

    def dissipates(self) -> bool:
        """Return whether motion of the centre loses energy in the part."""
        return True

    @abstractmethod
    def pack(self, packing: Packing, name: str, damping: float) -> None:
        """Add its element to a mechanism, with further ``damping`` [N s/m] of the centre's motion relative to its carrier."""

    def at_temperature(self, path: str, journal: float, bush: float) -> Self:
        """Return the part with the expansion factors of its rotor and of its carrier or housing; ``path`` is named in errors."""
        return self

    def thermal_change(self, hot: Self) -> tuple[str, str] | None:
        """Return a field and a text on its change from here to ``hot``, the part at temperature; None if unchanged."""
        return None

    def time_invariant(self) -> Self:
        """Return the part without dissipation and time-varying terms of its contacts, for a linear system."""
        return self

    def findings(self, path: str, *, held: bool, alone: bool) -> Iterator[Finding]:
        """Yield findings; ``held`` is whether the centre cannot move, ``alone`` whether no other part holds the rotor."""
        return iter(())


class Joint(Part):
    """Base of parts that connect rotors: couplings."""

    kind: ClassVar[int]

    @property
    @abstractmethod
    def label(self) -> str:
        """Name in results, of one without others in parallel (`Case.named_joints`)."""

    @property
    @abstractmethod
    def summary(self) -> str:
        """Kind and main numbers, for tables."""

    @abstractmethod
    def named_rotors(self) -> Mapping[str, str]:
        """Return the rotors that it names, by field."""

    def rolling(self) -> Mapping[str, float]:
        """Return factors c of rotors' rotations with sum c theta = 0 where nothing is strained; empty for none."""
        return {}

    def shared_axis(self) -> Sequence[str]:
        """Return the rotors whose nominal centres coincide; empty for none."""
        return ()

    @abstractmethod
    def pack(self, packing: Packing, name: str) -> None:
        """Add its element to a mechanism, under its name in results."""

    def findings(self, path: str, *, held: bool) -> Iterator[Finding]:
        """Yield findings; ``held`` is whether no centre of its rotors can move."""
        return iter(())
