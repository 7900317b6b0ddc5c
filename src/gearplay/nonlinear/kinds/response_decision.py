"""How the evidence decides what kind of motion a response is: the thresholds, where they come from, and the words.

Thresholds were set on 2000 responses of ``tests/responses.py`` (seeds 100 to 109, none of them a test's); the comments give the
numbers seen. They were looked at on maps and oscillators that it does not hold: circle, standard and delayed logistic maps,
Duffing, van der Pol and clearance oscillators.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.kinds.response_drift import block_means, drift, features, slow_share
from gearplay.nonlinear.kinds.response_lines import GAIN, Lines, find_lines
from gearplay.nonlinear.kinds.response_recurrence import CLOSE, recurrence
from gearplay.nonlinear.kinds.response_repeats import (
    FEW,
    REPEATS,
    SPREAD,
    count_bands,
    find_order,
    misfit,
    nearest_order,
    unfolded,
)
from gearplay.nonlinear.kinds.zero_one import correlations, displacement, draw_angles

Floats = NDArray[np.float64]
Evidence = dict[str, float]
Kind = Literal["at rest", "periodic", "quasi-periodic", "chaotic", "transient", "undecided"]

STILL: Final = 2.0 * SPREAD
"""Swing within a period [resolutions] that is still rest: the spread that the section may have, to both sides."""

CLEAR: Final = 5.0
"""Spread about the best repetition [resolutions] from which the kind of a motion can be told; below, noise hides its states."""

PLAIN: Final = 30.0
"""Where some signal spreads so far about the best repetition [resolutions], signals that do less are left out: they add noise."""

STEP, TREND = 9.0, 8.0
"""t of a step or a line between blocks that means drift: blocks without memory reach the first once in 2e5 features and the
second once in 7e5 by chance, chaos with its correlations had 6.7 and 6.0 at most in 800 records, jumps mostly 15 and more."""

SMALL_GAIN, SMALL_NEEDS = 1.6, 0.3
"""Lines that gain less than `GAIN`, but this, mean drift where such a share of the motion drifts: a jump is no linear change."""

VISIBLE, MATERIAL = 5.0, 3e-3
"""A drift of lines must be so many resolutions large, and such a share of the motion: high harmonics of a torus may beat more
slowly than the record."""

EXPLAINED: Final = 0.05
"""Constant lines that leave less than this share of the motion explain it: blocks then differ by slow beats, not by drift."""

SLOW: Final = 0.05
"""Share of a torus's variance that may turn less than twice in the record: more is a slow beat or a drift, nobody can tell."""

DRAWN: Final = 1.25
"""Memory above which states draw nearer to each other, so that the motion is still settling: tori have 1.1 at most."""

FORGOTTEN, KEPT = 0.2, 0.6
"""Memory up to which neighbours have forgotten each other, and from which they have not: of 800 chaotic records one had more than
the first (0.26), of 400 tori one less than the second (0.56). Between them K decides."""

SURE: Final = 0.85
"""Memory from which K is not asked: a large K is then that of a torus with many lines in a short record."""

SPARSE: Final = 0.3
"""Nor is it where the next sample is foreseen worse than this and closeness is kept all the same: chaos that loses so much in one
period keeps nothing, a torus that the record covers thinly does."""

WALKS, STAYS = 0.8, 0.3
"""K of the 0-1 test from which the walk diffuses (its lower quartile being above the second), and up to which it stays: of 800
chaotic records 99 in 100 had 0.97 and more, of 400 tori nine in ten 0.12 and less."""

NOISY: Final = 0.2
"""Share of the walk's displacement that noise of the resolution explains, from which K says nothing."""

UNFORESEEN: Final = 0.85
"""Share of variance left by the forecast from which samples alone cannot be told from noise: noise leaves 1.0 +- 0.1, chaos left
0.77 at most (the Lorenz system seen once a unit of time, in short records). Where an exponent is known, of equations, chaos that
is looked at too seldom to be foreseen is chaos."""


@dataclass(frozen=True)
class Response:
    """What kind of motion a response is, and why.

    ``order`` is the number of periods after which it repeats (1 at rest, otherwise nothing); ``reason`` says in words what
    decided; ``evidence`` holds the numbers by the names that `gearplay.nonlinear.kinds.response.classify` lists.
    """

    kind: Kind
    reason: str
    order: int | None = None
    evidence: Mapping[str, float] = field(default_factory=dict)


