"""Overlap of one pair of teeth at the actual centres: flank on flank, or a tip's corner on the other flank.

Places rho_1, rho_2 count along the line of action from the base tangent points T1, T2: rho_1 + rho_2 = L - g of an external pair,
rho_2 = rho_1 + L + g of an internal one, L = A sin(alpha_w), g the gap of the involutes.

Where a tip would lie beyond its circle, its corner P at (R, gamma) about the other gear is the point that would touch:
g = r_b (gamma - zeta + inv(alpha_R)), zeta the half angle of that flank at its base circle. Involutes of one base circle are
parallel curves: this is the distance, its gradient by P the unit normal n = (-sin tau, cos tau), tau = gamma - alpha_R. With
t = (cos tau, sin tau), n turns by t.dP / l, l = R sin(alpha_R).
"""

import math
from typing import Any, NamedTuple

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import System
from gearplay.parts.mesh.geometry import (
    DISTANCE,
    DISTANCE_RATE,
    OPENING,
    P_D,
    P_D_RATE,
    PHI,
    PHI_RATE,
    PSI,
    ROLLED,
    SIN_W,
    SPIN_1,
    SPIN_2,
)
from gearplay.parts.mesh.pairs.deviations import (
    cubic_at,
    least_deviation,
    relief,
    tilted_least,
    tooth_deviation,
    tooth_kept,
)
from gearplay.parts.mesh.pairs.oblique import least_missing, line_of_contact


class Pair(NamedTuple):
    """One pair of teeth at a state: place, part that touches, derivatives of its overlap.

    By the distance A of the centres [m] and the angles a_1, a_2 of both gears against the line of centres, in the flank's sense.
    """

    p: float  # m, overlap
    penetration: float  # m, the less of it and what `STEEP` allows near a hard end
    edge: float  # its slope there by the place on the first gear's path, else 0
    place: float  # m, of the driver's flank, as on the first gear's path
    rho_1: float  # m, of both flanks on their own paths
    rho_2: float
    number: int
    touching: int
    by_a: float
    p_1: float  # m
    p_2: float  # m
    bend_aa: float  # second derivatives by A A, A z, z z; z the angle of the gear whose tip touches
    bend_az: float
    bend_zz: float
    by_1: float  # slopes of the deviations by the places on both paths, and their curvatures [1/m]
    by_2: float
    dev_1: float
    dev_2: float
    dev_12: float  # their second derivative by both places
    length: float  # m, l of a corner


TWO_PI = 2.0 * math.pi
BEYOND = 0.8
"""Base pitches beyond the path within which corners are followed."""
INTERFERING = 0.5
"""Base pitches before T1 within which teeth that interfere go on touching as involutes."""
FAR = 0.1
"""Gap in base pitches of a pair farther away."""
STEEP = 0.01
"""Penetration over the way within a hard end of the path, by which contact begins and ends there."""
ON_FLANK, TIP_OF_1, TIP_OF_2, AWAY = 0, 1, 2, 3


@compiled_inline
def sense(mesh: Any, flank: int) -> float:
    """Return 1 where a flank is on the counter-clockwise side of the first gear's teeth, else -1."""
    return float(mesh.sigma * (1.0 - 2.0 * flank))


class Line(NamedTuple):
    """Line of action of a flank: gap of its involutes [m], length L of the tangent of both base circles [m], alpha_w [rad].

    ``first`` is the place of pair 0 on the driver's path [m].
    """

    gap: float
    length: float
    alpha: float
    first: float


