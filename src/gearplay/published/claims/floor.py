"""Error floor of a perfect model: distance of single chaotic runs of the true model, and the bias of selection."""

import math
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.published.article import LINES, conditions
from gearplay.published.audit import best_factor, mean_error
from gearplay.published.claims.points import read_lines
from gearplay.published.han2021 import mean_acceleration
from gearplay.published.settings import Settings, base_case, condition_case
from gearplay.solver.simulate import run_members
from gearplay.solver.trajectory import acceleration_signals
from gearplay.vocabulary.progress import Progress

Floats = NDArray[np.float64]
RECORDS = (4.0, 16.0)
"""Lengths of record [s] that are tried: the article does not give its own."""
DRAWS = (1, 2, 3, 5, 8, 12, 20, 32, 48)
"""Numbers of runs of which the best is picked."""


def single_runs(
    settings: Settings,
    duration: float,
    *,
    members: int,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Floats:
    """Return the 18 amplitudes [m/s^2] read from single runs of the coupled model, shape [member, condition, line].

    Raises `KeyboardInterrupt` once ``stop`` is set.
    """
    variant, stop = settings.variants[0], stop or threading.Event()
    base, found = base_case(variant, settings), np.full((members, len(conditions()), len(LINES)), np.nan)
    for at, condition in enumerate(conditions()):
        case = condition_case(base, condition, variant.model)
        runs = run_members(
            case,
            range(1, members + 1),
            signals=acceleration_signals(["ring"]),
            duration=duration,
            transient=settings.transient,
            sampling=settings.sampling,
            stop=stop,
        )
        if stop.is_set():
            raise KeyboardInterrupt
        for m, run in enumerate(runs):
            if run.success:
                found[m, at] = read_lines([mean_acceleration(run)], condition, settings.sampling)
        if progress is not None:
            progress(f"perfect model, records of {duration:g} s", at + 1.0, float(len(conditions())))
    return found[np.all(np.isfinite(found), axis=(1, 2))]


def pair_errors(amplitudes: Floats) -> Floats:
    """Return the mean error [%] of each run (second index) taken as the model of each other (first index), one factor free.

    The diagonal is NaN. ``amplitudes`` has shape [run, condition, line].
    """
    flat = amplitudes.reshape(len(amplitudes), -1)
    errors = np.full((len(flat), len(flat)), np.nan)
    for i, test in enumerate(flat):
        for j, model in enumerate(flat):
            if i != j:
                errors[i, j] = mean_error(test, model, best_factor(test, model))
    return errors


def best_of(errors: Floats, draws: int) -> float:
    """Return the expected least of ``draws`` entries of each row, drawn without replacement, mean over rows; NaN is no entry.

    With the entries of a row in rising order, the k-th of m is the least of n with probability C(m - k, n - 1) / C(m, n).

    >>> best_of(np.array([[1.0, 2.0, 3.0]]), 2)
    1.3333333333333333
    """
    totals = []
    for row in errors:
        known = np.sort(row[np.isfinite(row)])
        m = known.size
        whole = math.comb(m, draws)
        weights = [math.comb(m - k - 1, draws - 1) / whole for k in range(m)]
        totals.append(float(np.dot(known, weights)))
    return float(np.mean(totals))


def condition_errors(amplitudes: Floats) -> Floats:
    """Return the mean error [%] of one condition's three lines, run against run, shape [condition, run, run]; diagonal NaN."""
    test, model = amplitudes[:, None], amplitudes[None, :]
    errors = 100.0 * np.mean(np.abs(model / test - 1.0), axis=-1)  # [run, run, condition]
    errors[np.arange(len(amplitudes)), np.arange(len(amplitudes))] = np.nan
    return np.moveaxis(errors, -1, 0)


def floor_of(amplitudes: Floats, duration: float, limit: float) -> dict[str, Any]:
    """Return what single runs of the true model say: how near pairs come, and curves of the best of n.

    ``limit`` [%] is the error that the article reports.
    """
    errors = pair_errors(amplitudes)
    known = errors[np.isfinite(errors)]
    free = condition_errors(amplitudes)
    draws = [n for n in DRAWS if n < len(amplitudes)]
    return {
        "record": duration,
        "runs": len(amplitudes),
        "pairs": int(known.size),
        "limit": limit,
        "within_limit": int(np.count_nonzero(known <= limit)),
        "quantiles": {str(q): float(np.percentile(known, q)) for q in (0, 5, 25, 50, 75, 95)},
        "draws": draws,
        "best_of": [best_of(errors, n) for n in draws],
        "free_per_condition": [float(np.mean([best_of(each, n) for each in free])) for n in draws],
    }


def runs_needed(floor: dict[str, Any], curve: str) -> int | None:
    """Return the least number of runs whose best comes within the limit on a curve; None beyond its end."""
    return next(
        (n for n, error in zip(floor["draws"], floor[curve], strict=True) if error <= floor["limit"]), None
    )


def floors(
    settings: Settings,
    limit: float,
    *,
    members: int,
    records: Sequence[float] = RECORDS,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> list[dict[str, Any]]:
    """Return the floor for each length of record."""
    return [
        floor_of(single_runs(settings, each, members=members, progress=progress, stop=stop), each, limit)
        for each in records
    ]
