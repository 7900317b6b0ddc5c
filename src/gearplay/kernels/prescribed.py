"""Variation of a prescribed speed, by its ripple or by its set-point over time, and its integral.

Ripple: omega(t) = omega_0 (1 + sum a_k sin(k omega_0 t + phase_k)). A set-point has pieces of the rotation, of second degree,
and a sine of the speed. Such a rotor is prescribed at every instant, so it is never integrated: whoever needs its rotation takes
it from here (docs/theory, "Ripple of a drive").
"""

import math

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled
from gearplay.kernels.layout import System, omega_of, theta_of
from gearplay.kernels.set_point import piece_at


@compiled
def variation(system: System, i: int, t: float) -> tuple[float, float, float]:
    """Return what rotor i's drive prescribes at t [s] relative to the nominal rotation: angle [rad], speed [rad/s], rad/s^2.

    Of a ripple with psi = k omega_0 t: angle a/k (cos(phase) - cos(psi + phase)), 0 at t = 0, speed omega_0 a sin(psi + phase).
    """
    r = system.rotors[i]
    theta, omega, alpha = 0.0, 0.0, 0.0
    for row in range(r.ripple_start, r.ripple_start + r.ripple_count):
        order, cosine, sine = system.terms[row, 0], system.terms[row, 1], system.terms[row, 2]
        rate = order * r.nominal_speed
        c, s = math.cos(rate * t), math.sin(rate * t)
        theta += (cosine * (1.0 - c) + sine * s) / order
        omega += r.nominal_speed * (cosine * s + sine * c)
        alpha += r.nominal_speed * rate * (cosine * c - sine * s)
    if r.set_points > 0:
        piece = system.record[piece_at(system, r.set_point, r.set_points, t)]
        u = t - piece[0]
        theta += piece[1] + u * (piece[2] + u * piece[3])
        omega += piece[2] + 2.0 * u * piece[3]
        alpha += 2.0 * piece[3]
    if r.wave >= 0:
        rate, cosine, sine = system.terms[r.wave, 0], system.terms[r.wave, 1], system.terms[r.wave, 2]
        c, s = math.cos(rate * t), math.sin(rate * t)
        theta += (cosine * (1.0 - c) + sine * s) / rate
        omega += cosine * s + sine * c
        alpha += rate * (cosine * c - sine * s)
    return theta, omega, alpha


@compiled
def follow_drive(system: System, i: int, t: float, y: Floats) -> float:
    """Set rotor i's relative rotation and its speed in ``y`` to those its drive prescribes at t [s]; return rad/s^2."""
    theta, omega, alpha = variation(system, i, t)
    y[theta_of(i)] = theta
    y[omega_of(system, i)] = omega
    return alpha
