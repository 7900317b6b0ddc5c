"""Lyapunov exponents from the exact tangent of the flow, with confidence intervals."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.reading import Source
from gearplay.nonlinear.orbits.period_map import sharp
from gearplay.nonlinear.record_length import (
    SAMPLES,
    check_span,
    shortest_period,
    too_few_oscillations,
    velocities,
)
from gearplay.pictures.style import CLEARANCE, COUPLED, new_axes
from gearplay.results.base import Column, Tabled
from gearplay.results.simulate import case_of
from gearplay.solver.flow import Flow
from gearplay.solver.integration import Course, refuse_fixed_steps
from gearplay.solver.limits import check_work
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.progress import Progress, Tick, ticking

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]
LONGEST = 2e-3  # s between two orthonormalisations, so that growth and decay fit into the digits of a number
BLOCKS = 20  # of the record
PARTS = 5  # parts of the record for the scatter, of four blocks each: long enough to be nearly independent
DOUBLINGS = 6  # of a record whose length was not given
LEAD = 0.1  # share of the record before it, in which the tangent vectors align


@dataclass(frozen=True, repr=False)
class Exponents(Tabled):
    """Lyapunov exponents [1/s], the largest first, shape [exponent], and the half-widths of their 95 % intervals.

    The intervals are Student's t over 5 parts of the record, of four of its ``blocks`` each, shape [block, exponent],
    see `half_width`. ``divergence`` is the mean divergence of the flow [1/s]: the sum of all exponents, where no sleeve
    stores its impact speed (NaN otherwise, and where not all were requested). ``time`` is the length of the record [s].
    """

    result_kind = "exponents"
    VARIABLES = MappingProxyType(
        {
            "values": Column(("exponent",), "1/s", "Lyapunov exponent"),
            "errors": Column(("exponent",), "1/s", "half-width of its 95 % interval"),
            "blocks": Column(("block", "exponent"), "1/s", "exponent over one block of the record"),
        }
    )
    SCALARS = MappingProxyType({"divergence": float, "time": float})

    values: Floats
    errors: Floats
    blocks: Floats
    divergence: float
    time: float
    case: Case

    @property
    def largest(self) -> tuple[float, float]:
        """The largest exponent [1/s] and the half-width of its 95 % interval."""
        return float(self.values[0]), float(self.errors[0])

    @property
    def message(self) -> str:
        """The largest exponent as text."""
        value, half = self.largest
        words = "zero within its interval"
        if value > half:
            words = f"neighbouring motions part e-fold in {1.0 / value:.3g} s"
        elif value < -half:
            words = "neighbouring motions come together"
        return (
            f"largest Lyapunov exponent {value:.4g} ± {half:.2g} 1/s (95 %) over {self.time:.4g} s: {words}"
        )

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return a line for each exponent."""
        each = enumerate(zip(self.values, self.errors, strict=True), 1)
        return [(f"exponent {n}", f"{value:.4g} ± {half:.2g} 1/s (95 %)") for n, (value, half) in each]

    def plot(self, *, ax: "Axes | None" = None) -> "Axes":
        """Draw the exponents with their 95 % intervals."""
        drawn = ax if ax is not None else new_axes()
        number = np.arange(1, len(self.values) + 1)
        drawn.errorbar(number, self.values, self.errors, fmt="o", color=COUPLED, markersize=4, capsize=3)
        drawn.axhline(0.0, color=CLEARANCE, linewidth=0.8)
        drawn.set_xticks(number)
        drawn.set_xlabel("number of the exponent, the largest first [1]", fontsize=8)
        drawn.set_ylabel("Lyapunov exponent [1/s], 95 % interval", fontsize=8)
        return drawn


def lyapunov(
    case: Source,
    *,
    count: int | None = None,
    duration: float | None = None,
    transient: float | None = None,
    member: int = 0,
    progress: Progress | None = None,
) -> Exponents:
    """Return the Lyapunov exponents of a case's motion: mean growth rates of small deviations, from the exact tangent.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; computed at its tolerance, at 1e-9 if that is looser.
    count
        How many, the largest first; all if not given.
    duration, transient
        Record and time before it [s]; the case's if not given. The record must hold 20 mesh periods and 25 slow oscillations of
        the motion, for its scatter; without a given duration it is extended until it does.
    member
        Member of the ensemble, 0 for the unperturbed start.
    progress
        Called with what is running, how much is done, and of how much.

    Returns
    -------
    Exponents
        ``values`` and half-widths ``errors`` of their 95 % intervals [1/s], shape [exponent].

    Raises
    ------
    InputError
        For an invalid count or time, and for a record too short for an interval.
    SimulationError
        Where the motion cannot be followed.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.lyapunov(gp.torsional_pair(0.7), count=1, duration=0.2, transient=0.1)
    >>> bool(found.largest[0] < 0.0), found.ds["values"].attrs["units"]
    (True, '1/s')

    """
    base = sharp(case_of(case))
    span = base.run.duration if duration is None else duration
    check_span(base, "duration", span, span)
    return lyapunov_exponents(
        base,
        count=count,
        duration=duration,
        transient=transient,
        member=member,
        checked=True,
        progress=ticking(progress, "exponents"),
    )


