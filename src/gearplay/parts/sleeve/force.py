"""Packed record of a sleeve, its contact force and the slopes of the force (docs/theory, section 3)."""

import math
from typing import Any

import numpy as np

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.layout import PLACES, Signal
from gearplay.parts.sleeve.conformal import BED_AS_PRINTED, BED_NONE, bed_integrals, bed_slopes
from gearplay.parts.sleeve.line import LINE_NONE, line_force, line_slope

KIND = 1
RECORD = np.dtype(
    [
        *PLACES,
        ("clearance", "f8"),  # m, radius difference
        ("stiffness", "f8"),  # N/m^n
        ("exponent", "f8"),  # n
        ("dissipation", "f8"),  # a of F = K delta^n (1 + a ddelta/v_in)
        ("friction", "f8"),  # Coulomb coefficient
        ("friction_speed", "f8"),  # m/s
        ("shaft_radius", "f8"),  # m
        ("bed_stiffness", "f8"),  # N/m^k/rad
        ("bed_exponent", "f8"),  # k
        ("line_length", "f8"),  # m, of a line contact
        ("line_modulus", "f8"),  # E* [Pa]
        ("damping", "f8"),  # N s/m, of the journal against a carried bush
        ("offset_x", "f8"),  # m, bush on its carrier at zero rotation
        ("offset_y", "f8"),
        ("misplaced_x", "f8"),  # m, of the offset: beside the journal's nominal centre
        ("misplaced_y", "f8"),
        ("journal", "i8"),  # rotor
        ("bush", "i8"),  # rotor, -1 for the ground
        ("bed", "i8"),
        ("line", "i8"),  # law of a line contact, 0 for none
        ("is_bush", "i8"),  # 1 where the rotor is the bush and its carrier or the ground the journal, else 0
    ],
    align=True,
)
SIGNALS = (
    Signal("sleeve_penetration", "delta", "m", "um", 1e6, "penetration of journal into bush", True),
    Signal("sleeve_force_x", "Fx", "N", "N", 1.0, "force of the bush on the journal along x"),
    Signal("sleeve_force_y", "Fy", "N", "N", 1.0, "force of the bush on the journal along y"),
    Signal("sleeve_power_loss", "P", "W", "W", 1.0, "power lost in the sleeve: impacts, friction, damping"),
)


@compiled_inline
def signed_power(x: float, n: float) -> float:
    """Return sign(x) |x|^n: a smooth continuation of x^n for stages beyond a release."""
    if n == 1.5:
        return x * math.sqrt(abs(x))
    if n == 1.0:
        return x
    return math.copysign(abs(x) ** n, x)


@compiled_inline
def sleeve_force(sleeve: Any, delta: float, rate: float, v_in: float) -> tuple[float, float]:
    """Return the normal force [N] and its margin (positive while pressing) at penetration delta [m].

    F = K delta^n (1 + a ddelta/v_in), equations (7)-(11) with the damping of (10) written as the factor ``a``;
    the conformal bed (12)-(14) or a line contact replaces K delta^n. ``rate`` is ddelta/dt [m/s], ``v_in`` the stored impact
    speed. As printed, the bed's damping C = a K delta_m^n / v_in is the same at every angle.
    """
    margin = 1.0 + sleeve.dissipation * rate / v_in
    if sleeve.line != LINE_NONE:
        return line_force(sleeve, delta) * margin, margin
    if sleeve.bed == BED_NONE:
        return sleeve.stiffness * signed_power(delta, sleeve.exponent) * margin, margin
    if delta <= 0.0:
        return 0.0, margin
    elastic, opening = bed_integrals(delta, sleeve.clearance, sleeve.shaft_radius, sleeve.bed_exponent)
    if sleeve.bed == BED_AS_PRINTED:
        damping = sleeve.dissipation * sleeve.stiffness * delta**sleeve.exponent / v_in
        force = sleeve.stiffness * elastic + damping * rate * opening
        return force, force
    return sleeve.bed_stiffness * elastic * margin, margin


@compiled
def sleeve_force_slopes(sleeve: Any, delta: float, rate: float, v_in: float) -> tuple[float, float, float]:
    """Return the derivatives of `sleeve_force` by delta [N/m], rate and v_in [N s/m]."""
    margin, by_rate = 1.0 + sleeve.dissipation * rate / v_in, sleeve.dissipation / v_in
    by_impact_speed = -by_rate * rate / v_in
    if sleeve.line != LINE_NONE:
        force = line_force(sleeve, delta)
        return line_slope(sleeve, delta) * margin, force * by_rate, force * by_impact_speed
    if sleeve.bed == BED_NONE:
        force = sleeve.stiffness * signed_power(delta, sleeve.exponent)
        steepness = sleeve.exponent * (
            math.sqrt(abs(delta)) if sleeve.exponent == 1.5 else abs(delta) ** (sleeve.exponent - 1.0)
        )
        return sleeve.stiffness * steepness * margin, force * by_rate, force * by_impact_speed
    if delta <= 0.0:
        return 0.0, 0.0, 0.0
    c, R, k = sleeve.clearance, sleeve.shaft_radius, sleeve.bed_exponent
    elastic, opening = bed_integrals(delta, c, R, k)
    stiffer, wider = bed_slopes(delta, c, R, k)
    if sleeve.bed == BED_AS_PRINTED:
        damping = by_rate * sleeve.stiffness * delta**sleeve.exponent
        grown = sleeve.exponent * damping / delta
        return (
            sleeve.stiffness * stiffer + (grown * opening + damping * wider) * rate,
            damping * opening,
            -damping * rate * opening / v_in,
        )
    pressed = sleeve.bed_stiffness * elastic
    return sleeve.bed_stiffness * stiffer * margin, pressed * by_rate, pressed * by_impact_speed
