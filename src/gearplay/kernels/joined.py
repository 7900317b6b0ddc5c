"""Closed-form free motion of rotors joined by springs: a small linear system.

Along each axis they make a chain, M q'' + C q' + K q = constant (docs/theory, "Free motion"). With z = (q, q') and z' = A z + b,
A R = R D in blocks of one or two, R prepared when packing, the rates z' are R exp(D tau) g with g = R^-1 z'(0), so that

    q(tau) = q(0) + R_q W,  q' = R_q w,  q'' = R_q D w,  w = exp(D tau) g,  W = integral of w.

A block is a drift of the whole, ((0, 1), (0, -d)), a decay -d, or an oscillation ((-d, f), (-f, -d)).
"""

import math
from typing import Any

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.decay import decay
from gearplay.kernels.layout import DECAY, DRIFT, System, vx_of, x_of


@compiled_inline
def amplitudes(vibration: Any, tau: float, g_a: float, g_b: float) -> tuple[float, float, float, float]:
    """Return both entries of W, then of w, of a vibration a time tau [s] after its rates were g.

    Of a drift without damping with g = (1, 3) W is (8, 6) and w (7, 3) after 2 s.
    """
    if vibration.kind == DRIFT:
        phi_1, phi_2 = decay(vibration.decay * tau)
        way = tau * phi_1
        late = 1.0 - vibration.decay * way
        return g_a * tau + g_b * tau * tau * phi_2, g_b * way, g_a + g_b * way, g_b * late
    if vibration.kind == DECAY:
        phi_1, _ = decay(vibration.decay * tau)
        way = tau * phi_1
        return g_a * way, 0.0, g_a * (1.0 - vibration.decay * way), 0.0
    d, f = vibration.decay, vibration.frequency
    sine, cosine = math.sin(0.5 * f * tau), math.cos(0.5 * f * tau)
    less = math.expm1(-d * tau)
    turn = 2.0 * sine * sine  # 1 - cos
    across = (1.0 + less) * 2.0 * sine * cosine
    along_1 = less * (1.0 - turn) - turn  # exp((-d + i f) tau) is 1 + along_1 + i across
    size = d * d + f * f
    c, s = (f * across - d * along_1) / size, -(d * across + f * along_1) / size
    along = 1.0 + along_1
    return c * g_a + s * g_b, c * g_b - s * g_a, along * g_a + across * g_b, along * g_b - across * g_a


@compiled_inline
def slopes_of(vibration: Any, w_a: float, w_b: float) -> tuple[float, float]:
    """Return D w of a vibration."""
    d, f = vibration.decay, vibration.frequency
    if vibration.kind == DRIFT:
        return w_b, -d * w_b
    return f * w_b - d * w_a, -f * w_a - d * w_b


@compiled_inline
def rates(vibration: Any, first: int, modal_rates: Floats) -> tuple[float, float]:
    """Return a vibration's rates g among those of all, its chain's beginning at ``first``; a decay has one."""
    at = first + vibration.column
    return modal_rates[at], 0.0 if vibration.kind == DECAY else modal_rates[at + 1]


@compiled_inline
def shape(system: System, vibration: Any, row: int) -> tuple[float, float]:
    """Return a vibration's shape in one coordinate, ``row`` being where that of the coordinate begins."""
    at, numbers = row + vibration.column, system.joined.numbers
    return numbers[at], 0.0 if vibration.kind == DECAY else numbers[at + 1]


@compiled_once
def acceleration(system: System, c: int, k: int, y: Floats, constant: float) -> float:
    """Return the acceleration of coordinate k of chain c at state y; with ``constant`` 0 of a change y of the state."""
    chain, numbers = system.joined.chains[c], system.joined.numbers
    count, speeds = chain.count + chain.fixed, vx_of(system, 0)
    at = chain.pull + k * (2 * count + 1)
    total = constant * numbers[at + 2 * count]
    for j in range(count):
        q = system.joined.coordinates[chain.first + j]
        total += numbers[at + j] * y[q] + numbers[at + count + j] * y[q + speeds]
    return total


