"""Lyapunov exponents: how fast neighbouring motions part, from the exact tangent of the flow, with their uncertainty."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.nonlinear.least_spans import shortest_period
from gearplay.nonlinear.slow_oscillation import SAMPLES, too_few_oscillations, velocities
from gearplay.pictures.style import CLEARANCE, COUPLED, new_axes
from gearplay.results.base import Column, Tabled
from gearplay.solver.compiling import prepare
from gearplay.solver.flow import Flow
from gearplay.solver.integration import Course
from gearplay.solver.limits import check_work
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.progress import Tick

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]
LONGEST = 2e-3  # s between two orthonormalisations: growth and shrinkage must fit into the digits of a number
BLOCKS = 20  # that are kept
JUDGED = 5  # blocks of these over which the scatter is judged: long enough to be nearly independent
DOUBLINGS = 6  # of a record whose length was not given
LEAD = 0.1  # share of the time in which the changes find their directions


@dataclass(frozen=True, repr=False)
class Exponents(Tabled):
    """Lyapunov exponents [1/s], the largest first, shape [exponent], and the half-widths of their 95 % intervals.

    The intervals are Student's t over 5 stretches of the record, of four of its ``blocks`` each, shape [block, exponent],
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
        return [(f"exponent {n}", f"{value:.4g} ± {half:.2g} 1/s") for n, (value, half) in each]

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
    """Return the ``count`` largest Lyapunov exponents of a motion, all of them if not given.

    The run takes ``transient`` and ``duration`` [s], the case's transient and duration if not given. Changes of all free states
    (in their natural sizes) move on with the exact tangent, contacts and switches included, and are made orthonormal again and
    again (G. Benettin et al., Meccanica 15 (1980) 9). In directions that are prescribed nothing can change: they do not count.
    With ``checked`` a record with too few slow swings of the motion for an interval (`too_few_oscillations`) is doubled, up to
    `DOUBLINGS` times, where no ``duration`` is given, and else refused.

    Raises `InputError` for a count or times that cannot be, `SimulationError` where the motion cannot be followed.
    """
    flow = Flow(case)
    most = len(flow.free)
    number = most if count is None else count
    if not 1 <= number <= most:
        rule = f"must lie between 1 and {most}, the number of free states"
        raise InputError(Fault("count", number, rule, "Choose fewer or more"))
    span = case.run.duration if duration is None else duration
    lead = case.run.transient if transient is None else transient
    if not (math.isfinite(span) and span > 0.0 and math.isfinite(lead) and lead >= 0.0):
        raise InputError(Fault("duration", span, "must be above 0 s, transient 0 s or more", "Correct it"))
    check_work("lyapunov", flow.packed, seconds=(lead + span) * (1 + number))
    prepare(case, derivative=True)
    remembers = any(sleeve.restitution < 1.0 for sleeve in case.sleeves.values())
    whole = number == most and not remembers
    found = _Following(flow, member, lead, span, number, whole=whole, checked=checked, progress=progress)
    fault = found.follow(span)
    for _ in range(DOUBLINGS if duration is None else 0):
        if fault is None:
            break
        check_work("lyapunov", flow.packed, seconds=(lead + 2.0 * found.span) * (1 + number))
        fault = found.follow(2.0 * found.span)
    if fault is not None:
        raise InputError(fault)
    return found.exponents()


class _Following:
    """A motion with tangent vectors that are repeatedly orthonormalised, and their growth in each piece."""

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
        self.course = course = flow.begin(flow.start(member), changes=changes, divergence=whole)
        self.begin = lead + LEAD * span
        period = shortest_period(flow.packed) if checked else None
        self.moving = [] if period is None else list(velocities(flow))
        longest = LONGEST if period is None else min(LONGEST, period / SAMPLES)
        pieces = max(BLOCKS, math.ceil(span / longest))
        self.piece = span / (pieces + -pieces % BLOCKS)
        for at in range(1, 1 + math.ceil(self.begin / LONGEST)):
            course.advance(min(at * LONGEST, self.begin))
            _orthonormalise(flow, course)
        self.before, self.span = course.divergence, 0.0
        self.grown: list[Floats] = []
        self.speeds: list[Floats] = []

    def follow(self, span: float) -> Fault | None:
        """Extend the record to ``span`` [s], a multiple of its length; return the reason if it is still too short."""
        pieces = round(span / self.piece)
        for at in range(len(self.grown), pieces):
            self.course.advance(self.begin + (at + 1) * self.piece)
            self.grown.append(_orthonormalise(self.flow, self.course))
            if self.moving:
                self.speeds.append(self.flow.seen(self.course.time, self.course.state)[self.moving])
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
        divergence = (self.course.divergence - self.before) / span if self.whole else math.nan
        return Exponents(values[order], errors[order], blocks[:, order], divergence, span, self.flow.case)


def half_width(blocks: Floats) -> float:
    """Return the half-width of the 95 % interval of the mean of successive block means, shape [block], a multiple of `JUDGED`.

    Neighbouring blocks make `JUDGED` stretches. Those of a slow motion are not independent: their variance is multiplied by
    1 + 2 (r_1 + r_2), at least 1, with the correlations r of neighbours (each 1 / n too small on average; M. Bartlett, J. R.
    Stat. Soc. Suppl. 8 (1946) 27).

    >>> round(half_width(np.array([1.0, 2.0, 1.0, 2.0, 1.0])), 3)  # t 2.776, error 0.2449, r -0.6 and 0.767
    0.785
    """
    from scipy.special import stdtrit

    stretches = blocks.reshape(JUDGED, -1).mean(axis=1)
    count, rest = JUDGED, stretches - stretches.mean()
    whole = float(rest @ rest)
    if whole == 0.0:
        return 0.0
    pulls = sum(float(rest[lag:] @ rest[:-lag]) / whole + 1.0 / count for lag in (1, 2))
    error = math.sqrt(whole / (count - 1.0) / count * max(1.0, 1.0 + 2.0 * pulls))
    return float(stdtrit(count - 1.0, 0.975)) * error


def _orthonormalise(flow: Flow, course: Course) -> Floats:
    """Make the changes orthonormal in natural sizes; return the logarithms of how far each has grown."""
    changes = course.changes
    # Only what can change: rounding in a prescribed direction would stay while all others shrink.
    places = np.concatenate([flow.free, flow.size + np.flatnonzero(course.closed[flow.impact_contacts])])
    sizes = flow.sizes[places]
    directions, lengths = np.linalg.qr((changes[:, places] / sizes).T)
    changes[:] = 0.0  # the impact speed of an open sleeve is not a state
    changes[:, places] = directions.T * sizes
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(np.abs(np.diagonal(lengths))))
