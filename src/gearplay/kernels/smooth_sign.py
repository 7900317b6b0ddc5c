"""Dry friction without a jump: a sign that passes through zero with a finite slope."""

from gearplay.kernels.compiled import compiled_inline


@compiled_inline
def smooth_sign(u: float) -> float:
    """Return the regularised sign: 1.5 u - 0.5 u^3 within |u| < 1, +-1 beyond; its slope is continuous.

    >>> smooth_sign(0.0), smooth_sign(2.0), smooth_sign(-1.0)
    (0.0, 1.0, -1.0)
    """
    if u >= 1.0:
        return 1.0
    if u <= -1.0:
        return -1.0
    return u * (1.5 - 0.5 * u * u)


@compiled_inline
def smooth_sign_slope(u: float) -> float:
    """Return the slope of `smooth_sign`.

    >>> smooth_sign_slope(0.0), smooth_sign_slope(1.0)
    (1.5, 0.0)
    """
    return 1.5 * (1.0 - u * u) if abs(u) < 1.0 else 0.0