@compiled_inline
def false_pull(system: System, c: int, y: Floats) -> float:
    """Return the acceleration that the springs of chain c give its drift at state y: rounding, as they pull nothing as a whole.

    Rotors that have turned far, unlike, would lose angular momentum by it.
    """
    chain, numbers = system.joined.chains[c], system.joined.numbers
    if system.joined.vibrations[chain.vibration].kind != DRIFT:
        return 0.0
    count, push, whole = chain.count + chain.fixed, 0.0, 0.0
    for k in range(chain.count):
        q = system.joined.coordinates[chain.first + k]
        r = system.rotors[q // 3]
        pulled, at = 0.0, chain.pull + k * (2 * count + 1)
        for j in range(count):
            pulled += numbers[at + j] * y[system.joined.coordinates[chain.first + j]]
        part = numbers[chain.right + 2 * chain.count * k] / (r.inv_inertia if q % 3 == 2 else r.inv_mass)
        push += part * pulled
        whole += part * numbers[chain.right + 2 * chain.count * k]
    return push / whole


@compiled_once
def find_rates(system: System, c: int, y: Floats, constant: float, modal_rates: Floats) -> None:
    """Fill chain c's rates g in ``modal_rates`` from state y, or from a change y of it with ``constant`` 0."""
    chain, numbers = system.joined.chains[c], system.joined.numbers
    n, pushed = chain.count, false_pull(system, c, y)
    for j in range(2 * n):
        modal_rates[chain.modal_rates + j] = 0.0
    for k in range(n):
        v = y[vx_of(system, 0) + system.joined.coordinates[chain.first + k]]
        a = acceleration(system, c, k, y, constant) - pushed * numbers[chain.right + 2 * n * k]
        for j in range(2 * n):
            row = chain.left + 2 * n * j
            modal_rates[chain.modal_rates + j] += numbers[row + k] * v + numbers[row + n + k] * a


@compiled_once
def largest_acceleration(system: System, c: int, k: int, tau: float, modal_rates: Floats) -> float:
    """Return a bound of the acceleration of coordinate k of chain c from tau [s] after its launch on.

    Swings only decay, so it is the sum of what is left of them.
    """
    chain = system.joined.chains[c]
    row, most = chain.right + 2 * chain.count * k, 0.0
    for m in range(chain.vibration, chain.vibration + chain.vibrations):
        vibration = system.joined.vibrations[m]
        g_a, g_b = rates(vibration, chain.modal_rates, modal_rates)
        r_a, r_b = shape(system, vibration, row)
        if vibration.kind == DRIFT:
            size = abs((r_a - vibration.decay * r_b) * g_b)
        else:
            size = math.sqrt((r_a * r_a + r_b * r_b) * (g_a * g_a + g_b * g_b))
            size *= math.sqrt(vibration.decay**2 + vibration.frequency**2)
        most += size if vibration.decay == 0.0 else size * math.exp(-vibration.decay * tau)
    return most


@compiled_once
def bound_joined(
    system: System, i: int, tau: float, modal_rates: Floats, acceleration_bounds: Floats
) -> None:
    """Fill bounds of those accelerations of rotor i that springs bear on, from tau [s] after its launch on."""
    for axis in range(3):
        q = x_of(i) + axis
        c = system.joined.places[2 * q]
        if c >= 0:
            acceleration_bounds[q] = largest_acceleration(
                system, c, system.joined.places[2 * q + 1], tau, modal_rates
            )


@compiled_inline
def move(system: System, c: int, k: int, tau: float, modal_rates: Floats) -> tuple[float, float, float]:
    """Return displacement, velocity and acceleration of coordinate k of chain c tau [s] after its launch."""
    chain = system.joined.chains[c]
    row, way, speed, curvature = chain.right + 2 * chain.count * k, 0.0, 0.0, 0.0
    for m in range(chain.vibration, chain.vibration + chain.vibrations):
        vibration = system.joined.vibrations[m]
        g_a, g_b = rates(vibration, chain.modal_rates, modal_rates)
        r_a, r_b = shape(system, vibration, row)
        W_a, W_b, w_a, w_b = amplitudes(vibration, tau, g_a, g_b)
        d_a, d_b = slopes_of(vibration, w_a, w_b)
        way += r_a * W_a + r_b * W_b
        speed += r_a * w_a + r_b * w_b
        curvature += r_a * d_a + r_b * d_b
    return way, speed, curvature


@compiled_once
def propagate_joined(
    system: System, i: int, tau: float, origin: Floats, modal_rates: Floats, y: Floats
) -> None:
    """Fill those entries of ``y`` of rotor i that springs join to others, tau [s] after ``origin``."""
    for axis in range(3):
        q = x_of(i) + axis
        c = system.joined.places[2 * q]
        if c >= 0:
            way, speed, _ = move(system, c, system.joined.places[2 * q + 1], tau, modal_rates)
            y[q], y[vx_of(system, i) + axis] = origin[q] + way, speed


@compiled_once
def joined_accelerations(system: System, i: int, tau: float, modal_rates: Floats, out: Floats) -> None:
    """Fill those of the three accelerations of rotor i that springs bear on, tau [s] after its launch."""
    for axis in range(3):
        q = x_of(i) + axis
        c = system.joined.places[2 * q]
        if c >= 0:
            _, _, out[axis] = move(system, c, system.joined.places[2 * q + 1], tau, modal_rates)


@compiled_once
def move_change(system: System, c: int, tau: float, z: Floats, modal_rates: Floats) -> None:
    """Propagate a change z of chain c's coordinates over a free motion of tau [s]; ``modal_rates`` is scratch."""
    find_rates(system, c, z, 0.0, modal_rates)
    chain = system.joined.chains[c]
    for k in range(chain.count):
        q = system.joined.coordinates[chain.first + k]
        way, speed, _ = move(system, c, k, tau, modal_rates)
        z[q] += way
        z[q + vx_of(system, 0)] = speed
