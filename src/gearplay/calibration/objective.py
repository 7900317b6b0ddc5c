"""Residuals of a trial against the measurement, in decades, weighted by measured and ensemble variance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.observe import AMPLITUDE, DISPLACEMENT, FREQUENCY, VALUE, Observed
from gearplay.calibration.plan import Plan
from gearplay.calibration.trials import Trial

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
            for key, seen in measurements[condition.name].get(target.name, {}).items():
                if key == DISPLACEMENT:
                    continue
                own = target.frequency_uncertainty if key == FREQUENCY else target.uncertainty
                default = plan.frequency_uncertainty if key == FREQUENCY else plan.uncertainty
                sigma = float(np.hypot(own if own is not None else default, seen.error))
                data.append(Datum(condition.name, target.name, key, seen.value, sigma))
    return tuple(data)


def printed_measurements(plan: Plan) -> dict[str, dict[str, dict[str, Observed]]]:
    """Return the values that the plan itself gives, by condition and target."""
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


@dataclass(frozen=True)
class Comparison:
    """The measured numbers against many points at once, in one reading of the ordinate.

    ``logs`` and ``errors`` have shape [point, datum]: log10 of what was simulated, and its standard error [decades].
    ``reading``: "absolute" compares as they are; "unnormalised" fits one common factor of all amplitudes at each point;
    "displacement" compares amplitudes with the displacement in um.
    """

    data: tuple[Datum, ...]
    reading: str

    def logs_of(self, trials: Sequence[Trial]) -> tuple[Floats, Floats]:
        """Return log10 and standard errors [decades] of good trials, shape [trial, datum]."""
        table = np.array([[self._seen(trial, d) for d in self.data] for trial in trials])
        return np.log10(np.maximum(table[..., 0], 1e-300)), table[..., 1]

    def _seen(self, trial: Trial, datum: Datum) -> tuple[float, float]:
        as_displacement = self.reading == "displacement" and datum.key == AMPLITUDE
        seen = trial.seen[datum.condition][datum.target][DISPLACEMENT if as_displacement else datum.key]
        return (1e6 * seen.value if as_displacement else seen.value), seen.error

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

        ``scatter`` [decades] is added to every uncertainty: how wrong the model itself is taken to be.
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
