"""Relief and profile deviations along the oblique line of contact of a helical pair (docs/teeth).

A point of the line is x [m] along the path from the middle of the facewidth, -h <= x <= h, h half of b tan(beta_b): its places on
both paths are rho_1 + x and rho_2 + s x. It lies on the path of the installed centres, A <= place + x <= E. The material missing
there, d(x) = d_1(rho_1 + x) + d_2(rho_2 + s x), is a quadratic between the starts of both reliefs, beyond the tips continued, and
convex: relief and wear are, profile slopes are linear. With P the overlap of the involutes less the pitch deviations,

    penetration   p = P - min d
    force         F = integral of q (P - d) + (C(p) / K_max) q (P - d)' over the part of the line where P > d,

q = (c' b / 2h) (1 - kappa u^2) the stiffness per length. All integrands are polynomials of the fifth degree at most between
located ends: Gauss's rule with three nodes is exact.
"""

import math
from typing import Any, NamedTuple

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import System
from gearplay.parts.mesh.flank import ON_RAMP, flank_damping, flank_force
from gearplay.parts.mesh.pairs.deviations import rising_relief

PIECES = 3
NODE = math.sqrt(0.6)
"""Outer nodes of Gauss's rule with three nodes, of weights 5/9, 8/9, 5/9."""


ROUNDING = 1e-18
"""Of overlaps [m]."""


class Contact(NamedTuple):
    """Line of contact of a pair: what its deviations depend on.

    Places on both paths in the middle of the facewidth and along the installed path [m], ends of the line, starts of both reliefs
    as x [m], first rows of `overlap.flank_rows`.
    """

    rho_1: float
    rho_2: float
    place: float
    low: float
    high: float
    start_1: float
    start_2: float
    at_1: int
    at_2: int


class Missing(NamedTuple):
    """Material missing at a point [m], its slopes by the places on both paths and its curvatures [1/m]."""

    value: float
    by_1: float
    by_2: float
    bend_1: float
    bend_2: float


@compiled_inline
def line_of_contact(mesh: Any, rho_1: float, rho_2: float, place: float, at_1: int, at_2: int) -> Contact:
    """Return the line of contact of a pair by its places [m]; beyond the path the end of the path that is nearest."""
    low, high = max(-mesh.oblique, mesh.path_start - place), min(mesh.oblique, mesh.path_end - place)
    if low > high:
        low = high = low if place < mesh.middle else high
    start_1 = mesh.tip_length_1 - mesh.relief_length_1 - rho_1
    start_2 = mesh.s * (mesh.tip_length_2 - rho_2) + mesh.relief_length_2
    if mesh.relief_1 == 0.0:
        start_1 = math.inf
    if mesh.relief_2 == 0.0:
        start_2 = -math.inf
    return Contact(rho_1, rho_2, place, low, high, start_1, start_2, at_1, at_2)


@compiled_inline
def _profile(
    system: System, at: int, rows: int, low: float, high: float, place: float
) -> tuple[float, float, float]:
    """Return profile slope and bow of a flank [m] at a place of its path, continued beyond it, slope and curvature."""
    if at < 0:
        return 0.0, 0.0, 0.0
    by = 1.0 / (high - low)
    tilt, away = system.terms[at, 1], 2.0 * by * (place - low) - 1.0
    bow = system.terms[at + 1, 0] if rows > 1 else 0.0
    return 0.5 * tilt * away + bow * away * away, by * (tilt + 4.0 * bow * away), 8.0 * bow * by * by


@compiled_inline
def missing_at(mesh: Any, system: System, line: Contact, x: float) -> Missing:
    """Return the material missing at a point inside a piece of a line of contact, pitch deviations aside."""
    value, by_1, bend_1 = _profile(system, line.at_1, mesh.rows_1, mesh.low_1, mesh.high_1, line.rho_1 + x)
    other, by_2, bend_2 = _profile(
        system, line.at_2, mesh.rows_2, mesh.low_2, mesh.high_2, line.rho_2 + mesh.s * x
    )
    value += other
    if x > line.start_1:
        into = (x - line.start_1) / mesh.relief_length_1
        more, slope, bend = rising_relief(mesh.relief_1, mesh.relief_length_1, mesh.relief_power_1, 1.0, into)
        value, by_1, bend_1 = value + more, by_1 + slope, bend_1 + bend
    if x < line.start_2:
        into = (line.start_2 - x) / mesh.relief_length_2
        more, slope, bend = rising_relief(
            mesh.relief_2, mesh.relief_length_2, mesh.relief_power_2, -mesh.s, into
        )
        value, by_2, bend_2 = value + more, by_2 + slope, bend_2 + bend
    return Missing(value, by_1, by_2, bend_1, bend_2)