@compiled_inline
def line_of_flank(mesh: Any, out: Floats, flank: int) -> Line:
    """Return the line of action of a flank, its mesh's gaps in the scratch (`mesh_gaps`).

    Where mesh phase and phi are 0 a tooth of the driver is on the line of centres, the space of a ring half a pitch on.
    """
    length = out[SIN_W] * out[DISTANCE]
    alpha = length / mesh.c0 - (mesh.inv_alpha0 + out[OPENING] / mesh.c0)
    opened = mesh.s * out[OPENING]
    gap = -out[ROLLED] - opened if flank == 0 else out[ROLLED] - opened + mesh.backlash
    teeth, base, offset = mesh.teeth_1, mesh.base_1, 0.0
    if mesh.ring_drives == 1:
        teeth, base, offset = mesh.teeth_2, mesh.base_2, 0.5
    pitches = sense(mesh, flank) * (out[PSI] + mesh.pair_phase - teeth * out[PHI]) / TWO_PI + offset
    first = mesh.base_pitch * pitches + base * (mesh.half_angle + alpha)
    return Line(gap, length, alpha, first)


@compiled_inline
def pitches_ahead(mesh: Any, line: Line) -> float:
    """Return the place of pair 0 beyond mid-path, in base pitches."""
    return float((line.first - mesh.shift - mesh.middle) / mesh.base_pitch)


@compiled_inline
def number_in_slot(mesh: Any, line: Line, slot: int) -> int:
    """Return the number of the pair in a slot: of those that share it the one within half the slots from mid-path."""
    ahead = pitches_ahead(mesh, line) + slot
    turns = math.floor((ahead + 0.5 * mesh.pairs) / mesh.pairs)
    return int(slot - mesh.pairs * turns)


@compiled_inline
def places_of_pair(mesh: Any, line: Line, number: int) -> tuple[float, float, float]:
    """Return the places of pair ``number`` on the driver's path and on those of both gears, rho_1 and rho_2 [m]."""
    place = line.first + number * mesh.base_pitch
    if mesh.ring_drives == 1:
        return place, place - line.gap - line.length, place
    if mesh.s < 0.0:
        return place, place, line.length - line.gap - place
    return place, place, place + line.length + line.gap


@compiled_inline
def part_in_touch(mesh: Any, rho_1: float, rho_2: float) -> int:
    """Return the part of a pair that would touch at places on both paths: flanks, a tip's corner, or none near contact."""
    if mesh.corners == 0:
        inside = min(rho_1 - mesh.start, mesh.end - rho_1)
        return AWAY if inside < -BEYOND * mesh.base_pitch else ON_FLANK
    if rho_1 < -INTERFERING * mesh.base_pitch:
        return AWAY
    reach = BEYOND * mesh.base_pitch
    beyond_1 = rho_1 - mesh.tip_length_1
    beyond_2 = -mesh.s * (rho_2 - mesh.tip_length_2)
    if beyond_2 > 0.0:
        return TIP_OF_2 if beyond_2 < reach else AWAY
    if beyond_1 > 0.0:
        return TIP_OF_1 if beyond_1 < reach else AWAY
    return ON_FLANK


@compiled_inline
def modulo(number: int, count: float) -> int:
    """Return ``number`` modulo ``count``, both whole: faster than the division of integers.

    >>> modulo(-1, 20.0), modulo(40, 20.0)
    (19, 0)
    """
    return int(number - count * math.floor(number / count))


@compiled_inline
def teeth_of_pair(mesh: Any, flank: int, number: int) -> tuple[int, int]:
    """Return the numbers, counter-clockwise, of the teeth of both gears in pair ``number`` of a flank."""
    forwards = sense(mesh, flank) > 0.0
    if mesh.s < 0.0:
        one, other = (number, -number - 1) if forwards else (-number, number)
    elif mesh.ring_drives == 1:
        one, other = (number, number + 1) if forwards else (-number - 1, -number - 1)
    else:
        one, other = (number, number) if forwards else (-number, -number - 1)
    return modulo(one + mesh.number_1, mesh.teeth_1), modulo(other + mesh.number_2, mesh.teeth_2)


