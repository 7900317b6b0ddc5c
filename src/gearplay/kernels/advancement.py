"""How long an open contact is sure to stay open: conservative advancement, so that no touch is missed.

Between rotors in free flight a gap p(t) < 0 has a second derivative that can be bounded by some M over a time H. Then
p + p' tau + M tau^2 / 2 <= 0 keeps the contact open for tau <= H. Stepping to the end of that time again and again converges
to the next onset quadratically and cannot pass over a touch, however short (docs/theory, "Free flight").
"""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.flight import NEVER, flight_rates
from gearplay.kernels.layout import MESH_COUPLED, MESH_PRINTED_COUPLED, System
from gearplay.kernels.mesh import mesh_geometry
from gearplay.kernels.sleeve import sleeve_geometry

Floats = NDArray[np.float64]

# m: a touch is found once it is deeper than rounding, and before it is deeper than this; one less deep may be missed.
RESOLUTION = 1e-15
PASSES = 3  # tries to narrow the time over which M is bounded

# What became of a gap: still open, touching now, or geometry that cannot mesh.
STAYS_OPEN, TOUCHES, FAILS = 0, 1, 2


@compiled_inline
def open_span(p: float, rate: float, bend: float) -> float:
    """Return the largest tau [s] with p + rate s + bend s^2 / 2 <= 0 for all s <= tau; p <= 0 <= bend.

    >>> open_span(-1.0, 0.0, 2.0)
    1.0
    """
    root = math.sqrt(max(rate * rate - 2.0 * bend * p, 0.0))
    if rate > 0.0:
        return -2.0 * p / (rate + root)
    if bend > 0.0:
        return (root - rate) / bend
    return NEVER


@compiled_inline
def rotor_bounds(system: System, i: int, y: Floats) -> tuple[float, float, float]:
    """Return |acceleration of the centre|, |angular acceleration|, |angular speed| of rotor i in flight, now.

    In flight accelerations only decay, and a ripple is bounded by its largest: the first two also bound the future.
    """
    v = 3 * (system.rotors.size + i)
    a_x, a_y, alpha = flight_rates(system, i, y[v], y[v + 1], y[v + 2])
    r = system.rotors[i]
    spin = abs(r.nominal_speed + y[v + 2])
    return math.sqrt(a_x * a_x + a_y * a_y), abs(alpha) + r.ripple_bend, spin


@compiled_inline
def sleeve_span(
    system: System, k: int, t: float, y: Floats, longest: float, out: Floats
) -> tuple[int, float]:
    """Return what sleeve k's gap does at (t, y), and for how long [s] it surely stays open (at most ``longest``).

    Works on q = |e|^2 - c^2 with q'' <= 2 (v^2 + c a): smooth through the centre, and without forces exact.
    """
    sleeve = system.sleeves[k]
    sleeve_geometry(sleeve, system, t, y, out)
    delta, rate = out[0], out[1]
    c = sleeve.clearance
    if delta >= 0.0 and rate > 0.0:
        return TOUCHES, 0.0
    a, _, _ = rotor_bounds(system, sleeve.journal, y)
    arm, b_a, b_alpha, b_spin = 0.0, 0.0, 0.0, 0.0
    if sleeve.bush >= 0:
        b_a, b_alpha, b_spin = rotor_bounds(system, sleeve.bush, y)
        arm = math.sqrt(sleeve.offset_x * sleeve.offset_x + sleeve.offset_y * sleeve.offset_y)
    speed = math.sqrt(rate * rate + out[7] * out[7])
    q, q_rate = min(delta, 0.0) * (delta + 2.0 * c), 2.0 * (delta + c) * rate
    over, best = longest, 0.0
    for _ in range(PASSES):
        spin = b_spin + b_alpha * over
        pull = a + b_a + arm * (spin * spin + b_alpha)
        fastest = speed + pull * over
        bend = 2.0 * (fastest * fastest + c * pull)
        span = open_span(q - 2.0 * RESOLUTION * c, q_rate, bend)
        if span >= over:
            return STAYS_OPEN, over
        best = max(best, span)
        over = max(math.sqrt(over * span), span)
    return STAYS_OPEN, best


