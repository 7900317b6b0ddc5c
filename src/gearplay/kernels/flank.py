"""One flank of a mesh: its one-sided force over penetration and rate, equations (15), (17), and that force's slopes."""

from typing import Any

from gearplay.kernels.compiled import compiled_inline

RAMP_SMOOTH, RAMP_AS_PRINTED = 0, 1


@compiled_inline
def damping_ramp(u: float, past: int) -> float:
    """Return s(u) = u^2 (3 - 2u), the ramp that (17) means: 0 at first touch, 1 from u = p/d = 1 on.

    >>> damping_ramp(0.5, 0)
    0.5
    """
    if past == 1:
        return 1.0
    if u <= 0.0:
        return 0.0
    return u * u * (3.0 - 2.0 * u)


@compiled_inline
def flank_damping(mesh: Any, p: float, past: int, back: int) -> float:
    """Return C(p) [N s/m] at penetration p [m], eq. (17): smooth ramp, or the ramp as printed.

    As printed: C_m (1 - b^2 (3 - 2b)) for 0 <= b = p/d < 1, C_m beyond, nothing on the back flank.
    """
    if mesh.C_m == 0.0:
        return 0.0
    if mesh.ramp == RAMP_SMOOTH:
        return mesh.C_m * damping_ramp(p * mesh.inv_depth, past)
    if back == 1:
        return 0.0
    return mesh.C_m if past == 1 else mesh.C_m * (1.0 - damping_ramp(p * mesh.inv_depth, past))


@compiled_inline
def flank_force(
    mesh: Any, stiffness: float, p: float, rate: float, past: int, back: int
) -> tuple[float, float]:
    """Return the force K p + C(p) dp/dt [N] of a flank and its margin, positive while it presses.

    On the smooth ramp the margin is F / p [N/m]: it keeps its sign where p vanishes, so that a flank which lets go and
    takes hold again before it opens (the ramp ends with p^2) shows both.
    """
    if past == 1 or mesh.ramp != RAMP_SMOOTH:
        force = stiffness * p + flank_damping(mesh, p, past, back) * rate
        return force, force
    u = max(p * mesh.inv_depth, 0.0)
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
    if past == 0 and u > 0.0:
        steepness = 6.0 * mesh.C_m * mesh.inv_depth * u * (1.0 - u)
        if mesh.ramp != RAMP_SMOOTH:
            steepness = 0.0 if back == 1 else -steepness
    return stiffness + steepness * rate, damping
