"""Force of one flank over penetration and rate, equations (15), (17), and its slopes: three damping laws.

``RAMP_SMOOTH`` raises the damping with the penetration (T7), ``RAMP_AS_PRINTED`` as (17) is printed, ``RAMP_CONSTANT`` has all
of it from the first touch on (T7c).
"""

from typing import Any

from gearplay.kernels.compiled import compiled_inline

RAMP_SMOOTH, RAMP_AS_PRINTED, RAMP_CONSTANT = 0, 1, 2
ON_RAMP, PAST_RAMP, NOT_LOCATED = 0, 1, 2
"""Modes of a flank: below the end of its ramp, past it, or not located: then the penetration alone decides."""


@compiled_inline
def damping_ramp(u: float, past: int) -> float:
    """Return s(u) = u^2 (3 - 2u), the ramp that (17) means: 0 at first touch, 1 from u = p/d = 1 on.

    It is 1 beyond its end before the switch is passed, too: the cubic would fall as u^3, and a stage that overshoots a steep
    ramp by 1e4 depths would be pulled out of all range.

    >>> damping_ramp(0.5, 0), damping_ramp(1e4, 0)
    (0.5, 1.0)
    """
    if past == PAST_RAMP or u >= 1.0:
        return 1.0
    if u <= 0.0:
        return 0.0
    return u * u * (3.0 - 2.0 * u)


@compiled_inline
def flank_damping(mesh: Any, p: float, past: int, back: int) -> float:
    """Return C(p) [N s/m] at penetration p [m], eq. (17): smooth ramp, the ramp as printed, or the constant C_m.

    As printed: C_m (1 - b^2 (3 - 2b)) for 0 <= b = p/d < 1, C_m beyond, nothing on the back flank.
    """
    if mesh.C_m == 0.0 or mesh.ramp == RAMP_CONSTANT:
        return float(mesh.C_m)
    if mesh.ramp == RAMP_SMOOTH:
        return mesh.C_m * damping_ramp(p * mesh.inv_depth, past)
    if back == 1:
        return 0.0
    return mesh.C_m if past == PAST_RAMP else mesh.C_m * (1.0 - damping_ramp(p * mesh.inv_depth, past))


@compiled_inline
def flank_force(
    mesh: Any, stiffness: float, p: float, rate: float, past: int, back: int
) -> tuple[float, float]:
    """Return the force K p + C(p) dp/dt [N] of a flank and its margin, positive while it presses.

    On the smooth ramp the margin is F / p [N/m], beyond its end F / d: it keeps its sign where p vanishes, so that a flank
    which lets go and takes hold again before it opens (the ramp ends with p^2) shows both.
    """
    u = max(p * mesh.inv_depth, 0.0)
    on_ramp = past != PAST_RAMP and mesh.ramp == RAMP_SMOOTH
    if u >= 1.0 or not on_ramp:
        force = stiffness * p + flank_damping(mesh, p, past, back) * rate
        return force, force * mesh.inv_depth if on_ramp else force
    margin = stiffness + mesh.C_m * mesh.inv_depth * u * (3.0 - 2.0 * u) * rate
    return p * margin, margin


@compiled_inline
def flank_slopes(
    mesh: Any, stiffness: float, p: float, rate: float, past: int, back: int
) -> tuple[float, float]:
    """Return the derivatives of a flank's force K p + C(p) dp/dt by p [N/m] and by the rate [N s/m]."""
    damping = flank_damping(mesh, p, past, back)
    steepness = 0.0
    u = p * mesh.inv_depth
    if past != PAST_RAMP and 0.0 < u < 1.0 and mesh.ramp != RAMP_CONSTANT:
        steepness = 6.0 * mesh.C_m * mesh.inv_depth * u * (1.0 - u)
        if mesh.ramp != RAMP_SMOOTH:
            steepness = 0.0 if back == 1 else -steepness
    return stiffness + steepness * rate, damping