@compiled_inline
def piece_of(line: Contact, piece: int) -> tuple[float, float]:
    """Return the ends of a piece of a line of contact: before, between and behind the starts of both reliefs."""
    one = min(max(min(line.start_1, line.start_2), line.low), line.high)
    two = min(max(max(line.start_1, line.start_2), line.low), line.high)
    if piece == 0:
        return line.low, one
    return (one, two) if piece == 1 else (two, line.high)


@compiled_inline
def end_motion(mesh: Any, line: Contact, x: float) -> tuple[float, float]:
    """Return the slopes of an end of a piece by rho_1 and rho_2: end of the facewidth, of the path, or start of a relief."""
    if x == line.start_1:
        return -1.0, 0.0
    if x == line.start_2:
        return 0.0, -mesh.s
    if abs(x) == mesh.oblique:
        return 0.0, 0.0
    return (0.0, -1.0) if mesh.ring_drives == 1 else (-1.0, 0.0)


@compiled_inline
def least_missing(
    mesh: Any, system: System, line: Contact
) -> tuple[float, float, float, float, float, float]:
    """Return the least material missing along a line of contact [m], its slopes by rho_1 and rho_2, second ones 1 1, 2 2, 1 2."""
    least, where, slope, found = math.inf, 0.0, 0.0, Missing(0.0, 0.0, 0.0, 0.0, 0.0)
    s = mesh.s
    for piece in range(PIECES):
        start, end = piece_of(line, piece)
        if piece > 0 and start >= end:
            continue
        middle = 0.5 * (start + end)
        each = missing_at(mesh, system, line, middle)
        by, bend = each.by_1 + s * each.by_2, each.bend_1 + each.bend_2
        x = middle
        if bend > 0.0:
            x = min(max(middle - by / bend, start), end)
        elif by != 0.0:
            x = start if by > 0.0 else end
        way = x - middle
        value = each.value + way * (by + 0.5 * bend * way)
        if value < least:
            least, where, slope = value, x, by + bend * way
            by_1, by_2 = each.by_1 + each.bend_1 * way, each.by_2 + s * each.bend_2 * way
            found = Missing(value, by_1, by_2, each.bend_1, each.bend_2)
    bend = found.bend_1 + found.bend_2
    e_1, e_2 = 0.0, 0.0
    if abs(slope) > 1e-12:
        e_1, e_2 = end_motion(mesh, line, where)
    elif bend > 0.0:
        e_1, e_2 = -found.bend_1 / bend, -s * found.bend_2 / bend
    return (
        least,
        found.by_1 * (1.0 + e_1) + s * found.by_2 * e_1,
        found.by_1 * e_2 + found.by_2 * (1.0 + s * e_2),
        found.bend_1 * (1.0 + e_1) ** 2 + found.bend_2 * e_1 * e_1,
        found.bend_1 * e_2 * e_2 + found.bend_2 * (1.0 + s * e_2) ** 2,
        found.bend_1 * (1.0 + e_1) * e_2 + found.bend_2 * s * e_1 * (1.0 + s * e_2),
    )


class Sums(NamedTuple):
    """Integrals over the part of a line of contact in touch, overlap p, its rate v, stiffness per length q.

    Of q, q p, q v; slopes of the last two by P and by both places, of the last by the rates of P and of both places; powers:
    of q p v and q v v, of q p and q v times the rate of what is missing, and of q as it moves, with p p / 2.
    """

    stiffness: float  # N/m
    force: float  # N
    rate: float  # N/s
    force_1: float
    force_2: float
    rate_p: float
    rate_1: float
    rate_2: float
    rate_by_1: float
    rate_by_2: float
    pressing: float
    losing: float
    missed: float
    missed_rate: float
    carried: float


