"""Registry of the kinds of elements: the only list of them.

A kind is a module with its record, the sizes of its entries and its laws, under the names of the functions in
`gearplay.integrate.dispatch`, which calls them. Its constant ``KIND`` is its place in this list.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from gearplay.kernels.arrays import Floats
from gearplay.kernels.layout import System
from gearplay.parts.bearing import law as bearing
from gearplay.parts.coupling import law as coupling
from gearplay.parts.drive import excitation, positioner, servo
from gearplay.parts.housing import law as housing
from gearplay.parts.mesh import law as mesh
from gearplay.parts.mesh.pairs import observed as pair
from gearplay.parts.mount import Mount
from gearplay.parts.sleeve import law as sleeve
from gearplay.parts.support import law as support

SERVO, SLEEVE, MESH, COUPLING = servo.KIND, sleeve.KIND, mesh.KIND, coupling.KIND
EXCITATION, POSITIONER, BEARING, PAIR = excitation.KIND, positioner.KIND, bearing.KIND, pair.KIND

CONSTANTS = ("KIND", "RECORD", "SIGNALS", "MEMORY", "MODES", "PER_CONTACT", "SLOPES")


@dataclass(frozen=True)
class Kind:
    """A kind of element, by the name of its dimension in results, and its module."""

    name: str
    file: ModuleType

    def __post_init__(self) -> None:
        missing = [word for word in CONSTANTS if not hasattr(self.file, word)]
        if missing:
            raise TypeError(f"{self.file.__name__} lacks {', '.join(missing)}")


KINDS = (
    Kind("servo", servo),
    Kind("sleeve", sleeve),
    Kind("mesh", mesh),
    Kind("coupling", coupling),
    Kind("support", support),
    Kind("excitation", excitation),
    Kind("base", housing),
    Kind("positioner", positioner),
    Kind("bearing", bearing),
    Kind("pair", pair),
)
if [kind.file.KIND for kind in KINDS] != list(range(len(KINDS))):
    raise TypeError("KIND of each module must be its place in KINDS")
System.declare("records", [kind.file.RECORD for kind in KINDS])
SIGNAL_COUNTS = tuple(len(kind.file.SIGNALS) for kind in KINDS)
"""Number of signals of an element, by its kind."""


def _laws_with(name: str) -> list[tuple[int, Callable[..., Any]]]:
    """Return the functions of a name that laws have, with their kinds."""
    return [(kind.file.KIND, getattr(kind.file, name)) for kind in KINDS if hasattr(kind.file, name)]


def mounts(records: Sequence[Any]) -> Iterator[Mount]:
    """Yield the mounting of rotors in the parts that hold them, from the ``records`` of a packed system, kind after kind.

    Laws with a function ``mounts`` of their records have such parts.
    """
    for kind, law in _laws_with("mounts"):
        yield from law(records[kind])


def joined_centres(records: Sequence[Any]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of rotors between whose centres a force acts (function ``joined_centres`` of a law)."""
    for kind, law in _laws_with("joined_centres"):
        yield from law(records[kind])


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] with which elements excite a system anew, meshes first.

    From ``recurrence_rates`` of their laws. ``speeds`` are nominal speeds of rotors, ``frames`` those of their frames
    of reference (`gearplay.solver.frames`), shapes [rotor]. NaN for an excitation that does not repeat.
    """
    laws = sorted(_laws_with("recurrence_rates"), key=lambda each: each[0] != MESH)
    return [float(rate) for _, law in laws for rate in law(system, speeds, frames)]
