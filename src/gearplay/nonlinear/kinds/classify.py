"""Kind of motion from its section: at rest, periodic, quasi-periodic, chaotic, transient or undecided.

1. A section that repeats within the resolution is at rest or periodic (``repetition``); one of which only the last or first
   quarter repeats is transient.
2. Three independent tests vote on any other: the loss of closeness of neighbouring states (``recurrence``), the 0-1 test
   (``zero_one``), and the largest Lyapunov exponent where it is known.
3. A motion whose lines or statistics change within the record is transient (``stationarity``).
4. Two votes at least and none against decide between quasi-periodic and chaotic; everything else is undecided.

Limits: a torus whose slowest beat turns less than about twice in the record is a slow drift; a transient that is chaotic to the
end of the record is chaos; on the edge of chaos (an endless cascade of bands) quasi-periodic means no more than regular.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearplay.nonlinear.kinds.recurrence import closeness_loss, forecast_error
from gearplay.nonlinear.kinds.repetition import Misfit, count_bands, find_order, nearest_order, unfolded
from gearplay.nonlinear.kinds.stationarity import block_change, line_change
from gearplay.nonlinear.kinds.thresholds import (
    BLOCK_STEP,
    CHAOTIC,
    CLEAR,
    ERRORS,
    LINE_RATIO,
    LINE_SHARE,
    REGULAR,
    REPEATS,
    SLOW,
    SPREAD,
)
from gearplay.nonlinear.kinds.zero_one import zero_one
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
Evidence = dict[str, float]
Kind = Literal["at rest", "periodic", "quasi-periodic", "chaotic", "transient", "undecided"]

LEAST = 100
"""Fewest periods: the 0-1 test then correlates ten displacements."""


@dataclass(frozen=True)
class Response:
    """Kind of motion of a response and the reason for it.

    ``order`` is the number of periods after which it repeats (1 at rest, otherwise nothing); ``evidence`` holds the numbers
    by the names that `classify` lists.
    """

    kind: Kind
    reason: str
    order: int | None = None
    evidence: Mapping[str, float] = field(default_factory=dict)


def classify(
    samples: ArrayLike,
    *,
    resolution: ArrayLike,
    exponent: tuple[float, float] | None = None,
    swing: ArrayLike | None = None,
) -> Response:
    """Classify the motion of a section.

    Parameters
    ----------
    samples
        The state once per forcing period, after the transient, shape [period, signal] or [period]; angles that grow must be taken
        within one turn.
    resolution
        Smallest difference that means anything (tolerance of the solver, standard deviation of the sensor's noise), in the units
        of the signals, shape [signal] or one number.
    exponent
        Largest Lyapunov exponent per period and its standard error, where known.
    swing
        Peak-to-peak motion of each signal within a period, shape [signal], where known. It separates a motion that repeats every
        period (periodic of order 1) from rest (also order 1).

    Returns
    -------
    Response
        With the evidence as far as it was computed: ``order`` and ``misfit`` (best repetition and deviation from it, in
        resolutions), ``swing`` (in resolutions), ``quarter order``, ``bands``, ``loss``, ``forecast error`` (`closeness_loss`,
        `forecast_error`), ``k`` (`zero_one`), ``line ratio``, ``line share``, ``slow`` (`line_change`, of the motion within
        bands), ``block change`` (`block_change`), ``exponent`` and ``exponent error``.

    Raises
    ------
    InputError
        For fewer than 100 periods, values that are not finite, or a resolution that is not above 0.

    Examples
    --------
    >>> n = np.arange(400)
    >>> found = classify(np.cos(2.0 * np.pi * n / 5.0), resolution=1e-6)
    >>> found.kind, found.order
    ('periodic', 5)
    >>> classify(np.cos(n), resolution=1e-6).kind, classify(0.99**n, resolution=1e-6).kind
    ('quasi-periodic', 'transient')

    """
    scaled, sizes = _scaled(samples, resolution)
    evidence: Evidence = {}
    if exponent is not None:
        evidence |= {"exponent": float(exponent[0]), "exponent error": float(exponent[1])}
    votes = {"exponent": _exponent_vote(exponent, len(scaled))} if exponent is not None else {}
    found = find_order(scaled)
    if found is not None:
        swings = None if swing is None else np.asarray(swing, dtype=np.float64) / sizes
        return _repeated(found, swings, votes, evidence)
    return _unsettled(scaled, evidence) or _unclear(scaled, evidence) or _moving(scaled, votes, evidence)


def _scaled(samples: ArrayLike, resolution: ArrayLike) -> tuple[Floats, Floats]:
    """Return the samples less their mean [resolutions], shape [period, signal], and the resolutions, shape [signal]."""
    table = np.asarray(samples, dtype=np.float64)
    table = table.reshape(len(table), -1)
    sizes = np.broadcast_to(np.asarray(resolution, dtype=np.float64), table.shape[1:])
    if len(table) < LEAST:
        rule = f"must have at least {LEAST} periods"
        raise InputError.of("samples", f"{len(table)} periods", rule, "Take a longer record")
    bad = np.flatnonzero(~np.isfinite(table).all(axis=1))
    if bad.size:
        place = f"period {bad[0]}, {bad.size} in all"
        raise InputError.of(
            "samples", place, "must be finite numbers", "Remove the periods with NaN or infinite values"
        )
    if not (np.all(sizes > 0.0) and np.all(np.isfinite(sizes))):
        rule = "must be finite and above 0 for every signal"
        raise InputError.of("resolution", str(resolution), rule, "Give the tolerance or the noise")
    return (table - table.mean(axis=0)) / sizes, sizes


def _exponent_vote(exponent: tuple[float, float], periods: int) -> Kind:
    """Return the kind that an exponent votes for.

    It is zero within three standard errors and within log(N) / N: N periods of a torus give as much.

    >>> _exponent_vote((0.1, 0.01), 1000), _exponent_vote((0.005, 0.001), 1000), _exponent_vote((-0.1, 0.01), 1000)
    ('chaotic', 'quasi-periodic', 'periodic')
    """
    limit = max(ERRORS * exponent[1], math.log(periods) / periods)
    if abs(exponent[0]) <= limit:
        return "quasi-periodic"
    return "chaotic" if exponent[0] > 0.0 else "periodic"


def _vote(value: float) -> Kind:
    """Return the kind that a number between 0 (regular) and 1 (chaotic) votes for; a NaN votes for nothing."""
    return "quasi-periodic" if value <= REGULAR else "chaotic" if value >= CHAOTIC else "undecided"


def _repeated(found: Misfit, swings: Floats | None, votes: dict[str, Kind], evidence: Evidence) -> Response:
    """Return rest or a cycle for a section that repeats within the resolution."""
    evidence |= {"order": float(found.order), "misfit": found.spread}
    every = "period" if found.order == 1 else f"{found.order} periods"
    reason = f"The section repeats every {every} within the resolution (deviation {found.spread:.2g}, limit {SPREAD:g})"
    if votes.get("exponent") == "chaotic":
        reason += f", but neighbours part{_exponent_words(evidence)}: the resolution may be too coarse."
        return Response("undecided", reason, evidence=evidence)
    if found.order > 1:
        return Response("periodic", f"{reason}.", found.order, evidence)
    if swings is None:
        reason += ": at rest, or a motion that repeats every period."
        return Response("at rest", reason, 1, evidence)
    evidence["swing"] = float(np.max(swings))
    reason += f"; within a period the signals swing by {evidence['swing']:.3g} resolutions."
    return Response("at rest" if evidence["swing"] <= 2.0 * SPREAD else "periodic", reason, 1, evidence)


def _unsettled(scaled: Floats, evidence: Evidence) -> Response | None:
    """Return a transient where the last or the first quarter of the record repeats within the resolution."""
    quarter = len(scaled) // 4
    for part, name in ((scaled[-quarter:], "last"), (scaled[:quarter], "first")):
        found = find_order(part)
        if found is not None:
            evidence["quarter order"] = float(found.order)
            reason = f"The {name} quarter repeats with order {found.order} within the resolution, the record does not."
            return Response("transient", reason, evidence=evidence)
    return None


def _unclear(scaled: Floats, evidence: Evidence) -> Response | None:
    """Return undecided for a cycle that repeats too few times, or a motion near the resolution."""
    found = find_order(scaled, 3)
    if found is not None:
        evidence |= {"order": float(found.order), "misfit": found.spread}
        reason = (
            f"The section repeats every {found.order} periods within the resolution, but the record holds only "
            f"{len(scaled) / found.order:.1f} of the {REPEATS} cycles required. Take a longer record."
        )
        return Response("undecided", reason, evidence=evidence)
    nearest = nearest_order(scaled)
    evidence |= {"order": float(nearest.order), "misfit": nearest.spread}
    if nearest.spread >= CLEAR:
        return None
    reason = (
        f"The section deviates from repetition with order {nearest.order} by {nearest.spread:.2g} resolutions, {CLEAR:g} are "
        "required to tell motion from noise. Give a finer resolution."
    )
    return Response("undecided", reason, evidence=evidence)


def _moving(scaled: Floats, votes: dict[str, Kind], evidence: Evidence) -> Response:
    """Return the kind of a motion that does not repeat: transient, or the majority of three tests."""
    # Signals that are clear of the noise, or the clearest, each of standard deviation 1.
    sizes, apart = np.std(scaled, axis=0), np.std(unfolded(scaled, int(evidence["order"])), axis=0)
    kept = apart >= min(CLEAR, float(apart.max()))
    states = scaled[:, kept] / sizes[kept]
    noise = float(np.sqrt(np.sum(sizes[kept] ** -2.0)))
    bands = count_bands(states)
    within = unfolded(states, bands)
    loss, k, error = closeness_loss(states, noise, bands), zero_one(within), forecast_error(states, bands)
    votes = {"recurrence": _vote(loss), "0-1 test": _vote(k)} | votes
    evidence |= {"bands": float(bands), "loss": loss, "k": k, "forecast error": error}
    closeness = f"loss of closeness {loss:.2f}" if math.isfinite(loss) else "no close neighbours"
    summary = f"{closeness}, K {k:.2f}{_exponent_words(evidence)}"
    if not loss >= CHAOTIC:
        lines = line_change(states)
        part = float(np.mean(np.sum(within**2, axis=1))) / states.shape[1]  # of the variance, within bands
        ratio, share = lines.ratio, lines.share / math.sqrt(part)
        evidence |= {"line ratio": ratio, "line share": share, "slow": lines.slow / part}
        changed = f"The spectral lines change by {share:.2g} of the motion over the record, {ratio:.3g} times what they leave"
        if (ratio >= LINE_RATIO and share >= LINE_SHARE) or (ratio >= 0.5 * LINE_RATIO and share >= SLOW):
            return Response("transient", f"{changed}.", evidence=evidence)
    if not loss <= REGULAR or evidence["slow"] > SLOW:
        evidence["block change"] = block_change(states, bands)
        if evidence["block change"] >= BLOCK_STEP:
            t = evidence["block change"]
            reason = f"The statistics change within the record (t = {t:.3g}, {BLOCK_STEP:g} may be chance)."
            return Response("transient", reason, evidence=evidence)
    if (
        loss <= REGULAR
        and evidence["line ratio"] >= 0.5 * LINE_RATIO
        and evidence["line share"] >= 0.5 * LINE_SHARE
    ):
        reason = f"{changed}: a drift, or a combination of frequencies slower than the record ({summary})."
        return Response("undecided", reason, evidence=evidence)
    if error > CHAOTIC and votes["0-1 test"] == "chaotic" and "exponent" not in votes:
        reason = f"Neighbours forecast no better than a linear law ({error:.2f} of its error): chaos or noise ({summary})."
        return Response("undecided", reason, evidence=evidence)
    for kind in ("quasi-periodic", "chaotic"):
        cast = [vote for vote in votes.values() if vote != "undecided"]
        if len(cast) < 2 or set(cast) != {kind}:
            continue
        if kind == "quasi-periodic" and evidence["slow"] > SLOW:
            reason = f"The motion varies with less than two turns in the record: a slow beat or a drift ({summary})."
            return Response("undecided", reason, evidence=evidence)
        return Response(kind, f"{len(cast)} of {len(votes)} tests: {summary}.", evidence=evidence)
    words = ", ".join(f"{name} {vote}" for name, vote in votes.items())
    return Response("undecided", f"The tests do not agree ({words}): {summary}.", evidence=evidence)


def _exponent_words(evidence: Evidence) -> str:
    """Return the exponent with the half-width of its 95 % interval, two standard errors, as text; empty where it is not known."""
    if "exponent" not in evidence:
        return ""
    half = 2.0 * evidence["exponent error"]
    return f", exponent {evidence['exponent']:.3g} ± {half:.2g} per period (95 %)"
