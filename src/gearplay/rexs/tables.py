"""Tables of the case: rotors, supports, planetary sets, meshes, couplings."""

import math
from typing import Any, Final

from gearplay.parts.coupling.schema import Coupling
from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.rotor.gear import Gear as CaseGear
from gearplay.parts.rotor.schema import Rotor as CaseRotor
from gearplay.parts.support.schema import Support
from gearplay.rexs.bodies import GROUND, Bodies, Link
from gearplay.rexs.holding import Holding, holding_of
from gearplay.rexs.loads import Motion
from gearplay.rexs.mechanism import Rotor, drive_and_load, material_of, shaft_twist
from gearplay.rexs.placement import Plane
from gearplay.rexs.records import refused
from gearplay.rexs.sets import PlanetSet, planet_bearings, stage_direction
from gearplay.rexs.teeth import SPUR, Gear, Pair
from gearplay.rexs.text import number, quantity
from gearplay.rexs.writing import Table, kinds_of
from gearplay.vocabulary import quantities as q

MESH_DAMPING: Final = 0.05
TWIST_DAMPING: Final = 0.02


class Tables:
    """Maker of the tables of one gearbox."""

    def __init__(
        self,
        bodies: Bodies,
        plane: Plane,
        motion: Motion,
        rotors: list[Rotor],
        sets: list[PlanetSet],
        allowance: str,
    ) -> None:
        self.box, self.bodies, self.notes = bodies.box, bodies, bodies.notes
        self.plane, self.motion, self.rotors, self.allowance = plane, motion, rotors, allowance
        self.fixed = bodies.fixed
        self.pins = {
            link.component.id
            for found in sets
            for planet in found.planets
            for link in planet_bearings(bodies, found, planet)
        }
        self.ranks: dict[int, int] = {}

    def rotor_of(self, gear: Gear) -> Rotor:
        """Return the rotor that carries a gear."""
        for rotor in self.rotors:
            if gear in rotor.gears:
                return rotor
        raise refused(
            str(gear.component), "is in a stage outside its planetary stage", "Split the planetary stage"
        )

    def rank(self, pairs: list[Pair], sets: list[PlanetSet]) -> None:
        """Count for every body how many stages and couplings it is away from the drive."""
        find, near = self.bodies.find, dict[int, set[int]]()
        groups = [{find(each.component.id) for each in (pair.first, pair.second)} for pair in pairs]
        groups += [{find(number) for number in found.members.values()} for found in sets]
        groups += [{find(link.inner), find(link.outer)} for link in self.bodies.links]
        for group in groups:
            for root in group:
                near.setdefault(root, set()).update(group)
        start = self.motion.driver if self.motion.driver is not None else min(near, default=GROUND)
        far, edge = 0, {start}
        while edge:
            self.ranks |= dict.fromkeys(edge, far)
            far, edge = far + 1, {root for known in edge for root in near.get(known, ())} - set(self.ranks)
        self.ranks = dict.fromkeys(near, far) | self.ranks

    def held_by(self, rotor: Rotor) -> Holding:
        """Return the parts that hold a rotor to the casing; several rotors of one body share them."""
        root, name = rotor.root, rotor.name
        own: list[Link] = []
        others: list[Link] = []
        for link in self.bodies.bearings:
            ends = [self.bodies.find(link.inner), self.bodies.find(link.outer)]
            if root in ends and ends[0] != ends[1]:
                other = ends[1] if ends[0] == root else ends[0]
                (own if self.bodies.stands(other) else others).append(link)
        holding = holding_of(self.box, own, self.notes)
        on_pins = [link for link in others if link.component.id in self.pins]
        for link in others:
            if link in on_pins:
                continue
            if holding.held or holding.stiffness:
                self.notes.leave_out(
                    f"between two rotors: {name} is held by its own bearings alone", link.component
                )
            else:
                text = f"between two rotors; it holds {name} to the ground, since a case has no bearing between them"
                self.notes.assume(text, link.component)
        if not holding.held and holding.stiffness is None:
            holding = holding_of(self.box, [link for link in others if link not in on_pins], self.notes)
        return holding.shared(rotor.parts)

    def common(self, table: Table, rotor: Rotor) -> None:
        """Add mass, inertia, drive, load and material."""
        body = rotor.body
        if len(body.members) > 1 or not body.said:
            table.comments.append(f"{', '.join(str(each) for each in body.members)}.")
        table.comments += body.said
        table.add("mass", quantity(float(f"{rotor.weight.mass:.9g}"), "kg"))
        table.add("inertia", quantity(float(f"{rotor.weight.inertia:.9g}"), "kg m^2"))
        drive, load, comment = drive_and_load(rotor, self.rotors, self.motion, fixed=rotor.root in self.fixed)
        table.add("drive", drive, comment)
        table.add("load", load, "" if drive else comment)
        table.add("material", material_of(self.box, body.main))

    def toothing(self, table: Table, gear: Gear) -> None:
        """Add the fields of a gear's drawing."""
        if abs(gear.helix) > SPUR:
            table.add("helix_angle", quantity(gear.helix, "deg"))
        table.add("profile_shift", float(number(gear.shift or 0.0)) or None)
        for key, value in gear.fields.items():
            table.add(key, value)
        table.add("facewidth", quantity(gear.facewidth, "mm") if gear.facewidth else None)

    def rotor(self, rotor: Rotor) -> list[Table]:
        """Return the tables of a rotor outside planetary sets: itself, its gears, its support."""
        table = Table(f"[rotors.{rotor.name}]", CaseRotor)
        self.common(table, rotor)
        tables = [table]
        if rotor.root in self.fixed:
            table.add("drive", {"kind": "speed", "speed": "0 rpm"}, "fixed to the casing")
        for gear in rotor.gears:
            own = table
            if rotor.called:
                own = Table(
                    f"[rotors.{rotor.name}.gears.{rotor.called[gear.component.id]}]",
                    CaseGear,
                    [f"{gear.component}."],
                )
                tables.append(own)
            own.add("teeth", gear.teeth)
            own.add("internal", True if gear.internal else None)
            self.toothing(own, gear)
        holding = self.held_by(rotor)
        if rotor.root not in self.fixed:
            support = Table(f"[supports.{rotor.name}]", Support, list(holding.said))
            self.support(support, holding, rotor)
            if support.entries:
                tables.append(support)
            elif holding.said:
                table.comments.append(f"Its centre is held: {'; '.join(holding.said)}.")
            if not holding.said:
                self.notes.assume("no bearing in the file: its centre is held", rotor.name)
        return tables

    def support(self, table: Table, holding: Holding, rotor: Rotor) -> None:
        """Add stiffness and damping of the centre, and a coupling to the casing."""
        if holding.stiffness is not None:
            table.add("stiffness", [quantity(each, "N/m") for each in holding.stiffness])
            damping = [quantity(each, "N s/m") for each in holding.damping(rotor.weight.mass)]
            table.add("damping", damping, "assumed: damping ratio 0.05 of the rotor on its supports")
        twist = sum(self._twist(link) for link in self.bodies.links if self._to_ground(link, rotor.root))
        if twist:
            table.add("torsional_stiffness", quantity(twist, "N m/rad"))

    def _to_ground(self, link: Link, root: int) -> bool:
        ends = [self.bodies.find(link.inner), self.bodies.find(link.outer)]
        return root in ends and any(self.bodies.stands(end) for end in ends if end != root)

    def _twist(self, link: Link) -> float:
        return self.box.number(link.component, q.ROTATIONAL_STIFFNESS, "rotational_stiffness") or 0.0

    def mesh(self, pair: Pair) -> Table:
        """Return the table of a stage; the gear nearer to the drive is the driver."""
        first, second = self.rotor_of(pair.first), self.rotor_of(pair.second)
        back = self.ranks[second.root] < self.ranks[first.root]
        driver, driven = (pair.second, pair.first) if back else (pair.first, pair.second)
        table = Table("[[meshes]]", Mesh, [f"{pair.stage}: {driver.component} drives {driven.component}."])
        table.add("driver", self.rotor_of(driver).gear_name(driver))
        table.add("driven", self.rotor_of(driven).gear_name(driven))
        table.add("module", quantity(pair.first.module, "mm"))
        table.add("pressure_angle", quantity(pair.first.pressure_angle, "deg"))
        table.add("center_distance", quantity(pair.distance, "mm"))
        turned = stage_direction(self.box, pair.stage)
        direction = self.plane.direction(driver.component.id, driven.component.id)
        if direction is None and turned is not None:
            direction = turned + math.pi if back else turned
        table.add(
            "angle", None if direction is None else f"{number(round(math.degrees(direction), 9) % 360.0)} deg"
        )
        self.pair_fields(table, pair)
        self.allow([pair])
        table.add("stiffness", self.stiffness(pair))
        table.add("damping", {"ratio": MESH_DAMPING}, "assumed")
        return table

    def pair_fields(self, table: Table, pair: Pair) -> None:
        """Add the fields of the stage itself."""
        for key, value in pair.fields.items():
            table.add(key, value)

    def allow(self, pairs: list[Pair]) -> None:
        """Assume allowances where no gear of a pair has one, as it had no backlash; note where one gear has none."""
        for pair in pairs:
            bare = [gear for gear in (pair.first, pair.second) if "allowance" not in gear.fields]
            if len(bare) < 2:
                for gear in bare:
                    text = "no allowance of its tooth thickness in the file: 0, so that backlash is of the other gear alone"
                    self.notes.assume(text, gear.component)
                continue
            pair.first.fields["allowance"] = pair.second.fields["allowance"] = self.allowance
            text = f"no allowance of tooth thicknesses in the file, and so no backlash: both gears {self.allowance} of DIN 3967"
            self.notes.assume(text, pair.stage)

    def stiffness(self, pair: Pair) -> dict[str, Any]:
        """Return the stiffness of a pair, of the kind ``teeth`` if this version has it."""
        width = pair.facewidth
        if width is None:
            width = 10.0 * pair.first.module
            self.notes.assume("gears without a facewidth in the file: 10 modules", pair.stage)
            for gear in (pair.first, pair.second):
                gear.facewidth = gear.facewidth or width
        if "teeth" in kinds_of(Mesh, "stiffness"):
            return {"kind": "teeth", "method": "iso6336"}
        return {"kind": "iso6336", "facewidth": quantity(width, "mm")}

    def couplings(self) -> list[Table]:
        """Return the tables of elastic couplings, and of shafts that are in several sets."""
        tables = []
        last = {rotor.root: rotor for rotor in self.rotors}
        for link in self.bodies.links:
            ends = [last.get(self.bodies.find(side)) for side in (link.inner, link.outer)]
            if ends[0] is None or ends[1] is None or ends[0] is ends[1]:
                continue
            table = Table("[[couplings]]", Coupling, [f"{link.component}."])
            table.add("between", [each.name for each in ends if each is not None])
            twist = self._twist(link)
            table.add("torsional_stiffness", quantity(twist, "N m/rad"))
            inertias = [each.weight.inertia for each in ends if each is not None]
            if min(inertias) > 0.0:
                reduced = inertias[0] * inertias[1] / sum(inertias)
                damping = float(f"{2.0 * TWIST_DAMPING * math.sqrt(twist * reduced):.3g}")
                table.add(
                    "torsional_damping",
                    quantity(damping, "N m s/rad"),
                    f"assumed: damping ratio {TWIST_DAMPING:g}",
                )
            radial = self.box.number(link.component, q.STIFFNESS, "radial_stiffness")
            if radial and radial < 1e13:
                table.add("lateral_stiffness", quantity(radial, "N/m"))
            tables.append(table)
        for before, after in zip(self.rotors, self.rotors[1:], strict=False):
            if before.root == after.root:
                table = Table("[[couplings]]", Coupling, [f"Twist of {before.body.main} between its places."])
                table.add("between", [before.name, after.name])
                table.add("torsional_stiffness", quantity(shaft_twist(self.bodies, before.body), "N m/rad"))
                tables.append(table)
        return tables
