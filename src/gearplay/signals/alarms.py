"""Alarms: indicators of a gear against those of healthy records, with a stated rate of false alarms."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.signals.checks import refuse
from gearplay.signals.indicators import GearIndicators

Floats = NDArray[np.float64]

WATCHED: Final = ("fm4", "m6a", "m8a", "energy_ratio")
"""Indicators that rise with damage of a single tooth and have no unit."""
FALSE_ALARMS: Final = 0.02
LEAST_SPREAD: Final = 1e-6
"""Least spread of the logarithm of an indicator."""


@dataclass(frozen=True)
class AlarmLimit:
    """Limit of a score of indicators, set by a number of healthy records; see `alarm_limit`.

    ``middle`` and ``spread`` are those of the logarithms of the indicators, shape [indicator]; ``turns`` is the median number of
    turns that the healthy averages are of, where all have it.
    """

    threshold: float
    false_alarms: float
    records: int
    middle: Floats
    spread: Floats
    watched: tuple[str, ...] = WATCHED
    turns: float | None = None

    def score(self, indicators: GearIndicators) -> float:
        """Return the largest excess of an indicator over the healthy median, in healthy spreads of its logarithm.

        Raises `InputError` for indicators that are not above 0, or of an average over other than 0.8 to 1.25 times as many turns
        as the healthy ones: noise that is averaged less would raise an alarm.
        """
        _check_turns("indicators", indicators, self.turns)
        values = _logarithms("indicators", indicators, self.watched)
        return float(np.max((values - self.middle) / self.spread))

    def raises(self, indicators: GearIndicators) -> bool:
        """Return whether indicators raise an alarm: a score above the threshold."""
        return self.score(indicators) > self.threshold

    @property
    def message(self) -> str:
        """Threshold and what it was set by, as text."""
        return (
            f"alarm above {self.threshold:.3g} healthy spreads of {', '.join(self.watched)}, set by {self.records} healthy "
            f"records for false alarms in {100.0 * self.false_alarms:g} %"
        )


def alarm_limit(healthy: Sequence[GearIndicators], *, false_alarms: float = FALSE_ALARMS) -> AlarmLimit:
    """Return the limit above which indicators raise an alarm, from those of healthy records.

    The score of a record is the largest of its watched indicators, each as the logarithm less the healthy median over the healthy
    spread (1.4826 times the median deviation). The threshold is the k-th smallest score of the n healthy records,
    k = ceil((n + 1)(1 - p)): a further record that is drawn alike is above it with a probability of at most p, whatever the
    distribution (split conformal prediction, Vovk, Gammerman, Shafer, Algorithmic Learning in a Random World, 2005), but for the
    part of the healthy records in median and spread.

    Parameters
    ----------
    healthy
        Indicators of healthy records of gears alike, with the deviations, clearances and loads that they may have.
    false_alarms
        Wanted share p of healthy records that raise an alarm.

    Returns
    -------
    AlarmLimit
        ``.threshold``, ``.score(indicators)``, ``.raises(indicators)``.

    Raises
    ------
    InputError
        For fewer than 1/p - 1 records, indicators that are not above 0, or averages over 0.8 to 1.25 times the usual turns.

    Examples
    --------
    >>> from gearplay.signals import gear_indicators
    >>> noise = np.random.default_rng(0).normal(size=(100, 256))
    >>> turn = 2.0 * np.pi * np.arange(256) / 256
    >>> healthy = [gear_indicators(np.cos(20 * turn) + 0.05 * each, 20) for each in noise]
    >>> limit = alarm_limit(healthy)
    >>> limit.raises(gear_indicators(np.cos(20 * turn) + 0.05 * noise[0] + (turn < 0.1), 20))
    True

    """
    if not 0.0 < false_alarms < 1.0:
        refuse("false_alarms", false_alarms, "must be above 0 and below 1", "Give for example 0.02")
    least = math.ceil(1.0 / false_alarms - 1.0 - 1e-9)
    if len(healthy) < max(least, 3):
        rule = f"must be at least {max(least, 3)} for false alarms in {100.0 * false_alarms:g} %"
        refuse("healthy", f"{len(healthy)} records", rule, "Measure more, or allow more false alarms")
    counts = [each.turns for each in healthy if each.turns is not None]
    turns = float(np.median(counts)) if len(counts) == len(healthy) else None
    for k, each in enumerate(healthy):
        _check_turns(f"healthy.{k}", each, turns)
    values = np.array([_logarithms(f"healthy.{k}", each, WATCHED) for k, each in enumerate(healthy)])
    middle = np.median(values, axis=0)
    spread = np.maximum(1.4826 * np.median(np.abs(values - middle), axis=0), LEAST_SPREAD)
    scores = np.sort(np.max((values - middle) / spread, axis=1))
    place = min(math.ceil((len(healthy) + 1) * (1.0 - false_alarms) - 1e-9), len(healthy))
    return AlarmLimit(float(scores[place - 1]), false_alarms, len(healthy), middle, spread, turns=turns)


def _logarithms(at: str, indicators: GearIndicators, watched: Sequence[str]) -> Floats:
    """Return the logarithms of indicators, shape [indicator]."""
    values = np.array([getattr(indicators, name) for name in watched], dtype=np.float64)
    for name, value in zip(watched, values, strict=True):
        if not value > 0.0:
            rule = "must be above 0: the difference signal has no power"
            refuse(f"{at}.{name}", float(value), rule, "Give a record of a gear that runs")
    return np.log(values)


def _check_turns(at: str, indicators: GearIndicators, turns: float | None) -> None:
    """Refuse an average over other than 0.8 to 1.25 times as many turns as those of healthy records."""
    if turns is None or indicators.turns is None or 0.8 * turns <= indicators.turns <= 1.25 * turns:
        return
    rule = f"must be {0.8 * turns:.4g} to {1.25 * turns:.4g}, as the healthy records have: fewer turns leave more noise"
    refuse(f"{at}.turns", indicators.turns, rule, "Give records of one length")