@compiled_inline
def flank_rows(mesh: Any, flank: int, number: int) -> tuple[int, int]:
    """Return the first rows of `System.terms` of both flanks of pair ``number``, -1 for a gear of perfect teeth.

    Two flanks a tooth, clockwise first: pitch, slope, form [m]; with faults also bow [m], start and end of a spall; its depth
    [m], start and share of a chip; losses of stiffness at the root end, in the middle and at the tip. Of a gear with a worn
    profile also the first row of its cubics over height in `System.spline`, their number.
    """
    one, two = teeth_of_pair(mesh, flank, number)
    ahead = 1 if sense(mesh, flank) > 0.0 else 0
    side = ahead if mesh.s < 0.0 else 1 - ahead
    first = mesh.toothing_1 + mesh.rows_1 * (2 * one + ahead) if mesh.toothing_1 >= 0 else -1
    second = mesh.toothing_2 + mesh.rows_2 * (2 * two + side) if mesh.toothing_2 >= 0 else -1
    return int(first), int(second)


@compiled_inline
def deviations(
    mesh: Any, system: System, flank: int, number: int, rho_1: float, rho_2: float, place: float
) -> tuple[float, float, float, float, float, float]:
    """Return the material missing on both flanks of a pair [m], its slopes by both places, second derivatives 1 1, 2 2, 1 2.

    Where it varies along an oblique line of contact the least along the line.
    """
    at_1, at_2 = -1, -1
    if mesh.toothing_1 >= 0 or mesh.toothing_2 >= 0:
        at_1, at_2 = flank_rows(mesh, flank, number)
    if mesh.varies == 1:
        line = line_of_contact(mesh, rho_1, rho_2, place, at_1, at_2)
        least, m_1, m_2, m_11, m_22, m_12 = least_missing(mesh, system, line)
        pitch = system.terms[at_1, 0] if at_1 >= 0 else 0.0
        pitch += system.terms[at_2, 0] if at_2 >= 0 else 0.0
        return pitch + least, m_1, m_2, m_11, m_22, m_12
    found, by_1, bend_1 = relief(
        mesh.relief_1, mesh.relief_length_1, mesh.relief_power_1, mesh.tip_length_1, 1.0, rho_1
    )
    other, by_2, bend_2 = relief(
        mesh.relief_2, mesh.relief_length_2, mesh.relief_power_2, mesh.tip_length_2, -mesh.s, rho_2
    )
    found += other
    if at_1 >= 0 or at_2 >= 0:
        of_1, slope_1, curve_1 = tooth_deviation(system, at_1, mesh.rows_1, mesh.low_1, mesh.high_1, rho_1)
        of_2, slope_2, curve_2 = tooth_deviation(system, at_2, mesh.rows_2, mesh.low_2, mesh.high_2, rho_2)
        found += of_1 + of_2
        by_1, by_2, bend_1, bend_2 = by_1 + slope_1, by_2 + slope_2, bend_1 + curve_1, bend_2 + curve_2
    return found, by_1, by_2, bend_1, bend_2, 0.0


@compiled_inline
def largest_overlap(mesh: Any, system: System, out: Floats, flank: int, line: Line, number: int) -> float:
    """Return a bound of the penetration of pair ``number`` of a flank [m] from above: corners lie above the involutes' gap."""
    _, rho_1, rho_2 = places_of_pair(mesh, line, number)
    if part_in_touch(mesh, rho_1, rho_2) == AWAY:
        return out[P_D + flank] - FAR * mesh.base_pitch
    at_1, at_2 = flank_rows(mesh, flank, number)
    if mesh.varies == 1:
        return out[P_D + flank] - (tilted_least(system, at_1) + tilted_least(system, at_2))
    one = least_deviation(system, at_1, mesh.low_1, mesh.high_1, rho_1)
    other = least_deviation(system, at_2, mesh.low_2, mesh.high_2, rho_2)
    first = relief(mesh.relief_1, mesh.relief_length_1, mesh.relief_power_1, mesh.tip_length_1, 1.0, rho_1)
    second = relief(
        mesh.relief_2, mesh.relief_length_2, mesh.relief_power_2, mesh.tip_length_2, -mesh.s, rho_2
    )
    return out[P_D + flank] - (one + other + first[0] + second[0])


