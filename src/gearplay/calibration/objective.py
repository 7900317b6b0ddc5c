"""Measured values of a plan, and residuals of trials in decades, weighted by measured and ensemble variance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.observe import (
    AMPLITUDE,
    DISPLACEMENT,
    FREQUENCY,
    VALUE,
    Ensemble,
    Observed,
    observe,
)
from gearplay.calibration.plan import Condition, Plan, StatisticTarget
from gearplay.calibration.trials import Problem, Trial
from gearplay.files.measurements import read_measurement
from gearplay.files.record import Channel
from gearplay.parts.mesh.train import rolling
from gearplay.schema.units import UnitError, parse_quantity
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import ACCELERATION

Floats = NDArray[np.float64]
Measurements = Mapping[str, Mapping[str, Mapping[str, Observed]]]  # by condition, target, key


@dataclass(frozen=True)
class Datum:
    """One measured number: where, which key, its value (SI, or the ordinate's unit) and standard uncertainty [decades]."""

    condition: str
    target: str
    key: str  # amplitude, frequency or value
    value: float
    uncertainty: float

    @property
    def label(self) -> str:
        """Short name for tables."""
        return f"{self.condition}, {self.target}, {self.key}"


def data_of(plan: Plan, measurements: Measurements) -> tuple[Datum, ...]:
    """Return every measured number in the plan's order, with its uncertainty; see `measurements_of`."""
    data = []
    for condition in plan.conditions:
        for target in plan.targets:
            for key, number in measurements[condition.name].get(target.name, {}).items():
                if key == DISPLACEMENT:
                    continue
                own = target.frequency_uncertainty if key == FREQUENCY else target.uncertainty
                default = plan.frequency_uncertainty if key == FREQUENCY else plan.uncertainty
                sigma = float(np.hypot(own if own is not None else default, number.error))
                data.append(Datum(condition.name, target.name, key, number.value, sigma))
    return tuple(data)


def printed_measurements(plan: Plan) -> dict[str, dict[str, dict[str, Observed]]]:
    """Return the measured values given in the plan, by condition and target."""
    return {
        condition.name: {
            name: {
                key: Observed(float(number), 0.0)
                for key in (AMPLITUDE, FREQUENCY, VALUE)
                if (number := getattr(values, key)) is not None
            }
            for name, values in condition.measured.items()
        }
        for condition in plan.conditions
    }


def measurements_of(plan: Plan, folder: Path) -> dict[str, dict[str, dict[str, Observed]]]:
    """Return the measured numbers by condition and target; records are searched in ``folder``.

    A record is averaged over the plan's sampling intervals and cut into pieces as long as a simulated record: the
    pieces are its ensemble, so that noise-like content, whose lines depend on the length, is compared like with like.

    Raises `InputError` for a record that does not fit the plan, `MeasurementError` for one that cannot be read.
    """
    found = printed_measurements(plan)
    problem = Problem(plan, plan.models[0])
    for at, (condition, case) in enumerate(zip(plan.conditions, problem.cases, strict=True)):
        if condition.record is None:
            continue
        targets = [
            t for t in plan.targets if not (isinstance(t, StatisticTarget) and t.contact is not None)
        ]  # an accelerometer measures no contacts
        if not targets:
            rule = "must be observable in a record; statistics of contacts are not"
            raise InputError.of("targets", plan.targets, rule, "Add a line, a hump, a level or rms")
        pieces = _pieces(plan, condition, at, folder)
        ensemble = Ensemble(
            pieces, plan.simulation.sampling, rolling.first_mesh_frequency(case), plan.simulation.window
        )
        found[condition.name] = observe(targets, ensemble)
    return found


def _acceleration_factor(channel: Channel, at: int) -> float:
    """Return the factor to m/s^2 of a channel of condition ``at``; `InputError` where it has no unit of acceleration."""
    spelled = "m/s^2" if channel.unit == "m s-2" else channel.unit
    try:
        return parse_quantity(f"1 {spelled}", ACCELERATION)
    except UnitError:
        cure = f'Write the unit behind its name in the file, as "{channel.name} [m/s^2]", or name the channel of an acceleration'
        shown = f"{channel.name} [{channel.unit}]"
        raise InputError.of(
            f"conditions.{at}.channel", shown, "must have a unit of acceleration", cure
        ) from None


def _pieces(plan: Plan, condition: Condition, at: int, folder: Path) -> Floats:
    """Return the record's accelerations [m/s^2] as the simulation's are sampled and cut, shape [piece, time]."""
    where = f"conditions.{at}.record"
    path = folder / str(condition.record)
    channel = read_measurement(path).channel(condition.channel)
    factor = _acceleration_factor(channel, at)
    averaged = _averaged(channel, plan.simulation.sampling, where)
    length = round(plan.simulation.duration * plan.simulation.sampling) - 1  # increments between the samples
    count = averaged.size // length
    if count == 0:
        rule = (
            f"must be at least {plan.simulation.duration:g} s long, as the simulated records are,"
            f" not {channel.duration:.3g} s"
        )
        raise InputError.of(
            where, condition.record, rule, "Shorten simulation.duration, or take a longer record"
        )
    return factor * averaged[: count * length].reshape(count, length)


def _averaged(channel: Channel, sampling: float, where: str) -> Floats:
    ratio = channel.sampling / sampling
    whole = round(ratio)
    if whole < 1 or abs(ratio - whole) > 1e-6 * whole:
        rule = f"must be sampled at a multiple of simulation.sampling = {sampling:g} Hz, not at {channel.sampling:g} Hz"
        raise InputError.of(where, channel.name, rule, "Change simulation.sampling")
    count = channel.values.size // whole
    return np.asarray(channel.values[: count * whole].reshape(count, whole).mean(axis=1))


@dataclass(frozen=True)
class Comparison:
    """The measured numbers against many points at once, in one reading of the ordinate.

    ``logs`` and ``errors`` have shape [point, datum]: log10 of what was simulated, and its standard error [decades].
    ``reading``: "absolute" compares amplitudes in m/s^2; "unnormalised" fits one common factor of all amplitudes at each point;
    "displacement" compares amplitudes with the displacement in um.
    """

    data: tuple[Datum, ...]
    reading: str

    def logs_of(self, trials: Sequence[Trial]) -> tuple[Floats, Floats]:
        """Return log10 and standard errors [decades] of good trials, shape [trial, datum]."""
        table = np.array([[self._observed(trial, d) for d in self.data] for trial in trials])
        return np.log10(np.maximum(table[..., 0], 1e-300)), table[..., 1]

    def _observed(self, trial: Trial, datum: Datum) -> tuple[float, float]:
        as_displacement = self.reading == "displacement" and datum.key == AMPLITUDE
        observed = trial.observed[datum.condition][datum.target][
            DISPLACEMENT if as_displacement else datum.key
        ]
        return (1e6 * observed.value if as_displacement else observed.value), observed.error

    @cached_property
    def measured(self) -> Floats:
        """log10 of the measured numbers, shape [datum]."""
        return np.log10([d.value for d in self.data])

    @cached_property
    def uncertainty(self) -> Floats:
        """Standard uncertainty of the measured numbers [decades], shape [datum]."""
        return np.array([d.uncertainty for d in self.data])

    @cached_property
    def amplitudes(self) -> NDArray[np.bool_]:
        """Which data are amplitudes, shape [datum]."""
        return np.array([d.key == AMPLITUDE for d in self.data])

    @cached_property
    def frequencies(self) -> NDArray[np.bool_]:
        """Which data are frequencies, shape [datum]."""
        return np.array([d.key == FREQUENCY for d in self.data])

    def log_factor(self, logs: Floats, variance: Floats) -> Floats:
        """Return log10 of the common factor at each point, shape [point]: the weighted mean of the amplitudes' residuals."""
        if self.reading != "unnormalised" or not self.amplitudes.any():
            return np.zeros(logs.shape[0])
        weights = self.amplitudes / variance
        return np.asarray(np.sum((self.measured - logs) * weights, axis=1) / np.sum(weights, axis=1))

    def residuals(self, logs: Floats, errors: Floats, scatter: float = 0.0) -> tuple[Floats, Floats]:
        """Return residuals simulated - measured [decades] and their variances, shape [point, datum].

        ``scatter`` [decades] is added to every uncertainty: the assumed error of the model.
        """
        variance = self.uncertainty**2 + errors**2 + scatter**2
        factor = self.log_factor(logs, variance)
        return logs + factor[:, None] * self.amplitudes - self.measured, variance

    def objective(self, logs: Floats, errors: Floats, scatter: float = 0.0) -> Floats:
        """Return -2 log likelihood at each point but for a constant, shape [point]: sum of r^2 / v + log(v / u^2).

        r are the residuals, v their variances, u the measured uncertainties. The logarithm keeps a trial whose
        ensemble scatters widely from being taken for a good one.
        """
        residuals, variance = self.residuals(logs, errors, scatter)
        return np.asarray(np.sum(residuals**2 / variance + np.log(variance / self.uncertainty**2), axis=1))

    def mean_errors(self, logs: Floats, errors: Floats) -> tuple[Floats, Floats]:
        """Return the mean error [%] of the amplitudes (or values) and of the frequencies at each point; NaN without any."""
        residuals, _ = self.residuals(logs, errors)
        per_cent = 100.0 * np.abs(10.0**residuals - 1.0)
        rest = ~self.frequencies

        def mean(which: NDArray[np.bool_]) -> Floats:
            if not which.any():
                return np.full(len(per_cent), np.nan)
            return np.asarray(per_cent[:, which].mean(axis=1))

        return mean(rest), mean(self.frequencies)
