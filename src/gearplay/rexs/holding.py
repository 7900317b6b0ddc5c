"""Bearings as supports of rotors."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from gearplay.rexs.bodies import RIGID, Link
from gearplay.rexs.notes import Notes
from gearplay.rexs.records import Component, Gearbox
from gearplay.vocabulary import quantities as q

BALL: Final = 2e8
ROLLER: Final = 8e8
"""Radial stiffness of a rolling bearing whose file gives none [N/m]: the order of a loaded bearing of 40 to 80 mm bore."""
DAMPING_RATIO: Final = 0.05
"""Of a rotor on its supports, which files of gearboxes do not have."""
CLEARANCES: Final = (
    "mounted_radial_bearing_clearance", "radial_bearing_clearance", "maximum_radial_bearing_clearance", "radial_clearance",
    "maximum_bearing_clearance", "diameter_clearance_plain_bearing",
)  # fmt: skip


@dataclass(frozen=True)
class Holding:
    """Support of a rotor by its bearings: ``held`` at its centre, or by ``stiffness`` [N/m] along x and y, or not at all."""

    held: bool
    stiffness: tuple[float, float] | None
    said: tuple[str, ...]

    def shared(self, parts: int) -> "Holding":
        """Return the share of each rotor of a body that becomes ``parts`` rotors."""
        if self.stiffness is None or parts == 1:
            return self
        return Holding(self.held, (self.stiffness[0] / parts, self.stiffness[1] / parts), self.said)

    def damping(self, mass: float) -> tuple[float, float]:
        """Return the damping [N s/m] along x and y for a rotor of a mass [kg]."""
        x, y = (2.0 * DAMPING_RATIO * math.sqrt(k * mass) for k in self.stiffness or (0.0, 0.0))
        return float(f"{x:.3g}"), float(f"{y:.3g}")


def holding_of(box: Gearbox, links: Iterable[Link], notes: Notes) -> Holding:
    """Return how the bearings of one rotor hold it: rigidly by any rigid one, else by the sum of their stiffnesses.

    The plane of a case has one place for a rotor, so that bearings act in its centre and shafts do not tilt.
    """
    total, held, said = [0.0, 0.0], False, []
    for link in links:
        component = link.component
        if box.flag(component, "radial_force_absorption") is False:
            notes.leave_out(f"{component} takes axial forces only: a plane has none")
            continue
        stiffness, why = _stiffness(box, component, notes)
        rigid = max(stiffness) >= RIGID
        held = held or rigid
        said.append(f"{component}: {'rigid' if rigid else f'{stiffness[0]:.4g} N/m'}{why}")
        total = [each + more for each, more in zip(total, stiffness, strict=True)]
        _note_clearance(box, component, notes)
    if held or not said:
        return Holding(held, None, tuple(said))
    return Holding(False, (total[0], total[1]), tuple(said))


def _stiffness(box: Gearbox, component: Component, notes: Notes) -> tuple[tuple[float, float], str]:
    """Return the stiffness [N/m] of a bearing along x and y, and where it is from."""
    at_load = [
        box.number(component, q.STIFFNESS, f"operating_point_stiffness_f_{axis}_d_{axis}") for axis in "vw"
    ]
    if at_load[0] and at_load[1]:
        return (abs(at_load[0]), abs(at_load[1])), ", at the operating point"
    radial = box.number(component, q.STIFFNESS, "radial_stiffness")
    if radial is not None and radial > 0.0:
        return (radial, radial), ""
    if component.type == "concept_bearing" or "coupling" in component.type:
        return (math.inf, math.inf), ", without a stiffness in the file"
    kind = box.text(component, "bearing_type").lower()
    roller = any(word in kind for word in ("roller", "needle", "tapered"))
    designation = box.text(component, "catalogue_designation", "name")
    called = f"{component}{f', catalogue {designation}' if designation else ''}"
    value = ROLLER if roller else BALL
    notes.assume(
        f"stiffness of {called}: a support of {value:g} N/m, as of a loaded {'roller' if roller else 'ball'} bearing"
    )
    return (value, value), ", assumed"


def _note_clearance(box: Gearbox, component: Component, notes: Notes) -> None:
    clearance = box.number(component, q.LENGTH, *CLEARANCES)
    grade = box.text(component, "radial_clearance_class", "clearance_class")
    if clearance or grade:
        size = f"{1e6 * clearance:.4g} um" if clearance else f"class {grade}"
        notes.leave_out(
            f"internal clearance of {component}, {size}: its support has none, so that the shaft does not move within it; give "
            "the rotor a sleeve or a bearing"
        )