@compiled_inline
def stiffness_at(mesh: Any, system: System, place: float) -> tuple[float, float]:
    """Return stiffness [N/m] of a pair at a place on the first gear's path [m] and its slope, beyond the path that of its end."""
    first = mesh.stiffness_start
    stiffness, slope, _ = cubic_at(system, first, first + mesh.stiffness_count - 1, place)
    return stiffness, slope


@compiled_inline
def pair_stiffness(mesh: Any, system: System, flank: int, pair: Pair) -> tuple[float, float, float]:
    """Return the stiffness [N/m] of a pair of teeth of a flank, faults of its teeth included, and its slopes by both places."""
    stiffness, slope = stiffness_at(mesh, system, pair.place)
    by_1, by_2 = (0.0, slope) if mesh.ring_drives == 1 else (slope, 0.0)
    if mesh.rows_1 > 1 or mesh.rows_2 > 1:
        at_1, at_2 = flank_rows(mesh, flank, pair.number)
        kept_1, slope_1 = tooth_kept(system, at_1, mesh.rows_1, mesh.low_1, mesh.high_1, pair.rho_1)
        kept_2, slope_2 = tooth_kept(system, at_2, mesh.rows_2, mesh.low_2, mesh.high_2, pair.rho_2)
        by_1 = by_1 * kept_1 * kept_2 + stiffness * slope_1 * kept_2
        by_2 = by_2 * kept_1 * kept_2 + stiffness * kept_1 * slope_2
        stiffness *= kept_1 * kept_2
    return stiffness, by_1, by_2


