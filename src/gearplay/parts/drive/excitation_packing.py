"""Packing of varying torques: rows of terms, pieces of tables, one element per excited rotor."""

import math
from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np

from gearplay.parts.assembly import blank
from gearplay.parts.drive import excitation
from gearplay.parts.drive.schema import TorqueDrive
from gearplay.parts.drive.set_point_packing import add_set_point
from gearplay.parts.drive.terms import Term, TorqueTable
from gearplay.parts.protocol import Packing
from gearplay.schema.records import cubic_pieces, edges, harmonic_rows
from gearplay.vocabulary.errors import InputError


def refuse_senseless(name: str, field: str, value: str) -> NoReturn:
    """Raise `InputError` for a load that depends on the sense of rotation of a rotor whose sense is undetermined."""
    rule = "it opposes the nominal sense of rotation, but nothing says which way this rotor turns"
    cure = "Drive the train, give an initial.omega, or use a torque drive of the wanted sign."
    raise InputError.of(f"rotors.{name}.load.{field}", value, rule, cure)


def pack_excitations(packing: Packing) -> None:
    """Add an element for every rotor whose torque has terms, a table or a set-point over time."""
    for i, (name, given) in enumerate(packing.bodies.items()):
        torque = given.drive if isinstance(given.drive, TorqueDrive) else None
        terms, table = (torque.terms, torque.table) if torque is not None else ((), None)
        over_time = torque.over_time if torque is not None else None
        load, opposing = given.load, -float(np.sign(packing.moving[i]))
        if not (terms or table or over_time or load.terms or load.table):
            continue
        for field in ("terms", "table"):
            if getattr(load, field) and opposing == 0.0:
                refuse_senseless(name, field, "given")
        each = blank(excitation.RECORD)
        wave = add_set_point(packing, each, over_time)
        each.constant = 0.0 if over_time is None else over_time.constant
        of_drive, of_load = _term_rows(terms, 1.0), _term_rows(load.terms, opposing)
        each.in_time, each.in_rotation = map(len, of_drive)
        each.load_in_time, each.load_in_rotation = map(len, of_load)
        each.rotor = i
        each.start, _ = packing.add_terms(row for part in (*of_drive, *of_load) for row in part)
        fastest = max((row[0] for row in (*of_drive[0], *of_load[0])), default=0.0)
        fastest = max(fastest, wave)
        for prefix, tabled, sign in (("", table, 1.0), ("load_", load.table, opposing)):
            if tabled is not None:
                _add_table(packing, each, prefix, tabled, sign)
                fastest = max(fastest, 0.5 * math.pi * tabled.sampling)
        packing.records[i].excitation = len(packing.assembly.entries)
        packing.assembly.add(excitation, name, each, [i], always=True, rate=fastest)


def _add_table(packing: Packing, each: Any, prefix: str, table: TorqueTable, sign: float) -> None:
    """Note a table in the record of its element, and its pieces."""
    pieces, first = cubic_pieces(sign * np.array(table.values)), len(packing.record)
    where = {"table": first, "pieces": len(pieces), "begin": table.start, "step": 1.0 / table.sampling}
    for field, value in where.items():
        setattr(each, prefix + field, value)
    packing.record = np.concatenate([packing.record, pieces])
    packing.stops |= edges(table.start, table.start + 1.0 / table.sampling * (len(table.values) - 1))


def _term_rows(terms: Sequence[Term], sign: float) -> tuple[list[list[float]], list[list[float]]]:
    """Return the rows of terms in time, and of those in rotation."""
    in_time = [
        (2.0 * math.pi * term.frequency, sign * term.amplitude, term.phase)
        for term in terms
        if term.frequency is not None
    ]
    in_rotation = [
        (term.order, sign * term.amplitude, term.phase) for term in terms if term.order is not None
    ]
    return harmonic_rows(in_time), harmonic_rows(in_rotation)
