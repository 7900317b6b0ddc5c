"""Values of the targets in simulated records: amplitude, frequency or level, with the standard error of the ensemble."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.plan import HumpTarget, LevelTarget, LineTarget, StatisticTarget
from gearplay.results.spectra import Spectrum, ensemble_spectrum
from gearplay.signals.lines import band_level, find_hump, find_line
from gearplay.solver.trajectory import ContactStatistics

Floats = NDArray[np.float64]
AnyTarget = LineTarget | HumpTarget | LevelTarget | StatisticTarget
GROUPS = 8  # of members that are left out in turn

AMPLITUDE, DISPLACEMENT, FREQUENCY, VALUE = "amplitude", "displacement", "frequency", "value"


@dataclass(frozen=True)
class Observed:
    """One observed value in SI, with the standard error [decades] of the ensemble's mean."""

    value: float
    error: float


@dataclass(frozen=True)
class Ensemble:
    """Records of one condition: accelerations [m/s^2], shape [member, time], and each member's contact statistics."""

    accelerations: Floats
    sampling: float  # Hz
    mesh_frequency: float  # Hz
    window: str = "hann"
    contacts: Sequence[ContactStatistics] = ()

    def only(self, keep: NDArray[np.bool_]) -> "Ensemble":
        """Return the ensemble with some of its members, ``keep`` of shape [member]."""
        contacts = [c for c, kept in zip(self.contacts, keep, strict=True) if kept] if self.contacts else ()
        return replace(self, accelerations=self.accelerations[keep], contacts=contacts)


def observe(targets: Sequence[AnyTarget], ensemble: Ensemble) -> dict[str, dict[str, Observed]]:
    """Return the values of each target by its name; errors from leaving out one group of members in turn (jackknife).

    A line or hump has amplitude [m/s^2], displacement [m] and frequency [Hz]; a level amplitude and displacement; a
    statistic a value. A single record has error 0: its uncertainty is the plan's.
    """
    spectrum = ensemble_spectrum(list(ensemble.accelerations), ensemble.sampling, window=ensemble.window)
    whole = _numbers(targets, ensemble, spectrum)
    members = len(ensemble.accelerations)
    groups = min(GROUPS, members)
    parts = []
    for group in range(groups if groups > 1 else 0):
        keep = np.arange(members) % groups != group
        parts.append(_numbers(targets, ensemble.only(keep), _averaged(spectrum, keep)))
    return {
        name: {
            key: Observed(number, _jackknife([p[name][key] for p in parts]))
            for key, number in numbers.items()
        }
        for name, numbers in whole.items()
    }


def _averaged(spectrum: Spectrum, keep: NDArray[np.bool_]) -> Spectrum:
    """Return the ensemble's spectrum over some of its members."""
    assert spectrum.each is not None
    return replace(
        spectrum, amplitude=np.sqrt(np.mean(spectrum.each[keep] ** 2, axis=0)), members=int(keep.sum())
    )


def _jackknife(values: Sequence[float]) -> float:
    """Return the standard error [decades] from values with one group left out: sqrt((g - 1) / g sum (v - mean)^2)."""
    if len(values) < 2 or min(values) <= 0.0:
        return 0.0
    logs = np.log10(values)
    return float(np.sqrt((len(logs) - 1) * np.var(logs)))


def _numbers(
    targets: Sequence[AnyTarget], ensemble: Ensemble, spectrum: Spectrum
) -> dict[str, dict[str, float]]:
    return {target.name: _of_target(target, ensemble, spectrum) for target in targets}


def _of_target(target: AnyTarget, ensemble: Ensemble, spectrum: Spectrum) -> dict[str, float]:
    if isinstance(target, StatisticTarget):
        return {VALUE: _statistic(target, ensemble)}
    if isinstance(target, LevelTarget):
        return _level(target, ensemble, spectrum)
    if isinstance(target, HumpTarget):
        line = find_hump(spectrum, *target.band, width=target.width)
    else:
        near = target.near if target.near is not None else (target.order or 1) * ensemble.mesh_frequency
        line = find_line(spectrum, near, search=target.search)
    displacement = line.amplitude / (2.0 * np.pi * line.frequency) ** 2
    return {AMPLITUDE: line.amplitude, DISPLACEMENT: displacement, FREQUENCY: line.frequency}


def _level(target: LevelTarget, ensemble: Ensemble, spectrum: Spectrum) -> dict[str, float]:
    """Return the rms within the band, of the acceleration and of the displacement behind it."""
    samples = ensemble.accelerations.shape[1]
    omega = 2.0 * np.pi * np.where(spectrum.frequency > 0.0, spectrum.frequency, np.inf)
    displaced = replace(spectrum, amplitude=spectrum.amplitude / omega**2)
    return {
        AMPLITUDE: band_level(spectrum, samples, *target.band),
        DISPLACEMENT: band_level(displaced, samples, *target.band),
    }


def _statistic(target: StatisticTarget, ensemble: Ensemble) -> float:
    a = ensemble.accelerations - ensemble.accelerations.mean(axis=1, keepdims=True)
    mean_square = float(np.mean(a**2))
    if target.statistic == "rms":
        return float(np.sqrt(mean_square))
    if target.statistic == "kurtosis":
        return float(np.mean(a**4)) / mean_square**2
    if target.statistic == "crest_factor":
        return float(np.mean(np.max(np.abs(a), axis=1) / np.sqrt(np.mean(a**2, axis=1))))
    values: list[Any] = []
    for contacts in ensemble.contacts:
        values.append(getattr(contacts, target.statistic)[contacts.labels.index(str(target.contact))])
    return float(np.mean(values))