def lyapunov_exponents(
    case: Case,
    *,
    count: int | None = None,
    duration: float | None = None,
    transient: float | None = None,
    member: int = 0,
    checked: bool = False,
    progress: Tick | None = None,
) -> Exponents:
    """Return the Lyapunov exponents of a case at its own tolerance; parameters are those of `lyapunov`.

    Tangent vectors of all free states (in their natural sizes) are integrated with the exact tangent flow, contacts and switches
    included, and orthonormalised repeatedly (G. Benettin et al., Meccanica 15 (1980) 9). Prescribed directions do not count.
    With ``checked`` a record with too few slow oscillations for an interval (`too_few_oscillations`) is doubled, up to
    `DOUBLINGS` times, where no ``duration`` is given, and refused otherwise.
    """
    flow = Flow(case)
    most = len(flow.free)
    number = most if count is None else count
    if not 1 <= number <= most:
        rule = f"must lie between 1 and {most}, the number of free states"
        raise InputError.of("count", number, rule, "Choose a number in that range")
    span = case.run.duration if duration is None else duration
    lead = case.run.transient if transient is None else transient
    check_work("lyapunov", flow.packed, seconds=(lead + span) * (1 + number))
    refuse_fixed_steps(case)
    remembers = any(sleeve.restitution < 1.0 for sleeve in case.sleeves.values())
    whole = number == most and not remembers
    found = _Record(flow, member, lead, span, number, whole=whole, checked=checked, progress=progress)
    fault = found.extend(span)
    for _ in range(DOUBLINGS if duration is None else 0):
        if fault is None:
            break
        check_work("lyapunov", flow.packed, seconds=(lead + 2.0 * found.span) * (1 + number))
        fault = found.extend(2.0 * found.span)
    if fault is not None:
        raise InputError(fault)
    return found.exponents()


class _Record:
    """Integration with tangent vectors that are orthonormalised repeatedly: their growth in each piece of the record."""

    def __init__(
        self,
        flow: Flow,
        member: int,
        lead: float,
        span: float,
        number: int,
        *,
        whole: bool,
        checked: bool,
        progress: Tick | None,
    ) -> None:
        self.flow, self.whole, self.progress = flow, whole, progress
        changes = np.zeros((number, flow.size + flow.impact_count))
        random = np.linalg.qr(np.random.default_rng(0).normal(size=(len(flow.free), number)))[0]
        changes[:, flow.free] = random.T * flow.natural[flow.free]
        self.integration = integration = flow.begin(flow.start(member), changes=changes, divergence=whole)
        self.begin = lead + LEAD * span
        period = shortest_period(flow.packed) if checked else None
        self.moving = [] if period is None else list(velocities(flow))
        longest = LONGEST if period is None else min(LONGEST, period / SAMPLES)
        pieces = max(BLOCKS, math.ceil(span / longest))
        self.piece = span / (pieces + -pieces % BLOCKS)
        for at in range(1, 1 + math.ceil(self.begin / LONGEST)):
            integration.advance(min(at * LONGEST, self.begin))
            _orthonormalise(flow, integration)
        self.before, self.span = integration.divergence, 0.0
        self.grown: list[Floats] = []
        self.speeds: list[Floats] = []

    def extend(self, span: float) -> Fault | None:
        """Extend the record to ``span`` [s], a multiple of its length; return the fault if it is still too short."""
        pieces = round(span / self.piece)
        for at in range(len(self.grown), pieces):
            self.integration.advance(self.begin + (at + 1) * self.piece)
            self.grown.append(_orthonormalise(self.flow, self.integration))
            if self.moving:
                self.speeds.append(self.flow.seen(self.integration.time, self.integration.state)[self.moving])
            if self.progress is not None:
                self.progress(self.begin + (at + 1) * self.piece, self.begin + span)
        self.span = span
        return too_few_oscillations(self.flow, np.array(self.speeds), span) if self.moving else None

    def exponents(self) -> Exponents:
        """Return the exponents of the record so far."""
        grown, span = np.array(self.grown), self.span
        blocks = grown.reshape(BLOCKS, -1, grown.shape[1]).sum(axis=1) * BLOCKS / span
        values = blocks.mean(axis=0)
        errors = np.array([half_width(column) for column in blocks.T])
        order = np.argsort(-values, kind="stable")
        divergence = (self.integration.divergence - self.before) / span if self.whole else math.nan
        return Exponents(values[order], errors[order], blocks[:, order], divergence, span, self.flow.case)


def half_width(blocks: Floats) -> float:
    """Return the half-width of the 95 % interval of the mean of successive block means, shape [block], a multiple of `PARTS`.

    Neighbouring blocks are joined to `PARTS` parts. Those of a slow motion are not independent: their variance is multiplied by
    1 + 2 (r_1 + r_2), at least 1, with the correlations r of neighbours (each 1 / n too small on average; M. Bartlett, J. R.
    Stat. Soc. Suppl. 8 (1946) 27).

    >>> round(half_width(np.array([1.0, 2.0, 1.0, 2.0, 1.0])), 3)  # t 2.776, error 0.2449, r -0.6 and 0.767
    0.785
    """
    from scipy.special import stdtrit

    parts = blocks.reshape(PARTS, -1).mean(axis=1)
    count, rest = PARTS, parts - parts.mean()
    whole = float(rest @ rest)
    if whole == 0.0:
        return 0.0
    pulls = sum(float(rest[lag:] @ rest[:-lag]) / whole + 1.0 / count for lag in (1, 2))
    error = math.sqrt(whole / (count - 1.0) / count * max(1.0, 1.0 + 2.0 * pulls))
    return float(stdtrit(count - 1.0, 0.975)) * error


def _orthonormalise(flow: Flow, integration: Course) -> Floats:
    """Orthonormalise the tangent vectors in natural sizes; return the logarithms of their growth factors."""
    changes = integration.changes
    # Only what can change: rounding in a prescribed direction would stay while all others shrink.
    places = np.concatenate([flow.free, flow.size + np.flatnonzero(integration.closed[flow.impact_contacts])])
    sizes = flow.sizes[places]
    directions, lengths = np.linalg.qr((changes[:, places] / sizes).T)
    changes[:] = 0.0  # the impact speed of an open sleeve is not a state
    changes[:, places] = directions.T * sizes
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.abs(np.diagonal(lengths))))