def voice(exponent: tuple[float, float] | None, periods: int) -> str:
    """Return what kind an exponent speaks for, nothing where none is known.

    It is zero within three standard errors and within log(N) / N: so large is still what N periods of a torus give.

    >>> voice((0.1, 0.01), 1000), voice((0.005, 0.001), 1000), voice((-0.1, 0.01), 1000), voice(None, 1000)
    ('chaotic', 'quasi-periodic', 'periodic', '')
    """
    if exponent is None:
        return ""
    limit = max(3.0 * exponent[1], math.log(periods) / periods)
    if exponent[0] > limit:
        return "chaotic"
    return "quasi-periodic" if exponent[0] >= -limit else "periodic"


def repeating(scaled: Floats, swings: Floats | None, said: str, evidence: Evidence) -> Response | None:
    """Return rest or a cycle, where samples [resolutions], shape [period, signal], repeat within the resolution."""
    found = find_order(scaled)
    if found is None:
        best, *beside = nearest_order(scaled)
    else:
        best = found
        beside = [misfit(scaled, order) for order in (best.order - 1, best.order + 1) if order > 0]
    evidence |= {"order": float(best.order), "misfit": best.spread}
    evidence |= {
        "misfit below" if other.order < best.order else "misfit above": other.spread for other in beside
    }
    if found is None:
        return _seldom(scaled, evidence)
    told = f"spread {best.spread:.2g} and largest deviation {best.peak:.2g} resolutions"
    every = "period" if best.order == 1 else f"{best.order} periods"
    if said == "chaotic":
        reason = f"The section repeats every {every} within the resolution ({told}), but neighbours part"
        reason += f" ({_exponent_of(evidence)}): the resolution may be too coarse."
        return Response("undecided", reason, evidence=evidence)
    if best.order > 1:
        others = ", ".join(f"{other.spread:.3g} with {other.order}" for other in beside)
        reason = f"The section repeats every {every} within the resolution ({told}; spread {others})."
        return Response("periodic", reason, best.order, evidence)
    reason = f"The section stands still within the resolution ({told})"
    if swings is None:
        return Response("at rest", f"{reason}: at rest, or a motion that repeats every period.", 1, evidence)
    evidence["swing"] = float(np.max(swings))
    reason += f", and within a period the signals swing by up to {evidence['swing']:.3g} resolutions."
    return Response("at rest" if evidence["swing"] <= STILL else "periodic", reason, 1, evidence)