@compiled_inline
def corner(
    A: float, base: float, zeta: float, tip: float, z: float, sign_a: float, q: float, side: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return gap [m] of a corner at angle z [rad] of its gear from a flank at angle ``zeta`` of the other, and its derivatives.

    P = (sign_a A + q tip cos z, q tip sin z) about the other gear; by A, by z, then second ones by A A, A z, z z. The last is l
    [m], 0 where P is within the base circle. ``side`` is -1 for the flank of a ring.
    """
    cosine, sine = math.cos(z), math.sin(z)
    x, y = sign_a * A + q * tip * cosine, q * tip * sine
    squared = x * x + y * y
    rest = squared - base * base
    if rest <= 1e-6 * base * base:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    length = math.sqrt(rest)
    tangent = length / base
    gap = side * base * (math.atan2(y, x) - zeta + tangent - math.atan(tangent))
    c, s = (x * base + y * length) / squared, (y * base - x * length) / squared
    along_a, along_z = sign_a * c, q * tip * (s * cosine - c * sine)
    return (
        gap,
        -side * sign_a * s,
        side * q * tip * (s * sine + c * cosine),
        side * along_a * along_a / length,
        side * along_a * along_z / length,
        side * (along_z * along_z / length + along_z),
        length,
    )


@compiled_inline
def pair_overlap(mesh: Any, system: System, out: Floats, flank: int, slot: int) -> Pair:
    """Return the pair of teeth in a slot of a flank, its mesh's gaps in the scratch (`mesh_gaps`)."""
    line = line_of_flank(mesh, out, flank)
    return numbered_pair(mesh, system, out, flank, line, number_in_slot(mesh, line, slot))


@compiled_inline
def numbered_pair(mesh: Any, system: System, out: Floats, flank: int, line: Line, number: int) -> Pair:
    """Return pair ``number`` of a flank, ``line`` its line of action."""
    s, A, alpha = mesh.s, out[DISTANCE], line.alpha
    place, rho_1, rho_2 = places_of_pair(mesh, line, number)
    place -= mesh.shift
    dev, by_1, by_2, dev_1, dev_2, dev_12 = deviations(mesh, system, flank, number, rho_1, rho_2, place)
    p = out[P_D + flank] - dev
    sine = out[SIN_W]
    by_a, p_1, p_2 = s * sine, mesh.base_1, -s * mesh.base_2
    bend_aa, bend_az, bend_zz, length = s * mesh.c0 * mesh.c0 / (A * A * A * sine), 0.0, 0.0, 0.0
    touching = part_in_touch(mesh, rho_1, rho_2)
    inside = min(rho_1 - mesh.start, mesh.end - rho_1)
    if touching == TIP_OF_2:
        zeta, z = rho_1 / mesh.base_1 - alpha, rho_2 / mesh.base_2 - alpha - mesh.tip_involute_2
        gap, d_a, d_z, h_aa, h_az, h_zz, length = corner(A, mesh.base_1, zeta, mesh.tip_2, z, -s, s, 1.0)
        p += line.gap - gap
        by_a, p_1, p_2 = -d_a, mesh.base_1, -d_z
        bend_aa, bend_az, bend_zz = -h_aa, -h_az, -h_zz
    elif touching == TIP_OF_1:
        zeta, z = rho_2 / mesh.base_2 - alpha, rho_1 / mesh.base_1 - alpha - mesh.tip_involute_1
        gap, d_a, d_z, h_aa, h_az, h_zz, length = corner(A, mesh.base_2, zeta, mesh.tip_1, z, 1.0, s, -s)
        p += line.gap - gap
        by_a, p_1, p_2 = -d_a, -d_z, -s * mesh.base_2
        bend_aa, bend_az, bend_zz = -h_aa, -h_az, -h_zz
    if touching != ON_FLANK and length == 0.0:
        touching = AWAY
    penetration, edge = p, 0.0
    if touching == AWAY:
        p = penetration = out[P_D + flank] - FAR * mesh.base_pitch
        by_1 = by_2 = dev_1 = dev_2 = dev_12 = 0.0
    elif inside * STEEP < p:
        penetration = inside * STEEP
        edge = STEEP if rho_1 - mesh.start < mesh.end - rho_1 else -STEEP
    return Pair(
        p, penetration, edge, place, rho_1, rho_2, number, touching,
        by_a, p_1, p_2, bend_aa, bend_az, bend_zz, by_1, by_2, dev_1, dev_2, dev_12, length,
    )  # fmt: skip


@compiled_inline
def turn_rates(mesh: Any, out: Floats, flank: int) -> tuple[float, float, float]:
    """Return the rates of both gears' angles against the line of centres in a flank's sense, and d(alpha_w)/dt [rad/s]."""
    m = sense(mesh, flank)
    swing = mesh.c0 * out[DISTANCE_RATE] / (out[DISTANCE] * out[DISTANCE] * out[SIN_W])
    return m * (out[SPIN_1] - out[PHI_RATE]), m * (out[SPIN_2] - out[PHI_RATE]), swing


@compiled_inline
def overlap_rate(mesh: Any, out: Floats, flank: int, pair: Pair) -> tuple[float, float, float, float]:
    """Return dp/dt of a pair [m/s], that of its deviations alone, and the rates of its places on both paths [m/s]."""
    turn_1, turn_2, swing = turn_rates(mesh, out, flank)
    rate_1, rate_2 = mesh.base_1 * (turn_1 + swing), mesh.base_2 * (turn_2 + swing)
    worn = pair.by_1 * rate_1 + pair.by_2 * rate_2
    rate = out[P_D_RATE + flank] - worn
    if pair.touching == TIP_OF_1 or pair.touching == TIP_OF_2:
        by_a = pair.by_a - mesh.s * out[SIN_W]
        by_turns = (pair.p_1 - mesh.base_1) * turn_1 + (pair.p_2 + mesh.s * mesh.base_2) * turn_2
        rate += by_a * out[DISTANCE_RATE] + by_turns
    return rate, worn, rate_1, rate_2


@compiled_inline
def penetration_rate(pair: Pair, rate: float, rate_1: float) -> float:
    """Return the rate of a pair's penetration [m/s], dp/dt but near a hard end."""
    return rate if pair.edge == 0.0 else pair.edge * rate_1
