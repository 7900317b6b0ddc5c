"""Points of the unknown parameters, simulated with each formulation and model under all six conditions."""

import dataclasses
import threading
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.plan import Plan
from gearplay.calibration.reading import load_plan
from gearplay.calibration.search import even_point
from gearplay.calibration.trials import Problem
from gearplay.files.parts import part_key
from gearplay.model.case import Case
from gearplay.model.reading import replace
from gearplay.published.article import LINES, Condition, conditions
from gearplay.published.han2021 import Store, find_lines, mean_acceleration
from gearplay.results.spectra import amplitude_spectrum, ensemble_spectrum
from gearplay.solver.simulate import run_batch
from gearplay.solver.trajectory import Trajectory, acceleration_signals
from gearplay.vocabulary.progress import Progress

Floats = NDArray[np.float64]

PLAN = "han2021"
"""The calibration plan whose parameters, ranges and models these are."""
WIDER = dict.fromkeys(("tilt_along", "tilt_across"), ("-0.05 m/s^2", "0.05 m/s^2"))
"""Ranges that differ from the calibration's: a tilt of up to 0.3 degrees."""
MODELS = ("coupled", "uncoupled", "coupled_as_published", "uncoupled_as_published")


@dataclass(frozen=True)
class ClaimSettings:
    """How the claims are tried: Sobol points, members of each, records [s, Hz], error tolerance, and the seed of it all.

    The first half of the points is tried again with ``finer_tolerance``.
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
        """Return the settings of the repetition."""
        return dataclasses.replace(self, points=self.points // 2, tolerance=self.finer_tolerance)

    @property
    def floor_runs(self) -> int:
        """Runs for each condition from which the perfect model's floor is told: fewer for a try with a few points, 64 at most."""
        return min(64, max(8, self.points // 2))


@dataclass(frozen=True)
class PointResult:
    """One point with one model: amplitudes [m/s^2] of f_r, f_m, 2 f_m under the six conditions, in print order.

    ``ensemble`` has shape [condition, line], ``single`` [member, condition, line]: each member read by itself, as a test is;
    NaN for a member that did not finish. ``wedged`` is the share of time with negative backlash, by condition. A point that
    was dropped has a ``reason`` and nothing else.
    """

    model: str
    point: int
    ensemble: Floats
    single: Floats
    wedged: tuple[float, ...]
    reason: str = ""

    def to_part(self) -> dict[str, Any]:
        """Return its JSON-able form."""
        return {
            "model": self.model,
            "point": self.point,
            "ensemble": _rounded(self.ensemble),
            "single": _rounded(self.single),
            "wedged": [float(f"{w:.4g}") for w in self.wedged],
            "reason": self.reason,
        }


def _rounded(values: Floats) -> Any:
    return [float(f"{v:.6g}") for v in values.ravel()]


def point_from(part: dict[str, Any]) -> PointResult:
    """Return it from its JSON-able form."""
    shape = (len(conditions()), len(LINES))
    return PointResult(
        part["model"],
        part["point"],
        np.array(part["ensemble"]).reshape(-1, *shape)[0] if part["ensemble"] else np.empty((0, 0)),
        np.array(part["single"]).reshape(-1, *shape),
        tuple(part["wedged"]),
        part["reason"],
    )


def claims_plan() -> Plan:
    """Return the plan that declares the ranges; rigs may be less level than the calibration has them."""
    plan = load_plan(PLAN)
    wider = [
        p.model_copy(update={"low": WIDER[p.name][0], "high": WIDER[p.name][1]}) if p.name in WIDER else p
        for p in plan.parameters
    ]
    return plan.model_copy(update={"parameters": tuple(wider)})


def problems_of(plan: Plan) -> dict[str, Problem]:
    """Return the four combinations of formulation and backlash model, by name."""
    return {model.name: Problem(plan, model) for model in plan.models if model.name in MODELS}


def cases_at(problem: Problem, point: int, settings: ClaimSettings) -> list[Case]:
    """Return the six cases of a Sobol point."""
    unit = even_point(point, len(problem.plan.parameters), settings.seed)
    cases = problem.cases_at(problem.values(unit), seed=settings.seed + point)
    return [replace(case, {"run.tolerance": settings.tolerance}) for case in cases]


def read_lines(accelerations: Sequence[Floats], condition: Condition, sampling: float) -> Floats:
    """Return the amplitudes [m/s^2] of f_r, f_m and 2 f_m of an ensemble of records, shape [line]."""
    spectrum = (
        ensemble_spectrum(list(accelerations), sampling)
        if len(accelerations) > 1
        else amplitude_spectrum(accelerations[0], sampling)
    )
    found = find_lines(spectrum, condition)
    return np.array([found[line].amplitude for line in LINES])


def run_point(
    problem: Problem, point: int, settings: ClaimSettings, stop: threading.Event | None = None
) -> PointResult:
    """Simulate one point with one model.

    Raises `KeyboardInterrupt` once ``stop`` is set.
    """
    stop = stop or threading.Event()
    members = range(1, settings.members + 1)
    cases = cases_at(problem, point, settings)
    runs = run_batch(
        [(case, members) for case in cases],
        signals=acceleration_signals(["ring"]),
        duration=settings.duration,
        transient=settings.transient,
        sampling=settings.sampling,
        stop=stop,
    )
    if stop.is_set():
        raise KeyboardInterrupt
    name = problem.model.name
    for condition, of_condition in zip(conditions(), runs, strict=True):
        bad = [run for run in of_condition if not run.success]
        if 2 * len(bad) > settings.members:
            reason = f"{condition.label}: {len(bad)} of {settings.members} members failed: {bad[0].message}"
            return PointResult(name, point, np.empty((0, 0)), np.empty((0, 0, 0)), (), reason)
    return PointResult(name, point, *_amplitudes(runs, settings))


def _amplitudes(
    runs: Sequence[Sequence[Trajectory]], settings: ClaimSettings
) -> tuple[Floats, Floats, tuple[float, ...]]:
    shape = (len(runs), len(LINES))
    ensemble, single = np.empty(shape), np.full((settings.members, *shape), np.nan)
    wedged = []
    for at, (condition, of_condition) in enumerate(zip(conditions(), runs, strict=True)):
        records = {m: mean_acceleration(run) for m, run in enumerate(of_condition) if run.success}
        ensemble[at] = read_lines(list(records.values()), condition, settings.sampling)
        for m, record in records.items():
            single[m, at] = read_lines([record], condition, settings.sampling)
        wedged.append(float(np.mean([sum(run.wedged.values()) for run in of_condition])))
    return ensemble, single, tuple(wedged)


def run_points(
    settings: ClaimSettings,
    *,
    progress: Progress | None = None,
    store: Store | None = None,
    stop: threading.Event | None = None,
) -> list[PointResult]:
    """Simulate every point with every model; finished ones come from ``store`` where it has them.

    Raises `KeyboardInterrupt` soon after ``stop`` is set.
    """
    plan = claims_plan()
    problems = problems_of(plan)
    ranges = [p.model_dump(mode="json") for p in plan.parameters]
    own = {k: v for k, v in asdict(settings).items() if k not in ("points", "finer_tolerance")}
    total, found = settings.points * len(problems), []
    for point in range(settings.points):
        for name, problem in problems.items():
            if stop is not None and stop.is_set():
                raise KeyboardInterrupt
            key = part_key([ranges, problem.cases[0].sha256, own, name, point])
            part = store.get(key) if store is not None else None
            if part is None:
                part = run_point(problem, point, settings, stop).to_part()
                if store is not None:
                    store.put(key, part)
            found.append(point_from(part))
            if progress is not None:
                words = f"claims, tolerance {settings.tolerance:g}: point {point + 1} of {settings.points}"
                progress(words, float(len(found)), float(total))
    return found
