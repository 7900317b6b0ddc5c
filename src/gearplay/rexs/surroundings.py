"""Fields of a case besides its mechanism: title, gravity, run, load cases in comments, notes on the plane."""

import math
from collections.abc import Mapping
from typing import Final

from gearplay.rexs.loads import Motion
from gearplay.rexs.notes import Notes
from gearplay.rexs.records import Gearbox, LoadCase
from gearplay.rexs.sets import PlanetSet
from gearplay.rexs.teeth import SPUR, Gear, Pair
from gearplay.rexs.text import quantity
from gearplay.rexs.writing import Table
from gearplay.vocabulary import quantities as q

GRAVITY: Final = 9.80665


def run_table(motion: Motion) -> Table:
    """Return the run: some turns of the drive, at most 1 s."""
    speed = abs(motion.speeds.get(motion.driver, 0.0)) if motion.driver is not None else 0.0
    turn = 2.0 * math.pi / speed if speed else 0.04
    table = Table("[run]", None, ["Three turns of the drive recorded after one, 1 s at most."])
    table.add("duration", quantity(min(float(f"{3.0 * turn:.2g}"), 1.0), "s"))
    table.add("transient", quantity(min(float(f"{turn:.2g}"), 1.0), "s"))
    return table


def title_of(sets: list[PlanetSet], pairs: list[Pair]) -> str:
    """Return the title: the teeth of all stages."""
    named = [
        f"{found.sun.teeth}/{found.planets[0].teeth}/{found.ring.teeth}"
        for found in sets
        if found.sun and found.ring
    ]
    named += [f"{pair.first.teeth}/{pair.second.teeth}" for pair in pairs]
    shown = ", ".join(named[:6]) + (f" and {len(named) - 6} more" if len(named) > 6 else "")
    kind = "planetary stage" if sets and not pairs else "gearbox"
    return f"{kind.capitalize()} {shown}, imported"


def gravity_of(box: Gearbox, notes: Notes) -> list[str] | None:
    """Return gravity along x and y where the file accounts for it."""
    for unit in box.of_type("gear_unit"):
        if box.flag(unit, "account_for_gravity") is not True:
            continue
        size = box.number(unit, q.ACCELERATION, "gravitational_acceleration") or GRAVITY
        u, v, w = (box.number(unit, None, f"direction_vector_gravity_{axis}") or 0.0 for axis in "uvw")
        length = math.sqrt(u * u + v * v + w * w)
        if length == 0.0:
            return None
        if abs(u) > 1e-6 * length:
            notes.leave_out(f"gravity along the shafts, {size * u / length:.4g} m/s^2: it acts in no plane")
        return [quantity(size * each / length, "m/s^2") for each in (v, w)]
    return None


def note_plane(gears: Mapping[int, Gear], notes: Notes) -> None:
    """Note quantities that a planar model lacks: axial forces, bending, positions along shafts."""
    helical = [each for each in gears.values() if abs(each.helix) > SPUR]
    if helical:
        named = ", ".join(str(each.component) for each in helical[:4]) + (" ..." if len(helical) > 4 else "")
        notes.leave_out(
            f"axial forces of helical gears ({named}) and their tilting moments: bearings carry radial forces alone"
        )
    notes.leave_out(
        "bending and tilt of shafts, and where along them gears and bearings sit: gears of a shaft move together, and "
        "misalignment of the teeth does not change their contact"
    )


def load_case_comments(box: Gearbox) -> list[str]:
    """Return a comment on each load case of the file."""
    return [
        f"Load case {case.id}{' (this one)' if case is box.load_case else ''}: {_described(box, case)}."
        for case in box.load_cases
    ]


def _described(box: Gearbox, case: LoadCase) -> str:
    words = {
        "rotational_speed": "",
        "torque_around_u_axis": "",
        "power": "",
        "load_duration_fraction": " of the time",
    }
    said = []
    for number, attributes in case.attributes.items():
        for key, after in words.items():
            if key in attributes:
                found = attributes[key]
                said.append(f"{box.components[number]} {found.value} {found.unit}{after}")
    return "; ".join(said) or "no speed and no torque"