def _seldom(scaled: Floats, evidence: Evidence) -> Response | None:
    """Return undecided where a cycle repeats, but too seldom in the record to be sure of it."""
    found = find_order(scaled, len(scaled) // REPEATS + 1, FEW)
    if found is None:
        return None
    evidence |= {"order": float(found.order), "misfit": found.spread}
    reason = (
        f"The section repeats every {found.order} periods within the resolution (spread {found.spread:.2g} resolutions), but the "
        f"record holds only {len(scaled) / found.order:.1f} repeats of the {REPEATS} that it takes: a longer record would tell."
    )
    return Response("undecided", reason, evidence=evidence)


def half_settled(scaled: Floats, evidence: Evidence) -> Response | None:
    """Return a transient where the last or the first quarter of the record repeats within the resolution."""
    quarter = len(scaled) // 4
    for part, name in ((scaled[-quarter:], "last"), (scaled[:quarter], "first")):
        found = find_order(part)
        if found is not None:
            evidence["quarter order"] = float(found.order)
            reason = (
                f"The {name} quarter repeats with order {found.order} within the resolution (spread {found.spread:.2g} "
                f"resolutions), the whole does not (spread {evidence['misfit']:.3g}, order {evidence['order']:.0f})."
            )
            return Response("transient", reason, evidence=evidence)
    return None


def moving(scaled: Floats, said: str, evidence: Evidence) -> Response:
    """Return what a motion is that repeats neither as a whole nor in a part."""
    if evidence["misfit"] < CLEAR:
        reason = (
            f"It repeats neither within the resolution nor is it far from it (spread {evidence['misfit']:.2g} resolutions about "
            f"repetition with order {evidence['order']:.0f}): noise or motion, a finer resolution would tell."
        )
        return Response("undecided", reason, evidence=evidence)
    sizes = np.std(scaled, axis=0)
    apart = np.std(unfolded(scaled, int(evidence["order"])), axis=0)
    kept = apart >= min(PLAIN, float(apart.max()))
    states = scaled[:, kept] / sizes[kept]
    states = states - states.mean(axis=0)
    noise = float(np.sqrt(np.sum(sizes[kept] ** -2.0)))  # of a sample, as a distance
    bands = count_bands(states)
    found = recurrence(states, noise, bands)
    evidence |= {"bands": float(bands), "memory": found.memory}
    evidence |= {"closeness": found.closeness, "unforeseen": found.unforeseen}
    blocks = drift(block_means(features(states, found.distances, noise), bands))
    evidence |= {"step": blocks.step, "trend": blocks.trend, "slow": slow_share(unfolded(states, bands))}
    return drifting(states, noise, evidence) or torus_or_chaos(states, noise, said, evidence)


def drifting(states: Floats, noise: float, evidence: Evidence) -> Response | None:
    """Return a transient where lines or blocks drift; ``states`` have signals of standard deviation 1."""
    jumps = evidence["step"] >= STEP or evidence["trend"] >= TREND
    told = f"blocks of the record differ by t = {evidence['step']:.3g} (a step) and {evidence['trend']:.3g} (a line)"
    if evidence["memory"] > FORGOTTEN:
        lines = find_lines(states)
        within = np.mean(np.sum(unfolded(states, int(evidence["bands"])) ** 2, axis=1))
        size = math.sqrt(states.shape[1] / within)  # of all motion, over that within bands
        evidence |= {"lines": float(len(lines.turns)), "line misfit": lines.unexplained}
        evidence |= {"line gain": lines.gain, "line drift": lines.drift * size}
        if _lines_drift(lines, lines.drift * size, noise / math.sqrt(states.shape[1])):
            reason = (
                f"Its spectral lines change over the record: constant ones leave {lines.constant:.2g} of the motion, "
                f"{lines.gain:.3g} times what lines leave that change linearly; {told}."
            )
            return Response("transient", reason, evidence=evidence)
        jumps = jumps and (lines.unexplained > EXPLAINED or evidence["slow"] > SLOW)
    if jumps:
        reason = f"Its statistics drift or jump: {told}; chance gives less than {STEP:.0f} and {TREND:.0f}."
        return Response("transient", reason, evidence=evidence)
    if evidence["memory"] > DRAWN:
        reason = (
            f"Neighbouring states draw nearer to each other: their closeness is {evidence['memory']:.2f} of what it was, a "
            f"quarter of the record later, where a settled motion has 1 at most; {told}."
        )
        return Response("transient", reason, evidence=evidence)
    return None


def _lines_drift(lines: Lines, share: float, noise: float) -> bool:
    if share < MATERIAL or lines.drift < VISIBLE * noise:
        return False
    return lines.gain >= GAIN or (lines.gain >= SMALL_GAIN and share >= SMALL_NEEDS)


def torus_or_chaos(states: Floats, noise: float, said: str, evidence: Evidence) -> Response:
    """Return torus or chaos by the voices of recurrence, of the 0-1 test and of the exponent, which must not conflict."""
    moved = displacement(unfolded(states, int(evidence["bands"])), draw_angles(0, 100))
    low, k, high = (float(q) for q in np.quantile(correlations(moved), [0.25, 0.5, 0.75]))
    evidence |= {"k": k, "k low": low, "k high": high}
    memory = evidence["memory"]
    sparse = memory > FORGOTTEN and evidence["unforeseen"] > SPARSE
    by_states = "quasi-periodic" if memory >= KEPT or sparse else ""
    if memory <= FORGOTTEN and evidence["closeness"] >= CLOSE:
        by_states = "chaotic"
    by_walk = "quasi-periodic" if k <= STAYS else "chaotic" if k >= WALKS and low > STAYS else ""
    by_noise = noise**2 * moved.shape[1] / float(np.median(moved[:, -1]))
    if by_noise > NOISY or memory >= SURE or sparse:
        by_walk = ""
    told = (
        f"neighbouring states have {memory:.2f} of their closeness left a quarter of the record later, "
        f"K is {k:.2f} ({low:.2f} to {high:.2f})"
    )
    return _verdict({by_states, by_walk, said} - {""}, told + _exponent_of(evidence, ", "), evidence)


def _verdict(voices: set[str], told: str, evidence: Evidence) -> Response:
    kind: Kind = "undecided"
    if voices == {"quasi-periodic"} and evidence["slow"] > SLOW:
        start = f"{evidence['slow']:.2f} of its variance turns less than twice in the record, a slow beat or a drift"
    elif voices == {"quasi-periodic"}:
        kind, start = "quasi-periodic", "It neither repeats nor drifts, and stays regular"
    elif voices == {"chaotic"} and evidence["unforeseen"] > UNFORESEEN and "exponent" not in evidence:
        start = f"It cannot be told from noise, {evidence['unforeseen']:.2f} of its variance being unforeseen"
    elif voices == {"chaotic"}:
        kind, start = "chaotic", "It neither repeats nor drifts, and neighbours part"
    else:
        start = "The evidence conflicts" if voices else "The evidence is weak"
    return Response(kind, f"{start}: {told}.", evidence=evidence)


def _exponent_of(evidence: Evidence, before: str = "") -> str:
    if "exponent" not in evidence:
        return ""
    return f"{before}exponent {evidence['exponent']:.3g} +- {evidence['exponent error']:.2g}"
