"""Bounds of the motion of the toothing centres of a mesh over a time of free motion."""

from typing import Any

from gearplay.kernels.compiled import compiled_inline


@compiled_inline
def pull_of_centres(
    mesh: Any, pull: float, alpha_a: float, spin_a: float, alpha_b: float, spin_b: float, over: float
) -> float:
    """Return the largest relative acceleration of the toothing centres [m/s^2] over a time [s].

    ``pull`` is that of the shafts; their rotations have accelerations of at most alpha [rad/s^2] and now the speeds spin [rad/s].
    """
    spin_a_most, spin_b_most = spin_a + alpha_a * over, spin_b + alpha_b * over
    return float(
        pull
        + mesh.runout_a * (spin_a_most * spin_a_most + alpha_a)
        + mesh.runout_b * (spin_b_most * spin_b_most + alpha_b)
    )


@compiled_inline
def centre_bounds(
    pull: float, speed: float, approach: float, A: float, over: float
) -> tuple[float, float, float, float]:
    """Return the largest relative speed of the centres [m/s], |A''| [m/s^2], |A'| [m/s] and change of A [m] over a time [s].

    |A'| <= |A'(0)| + |A''| tau with |A''| <= pull + v^2 / A, twice the latter as A changes; ``speed`` and ``approach`` are v and
    |A'| now.
    """
    fastest = speed + pull * over
    distance_curvature = pull + 2.0 * fastest * fastest / A
    way = (approach + 0.5 * distance_curvature * over) * over
    return fastest, distance_curvature, min(fastest, approach + distance_curvature * over), way
