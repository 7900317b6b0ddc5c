"""Measurement chain: acceleration, sensor, anti-alias filter, counts, channel by channel."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel, Record
from gearplay.rig.instruments import (
    convert,
    keep_back_aliases,
    noise_voltage,
    sensor_voltage,
    thin_out,
)
from gearplay.rig.plan import Accelerometer, Collector, Rig, load_rig
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError

Floats = NDArray[np.float64]

LEAST_FACTOR: Final = 4
"""Fewest internal samples per sample of the collector: the ideal acceleration is thinned out from them."""

PER_BAND_EDGE: Final = 32
"""Least internal samples per period at a sensor's upper edge, where two reconstructions cost 16/45 (pi/32)^4 = 3e-5."""

PER_RESONANCE: Final = 16
"""Least internal samples per period of a sensor's resonance, where they cost 5e-4 of the response."""


def internal_factor(rig: Rig) -> int:
    """Return the oversampling factor over the collector's rate, for an error of the chain of at most 0.1 % in the band.

    >>> internal_factor(load_rig())  # 8 x 100 kHz = 32 x 25 kHz
    8
    >>> internal_factor(load_rig({"collector": {"sampling": "10 kHz"}}))  # 16 x 25 kHz / 10 kHz
    40
    """
    needed = [
        rate
        for sensor in rig.accelerometers.values()
        for rate in (
            PER_BAND_EDGE * sensor.upper_frequency,
            PER_RESONANCE * sensor.natural_frequency,
            *(PER_RESONANCE * mode.frequency for path in sensor.paths for mode in path.modes),
        )
    ]
    return max(8, math.ceil(max(needed) / rig.collector.sampling))


def apply_chain(
    acceleration: Floats | Mapping[str, Floats],
    sampling: float,
    rig: Rig | Mapping[str, object] | None = None,
    *,
    settling: float = 0.0,
    duration: float | None = None,
    start: float = 0.0,
    seed: int | Sequence[int] = 0,
    source: str = "",
    attributes: Mapping[str, str] | None = None,
) -> Record:
    """Return the record of given accelerations by the rig's sensors and data collector.

    Parameters
    ----------
    acceleration
        Mean acceleration [m/s^2] of each sampling interval, item k from k to k + 1 intervals after the start:
        increments of velocity give it exactly. Shape [time] along the axis, or [time, 2] along and across it; one
        array for all accelerometers, or one by name.
    sampling
        Rate of these samples [Hz]: a whole multiple, 4 or more, of the collector's. The error of the chain's magnitude at f
        is (16 / 45) (pi f / sampling)^4.
    rig
        As `load_rig` takes it.
    settling
        Time at the beginning [s] that the sensors feel but the collector does not record. They are at rest at first.
    duration
        Length of the record [s]; up to the end if not given.
    start
        Time of the record's first sample [s].
    seed
        Of the noise: one whole number or several. Each accelerometer has its own noise.
    source, attributes
        For the record.

    Returns
    -------
    Record
        For each accelerometer, by its name:

        ``<name>.acceleration`` [m/s^2]
            The true one along the axis, limited to the collector's band, without delay.
        ``<name>.voltage`` [V]
            At the converter, behind sensor and anti-alias filter, noise included.
        ``<name>.counts`` [count]
            Whole numbers, as floats.
        ``<name>.recorded`` [m/s^2]
            Counts times the converter's step over the nominal sensitivity.

    Raises
    ------
    InputError
        For a rate that is no such multiple, a record that is too short, and samples that are not finite.

    Examples
    --------
    >>> record = apply_chain(np.zeros(8000), 8e5, {"accelerometers": {"ring": {"noise_density": 0.0}}})
    >>> record.names, record.channel("ring.counts").values.size
    (('ring.acceleration', 'ring.voltage', 'ring.counts', 'ring.recorded'), 1000)

    """
    built = load_rig(rig)
    inputs = _inputs(acceleration, built)
    shortest = min(len(array) for array in inputs.values())
    kept = _kept(shortest, sampling, built.collector, settling=settling, duration=duration, start=start)
    seeds = _seeds(seed)
    channels: list[Channel] = []
    for place, (name, sensor) in enumerate(built.accelerometers.items()):
        generator = np.random.default_rng([*seeds, place])
        channels += _channels(name, sensor, built.collector, inputs[name], kept, start, generator)
    about = {
        "rig": json.dumps(built.resolved(), allow_nan=False),
        "rig_sha256": built.sha256,
        "seed": " ".join(str(number) for number in seeds),
        "internal_sampling": f"{sampling:g} Hz",
        **(attributes or {}),
    }
    return Record(tuple(channels), source, attributes=about)


