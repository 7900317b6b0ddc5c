"""Variance decomposition of a measure: scatter of members, first-order and total Sobol indices.

The first-order index is the share of the variance that would go if the parameter were known, the total index the share that
would stay if all others were (Sobol', Math. Comput. Simul. 55 (2001) 271). A ``saltelli`` design has estimators of its own
(Saltelli et al., Comput. Phys. Commun. 181 (2010) 259; Jansen's for the total index), in SALib. Of other designs a polynomial
is fitted and its variance split (Sudret, Reliab. Eng. Syst. Saf. 93 (2008) 964): only as good as the polynomial, so its
leave-one-out error is given with it. Of a full grid the variance is split exactly.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.surrogates.polynomials import Emulator, terms
from gearplay.surrogates.polynomials import design as polynomials
from gearplay.sweeps.cases.draws import sample_size, unit_points
from gearplay.sweeps.plans.design import Design
from gearplay.vocabulary.optional import load_optional

Floats = NDArray[np.float64]
FEWEST_BLOCKS = 8  # of a saltelli design, without a failed case
POINTS_PER_TERM = 4  # finished points that a polynomial of degree 1 needs at least, for each of its terms
MOST_FITTED = 4096  # points that a polynomial is fitted to
DRAWS = 400  # of coefficients, for the scatter of a polynomial's indices
CONSTANT = "the measure does not vary"
MOST_RANKED = 6
"""Most parameters whose shares are listed."""


def as_table(values: Floats) -> Floats:
    """Return values as a table, shape [sample, member]; values that are not finite count as failed and become NaN.

    >>> as_table(np.array([1.0, np.inf])).tolist()
    [[1.0], [nan]]
    """
    table = np.array(values, dtype=np.float64)
    if table.ndim not in (1, 2):
        raise ValueError(f"values must have shape [sample] or [sample, member], not {table.shape}")
    table = table.reshape(len(table), -1)
    table[~np.isfinite(table)] = np.nan
    return table


def member_means(table: Floats) -> Floats:
    """Return the mean of each point's finished members, shape [sample]; NaN where none finished."""
    known = np.isfinite(table)
    count = known.sum(axis=1)
    total = np.where(known, table, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def member_variance(table: Floats) -> float:
    """Return the variance of single cases about their point's mean; NaN where no point has two finished members."""
    known = np.isfinite(table)
    kept = known.sum(axis=1) > 1
    samples = int(kept.sum())
    if samples == 0:
        return math.nan
    part = table[kept]
    rest = part - member_means(part)[:, None]
    spare = float((known[kept].sum(axis=1) - 1).sum())
    return float(np.nansum(rest**2)) / spare


def noise_share(own: float, whole: float) -> float:
    """Return the ratio of the variance among members to the total variance, at most 1; NaN where one is unknown or 0.

    >>> noise_share(1.0, 4.0), noise_share(float("nan"), 4.0)
    (0.25, nan)
    """
    return min(own / whole, 1.0) if whole > 0.0 else math.nan


@dataclass(frozen=True)
class Indices:
    """Sobol indices of each parameter, with half-widths of their confidence intervals; empty, with a ``reason``, for none.

    ``source`` is "sobol", "polynomial" or "grid". ``used`` counts the points they are made from, ``left_out`` those left out
    because a case failed. ``noise`` is the share of the variance of the members' mean that no parameter explains, judged by the
    members (NaN with one member); each total index of a saltelli design or a grid contains it. ``unexplained`` is the
    leave-one-out variance of the polynomial over that of the measure, NaN for others.
    """

    source: str
    names: tuple[str, ...]
    confidence: float
    used: int
    left_out: int
    first: tuple[float, ...] = ()
    first_error: tuple[float, ...] = ()
    total: tuple[float, ...] = ()
    total_error: tuple[float, ...] = ()
    noise: float = math.nan
    degree: int = 0
    unexplained: float = math.nan
    reason: str = ""

    @property
    def ranking(self) -> list[int]:
        """Places of the parameters, the one with the largest total index first."""
        return sorted(range(len(self.total)), key=lambda at: -self.total[at])


def independent_rows(design: Design) -> NDArray[np.int64]:
    """Return the places of the points that are draws of their own: of a saltelli block the first and the last, else all.

    The points between repeat values of those two, so they add nothing to the distribution.
    """
    block = len(design.parameters) + 2
    rows = np.arange(sample_size(design))
    return rows[(rows % block == 0) | (rows % block == block - 1)] if design.kind == "saltelli" else rows


def indices_of(design: Design, values: Floats, *, confidence: float = 0.95, seed: int = 0) -> Indices:
    """Return the Sobol indices in the way that the design allows: `sobol_indices` or `emulated_indices`."""
    make = sobol_indices if design.kind == "saltelli" else emulated_indices
    return make(design, values, confidence=confidence, seed=seed)


def sobol_indices(design: Design, values: Floats, *, confidence: float = 0.95, seed: int = 0) -> Indices:
    """Return Sobol indices from the points of a saltelli design, values of shape [sample] or [sample, member].

    Members are averaged first. A block of points in which one failed is left out whole. The intervals are SALib's bootstrap
    over blocks, the same for the same ``seed``.

    Raises `InputError` where SALib is not installed.
    """
    table, block = _checked(design, values), len(design.parameters) + 2
    names = tuple(p.name for p in design.parameters)
    blocks = member_means(table).reshape(-1, block)
    whole = np.isfinite(blocks).all(axis=1)
    kept, left_out = blocks[whole], int((~whole).sum()) * block
    if len(kept) < FEWEST_BLOCKS:
        reason = f"only {len(kept)} complete blocks of points: {FEWEST_BLOCKS} or more are needed"
        return Indices("sobol", names, confidence, kept.size, left_out, reason=reason)
    if not _varies(kept[:, [0, -1]]):
        return Indices("sobol", names, confidence, kept.size, left_out, reason=CONSTANT)
    analyzer = load_optional("SALib.analyze.sobol", "sweeps")
    found = analyzer.analyze(
        {"num_vars": len(names), "names": list(names), "bounds": [[0.0, 1.0]] * len(names)},
        kept.ravel(),
        calc_second_order=False,
        num_resamples=max(20, min(400, 5_000_000 // len(kept))),
        conf_level=confidence,
        seed=seed + 1,  # to SALib 0 means: differently each time
    )
    whole_table = table.reshape(-1, block, table.shape[1])[whole][:, [0, -1]].reshape(-1, table.shape[1])
    return Indices(
        "sobol",
        names,
        confidence,
        kept.size,
        left_out,
        first=_floats(found["S1"]),
        first_error=_floats(found["S1_conf"]),
        total=_floats(found["ST"]),
        total_error=_floats(found["ST_conf"]),
        noise=_noise(whole_table),
    )


def grid_indices(names: tuple[str, ...], table: Floats) -> Indices:
    """Return the Sobol indices of the axes of a full grid, all values equally likely; shape [axis, ..., member].

    Members are averaged first. The first-order index is the variance of the means over all other axes, the total index the
    mean of the variances along the axis itself, both over the variance of the whole; exact, so without an interval.

    >>> found = grid_indices(("a", "b"), np.array([[[0.0], [1.0]], [[2.0], [3.0]]]))
    >>> found.first, found.total
    ((0.8, 0.2), (0.8, 0.2))
    """
    cells = table.reshape(-1, table.shape[-1])
    means = member_means(cells).reshape(table.shape[:-1])
    missing = int(np.count_nonzero(~np.isfinite(means)))
    if missing or not names:
        reason = f"{missing} of {means.size} combinations have no number" if names else "nothing varies"
        return Indices("grid", names, math.nan, means.size - missing, missing, reason=reason)
    if not _varies(means):
        return Indices("grid", names, math.nan, means.size, 0, reason=CONSTANT)
    whole, axes = float(np.var(means)), range(means.ndim)
    first = [float(np.var(means.mean(axis=tuple(k for k in axes if k != own)))) / whole for own in axes]
    total = [float(np.mean(np.var(means, axis=own))) / whole for own in axes]
    none = (0.0,) * len(names)
    return Indices(
        "grid", names, math.nan, means.size, 0, tuple(first), none, tuple(total), none, noise=_noise(cells)
    )


def emulated_indices(design: Design, values: Floats, *, confidence: float = 0.95, seed: int = 0) -> Indices:
    """Return Sobol indices of a polynomial fitted to any design of independent parameters.

    The variance of a Legendre product of degrees d over the cube is ``prod 1 / (2 d + 1)``; what the error of a coefficient
    adds to its square is taken off. The whole is the polynomial's variance and its leave-one-out error's. Intervals: the
    scatter of the coefficients that this error means.
    """
    from scipy.special import ndtri

    table, names = _checked(design, values), tuple(p.name for p in design.parameters)
    if design.correlations:
        reason = "the drawn parameters are correlated: their shares of the variance cannot be told apart"
        return Indices("polynomial", names, confidence, 0, 0, reason=reason)
    unit, means = unit_points(design)[:MOST_FITTED], member_means(table[:MOST_FITTED])
    known = np.isfinite(means)
    unit, means, left_out = unit[known], means[known], int((~known).sum())
    fewest = POINTS_PER_TERM * (len(names) + 1)
    if len(means) < fewest:
        reason = f"only {len(means)} finished points: {fewest} or more are needed"
        return Indices("polynomial", names, confidence, len(means), left_out, reason=reason)
    if not _varies(means):
        return Indices("polynomial", names, confidence, len(means), left_out, reason=CONSTANT)
    centre, scale = float(np.mean(means)), float(np.std(means, ddof=1))
    fitted = Emulator.fit(unit, ((means - centre) / scale)[:, None])
    rest = float(fitted.scatter[0]) ** 2
    errors = math.sqrt(rest) * np.linalg.inv(np.linalg.qr(polynomials(unit, fitted.degree))[1])
    coefficients = fitted.coefficients[:, 0]
    generator = np.random.default_rng(seed)
    drawn = coefficients + (errors @ generator.normal(size=(len(errors), DRAWS))).T
    first, total, whole = _parts(len(names), fitted.degree)
    own = coefficients**2 - np.sum(errors**2, axis=1)
    scatter = drawn**2 / (drawn**2 @ whole + rest)[:, None]
    variance = float(own @ whole) + rest
    half = float(ndtri(0.5 + 0.5 * confidence))
    return Indices(
        "polynomial",
        names,
        confidence,
        len(means),
        left_out,
        first=_floats(first @ own / variance),
        first_error=_floats(half * np.std(scatter @ first.T, axis=0, ddof=1)),
        total=_floats(total @ own / variance),
        total_error=_floats(half * np.std(scatter @ total.T, axis=0, ddof=1)),
        noise=_noise(table),
        degree=fitted.degree,
        unexplained=rest / variance,
    )


def _floats(values: Floats) -> tuple[float, ...]:
    return tuple(float(x) for x in values)


def _parts(parameters: int, degree: int) -> tuple[Floats, Floats, Floats]:
    """Return the weights of squared coefficients in first-order and total variances, shape [parameter, term], and their sum."""
    exponents = terms(parameters, degree)
    variance = np.prod(1.0 / (2.0 * exponents + 1.0), axis=1)
    takes_part = (exponents > 0).T
    alone = takes_part & (takes_part.sum(axis=0) == 1)
    return alone * variance, takes_part * variance, takes_part.any(axis=0) * variance


def _checked(design: Design, values: Floats) -> Floats:
    table = as_table(values)
    if len(table) != sample_size(design):
        raise ValueError(
            f"values must have a row for each of the {sample_size(design)} points, not {len(table)}"
        )
    return table


def _varies(values: Floats) -> bool:
    return bool(np.ptp(values) > 1e-12 * np.max(np.abs(values)))


def _noise(table: Floats) -> float:
    """Return the share of the variance of the members' mean that is scatter among members."""
    counts = np.isfinite(table).sum(axis=1)
    means = member_means(table)
    known = np.isfinite(means)
    if known.sum() < 2:
        return math.nan
    spread = float(np.var(means[known], ddof=1))
    own = member_variance(table) * float(np.mean(1.0 / counts[known]))
    return noise_share(own, spread)


def spoken(name: str) -> str:
    """Return a name as text for a message.

    >>> spoken("tooth_error")
    'tooth error'
    """
    return name.replace("_", " ")


def shares_words(found: Indices, names: Sequence[str] = ()) -> str:
    """Return the shares of the variance in one sentence, the same on every page: first order and total, the largest first.

    Each with the half-width of its confidence interval, if it has one.

    >>> shares_words(Indices("grid", ("speed", "play"), 0.95, 4, 0, (0.8, 0.1), (0.0, 0.0), (0.9, 0.2), (0.0, 0.0)))
    'Shares of its variance, first order (alone) and total (with others): speed 80 and 90 %, play 10 and 20 %.'
    >>> shares_words(Indices("sobol", ("play",), 0.95, 40, 0, (0.8,), (0.061,), (0.9,), (0.1,)))
    'Shares of its variance, first order (alone) and total (with others), with 95 % intervals: play 80 ± 6 and 90 ± 10 %.'
    """
    if found.reason:
        return f"No Sobol indices: {found.reason}."
    shown = [spoken(name) for name in names or found.names]
    exact = found.source == "grid"

    def share(value: float, error: float) -> str:
        return f"{100.0 * value:.3g}" if exact else f"{100.0 * value:.0f} ± {100.0 * error:.0f}"

    ranked = ", ".join(
        f"{shown[at]} {share(found.first[at], found.first_error[at])} and {share(found.total[at], found.total_error[at])} %"
        for at in found.ranking[:MOST_RANKED]
    )
    more = len(shown) - MOST_RANKED
    return (
        "Shares of its variance, first order (alone) and total (with others)"
        + ("" if exact else f", with {100.0 * found.confidence:.3g} % intervals")
        + f": {ranked}"
        + (f" and {more} more" if more > 0 else "")
        + "."
    )
