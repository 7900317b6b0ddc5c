"""Time-synchronous average over the turns of a shaft, and the residual share."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.signals.angle import ShaftAngle
from gearplay.signals.checks import TWO_PI, check_count, refuse
from gearplay.signals.resampling import resampled

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SynchronousAverage:
    """Mean of a signal over turns of a shaft.

    ``angle`` [rad] and ``average``, ``error`` [unit] have shape [sample]; ``error`` is the standard error of the average,
    the deviation between periods over the root of their number. ``residual_rms`` [unit] is the rms of what the average
    leaves, ``residual_share`` its share of the mean square about the mean. A period is ``period`` revolutions.
    """

    angle: Floats
    average: Floats
    error: Floats
    periods: int
    period: int
    residual_rms: float
    residual_share: float
    unit: str
    source: str
    name: str = ""

    @property
    def caption(self) -> str:
        """The settings in one line."""
        turns = "1 revolution" if self.period == 1 else f"{self.period} revolutions"
        return (
            f"mean of {self.periods} periods of {turns}, {self.angle.size} samples, "
            f"residual {100.0 * self.residual_share:.3g} % of the mean square; {self.source}"
        )


def synchronous_average(
    channel: Channel,
    speed: float | Channel | ShaftAngle,
    *,
    period: int = 1,
    highest: float | None = None,
    samples_per_revolution: int | None = None,
) -> SynchronousAverage:
    """Return the average over periods of ``period`` whole turns, each starting at angle zero of the shaft.

    Noise, and what keeps no fixed phase to the shaft, falls with the root of the number n of periods; of white noise the
    residual holds the share 1 - 1/n. A gear pair repeats after the other gear's teeth over their greatest common divisor.

    Source: McFadden, Mech. Syst. Signal Process. 1 (1987) 83. ``speed`` and the other arguments as `resampled`.

    Parameters
    ----------
    channel
        Signal, shape [time].
    speed
        Of the shaft: a constant [rad/s], a speed channel, or a `ShaftAngle`.
    period
        Whole revolutions of a period.
    highest
        Highest order; as far as the sampling allows if not given.
    samples_per_revolution
        As `resampled` takes it.

    Returns
    -------
    SynchronousAverage
        ``average`` [unit] over ``angle`` [rad] with its standard error.

    Raises
    ------
    InputError
        For a speed that is not positive, or fewer than two periods.

    Examples
    --------
    >>> c = Channel("acc", np.cos(2.0 * np.pi * 30.0 * np.arange(4001) / 1000.0), 1000.0, "m/s^2")
    >>> tsa = synchronous_average(c, 2.0 * np.pi * 10.0)
    >>> tsa.periods, round(float(tsa.average[0]), 3), tsa.residual_share < 1e-3
    (40, 1.0, True)

    """
    check_count("period", period, 1, 100_000, "Give the revolutions after which the signal repeats")
    record = resampled(channel, speed, highest=highest, samples_per_revolution=samples_per_revolution)
    per = record.samples_per_revolution * period
    skipped = -record.first % per
    periods = (record.values.size - skipped) // per
    if periods < 2:
        rule = f"must make at least 2 periods of {period} whole revolutions"
        refuse("speed", f"{record.revolutions:.4g} revolutions", rule, "Take a longer record")
    table = record.values[skipped : skipped + periods * per].reshape(periods, per)
    average = np.mean(table, axis=0)
    left = float(np.mean((table - average) ** 2))
    held = float(np.var(table))
    return SynchronousAverage(
        TWO_PI / record.samples_per_revolution * np.arange(per, dtype=np.float64), average,
        np.std(table, axis=0, ddof=1) / math.sqrt(periods), int(periods), period, math.sqrt(left),
        left / held if held > 0.0 else 0.0, channel.unit, record.source, channel.name,
    )  # fmt: skip
