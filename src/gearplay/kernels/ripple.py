"""Ripple of a prescribed speed: omega(t) = omega_0 (1 + sum a_k sin(k omega_0 t + phase_k)), and its integral.

A rippling rotor is prescribed at every instant, so it is never integrated: whoever needs its rotation takes it from here
(docs/theory, "Ripple of a drive").
"""

import math

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled
from gearplay.kernels.layout import System, omega_of, theta_of


@compiled
def ripple(system: System, i: int, t: float) -> tuple[float, float, float]:
    """Return the ripple of rotor i's drive at t [s], relative to the nominal rotation: angle [rad], speed [rad/s], rad/s^2.

    With psi = k omega_0 t: angle a/k (cos(phase) - cos(psi + phase)), zero at t = 0, speed omega_0 a sin(psi + phase).
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
    return theta, omega, alpha


@compiled
def follow_ripple(system: System, i: int, t: float, y: Floats) -> float:
    """Set rotor i's relative rotation and its speed in ``y`` to those its drive prescribes at t [s]; return rad/s^2."""
    theta, omega, alpha = ripple(system, i, t)
    y[theta_of(i)] = theta
    y[omega_of(system, i)] = omega
    return alpha
