"""What kind of motion a response is, from its section: at rest, periodic, quasi-periodic, chaotic, or not settled.

Questions are asked in this order, and the first one that finds an answer ends it (``response_decision``):

1. Does the section stand still, or repeat after some periods, within the resolution? (``response_repeats``)
2. Does its first or last quarter repeat though the whole does not? Then it has not settled.
3. Do its statistics drift? Regular motion is judged by its spectral lines (``response_lines``), all motion by blocks of the
   record (``response_drift``).
4. Do states that were close stay close (``response_recurrence``), does the walk of the 0-1 test stay in place (``zero_one``),
   what does a known Lyapunov exponent say? Torus or chaos, or undecided where the voices conflict.

Doubts: a torus whose slowest beat turns less than about twice in the record is a slow drift to anyone who sees no more of it; a
transient that is chaotic to the end of the record is chaos; coloured noise well above the stated resolution may pass for chaos,
white noise is found out; on the edge of chaos (an endless cascade of bands) "quasi-periodic" says no more than regular.
"""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearplay.nonlinear.kinds.response_decision import (
    Evidence,
    Kind,
    Response,
    half_settled,
    moving,
    repeating,
    voice,
)
from gearplay.nonlinear.kinds.zero_one import LEAST
from gearplay.vocabulary.errors import Fault, InputError

__all__ = ["Kind", "Response", "classify"]

Floats = NDArray[np.float64]

LARGEST: Final = 1e16
"""Largest motion taken [resolutions]: floating-point numbers resolve no more."""


def classify(
    samples: ArrayLike,
    *,
    resolution: ArrayLike,
    exponent: tuple[float, float] | None = None,
    swing: ArrayLike | None = None,
) -> Response:
    """Return what kind of motion a section shows.

    Parameters
    ----------
    samples
        The state once per forcing period, after the transient that the caller cut, shape [period, signal] or [period]; angles
        that grow must be taken within one turn.
    resolution
        Size below which differences mean nothing (tolerance of the solver, noise of the sensor as one standard deviation), in the
        units of the signals, shape [signal] or one number.
    exponent
        Largest Lyapunov exponent per period and its standard error, where known.
    swing
        Peak-to-peak motion of each signal within a period, shape [signal], where known. The section of a motion that repeats each
        period stands still just as rest does: with ``swing`` it is periodic of order 1 if any signal swings by more than a few
        resolutions; without, it is called at rest (and has order 1 too).

    Returns
    -------
    Response
        Its evidence, as far as the questions were asked: ``size`` (largest spread of a signal [resolutions]), ``order`` (the
        best), ``misfit``, ``misfit below`` and ``misfit above`` (spread about repetition with that order, one less and one more
        [resolutions]), ``quarter order``, ``bands``, ``memory``, ``closeness``, ``unforeseen`` (see ``response_recurrence``),
        ``step`` and ``trend`` (t between blocks), ``slow`` (share of the variance that turns less than twice in the record),
        ``lines`` (their number), ``line misfit`` (share of the motion that constant lines leave), ``line gain``, ``line drift``
        (see ``response_lines``), ``k``, ``k low``, ``k high`` (0-1 test and quartiles), ``exponent``, ``exponent error``,
        ``swing`` [resolutions].

    Raises
    ------
    InputError
        For fewer than 100 periods, values that are no finite numbers, or a resolution that is not greater than 0.

    Examples
    --------
    >>> n = np.arange(400)
    >>> found = classify(np.cos(2.0 * np.pi * n / 5.0), resolution=1e-6)
    >>> found.kind, found.order
    ('periodic', 5)
    >>> classify(np.cos(n), resolution=1e-6).kind, classify(0.99**n, resolution=1e-6).kind
    ('quasi-periodic', 'transient')

    """
    scaled, swings = _check(samples, resolution, swing)
    known = _check_exponent(exponent)
    evidence: Evidence = {"size": float(np.max(np.std(scaled, axis=0)))}
    if known is not None:
        evidence |= {"exponent": known[0], "exponent error": known[1]}
    said = voice(known, len(scaled))
    found = repeating(scaled, swings, said, evidence) or half_settled(scaled, evidence)
    return found or moving(scaled, said, evidence)


def _check(
    samples: ArrayLike, resolution: ArrayLike, swing: ArrayLike | None
) -> tuple[Floats, Floats | None]:
    """Return the samples less their mean, shape [period, signal], and the swing, both in resolutions."""
    raw = np.asarray(samples)
    if raw.dtype.kind not in "fiub" or raw.ndim not in (1, 2) or (raw.ndim == 2 and raw.shape[1] < 1):
        found = f"{raw.dtype}, shape {raw.shape}"
        raise InputError(
            Fault("samples", found, "must be real numbers of shape [period, signal]", "Give one row a period")
        )
    if len(raw) < LEAST:
        raise InputError(
            Fault(
                "samples",
                f"{len(raw)} periods",
                f"must have at least {LEAST} periods",
                "Take a longer record",
            )
        )
    table = raw.astype(np.float64).reshape(len(raw), -1)
    bad = np.flatnonzero(~np.isfinite(table).all(axis=1))
    if bad.size:
        found = f"period {bad[0]}, {bad.size} in all"
        raise InputError(Fault("samples", found, "must be finite numbers", "Cut or repair these periods"))
    sizes = _per_signal("resolution", resolution, table.shape[1])
    if not np.all(sizes > 0.0):
        rule, cure = (
            "must be greater than 0 for every signal",
            "Give the solver's tolerance or the sensor's noise",
        )
        raise InputError(Fault("resolution", float(sizes.min()), rule, cure))
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = (table - table.mean(axis=0)) / sizes
    if not np.all(np.abs(scaled) < LARGEST):
        rule, cure = (
            f"must be {1.0 / LARGEST:g} of the motion or more",
            "Give what differences can be trusted to",
        )
        raise InputError(Fault("resolution", float(sizes.min()), rule, cure))
    if swing is None:
        return scaled, None
    swings = _per_signal("swing", swing, table.shape[1])
    if not np.all(swings >= 0.0):
        raise InputError(Fault("swing", float(swings.min()), "must be 0 or more", "Give peak-to-peak values"))
    return scaled, swings / sizes


def _per_signal(path: str, given: ArrayLike, signals: int) -> Floats:
    values = np.asarray(given)
    if values.dtype.kind not in "fiu" or values.shape not in ((), (signals,)):
        rule = f"must be one number or {signals}, one a signal"
        raise InputError(Fault(path, f"{values.dtype}, shape {values.shape}", rule, "Give shape [signal]"))
    if not np.all(np.isfinite(values)):
        raise InputError(Fault(path, str(given), "must be finite numbers", "Repair these values"))
    return np.broadcast_to(values.astype(np.float64), (signals,))


def _check_exponent(exponent: tuple[float, float] | None) -> tuple[float, float] | None:
    if exponent is None:
        return None
    values = np.asarray(exponent)
    if (
        values.dtype.kind not in "fiu"
        or values.shape != (2,)
        or not np.all(np.isfinite(values))
        or values[1] < 0
    ):
        rule = "must be the exponent per period and its standard error, two finite numbers"
        raise InputError(Fault("exponent", str(exponent), rule, "Leave it out where it is not known"))
    return float(values[0]), float(values[1])
