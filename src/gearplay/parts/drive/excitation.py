"""An excitation: the part of a rotor's torque that varies, by terms in time or in its own rotation (docs/theory, section 4).

No contact: it always acts. Terms are rows of `System.terms`, of the drive and then of the load those in time first:
(2 pi f, a cos(phase), a sin(phase)), then those in rotation: (order, the same), of a sin(2 pi f t + phase) and
a sin(order theta + phase) with the full angle.
"""

import math

import numpy as np

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled import compiled
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.housing_motion import recorded
from gearplay.kernels.layout import (
    PLACES,
    Branch,
    Loads,
    Signal,
    System,
    spin_of,
    theta_of,
    turn_of,
)
from gearplay.kernels.set_point import FIELDS, set_point

KIND = 5
RECORD = np.dtype(
    [
        *PLACES,
        ("rotor", "i8"),
        ("start", "i8"),  # first of its rows in System.terms
        ("in_time", "i8"),  # how many of its drive's are in time
        ("in_rotation", "i8"),
        ("load_in_time", "i8"),  # and of its load's, which follow
        ("load_in_rotation", "i8"),
        ("table", "i8"),  # first piece in System.record of its drive's table, and how many
        ("pieces", "i8"),
        ("begin", "f8"),  # s, when it begins, and its step
        ("step", "f8"),
        ("load_table", "i8"),  # the same of its load's
        ("load_pieces", "i8"),
        ("load_begin", "f8"),
        ("load_step", "f8"),
        *FIELDS,  # of its drive's set-point over time [N m], and the constant in it
        ("constant", "f8"),
    ],
    align=True,
)
SIGNALS = (Signal("excitation_torque", "T", "N m", "N m", 1.0, "varying part of the applied torque", True),)
MEMORY: tuple[float, ...] = ()
MODES = 0
PER_CONTACT = 0
SLOPES = 1  # of the torque by the rotation


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] of terms; NaN for a table and other curves, which do not repeat."""
    rates: list[float] = []
    for each in system.records[KIND]:
        if each.pieces > 0 or each.load_pieces > 0 or each.set_points > 0:
            rates.append(math.nan)
        if each.wave >= 0:
            rates.append(float(system.terms[each.wave, 0]))
        at, speed = int(each.start), abs(speeds[each.rotor])
        for in_time, in_rotation in (
            (each.in_time, each.in_rotation),
            (each.load_in_time, each.load_in_rotation),
        ):
            rates += system.terms[at : at + in_time, 0].tolist()
            at += int(in_time)
            rates += (speed * system.terms[at : at + in_rotation, 0]).tolist()
            at += int(in_rotation)
    return rates


@compiled
def _sum_of(
    system: System, start: int, in_time: int, in_rotation: int, t: float, turn: float
) -> tuple[float, float]:
    """Return the sum [N m] of some rows of terms at t [s] and a rotation [rad], and its slope by the rotation."""
    torque, slope = 0.0, 0.0
    for row in range(start, start + in_time):
        angle = system.terms[row, 0] * t
        torque += system.terms[row, 1] * math.sin(angle) + system.terms[row, 2] * math.cos(angle)
    for row in range(start + in_time, start + in_time + in_rotation):
        order, cosine, sine = system.terms[row, 0], system.terms[row, 1], system.terms[row, 2]
        c, s = math.cos(order * turn), math.sin(order * turn)
        torque += cosine * s + sine * c
        slope += order * (cosine * c - sine * s)
    return torque, slope


@compiled_once
def torques_of(system: System, n: int, t: float, y: Floats) -> tuple[float, float, float]:
    """Return the torques [N m] of excitation n at (t, y) that are its drive's and its load's, and their slope by the rotation."""
    each = system.records[KIND][n]
    turn, load_start = turn_of(system, each.rotor, t, y), each.start + each.in_time + each.in_rotation
    drive, slope = _sum_of(system, each.start, each.in_time, each.in_rotation, t, turn)
    load, load_slope = _sum_of(system, load_start, each.load_in_time, each.load_in_rotation, t, turn)
    if each.pieces > 0:
        drive += recorded(system, each.table, each.pieces, each.begin, each.step, t)
    if each.load_pieces > 0:
        load += recorded(system, each.load_table, each.load_pieces, each.load_begin, each.load_step, t)
    if each.set_points > 0 or each.wave >= 0:
        more, _ = set_point(system, each.constant, each.set_point, each.set_points, each.wave, t)
        drive += more
    return drive, load, slope + load_slope


@compiled_once
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add excitation n's torque to the sum on its rotor; return 0."""
    drive, load, _ = torques_of(system, n, t, y)
    loads.rotors[system.records[KIND][n].rotor, 2] += drive + load
    return 0


@compiled_once
def forcing_rate(system: System, n: int, t: float, y: Floats) -> float:
    """Return the highest angular frequency [rad/s] of its terms."""
    each = system.records[KIND][n]
    fastest, spin, row = 0.0, abs(spin_of(system, each.rotor, y)), each.start
    if each.pieces > 0:
        fastest = max(fastest, 0.5 * math.pi / each.step)
    if each.load_pieces > 0:
        fastest = max(fastest, 0.5 * math.pi / each.load_step)
    if each.wave >= 0:
        fastest = max(fastest, system.terms[each.wave, 0])
    for in_time, in_rotation in (
        (each.in_time, each.in_rotation),
        (each.load_in_time, each.load_in_rotation),
    ):
        for term in range(in_time + in_rotation):
            fastest = max(fastest, system.terms[row, 0] * (1.0 if term < in_time else spin))
            row += 1
    return fastest


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill excitation n's row of slopes at (t, y); return 0."""
    _, _, row[0] = torques_of(system, n, t, y)
    return 0


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the change of excitation n's torque by a change z of the state to ``force`` [rotor, (N, N, N m)]."""
    rotor = system.records[KIND][n].rotor
    force[rotor, 2] += row[0] * z[theta_of(rotor)]


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill excitation n's signal of a full ``row`` at (t, y)."""
    drive, load, _ = torques_of(system, n, t, y)
    row[system.records[KIND][n].signal] = drive + load
