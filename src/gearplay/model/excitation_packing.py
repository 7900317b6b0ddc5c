"""Packing of varying torques: rows of terms, pieces of tables, one element per excited rotor."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from gearplay.model.set_point_packing import SetPoints
from gearplay.parts.assembly import Assembly, blank
from gearplay.parts.drive import excitation
from gearplay.schema.records import cubic_pieces, edges, harmonic_rows
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.parts.drive.terms import Term, TorqueTable

Floats = NDArray[np.float64]


def refuse_senseless(name: str, field: str, value: str) -> NoReturn:
    """Raise `InputError` for a load that depends on the sense of rotation of a rotor whose sense is undetermined."""
    rule = "it opposes the nominal sense of rotation, but nothing says which way this rotor turns"
    cure = "Drive the train, give an initial.omega, or use a torque drive of the wanted sign."
    raise InputError.of(f"rotors.{name}.load.{field}", value, rule, cure)


def pack_excitations(
    case: "Case",
    assembly: Assembly,
    rotors: Any,
    senses: Floats,
    start: int,
    record: Floats,
    set_points: SetPoints,
) -> tuple[Floats, Floats, set[float]]:
    """Add an element for every rotor whose torque has terms, a table or a set-point over time.

    Return its rows of terms, which begin at row ``start``, the pieces of ``record`` with those of tables behind, and when tables
    begin and end [s].
    """
    rows: list[list[float]] = []
    stops: set[float] = set()
    for i, (name, given) in enumerate(case.rotors.items()):
        torque = given.drive if given.drive is not None and given.drive.kind == "torque" else None
        terms, table = (torque.terms, torque.table) if torque is not None else ((), None)
        over_time = torque.over_time if torque is not None else None
        load, opposing = given.load, -float(senses[i])
        if not (terms or table or over_time or load.terms or load.table):
            continue
        for field in ("terms", "table"):
            if getattr(load, field) and opposing == 0.0:
                refuse_senseless(name, field, "given")
        each = blank(excitation.RECORD)
        each.rotor, each.start = i, start + len(rows)
        wave = set_points.add(each, over_time)
        each.constant = 0.0 if over_time is None else over_time.constant
        of_drive, of_load = _term_rows(terms, 1.0), _term_rows(load.terms, opposing)
        each.in_time, each.in_rotation = map(len, of_drive)
        each.load_in_time, each.load_in_rotation = map(len, of_load)
        rows += [row for part in (*of_drive, *of_load) for row in part]
        fastest = max((row[0] for row in (*of_drive[0], *of_load[0])), default=0.0)
        fastest = max(fastest, wave)
        for prefix, tabled, sign in (("", table, 1.0), ("load_", load.table, opposing)):
            if tabled is not None:
                record = _add_table(each, prefix, tabled, sign, record)
                stops |= edges(tabled.start, tabled.start + 1.0 / tabled.sampling * (len(tabled.values) - 1))
                fastest = max(fastest, 0.5 * math.pi * tabled.sampling)
        rotors[i].excitation = len(assembly.entries)
        assembly.add(excitation, name, each, [i], always=True, rate=fastest)
    return np.array(rows).reshape(-1, 3), record, stops


def _add_table(each: Any, prefix: str, table: "TorqueTable", sign: float, record: Floats) -> Floats:
    """Note a table in the record of its element; return the pieces with its own behind."""
    pieces = cubic_pieces(sign * np.array(table.values))
    where = {"table": len(record), "pieces": len(pieces), "begin": table.start, "step": 1.0 / table.sampling}
    for field, value in where.items():
        setattr(each, prefix + field, value)
    return np.concatenate([record, pieces])


def _term_rows(terms: Sequence["Term"], sign: float) -> tuple[list[list[float]], list[list[float]]]:
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
