"""Trials: one parameter point, simulated under every condition, and the observed targets."""

import math
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.observe import Ensemble, Observed, observe
from gearplay.calibration.plan import LineTarget, Model, Parameter, Plan, Simulation, to_value
from gearplay.model.case import Case
from gearplay.model.plan_values import changed, factor, number_in_si, value_at
from gearplay.model.reading import load_case, replace
from gearplay.parts.mesh.train import rolling
from gearplay.rig.instruments import sensor_response
from gearplay.rig.plan import Accelerometer
from gearplay.solver.simulate import run_batch
from gearplay.solver.trajectory import Trajectory, acceleration_signals
from gearplay.vocabulary.errors import GearplayError, InputError, SimulationError

Floats = NDArray[np.float64]
Observations = dict[str, dict[str, dict[str, Observed]]]  # by condition, target, key
DECIMALS = 6  # of a trial's place in the unit cube
DIGITS = 5  # significant, of observed values; an ensemble determines two or three
STARTUP, SEARCH, POLISH = "startup", "search", "polish"
"""Phases of a search; trials of the last have a number of members of their own."""


@dataclass(frozen=True)
class Trial:
    """One finished trial: place in the unit cube, shape [parameter], and observed values; none, with a reason, if it failed."""

    number: int
    unit: tuple[float, ...]
    observed: Observations
    reason: str = ""
    phase: str = SEARCH

    @property
    def same_as(self) -> tuple[tuple[float, ...], bool]:
        """Key of a trial's result: its point in the unit cube, and whether it is of the polishing phase."""
        return self.unit, self.phase == POLISH

    @property
    def good(self) -> bool:
        """Whether every condition gave its numbers."""
        return not self.reason


def distinct(trials: Iterable[Trial]) -> list[Trial]:
    """Return trials without repeats, which have the same initial states and results and would count twice."""
    first: dict[object, Trial] = {}
    for trial in trials:
        first.setdefault(trial.same_as, trial)
    return list(first.values())


def placed(unit: Sequence[float]) -> tuple[float, ...]:
    """Return a point rounded to `DECIMALS`, as it is simulated."""
    return tuple(round(float(u), DECIMALS) for u in unit)


class TrialStore(Protocol):
    """Store of finished trials, from which a stopped calibration is resumed."""

    def read(self) -> list[Trial]:
        """Return the finished trials in order."""

    def add(self, trial: Trial) -> None:
        """Store one finished trial."""


