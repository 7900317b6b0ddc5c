"""Integrals of s^n exp(-z s) for the closed form with linear damping, without cancellation.

phi_0 = exp(-z), phi_(n+1) = (1 / n! - phi_n) / z (docs/theory, "Free motion").
"""

import math

from gearplay.kernels.compiled import compiled_inline

SHORT = 0.1  # z below which the series below is exact to rounding


@compiled_inline
def short_decay(z: float) -> float:
    """Return phi2(z) for 0 <= z < ``SHORT``, by its power series."""
    return 0.5 - z * (
        1 / 6
        - z * (1 / 24 - z * (1 / 120 - z * (1 / 720 - z * (1 / 5040 - z * (1 / 40320 - z * (1 / 362880))))))
    )


@compiled_inline
def decay(z: float) -> tuple[float, float]:
    """Return phi1(z) and phi2(z), z >= 0, without cancellation.

    >>> decay(0.0)
    (1.0, 0.5)
    """
    if z < SHORT:
        phi_2 = short_decay(z)
        return 1.0 - z * phi_2, phi_2
    phi_1 = -math.expm1(-z) / z
    return phi_1, (1.0 - phi_1) / z


@compiled_inline
def slow_decays(z: float) -> tuple[float, float, float, float, float]:
    """Return phi1(z) to phi5(z), z >= 0.

    >>> slow_decays(0.0)[1]
    0.5
    """
    if z < 1.0:
        phi_5 = 1.0
        for n in range(10 if z < 0.01 else 22, 5, -1):
            phi_5 = 1.0 - z / n * phi_5
        phi_5 /= 120.0
        phi_4 = 1.0 / 24.0 - z * phi_5
        phi_3 = 1.0 / 6.0 - z * phi_4
        phi_2 = 0.5 - z * phi_3
        return 1.0 - z * phi_2, phi_2, phi_3, phi_4, phi_5
    phi_1, phi_2 = decay(z)
    phi_3 = (0.5 - phi_2) / z
    phi_4 = (1.0 / 6.0 - phi_3) / z
    return phi_1, phi_2, phi_3, phi_4, (1.0 / 24.0 - phi_4) / z
