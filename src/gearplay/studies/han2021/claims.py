"""Frequency of the article's claimed patterns over ranges of its unknown parameters, and the error floor of a perfect model."""

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

import gearplay as gp
from gearplay.studies.han2021 import article, shares, simulation
from gearplay.studies.han2021.article import AMPLITUDE, LINES, Floats, conditions
from gearplay.studies.han2021.shares import PointResult
from gearplay.studies.han2021.simulation import Settings, Work

PLAN = "han2021"
"""The calibration plan with the parameters, ranges, models and conditions."""
WIDER = dict.fromkeys(("tilt_along", "tilt_across"), ("-0.05 m/s^2", "0.05 m/s^2"))
"""Ranges that differ from the calibration's: a tilt of up to 0.3 degrees."""
RECORDS = (4.0, 16.0)
"""Lengths of record [s] of the floors: the article does not give its own."""


@dataclass(frozen=True)
class ClaimSettings:
    """Sobol points, members of each, records [s, Hz], error tolerance, and the seed of points and starts.

    The first half of the points is repeated with ``finer_tolerance``.
    """

    points: int = 128
    members: int = 8
    duration: float = 4.0
    transient: float = 8.0
    sampling: float = 1000.0
    tolerance: float = 1e-7
    seed: int = 1
    finer_tolerance: float = 1e-9

    def finer(self) -> "ClaimSettings":
        """Return the settings of the convergence check: half of the points, ``finer_tolerance``."""
        return dataclasses.replace(self, points=self.points // 2, tolerance=self.finer_tolerance)

    @property
    def floor_runs(self) -> int:
        """Runs for each condition of the perfect model: fewer for a trial with a few points, 64 at most."""
        return min(64, max(8, self.points // 2))


def claim_ranges() -> list[dict[str, Any]]:
    """Return the parameters of the plan with their ranges; rigs may be less level than the calibration has them."""
    found = []
    for p in gp.load_plan(PLAN).parameters:
        low, high = WIDER.get(p.name, (p.low, p.high))
        found.append({"name": p.name, "path": p.path, "low": low, "high": high, "scale": p.scale})
    return found


class Problem:
    """One model of the plan: its six cases, and the bounds [SI] of its parameters."""

    def __init__(self, name: str) -> None:
        plan = gp.load_plan(PLAN)
        model = next(model for model in plan.models if model.name == name)
        base = gp.replace(gp.load_case(plan.case), {**plan.set, **model.set})
        self.name, self.cases = name, [gp.replace(base, condition.set) for condition in plan.conditions]
        self.parameters = [
            ((p.path, *p.also), r["scale"], self._at(p.path, r["low"]), self._at(p.path, r["high"]))
            for p, r in zip(plan.parameters, claim_ranges(), strict=True)
        ]

    def _at(self, path: str, value: Any) -> float:
        """Return the value [SI] that a field of the first case has after it was set."""
        found: Any = gp.replace(self.cases[0], {path: value}).resolved()
        for name in path.split("."):
            found = found[int(name) if isinstance(found, list) else name]
        return float(found)

    def cases_at(self, point: int, settings: ClaimSettings) -> list[gp.Case]:
        """Return the six cases of a point of the scrambled Sobol sequence."""
        from scipy.stats import qmc

        sobol = qmc.Sobol(len(self.parameters), seed=settings.seed)
        if point:
            sobol.fast_forward(point)
        changes: dict[str, Any] = {
            "run.seed": settings.seed + point,
            "run.tolerance": settings.tolerance,
        }
        for u, (paths, scale, low, high) in zip(sobol.random(1)[0].tolist(), self.parameters, strict=True):
            ends = (math.log(low), math.log(high)) if scale == "log" else (low, high)
            value = (1.0 - u) * ends[0] + u * ends[1]
            changes |= dict.fromkeys(paths, math.exp(value) if scale == "log" else value)
        return [gp.replace(case, changes) for case in self.cases]


def read_lines(records: Sequence[Floats], condition: article.Condition, sampling: float) -> Floats:
    """Return the amplitudes [m/s^2] of f_r, f_m and 2 f_m of an ensemble of records, shape [line]."""
    spectrum = gp.signals.ensemble_spectrum(records, sampling)
    return np.array([line.amplitude for line in simulation.find_lines(spectrum, condition)])


def read_each(records: Sequence[Floats], condition: article.Condition, sampling: float) -> Floats:
    """Return the same of each record by itself, shape [record, line]."""
    return np.array([read_lines([each], condition, sampling) for each in records]).reshape(-1, len(LINES))


def run_point(problem: Problem, point: int, settings: ClaimSettings, work: Work) -> PointResult:
    """Simulate one point with one model.

    Raises `KeyboardInterrupt` once the work's ``stop`` is set.
    """
    shape = (len(conditions()), len(LINES))
    results = work.simulate(problem.cases_at(point, settings), range(1, settings.members + 1), settings)
    ensemble, single = np.empty(shape), np.full((settings.members, *shape), np.nan)
    wedged = []
    for at, (condition, result) in enumerate(zip(conditions(), results, strict=True)):
        bad = [run for run in result.runs if not run.success]
        if 2 * len(bad) > settings.members:
            reason = f"{condition.label}: {len(bad)} of {settings.members} members failed: {bad[0].message}"
            return PointResult(problem.name, point, reason=reason)
        records = simulation.accelerations(result)
        ensemble[at] = read_lines(records, condition, settings.sampling)
        good = [m for m, run in enumerate(result.runs) if run.success]
        single[good, at] = read_each(records, condition, settings.sampling)
        wedged.append(float(np.mean([sum(run.wedged.values()) for run in result.runs])))
    return PointResult(problem.name, point, ensemble, single, tuple(wedged))


def run_points(settings: ClaimSettings, work: Work) -> list[PointResult]:
    """Simulate every point with every model.

    Raises `KeyboardInterrupt` soon after the work's ``stop`` is set.
    """
    problems, ranges = [Problem(name) for name in shares.MODELS], claim_ranges()
    own = {k: v for k, v in asdict(settings).items() if k not in ("points", "finer_tolerance")}
    total, found = settings.points * len(problems), []
    for point in range(settings.points):
        for problem in problems:
            if work.stop.is_set():
                raise KeyboardInterrupt

            def make(problem: Problem = problem, point: int = point) -> dict[str, Any]:
                return run_point(problem, point, settings, work).to_part()

            part = work.keep([ranges, problem.cases[0].sha256, own, problem.name, point], make)
            found.append(PointResult.from_part(part))
            words = f"claims, tolerance {settings.tolerance:g}: point {point + 1} of {settings.points}"
            work.progress(words, float(len(found)), float(total))
    return found


def single_runs(settings: Settings, members: int, duration: float, work: Work) -> Floats:
    """Return the 18 amplitudes [m/s^2] of single runs of the coupled model, shape [member, condition, line].

    Raises `KeyboardInterrupt` once the work's ``stop`` is set.
    """
    variant = settings.variants[0]
    base, found = (
        simulation.base_case(variant, settings),
        np.full((members, len(conditions()), len(LINES)), np.nan),
    )
    for at, condition in enumerate(conditions()):
        case = simulation.condition_case(base, condition, variant.model)
        [result] = work.simulate([case], range(1, members + 1), settings, duration=duration)
        good = [m for m, run in enumerate(result.runs) if run.success]
        found[good, at] = read_each(simulation.accelerations(result), condition, settings.sampling)
        work.progress(f"perfect model, records of {duration:g} s", at + 1.0, float(len(conditions())))
    return np.asarray(found[np.all(np.isfinite(found), axis=(1, 2))])


def summarise(
    results: Sequence[PointResult],
    finer: Sequence[PointResult],
    floors: Sequence[dict[str, Any]],
    settings: ClaimSettings,
) -> dict[str, Any]:
    """Return the document: settings, shares, at a finer tolerance too, ratios, wedging, floors, and dropped points."""
    return {
        "version": gp.__version__,
        "settings": asdict(settings),
        "conditions": [c.label for c in conditions()],
        "ranges": claim_ranges(),
        "test_shows": shares.shown_by_the_test(),
        "shares": shares.pattern_shares(results),
        "repeated": shares.repeated(results, finer),
        "ratios": shares.coupling_ratios(results),
        "wedging": shares.wedging(results),
        "floors": list(floors),
        "dropped": [{"model": r.model, "point": r.point, "reason": r.reason} for r in results if r.reason],
    }


def run_claims(settings: ClaimSettings, study: Settings, work: Work) -> dict[str, Any]:
    """Compute the claims over the declared ranges, and the perfect model's floor with the study's parameters.

    Raises `KeyboardInterrupt` soon after the work's ``stop`` is set.
    """
    results, finer = (run_points(each, work) for each in (settings, settings.finer()))
    limit = round(article.article_error("coupled", AMPLITUDE), 1)
    floors = [
        shares.floor_of(single_runs(study, settings.floor_runs, record, work), record, limit)
        for record in RECORDS
    ]
    return summarise(results, finer, floors, settings)
