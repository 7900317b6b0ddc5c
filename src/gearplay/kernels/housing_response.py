"""Closed-form response of a free body to the acceleration a(t) of a moving housing.

v' = -a(t) - gamma v from rest, over a sine or pieces of a cubic record (docs/theory, T20a). With z = gamma h, phi_0 = exp(-z),

    k! h^(k+1) phi_(k+1)(z) = integral of exp(-gamma (h - s)) s^k from 0 to h,  phi_(n+1) = (1 / n! - phi_n) / z.
"""

import math

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.decay import decay, slow_decays
from gearplay.kernels.housing_motion import (
    AMPLITUDE,
    COUNT,
    END,
    KIND,
    PHASE,
    RATE,
    RECORD,
    START,
    STEP,
)
from gearplay.kernels.layout import System

FURTHEST = 1.0  # m, of a sine's way: its rounding is then far below what a touch is seen by
MOST_PIECES = 16  # of a record in one closed form: each evaluation passes through all of them


@compiled_once
def behind_sine(system: System, gamma: float, t: float, h: float) -> tuple[float, float]:
    """Return displacement [m] and velocity [m/s] of a free body relative to the moving housing at t + h [s]."""
    base = system.base
    rate, angle = base[RATE], base[RATE] * (t - base[START]) + base[PHASE]
    less = base[AMPLITUDE] / (gamma * gamma + rate * rate)
    sine, cosine = math.sin(angle), math.cos(angle)
    sine_1, cosine_1 = math.sin(angle + rate * h), math.cos(angle + rate * h)
    first = gamma * sine - rate * cosine
    phi_1, _ = decay(gamma * h)
    way = gamma / rate * (cosine_1 - cosine) + (sine_1 - sine) + first * h * phi_1
    return less * way, -less * (gamma * sine_1 - rate * cosine_1 - first * (1.0 - gamma * h * phi_1))


@compiled_once
def behind_record(system: System, gamma: float, t: float, h: float) -> tuple[float, float]:
    """Evaluate `behind_sine` for a record, piece by piece."""
    base, step, count = system.base, system.base[STEP], int(system.base[COUNT])
    at, end = (t - base[START]) / step, (t + h - base[START]) / step
    way, speed = 0.0, 0.0
    piece = min(int(at), count - 1)
    while True:
        u, c = at - piece, system.record[piece]
        last = end <= piece + 1 or piece == count - 1
        share = (end if last else piece + 1.0) - at
        # a = a_0 + a_1 s + ... over s from 0 to share, in steps
        a_0, a_1 = c[0] + u * (c[1] + u * (c[2] + u * c[3])), c[1] + u * (2.0 * c[2] + u * 3.0 * c[3])
        a_2, a_3 = 2.0 * (c[2] + u * 3.0 * c[3]), 6.0 * c[3]
        z, span = gamma * step * share, step * share
        phi_1, phi_2, phi_3, phi_4, phi_5 = slow_decays(z)
        way += span * (
            speed * phi_1
            - span * (a_0 * phi_2 + share * (a_1 * phi_3 + share * (a_2 * phi_4 + share * a_3 * phi_5)))
        )
        speed -= span * (
            gamma * speed * phi_1
            + a_0 * phi_1
            + share * (a_1 * phi_2 + share * (a_2 * phi_3 + share * a_3 * phi_4))
        )
        if last:
            return way, speed
        piece += 1
        at = float(piece)


@compiled_inline
def behind(system: System, gamma: float, t: float, h: float) -> tuple[float, float]:
    """Return way [m] and speed [m/s] along the housing's direction that its motion gives a free body by t + h [s].

    At t the body is at rest and in place; gamma [1/s] is its damping over its mass.
    """
    base = system.base
    begin = min(max(base[START], t), t + h)
    end = max(min(base[END], t + h), begin)
    if end <= begin:
        return 0.0, 0.0
    if base[KIND] == RECORD:
        way, speed = behind_record(system, gamma, begin, end - begin)
    else:
        way, speed = behind_sine(system, gamma, begin, end - begin)
    phi_1, _ = decay(gamma * (t + h - end))
    coast = (t + h - end) * phi_1
    return way + speed * coast, speed * (1.0 - gamma * coast)


@compiled_inline
def is_closed(system: System) -> bool:
    """Return whether a free motion may use the closed form: not a sine so slow that rounding of its way would show."""
    base = system.base
    return bool(base[KIND] == RECORD or abs(base[AMPLITUDE]) <= FURTHEST * base[RATE] * base[RATE])


@compiled_inline
def new_start(system: System) -> float:
    """Return how long [s] a closed form may be before it is restarted."""
    return float(MOST_PIECES * system.base[STEP]) if system.base[KIND] == RECORD else math.inf