class Problem:
    """Executable plan of one model: cases by condition, bounds in SI, and the observed values at a point.

    Raises `InputError` for a case, path or bound that does not fit.
    """

    def __init__(self, plan: Plan, model: Model) -> None:
        self.plan, self.model = plan, model
        self.parameters = plan.parameters_of(model.name)
        base = replace(load_case(plan.case), {**plan.set, **model.set})
        self.cases = [changed(base, c.set, f"conditions.{at}.set") for at, c in enumerate(plan.conditions)]
        self.bounds = [_bounds(p, plan.parameters.index(p), self.cases[0]) for p in self.parameters]
        for at, target in enumerate(plan.targets):
            if isinstance(target, LineTarget) and target.order is not None and not base.meshes:
                rule = "counts mesh frequencies, but the case has no mesh"
                raise InputError.of(
                    f"targets.{at}.order", target.order, rule, "Give near, a frequency, instead"
                )
        if plan.sensor.rotor not in base.rotors:
            known = ", ".join(base.rotors)
            raise InputError.of(
                "sensor.rotor", plan.sensor.rotor, "must be a rotor of the case", f"Rotors: {known}"
            )

    def values(self, unit: Sequence[float]) -> dict[str, float]:
        """Return the parameters in SI (or as factors) at a point of the unit cube."""
        return {
            p.name: to_value(u, *bounds, p.scale)
            for p, u, bounds in zip(self.parameters, unit, self.bounds, strict=True)
        }

    def cases_at(self, values: Mapping[str, float], *, seed: int | None = None) -> list[Case]:
        """Return the case of each condition at these parameters."""
        return [replace(case, self._changes(case, values, seed)) for case in self.cases]

    def _changes(self, case: Case, values: Mapping[str, float], seed: int | None) -> dict[str, Any]:
        changes: dict[str, Any] = {"run.seed": self.plan.effort.seed if seed is None else seed}
        for parameter in self.parameters:
            for path in (parameter.path, *parameter.also):
                value = values[parameter.name]
                changes[path] = value * float(value_at(case, path)) if parameter.mode == "scale" else value
        return changes

    def observe(
        self,
        unit: Sequence[float],
        *,
        seed: int | None = None,
        members: int | None = None,
        transient: float | None = None,
        stop: threading.Event | None = None,
    ) -> Observations:
        """Simulate every condition at a point and return the observed values.

        Every trial has the same seed, so the same initial states: common random numbers. ``seed`` replaces it, ``transient`` [s]
        the plan's.

        Raises `GearplayError` where a condition has fewer than half of its members, `KeyboardInterrupt` once stopped.
        """
        simulation = self.plan.simulation
        count = members or simulation.members
        cases = self.cases_at(self.values(unit), seed=seed)
        stop = stop or threading.Event()
        runs = run_batch(
            [(case, range(1, count + 1)) for case in cases],
            signals=acceleration_signals([self.plan.sensor.rotor]),
            duration=simulation.duration,
            transient=simulation.transient if transient is None else transient,
            sampling=simulation.sampling,
            stop=stop,
        )
        if stop.is_set():
            raise KeyboardInterrupt
        return {
            condition.name: observe(self.plan.targets, self._ensemble(case, members_run, simulation))
            for condition, case, members_run in zip(self.plan.conditions, cases, runs, strict=True)
        }

    def _ensemble(self, case: Case, runs: Sequence[Trajectory], simulation: Simulation) -> Ensemble:
        good = [run for run in runs if run.success]
        if 2 * len(good) < len(runs):
            bad = next(run for run in runs if not run.success)
            raise TrialError(f"{len(runs) - len(good)} of {len(runs)} members failed: {bad.message}")
        sensor = self.plan.sensor
        cos, sin = math.cos(sensor.direction), math.sin(sensor.direction)
        accelerations = np.array([(cos, sin) @ run.mean_acceleration(sensor.rotor) for run in good])
        return Ensemble(
            as_sensed(accelerations, simulation.sampling, sensor.accelerometer),
            simulation.sampling,
            rolling.first_mesh_frequency(case),
            simulation.window,
            [run.statistics for run in good],
        )

    def run(
        self,
        number: int,
        unit: Sequence[float],
        *,
        phase: str = SEARCH,
        members: int | None = None,
        stop: threading.Event | None = None,
    ) -> Trial:
        """Return the finished trial at a point; a simulation that fails is a trial with its reason.

        Its place is rounded to `DECIMALS` before it is simulated, and the observed values to `DIGITS` afterwards, so that trials
        take little space and a resumed search gives the same numbers.
        """
        place = placed(unit)
        try:
            return Trial(
                number, place, mapped(self.observe(place, members=members, stop=stop), rounded), phase=phase
            )
        except GearplayError as error:
            return Trial(number, place, {}, str(error).splitlines()[0], phase)


Changed = TypeVar("Changed")


def mapped(
    observations: Mapping[str, Any], change: Callable[[str, Any], Changed]
) -> dict[str, dict[str, dict[str, Changed]]]:
    """Return ``change(key, observed)`` of every observed value, by condition, target and key as before."""
    return {
        condition: {
            target: {key: change(key, observed) for key, observed in keys.items()}
            for target, keys in targets.items()
        }
        for condition, targets in observations.items()
    }


def rounded(_: str, observed: Observed) -> Observed:
    """Return an observed value with `DIGITS` significant digits, its error with three."""
    return Observed(float(f"{observed.value:.{DIGITS}g}"), float(f"{observed.error:.3g}"))


class TrialError(SimulationError):
    """A point at which too few members finish."""


def as_sensed(accelerations: Floats, sampling: float, sensor: Accelerometer | None) -> Floats:
    """Return accelerations, shape [member, time], filtered by a sensor's frequency response; None: an ideal sensor.

    Applied to the discrete Fourier transform, so each record counts as periodic.
    """
    if sensor is None:
        return accelerations
    length = accelerations.shape[1]
    response = sensor_response(sensor, np.asarray(np.fft.rfftfreq(length, 1.0 / sampling), dtype=np.float64))
    return np.asarray(np.fft.irfft(np.fft.rfft(accelerations, axis=1) * response, length, axis=1))


def _bounds(parameter: Parameter, at: int, case: Case) -> tuple[float, float]:
    """Return a parameter's bounds in SI, after trying each in the case."""
    bounds = []
    for name in ("low", "high"):
        raw, where = getattr(parameter, name), f"parameters.{at}.{name}"
        if parameter.mode == "scale":
            bounds.append(factor(raw, where))
            continue
        bounds.append(number_in_si(case, (parameter.path, *parameter.also), raw, where))
    low, high = bounds
    if not low < high:
        raise InputError.of(f"parameters.{at}.high", parameter.high, "must be above low", "Swap them")
    if parameter.scale == "log" and low <= 0.0:
        raise InputError.of(
            f"parameters.{at}.low",
            parameter.low,
            "must be above 0 on a log scale",
            "Raise it, or use linear",
        )
    return low, high
