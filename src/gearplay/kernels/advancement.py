"""Conservative advancement: a lower bound of the time for which an open contact stays open.

Between free rotors a gap p(t) < 0 has a second derivative that can be bounded by some M over a time H. Then
p + p' tau + M tau^2 / 2 <= 0 keeps the contact open for tau <= H. Stepping to the end of that time again and again converges
to the next onset quadratically and cannot pass over a touch, however short (docs/theory, "Free motion"). Each element
bounds its own gaps (`elements`); here is what they share.
"""

import math

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.free_motion import NEVER, free_rates
from gearplay.kernels.housing_motion import AMPLITUDE, shakes
from gearplay.kernels.layout import Branch, System, omega_of, spin_of, theta_of, vx_of, vy_of, x_of, y_of

# Share of a contact's natural size (1e-15 m of 0.1 mm): a touch is found once it is deeper than rounding, and before it is
# deeper than this; one less deep may be missed.
RESOLUTION = 1e-11
PASSES = 3  # tries to narrow the time over which M is bounded

# What became of a gap: still open, touching now, or geometry that cannot mesh.
STAYS_OPEN, TOUCHES, FAILS = 0, 1, 2


@compiled_inline
def open_span(p: float, rate: float, curvature: float) -> float:
    """Return the largest tau [s] with p + rate s + curvature s^2 / 2 <= 0 for all s <= tau; p <= 0 <= curvature.

    >>> open_span(-1.0, 0.0, 2.0)
    1.0
    """
    root = math.sqrt(max(rate * rate - 2.0 * curvature * p, 0.0))
    if rate > 0.0:
        return -2.0 * p / (rate + root)
    if curvature > 0.0:
        return (root - rate) / curvature
    return NEVER


@compiled_inline
def rotor_bounds(system: System, i: int, t: float, y: Floats, branch: Branch) -> tuple[float, float, float]:
    """Return |acceleration of the centre|, |angular acceleration|, |angular speed| of the free rotor i, at (t, y).

    In free motion accelerations only decay, ripple and housing motion are bounded by their maxima, the oscillation of
    joined rotors by its remaining amplitude (``branch.acceleration_bounds``): the first two also bound the future.
    """
    a_x, a_y, alpha = free_rates(system, i, y[vx_of(system, i)], y[vy_of(system, i)], y[omega_of(system, i)])
    if system.rotors[i].group >= 0:
        places, acceleration_bounds = system.joined.places, branch.acceleration_bounds
        a_x = acceleration_bounds[x_of(i)] if places[2 * x_of(i)] >= 0 else a_x
        a_y = acceleration_bounds[y_of(i)] if places[2 * y_of(i)] >= 0 else a_y
        alpha = acceleration_bounds[theta_of(i)] if places[2 * theta_of(i)] >= 0 else alpha
    spin = abs(spin_of(system, i, y))
    a = math.sqrt(a_x * a_x + a_y * a_y)
    if system.rotors[i].inv_mass > 0.0 and shakes(system, t):
        # damping gives back at most what it has taken
        a += abs(system.base[AMPLITUDE]) * (2.0 if system.rotors[i].radial_damping > 0.0 else 1.0)
    return a, abs(alpha) + system.rotors[i].ripple_curvature, spin
