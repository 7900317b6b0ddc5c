"""Printed test of the article: Tables 3 to 6 as arrays, and an audit of them by themselves."""

import csv
import json
import math
from functools import lru_cache
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LINES = ("radial", "mesh_1x", "mesh_2x")
LINE_WORDS = {"radial": "f_r", "mesh_1x": "f_m", "mesh_2x": "2 f_m"}
MODELS = ("coupled", "uncoupled")
SOURCES = ("test", *MODELS)
FREQUENCY, AMPLITUDE = "frequency_hz", "amplitude_as_printed"
PRINTED_TOLERANCE = 0.011  # per cent points: printed errors are rounded to two places, some cut instead
PACKAGE = "gearplay.studies.han2021"


class Condition(NamedTuple):
    """Test condition: pinion speed [rpm], radial clearance of the driven sleeve [um], backlash [um]."""

    speed_rpm: float
    radial_clearance_um: float
    backlash_um: float

    @property
    def mesh_frequency(self) -> float:
        """Mesh frequency f_m [Hz] of the 20-tooth pinion."""
        return 20.0 * self.speed_rpm / 60.0

    @property
    def clearances(self) -> str:
        """Radial clearance and backlash: ``100/100 um``."""
        return f"{self.radial_clearance_um:g}/{self.backlash_um:g} um"

    @property
    def label(self) -> str:
        """Short name: ``120 rpm, 100/100 um``."""
        return f"{self.speed_rpm:g} rpm, {self.clearances}"


def shown(text: str) -> str:
    """Return a text with ``um`` as µm."""
    return text.replace("um", "µm")


class Row(NamedTuple):
    """Row of Tables 3-6, in print order; the places of its condition and line are those of the arrays of `printed`."""

    table: int
    condition: Condition
    line: str
    quantity: str
    place: tuple[int, int]  # [condition, line]
    values: dict[str, float]  # by source, Hz or as printed
    printed_errors: dict[str, float]  # by model, per cent of the test value
    note: str

    def error(self, model: str) -> float:
        """Return the error [%] of a model that follows from the printed values."""
        return percent(self.values[model], self.values["test"])

    def follows(self, model: str) -> bool:
        """Return whether the printed error follows from the printed values."""
        return abs(self.printed_errors[model] - self.error(model)) <= PRINTED_TOLERANCE


def percent(value: float, test: float) -> float:
    """Return the error [%] of a value relative to the test's."""
    return 100.0 * abs(value - test) / test


def _text(name: str) -> str:
    return files(PACKAGE).joinpath(name).read_text(encoding="utf-8")


@lru_cache(maxsize=1)
def rows() -> tuple[Row, ...]:
    """Return the 36 rows of Tables 3-6 in print order."""
    table = list(csv.DictReader(_text("tables.csv").splitlines()))
    of = [Condition(*(float(row[name]) for name in Condition._fields)) for row in table]
    places = {condition: at for at, condition in enumerate(dict.fromkeys(of))}
    return tuple(
        Row(
            int(row["table"]),
            condition,
            row["line"],
            row["quantity"],
            (places[condition], LINES.index(row["line"])),
            {source: float(row[source]) for source in SOURCES},
            {model: float(row[f"{model}_error_printed_pct"]) for model in MODELS},
            row["note"],
        )
        for row, condition in zip(table, of, strict=True)
    )


@lru_cache(maxsize=1)
def conditions() -> tuple[Condition, ...]:
    """Return the six test conditions in print order."""
    return tuple(dict.fromkeys(row.condition for row in rows()))


@lru_cache(maxsize=16)
def printed(source: str, quantity: str) -> Floats:
    """Return the printed frequencies [Hz] or amplitudes [as printed] of a source, shape [condition, line]."""
    table = np.empty((len(conditions()), len(LINES)))
    for row in rows():
        if row.quantity == quantity:
            table[row.place] = row.values[source]
    table.flags.writeable = False
    return table


def article_error(model: str, quantity: str, line: str | None = None) -> float:
    """Return the article's mean error [%] of a model, recomputed from its printed values."""
    return float(
        np.mean([r.error(model) for r in rows() if r.quantity == quantity and line in (None, r.line)])
    )


