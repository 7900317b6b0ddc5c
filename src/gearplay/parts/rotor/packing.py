"""Packing of a rotor: inertia, speed, loads and unbalance in its record of the kernels."""

from typing import Any

from gearplay.kernels.layout import DRIVE_NONE, ROTOR
from gearplay.parts.assembly import blank
from gearplay.parts.drive.excitation_packing import refuse_senseless
from gearplay.parts.rotor.schema import Rotor
from gearplay.vocabulary.errors import InputError


def pack_rotor(name: str, given: Rotor, speed: float, sense: float, *, held: bool, carried: bool) -> Any:
    """Return the record of a rotor without its drive, of nominal ``speed`` [rad/s]; ``held`` is whether its centre cannot move.

    Raises `InputError` for a load without a sense of rotation, and for a velocity of a centre that is held.
    """
    r, start = blank(ROTOR), given.initial
    if held and (start.vx != 0.0 or start.vy != 0.0):
        axis = "vx" if start.vx != 0.0 else "vy"
        rule = "must be 0: its centre is held"
        cure = "Remove it, or give the rotor a sleeve, a support, or floating = true"
        raise InputError.of(f"rotors.{name}.initial.{axis}", getattr(start, axis), rule, cure)
    r.mass, r.inertia = given.mass, given.inertia
    r.inv_mass = 0.0 if held else 1.0 / (given.mass or 1.0)
    r.inv_inertia = 0.0 if given.is_prescribed else 1.0 / (given.inertia or 1.0)
    r.nominal_speed = speed
    if given.load.torque > 0.0 and sense == 0.0:
        refuse_senseless(name, "torque", f"{given.load.torque:g} N m")
    r.torque = -sense * given.load.torque
    if given.unbalance is not None:
        r.unbalance, r.unbalance_phase = given.unbalance.amount, given.unbalance.phase
    r.drag, r.friction, r.friction_speed = given.load.drag, given.load.friction, given.load.friction_speed
    r.radial_damping = 0.0 if carried else given.radial_damping  # else of the part that holds it on its pin
    r.drive, r.controller, r.excitation, r.group, r.wave = DRIVE_NONE, -1, -1, -1, -1
    return r