def _channels(
    name: str,
    sensor: Accelerometer,
    collector: Collector,
    acceleration: Floats,
    kept: slice,
    start: float,
    generator: np.random.Generator,
) -> list[Channel]:
    """Return the four channels of one accelerometer; ``kept`` are the internal samples at which the collector samples."""
    rate, factor = collector.sampling, kept.step
    size = (kept.stop - kept.start) // factor
    along = acceleration if acceleration.ndim == 1 else acceleration[:, 0]
    sensed = along
    if acceleration.ndim == 2 and sensor.transverse_sensitivity > 0.0:
        sensed = along + sensor.transverse_sensitivity * acceleration[:, 1]
    fine, beyond = sensor_voltage(sensor, sensed, rate * factor)
    if collector.filter == "none":
        # Nothing limits the band of internal samples here, so noise that stands for the record's band goes in behind.
        voltage = fine[kept] + noise_voltage(sensor, size, rate, generator)
    else:
        noise = noise_voltage(sensor, fine.size, rate * factor, generator)
        voltage = keep_back_aliases(collector, fine + noise, rate * factor)[kept]
    counts, cut = convert(collector, voltage)
    recorded = counts * (collector.quantum / sensor.sensitivity)
    ideal = thin_out(along, factor)[kept.start // factor :][:size]
    about = {
        "sensor": sensor.kind,
        "sensitivity": f"{sensor.sensitivity:g} V/(m/s^2)",
        "quantum": f"{collector.quantum:.9g} V",
        **_clipped("sensor_saturated", beyond[kept.start : kept.stop], rate * factor, start),
        **_clipped("converter_clipped", cut, rate, start),
    }
    return [
        Channel(f"{name}.acceleration", ideal, rate, "m/s^2", start, about),
        Channel(f"{name}.voltage", voltage.copy(), rate, "V", start, about),
        Channel(f"{name}.counts", counts, rate, "count", start, about),
        Channel(f"{name}.recorded", recorded, rate, "m/s^2", start, about),
    ]


def _clipped(what: str, beyond: NDArray[np.bool_], sampling: float, start: float) -> dict[str, str]:
    """Return whether samples were cut off, their share and the time of the first, as attributes.

    >>> _clipped("cut", np.array([False, True, True, False]), 10.0, 2.0)
    {'cut': 'yes', 'cut_share': '0.5', 'cut_first': '2.1 s'}
    """
    first = f"{start + int(np.argmax(beyond)) / sampling:.9g} s" if np.any(beyond) else "never"
    share = float(np.mean(beyond))
    return {what: "yes" if share else "no", f"{what}_share": f"{share:.6g}", f"{what}_first": first}


def _inputs(acceleration: Floats | Mapping[str, Floats], rig: Rig) -> dict[str, Floats]:
    """Return an array for each accelerometer, checked."""
    inputs: dict[str, Floats] = {}
    faults: list[Fault] = []
    for name in rig.accelerometers:
        given = acceleration.get(name) if isinstance(acceleration, Mapping) else acceleration
        path = f"acceleration.{name}"
        if given is None:
            faults.append(Fault(path, NO_VALUE, "is required", "Give an array for every accelerometer"))
            continue
        array = np.asarray(given)
        shaped = array.ndim == 1 or (array.ndim == 2 and array.shape[1] == 2)
        if not shaped or array.dtype.kind not in "fiu":
            rule = "must be numbers of shape [time] or [time, 2]"
            faults.append(Fault(path, f"{array.dtype} {array.shape}", rule, "Transpose it or pick columns"))
        elif not np.all(np.isfinite(array)):
            rule = "must hold finite numbers only"
            faults.append(Fault(path, float("nan"), rule, "Remove or fill the gaps first"))
        else:
            inputs[name] = array.astype(np.float64, copy=False)
    if faults:
        raise InputError(faults)
    return inputs


def _kept(
    samples: int,
    sampling: float,
    collector: Collector,
    *,
    settling: float,
    duration: float | None,
    start: float,
) -> slice:
    """Return the indices of the internal samples at which the collector samples; the times are in s."""
    rate = collector.sampling
    factor = round(sampling / rate) if math.isfinite(sampling) else 0
    if factor < LEAST_FACTOR or abs(factor * rate - sampling) > 1e-9 * sampling:
        rule = f"must be a whole multiple, {LEAST_FACTOR} or more, of the collector's rate, {rate:g} Hz"
        raise InputError.of("sampling", sampling, rule, "Resample, or change collector.sampling")
    for name, value in (("settling", settling), ("duration", duration), ("start", start)):
        if value is not None and not (math.isfinite(value) and (value >= 0.0 or name == "start")):
            raise InputError.of(name, value, "must be a finite time, 0 s or more", "Give seconds")
    covered, first = samples // factor, round(settling * rate)
    size = covered - first if duration is None else round(duration * rate)
    if size < 1 or first + size > covered:
        rule = (
            f"must fit into the acceleration with at least one sample kept: it has {covered} at {rate:g} Hz"
        )
        named, value = ("settling", settling) if duration is None else ("duration", duration)
        raise InputError.of(named, value, rule, "Shorten it, or give a longer acceleration")
    return slice(first * factor, (first + size) * factor, factor)


def _seeds(seed: int | Sequence[int]) -> list[int]:
    numbers = [seed] if isinstance(seed, int) else list(seed)
    if not numbers or any(isinstance(n, bool) or not isinstance(n, int) or n < 0 for n in numbers):
        raise InputError.of("seed", seed, "must be a whole number, 0 or more", "Choose another")
    return numbers