def best_factor(test: Floats, simulated: Floats) -> float:
    """Return the factor a for which the mean of |a simulated / test - 1| is least.

    It is a weighted median of test / simulated, with the weights simulated / test.

    >>> best_factor(np.array([2.0, 4.0, 60.0]), np.array([1.0, 2.0, 3.0]))
    2.0
    """
    ratio = test / simulated
    order = np.argsort(ratio)
    weight = np.cumsum(1.0 / ratio[order])
    return float(ratio[order][np.searchsorted(weight, 0.5 * weight[-1])])


def mean_error(test: Floats, simulated: Floats, factor: float = 1.0) -> float:
    """Return the mean error [%] of simulated values times a factor."""
    return float(100.0 * np.mean(np.abs(factor * simulated / test - 1.0)))


def free_factor(model: str) -> tuple[float, float]:
    """Return the mean error [%] of a printed model's 18 amplitudes, and the least with one free factor."""
    test, values = (printed(source, AMPLITUDE).ravel() for source in ("test", model))
    return mean_error(test, values), mean_error(test, values, best_factor(test, values))


def mesh_readings(harmonic: int) -> Floats:
    """Return the deviations [Hz] of the readings of a harmonic of f_m from its frequency, shape [source, condition]."""
    nominal = np.array([harmonic * c.mesh_frequency for c in conditions()])
    return np.array([printed(source, FREQUENCY)[:, harmonic] - nominal for source in SOURCES])


def reading_scatter(harmonic: int) -> float:
    """Return the rms deviation [Hz] of all 18 readings of a harmonic of f_m."""
    return float(np.sqrt(np.mean(mesh_readings(harmonic) ** 2)))


def harmonic_correlation() -> tuple[float, float]:
    """Return the correlation of the deviations of f_m and 2 f_m over 18 pairs of readings, and its p value.

    A speed that differs from the nominal one would move both together.
    """
    from scipy.stats import pearsonr

    found = pearsonr(mesh_readings(1).ravel(), mesh_readings(2).ravel())
    return float(found.statistic), float(found.pvalue)


def radial_error(model: str) -> float:
    """Return the rms error [Hz] of a printed model's six radial frequencies."""
    errors = printed(model, FREQUENCY)[:, 0] - printed("test", FREQUENCY)[:, 0]
    return math.sqrt(float(np.mean(errors**2)))


def error_of_readings() -> tuple[float, float]:
    """Return the 5 and 95 % quantiles of the mean error [%] of f_r that reading errors alone would give.

    Six true frequencies, the test's, are read twice with independent normal errors of the rms of f_m's readings.
    """
    test = printed("test", FREQUENCY)[:, 0]
    twice = np.random.default_rng(0).normal(0.0, reading_scatter(1), (20_000, 2, test.size))
    first, second = test + twice[:, 0], test + twice[:, 1]
    errors = np.mean(np.abs(second / np.maximum(first, 0.1) - 1.0), axis=1)
    low, high = np.percentile(errors, [5.0, 95.0])
    return 100.0 * float(low), 100.0 * float(high)


@lru_cache(maxsize=2)
def stored(name: str) -> dict[str, Any]:
    """Return a stored document: "calibration" or "claims".

    The calibration has plan, seed and trials, the pairwise comparisons, and of each model its errors, best point and left-out
    conditions; the claims are those of 128 points of 8 members each.
    """
    document: dict[str, Any] = json.loads(_text(f"{name}.json"))
    return document


def fit_of(model: str) -> dict[str, Any]:
    """Return the calibrated fit of a model; those with the printed equations end with ``_as_published``."""
    found: dict[str, Any] = stored("calibration")["fits"][model]
    return found


def left_out_error(model: str, condition: Condition, line: str, quantity: str) -> float:
    """Return the error [%] of a number, on fresh members, of the fit without its condition."""
    key = f"{line}, {'frequency' if quantity == FREQUENCY else 'amplitude'}"
    residual = float(fit_of(model)["left_out"][condition.label][key])
    return 100.0 * abs(math.pow(10.0, residual) - 1.0)