@compiled_inline
def mesh_span(system: System, j: int, t: float, y: Floats, longest: float, out: Floats) -> tuple[int, float]:
    """Return what both gaps of mesh j do at (t, y), and for how long [s] they surely stay open (at most ``longest``).

    ``out`` is filled by `mesh_geometry`. The bound M adds roll, swing of the line of centres, error of the teeth and opening
    of the flanks, each at its largest while the centre distance keeps to half its way to the ends of meshing.
    """
    if mesh_geometry(system, j, t, y, out) != 0:
        return FAILS, 0.0
    mesh = system.meshes[j]
    if (out[0] >= 0.0 and out[2] > 0.0) or (out[1] >= 0.0 and out[3] > 0.0):
        return TOUCHES, 0.0
    A, c0 = out[8], mesh.c0
    a_a, alpha_a, spin_a = rotor_bounds(system, mesh.a, y)
    a_b, alpha_b, spin_b = rotor_bounds(system, mesh.b, y)
    driver_is_a = mesh.driver == mesh.a
    psi_bend = mesh.z_driver * (alpha_a if driver_is_a else alpha_b)
    if mesh.frame >= 0:
        _, alpha_f, _ = rotor_bounds(system, mesh.frame, y)
        psi_bend += mesh.z_driver * alpha_f
    ecc_a, ecc_b = system.rotors[mesh.a].eccentricity, system.rotors[mesh.b].eccentricity
    roll = abs(mesh.rho_a) * alpha_a + abs(mesh.rho_b) * alpha_b
    rho = abs(mesh.rho_a + mesh.rho_b)
    speed, approach = math.sqrt(out[25]), abs(out[23])
    room = max(0.5 * min(A - mesh.A_min, mesh.A_max - A), 1e-9)
    over, best = longest, 0.0
    for _ in range(60):
        spin_a_most, spin_b_most = spin_a + alpha_a * over, spin_b + alpha_b * over
        pull = (
            a_a
            + a_b
            + ecc_a * (spin_a_most * spin_a_most + alpha_a)
            + ecc_b * (spin_b_most * spin_b_most + alpha_b)
        )
        fastest = speed + pull * over
        # |A'| <= |A'(0)| + |A''| tau with |A''| <= pull + v^2 / A
        distance_bend = pull + 2.0 * fastest * fastest / A
        fastest_approach = min(fastest, approach + distance_bend * over)
        way = (approach + 0.5 * distance_bend * over) * over
        if way > room:
            over *= max(0.1, 0.5 * room / way)
            continue
        nearest, farthest = max(A - way, c0), A + way
        psi_most = abs(out[13]) + psi_bend * over
        bend = roll + mesh.error_bend * psi_most * psi_most + mesh.error_slope * psi_bend
        if mesh.kind == MESH_COUPLED:
            bend += rho * (pull / nearest + 2.0 * fastest_approach * fastest / (nearest * nearest))
        else:
            bend += pull
        widening = 1.0 if mesh.kind == MESH_COUPLED else 2.0 if mesh.kind == MESH_PRINTED_COUPLED else 0.0
        if widening > 0.0:
            sine = math.sqrt(max(nearest * nearest - c0 * c0, 1e-30)) / nearest
            sine_most = math.sqrt(farthest * farthest - c0 * c0) / farthest
            curving = c0 * c0 / (nearest * nearest * nearest * sine)
            bend += widening * (sine_most * distance_bend + curving * fastest_approach * fastest_approach)
        span = min(
            open_span(min(out[0], 0.0) - RESOLUTION, out[2], bend),
            open_span(min(out[1], 0.0) - RESOLUTION, out[3], bend),
        )
        if span >= over:
            return STAYS_OPEN, over
        narrower = max(math.sqrt(over * span), span)
        done = best > 0.0 and span < 1.5 * best
        best = max(best, span)
        if done or narrower > 0.5 * over:
            break
        over = narrower
    return STAYS_OPEN, best
