"""`import_rexs`: a case from the file of a gearbox program."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from gearplay.files.atomic import check_new, write_text
from gearplay.model.case import Case
from gearplay.model.reading import load_case as read_case
from gearplay.model.toml_files import parse_toml
from gearplay.rexs.bodies import GEARS, Bodies
from gearplay.rexs.loads import motion_of
from gearplay.rexs.mechanism import add_gear_bodies, rotors_of
from gearplay.rexs.notes import Note, Notes
from gearplay.rexs.opening import read_gearbox
from gearplay.rexs.placement import Plane
from gearplay.rexs.records import Component, Gearbox, refused
from gearplay.rexs.set_tables import set_tables
from gearplay.rexs.sets import PlanetSet, find_sets
from gearplay.rexs.surroundings import gravity_of, load_case_comments, note_plane, run_table, title_of
from gearplay.rexs.tables import Tables
from gearplay.rexs.teeth import SERIES, Gear, Pair, gear_of, pair_of, zero_backlash_distance
from gearplay.rexs.unread import note_unread
from gearplay.rexs.writing import case_text
from gearplay.vocabulary.errors import InputError, shorten
from gearplay.vocabulary.version import VERSION

CROSSING: Final = {
    "worm_stage": "the axes of a worm stage cross, and its flanks slide along the teeth",
    "bevel_stage": "the axes of a bevel stage meet at an angle, and its teeth taper",
    "general_stage": "a general stage has no teeth in the file",
}
"""Stages that a planar case cannot have, with the reason."""


@dataclass(frozen=True)
class Imported:
    """A case that was read from another program's file.

    Parameters
    ----------
    case
        The validated case.
    text
        Its file, with comments.
    notes
        What was assumed, left out and not read, each with its consequence.

    """

    case: Case
    text: str
    notes: tuple[Note, ...]

    @property
    def message(self) -> str:
        """One sentence with the numbers of rotors, meshes and notes."""
        case, counts = self.case, {"assumed": 0, "left out": 0, "not read": 0}
        for note in self.notes:
            counts[note.kind] += 1
        said = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count) or "nothing left out"
        return f"{case.title}: {len(case.rotors)} rotors, {len(case.meshes)} meshes; {said}"

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> Path:
        """Write the case file and return its path."""
        place = Path(path)
        check_new(place, overwrite=overwrite)
        write_text(place, self.text)
        return place


def import_rexs(
    path: str | os.PathLike[str],
    *,
    load_case: int | None = None,
    gear_bodies: str = "none",
    allowance: str = "c25",
) -> Imported:
    """Read a gearbox in the REXS format, versions 1.0 to 1.6, as XML, JSON or zip, and return it as a case.

    Shafts become rotors with mass and inertia from their sections; shafts that a rigid coupling joins become one rotor. Stages
    become meshes, planetary stages planetary sets, bearings supports, external loads drives and loads. The comments of the case
    and ``notes`` list what was assumed, left out and not read.

    Parameters
    ----------
    path
        The file.
    load_case
        Number of the load case; the first if not given.
    gear_bodies
        "none": rotors have the mass of their shafts, as far as the file has shapes; "solid" adds bodies of the gears, solid from
        the shaft to the reference circle.
    allowance
        Series of DIN 3967 for pairs of gears whose tooth thicknesses have no allowance in the file, and so no backlash.

    Returns
    -------
    Imported
        The case, its file as text, and the notes.

    Raises
    ------
    InputError
        For a file that is damaged, hostile or no REXS model, and for gearboxes that a planar case cannot have: worm and bevel
        stages, crossed axes, stepped planets.

    Examples
    --------
    >>> import json, tempfile, gearplay as gp
    >>> names = ("number_of_teeth", "none", 20.0), ("normal_module", "mm", 2.0), ("face_width", "mm", 9.0)
    >>> drawing = [{"id": name, "unit": unit, "floating_point": value} for name, unit, value in names]
    >>> gears = [{"id": k, "type": "cylindrical_gear", "attributes": drawing} for k in (2, 3)]
    >>> roles = enumerate(("stage", "gear_1", "gear_2"), start=1)
    >>> stage = {"id": 1, "type": "stage", "refs": [{"id": k, "role": role} for k, role in roles]}
    >>> model = {"version": "1.6", "relations": [stage], "components": [{"id": 1, "type": "cylindrical_stage"}, *gears]}
    >>> with tempfile.NamedTemporaryFile("w", suffix=".rexsj") as file:
    ...     json.dump({"model": model}, file)
    ...     file.flush()
    ...     print(gp.import_rexs(file.name).case.meshes[0].module)
    0.002

    """
    if gear_bodies not in ("none", "solid"):
        raise InputError.of("gear_bodies", gear_bodies, "must be none or solid", "Choose one")
    if not SERIES.fullmatch(allowance):
        raise InputError.of("allowance", allowance, "must be a series of DIN 3967", "Write for example c25")
    place = Path(path)
    box, notes = read_gearbox(place), Notes()
    _refuse_stages(box)
    _choose_load_case(box, load_case, notes)
    bodies = Bodies(box, notes)
    gears = {each.id: gear_of(box, each, notes) for each in box.of_type(*GEARS)}
    sets = find_sets(box, bodies, gears, notes)
    for k, found in enumerate(sets, start=1):
        found.name = "stage" if len(sets) == 1 else f"stage{k}"
    plane = Plane(box, _axes(box, gears), notes)
    pairs = _pairs(box, bodies, gears, sets, plane, notes)
    _close_loops(bodies, pairs, plane, notes)
    motion = motion_of(box, bodies, plane, sets, pairs, notes)
    every = bodies.every(plane, {pin: found.sun_pairs[0].distance for found in sets for pin in found.pins})
    add_gear_bodies(bodies, every.values(), gears, notes, always=gear_bodies == "solid")
    rotors = rotors_of(bodies, every, gears, sets, motion, notes)
    tables = Tables(bodies, plane, motion, rotors, sets, allowance)
    tables.rank(pairs, sets)
    meshes = [tables.mesh(pair) for pair in pairs]
    blocks = [run_table(motion)]
    for found in sets:
        blocks += set_tables(tables, found, every)
    for rotor in rotors:
        if rotor.member is None:
            blocks += tables.rotor(rotor)
    blocks += [*meshes, *tables.couplings()]
    note_plane(gears, notes)
    top = {"title": title_of(sets, pairs), "gravity": gravity_of(box, notes)}
    note_unread(box, notes)
    head = [
        f"Imported by gearplay {VERSION} from REXS {box.version}, {box.application} {box.application_version}.".replace(
            "  ", " "
        )
    ]
    case_text(head, top, blocks, notes)  # notes fields that this version does not have
    text = case_text([*head, *load_case_comments(box)], top, blocks, notes)
    return Imported(_validated(text), text, tuple(notes.every))


def _validated(text: str) -> Case:
    try:
        return read_case(parse_toml(text, "case"))
    except InputError as error:
        faults = [
            fault._replace(rule=f"{fault.rule} (of the case that was made from the file)")
            for fault in error.faults
        ]
        raise InputError(faults) from None


def _refuse_stages(box: Gearbox) -> None:
    for component in box.components.values():
        if component.type.endswith("_stage") and component.type not in (
            "cylindrical_stage",
            "planetary_stage",
        ):
            reason = CROSSING.get(
                component.type, f"there is no {shorten(component.type.replace('_', ' '))} in a plane"
            )
            rule = f"cannot be imported, since a case lies in one plane and has cylindrical gears: {reason}"
            raise refused(str(component), rule, "Export the cylindrical stages without it")
    if not box.of_type("cylindrical_stage"):
        raise refused("model", "must have a cylindrical stage", "Export a gearbox with gears in mesh")


def _choose_load_case(box: Gearbox, wanted: int | None, notes: Notes) -> None:
    known = {case.id: case for case in box.load_cases}
    if wanted is not None and wanted not in known:
        rule = f"must be a load case of the file: {', '.join(map(str, known)) or 'it has none'}"
        raise InputError.of("load_case", wanted, rule, "Name one of them, or none")
    if known:
        box.load_case = known[wanted] if wanted is not None else box.load_cases[0]
        if len(known) > 1 and wanted is None:
            notes.assume(
                f"the first of {len(known)} load cases; the others are comments below, and load_case chooses one"
            )


def _axes(box: Gearbox, gears: Mapping[int, Gear]) -> list[Component]:
    """Return shafts and gears, whose axes must be parallel: those of gears first."""
    carrying = [shaft for number in gears for shaft in box.assemblies(number, "shaft")]
    others = [each.component for each in gears.values()]
    return list(
        {each.id: each for each in (*carrying, *others, *box.of_type("shaft", "side_plate"))}.values()
    )


def _pairs(
    box: Gearbox, bodies: Bodies, gears: dict[int, Gear], sets: list[PlanetSet], plane: Plane, notes: Notes
) -> list[Pair]:
    """Return the pairs of stages outside planetary sets; those inside are added to the sets."""
    outside = []
    inside = {stage.id: found for found in sets for stage in found.stages}
    for stage in box.of_type("cylindrical_stage"):
        numbers = box.stage_gears(stage)
        placed = plane.distance(numbers[0], numbers[1]) if len(numbers) == 2 else None
        pair = pair_of(box, stage, gears, placed, notes)
        if bodies.find(pair.first.component.id) == bodies.find(pair.second.component.id):
            raise refused(
                str(stage),
                "must have gears on two shafts that are not rigidly coupled",
                "Check the couplings",
            )
        found = inside.get(stage.id)
        if found is None:
            outside.append(pair)
        else:
            (found.ring_pairs if pair.first.internal or pair.second.internal else found.sun_pairs).append(
                pair
            )
        zero = zero_backlash_distance(pair.first, pair.second)
        if not abs(zero - pair.distance) < 0.1 * pair.first.module:
            notes.assume(
                f"{stage}: its shifts have no backlash at {1e3 * zero:.6g} mm; it is mounted at {1e3 * pair.distance:.6g} mm"
            )
    return outside


def _close_loops(bodies: Bodies, pairs: list[Pair], plane: Plane, notes: Notes) -> None:
    """Take all centre distances from the positions where stages form a loop, so that it closes."""
    joined: dict[int, int] = {}

    def find(root: int) -> int:
        while joined.get(root, root) != root:
            root = joined[root]
        return root

    loops = False
    for pair in pairs:
        first, second = (find(bodies.find(each.component.id)) for each in (pair.first, pair.second))
        loops = loops or first == second
        joined[first] = second
    if loops:
        for pair in pairs:
            placed = plane.distance(pair.first.component.id, pair.second.component.id)
            pair.distance = placed or pair.distance
        notes.assume("stages close a loop: centre distances are those of the positions, so that it closes")