@compiled_inline
def sums_over_line(
    mesh: Any, system: System, line: Contact, deepest: float, rate: float, rate_1: float, rate_2: float
) -> Sums:
    """Return the sums over a line of contact: its penetration P - min d [m], the rates of P and of both places [m/s].

    Below 0, as within a step that goes beyond the end of a touch, the part in touch is that of the first touch.
    """
    s, half = mesh.s, 0.5 * (mesh.path_end - mesh.path_start)
    least, _, _, _, _, _ = least_missing(mesh, system, line)
    within = least + max(deepest, 0.0)
    drives_1, drives_2 = (0.0, 1.0) if mesh.ring_drives == 1 else (1.0, 0.0)
    k, f, m = 0.0, 0.0, 0.0
    f_1, f_2, m_p, m_1, m_2, by_1, by_2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    pressing, losing, missed, missed_rate, carried = 0.0, 0.0, 0.0, 0.0, 0.0
    for piece in range(PIECES):
        start, end = piece_of(line, piece)
        if start >= end:
            continue
        middle = 0.5 * (start + end)
        each = missing_at(mesh, system, line, middle)
        low, high = touching_part(within - each.value, each.by_1 + s * each.by_2, each.bend_1 + each.bend_2,
                                  0.5 * (end - start))  # fmt: skip
        if low >= high:
            continue
        for node in range(PIECES):
            way = 0.5 * (low + high) + 0.5 * (high - low) * (
                NODE if node == 2 else -NODE if node == 0 else 0.0
            )
            weight = 0.5 * (high - low) * (8.0 if node == 1 else 5.0) / 9.0
            d_1, d_2 = each.by_1 + each.bend_1 * way, each.by_2 + s * each.bend_2 * way
            u = (line.place + middle + way - mesh.middle) / half
            q, q_1 = mesh.density * (1.0 - mesh.kappa * u * u), -2.0 * mesh.density * mesh.kappa * u / half
            q, q_1 = weight * q, weight * q_1
            p = (
                within
                - each.value
                - way * (each.by_1 + s * each.by_2 + 0.5 * (each.bend_1 + each.bend_2) * way)
            )
            gone = d_1 * rate_1 + d_2 * rate_2
            v = rate - gone
            k += q
            f += q * p
            m += q * v
            by_1 -= q * d_1
            by_2 -= q * d_2
            f_1 += drives_1 * q_1 * p - q * d_1
            f_2 += drives_2 * q_1 * p - q * d_2
            m_1 += drives_1 * q_1 * v - q * each.bend_1 * rate_1
            m_2 += drives_2 * q_1 * v - q * each.bend_2 * rate_2
            pressing += q * p * v
            losing += q * v * v
            missed += q * p * gone
            missed_rate += q * v * gone
            carried += 0.5 * q_1 * p * p * (drives_1 * rate_1 + drives_2 * rate_2)
        for side in range(2):
            way, sign = (low, -1.0) if side == 0 else (high, 1.0)
            u = (line.place + middle + way - mesh.middle) / half
            q = sign * mesh.density * (1.0 - mesh.kappa * u * u)
            d_1, d_2 = each.by_1 + each.bend_1 * way, each.by_2 + s * each.bend_2 * way
            v = rate - d_1 * rate_1 - d_2 * rate_2
            at = start if side == 0 else end
            if abs(way) < 0.5 * (end - start):  # where the overlap is 0
                steep = d_1 + s * d_2
                if steep != 0.0:
                    m_p += q * v / steep
                    m_1 -= q * v * d_1 / steep
                    m_2 -= q * v * d_2 / steep
                continue
            p = (
                within
                - each.value
                - way * (each.by_1 + s * each.by_2 + 0.5 * (each.bend_1 + each.bend_2) * way)
            )
            e_1, e_2 = end_motion(mesh, line, at)
            f_1 += q * p * e_1
            f_2 += q * p * e_2
            m_1 += q * v * e_1
            m_2 += q * v * e_2
            carried += 0.5 * q * p * p * (e_1 * rate_1 + e_2 * rate_2)
    f += k * min(deepest, 0.0)
    return Sums(k, f, m, f_1, f_2, m_p, m_1, m_2, by_1, by_2, pressing, losing, missed, missed_rate, carried)


@compiled_inline
def oblique_force(mesh: Any, p: float, sums: Sums) -> tuple[float, float]:
    """Return the force [N] of a line of contact of penetration p [m] and its margin; nothing in touch presses without force.

    F = k f(p) with f the force of a flank by the means over the part in touch, k its share of the largest stiffness.
    """
    share = sums.stiffness / mesh.stiffest
    if share <= 0.0:
        return 0.0, mesh.stiffest
    stiffness = sums.force / (share * p) if p > 0.0 else mesh.stiffest
    force, margin = flank_force(mesh, stiffness, p, sums.rate / sums.stiffness, ON_RAMP, 0)
    return share * force, margin


@compiled_inline
def oblique_powers(mesh: Any, p: float, sums: Sums, pressed: bool, pulled: float) -> tuple[float, float]:
    """Return the power lost in a line of contact and that put in by what is missing [W]; errors of teeth put in ``pulled``.

    A line whose force is cut at 0 loses what its springs give back.
    """
    if not pressed:
        return -sums.pressing, sums.carried
    share = flank_damping(mesh, p, ON_RAMP, 0) / mesh.stiffest
    return share * sums.losing, pulled - sums.missed - share * sums.missed_rate + sums.carried


@compiled_inline
def touching_part(overlap: float, by: float, bend: float, half: float) -> tuple[float, float]:
    """Return the part of a piece in touch, from its middle [m]: where overlap - by x - bend x^2 / 2 >= 0, |x| <= half."""
    if bend <= 0.0:
        if by == 0.0:
            return (-half, half) if overlap >= -ROUNDING else (0.0, 0.0)
        zero = min(max(overlap / by, -half), half)
        return (-half, zero) if by > 0.0 else (zero, half)
    squared = by * by + 2.0 * bend * overlap
    if squared <= 0.0:
        return 0.0, 0.0
    # Of the two zeros of a quadratic the one without a difference first.
    far = -(by + math.copysign(math.sqrt(squared), by)) / bend
    near = -2.0 * overlap / (bend * far)
    return max(min(near, far), -half), min(max(near, far), half)
