"""The rig's chain against closed forms: frequency response, quantisation, noise; a simulated record in its band."""

import math

import numpy as np
import pytest

from building import Floats, Measured
from gearplay.model.reading import load_case
from gearplay.rig import apply_chain, measure
from gearplay.rig.chain import internal_factor
from gearplay.rig.instruments import butterworth, sensor_response
from gearplay.rig.plan import Accelerometer, Collector, Rig, load_rig

QUIET = {"noise_density": 0.0}
FINE = {"bits": 32, "range": "10 V"}  # steps of 5 nV: far below anything that is looked at


def chain_response(sensor: Accelerometer, collector: Collector, frequency: Floats) -> np.ndarray:
    """Return the analytic response of sensor and filter, recorded over true acceleration, at each frequency [Hz]."""
    response = sensor_response(sensor, frequency)
    if collector.filter == "none":
        return response
    return response * butterworth(collector.filter_order, collector.corner).response(frequency)


def tones(frequencies: list[float], amplitudes: list[float], size: int, sampling: float) -> Floats:
    """Return the exact means over each interval of a sum of cosines, from the increments of its integral."""
    t = np.arange(size + 1) / sampling
    total = np.zeros(size)
    for frequency, amplitude in zip(frequencies, amplitudes, strict=True):
        w = math.tau * frequency
        total += amplitude * sampling / w * np.diff(np.sin(w * t))
    return total


def lines(signal: Floats, frequencies: list[float], sampling: float) -> Floats:
    """Return the complex amplitudes of tones that fit the record a whole number of times."""
    bins = [round(frequency * signal.size / sampling) for frequency in frequencies]
    return np.asarray(2.0 * np.fft.rfft(signal)[bins] / signal.size)


def recorded_over_true(rig: Rig, frequencies: list[float], settling: float, duration: float) -> Floats:
    """Measure the chain's complex response with all tones at once, 10 m/s^2 each."""
    rate = rig.collector.sampling
    fast = rate * internal_factor(rig)
    means = tones(frequencies, [10.0] * len(frequencies), round((settling + duration) * fast), fast)
    record = apply_chain(means, fast, rig, settling=settling)
    phase = np.exp(-1j * math.tau * np.array(frequencies) * settling)
    return np.asarray(lines(record.channel("a.recorded").values, frequencies, rate) * phase / 10.0)


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize(
    ("sensor", "collector", "edges"),
    [
        ({}, {}, (1.0, 5e3)),
        ({"kind": "352C33"}, {"sampling": "51.2 kHz", "filter_order": 4}, (0.5, 10e3)),
        ({}, {"filter": "none"}, (1.0, 5e3)),
        ({"damping_ratio": 0.7, "resonance": "9 kHz"}, {"sampling": "20 kHz"}, (1.0, 5e3)),
    ],
)
def test_rig_tones__equal_the_analytic_response(
    sensor: dict[str, object], collector: dict[str, object], edges: tuple[float, float], measured: Measured
) -> None:
    """Magnitude to 0.1 % and phase to 1 mrad from the lower to the upper edge of the sensor's band."""
    rig = load_rig({"accelerometers": {"a": {**QUIET, **sensor}}, "collector": {**FINE, **collector}})
    low, high = edges
    inside = [low, 2.0, 5.0, 20.0, 100.0, 500.0, 1e3, 2e3, 3e3, 4e3, 0.9 * high, high]
    found = recorded_over_true(rig, inside, 5.0 / low, 2.0 / low)  # 10 time constants of the coupling
    wanted = chain_response(rig.accelerometers["a"], rig.collector, np.array(inside))
    error = float(np.max(np.abs(np.abs(found) / np.abs(wanted) - 1.0)))
    measured("response of the measurement chain in the sensor's band, relative", error, "1e-3")
    assert error < 1e-3
    assert np.max(np.abs(np.angle(found / wanted))) < 1e-3


def test_stop_band__attenuation_equals_the_analytic_response(measured: Measured) -> None:
    """Tones past the corner, those above half the rate as aliases: to 1e-3 of a tone within the band."""
    rig = load_rig({"accelerometers": {"a": QUIET}, "collector": FINE})
    worst = 0.0
    for frequency in (41e3, 49e3, 53e3, 57e3, 63e3, 69e3, 82e3, 130e3):
        fast = 1e5 * internal_factor(rig)
        means = tones([frequency], [10.0], round(0.12 * fast), fast)
        record = apply_chain(means, fast, rig, settling=0.02).channel("a.recorded").values
        alias = abs(frequency - 1e5 * round(frequency / 1e5))
        found = abs(lines(record, [alias], 1e5)[0]) / 10.0
        wanted = abs(chain_response(rig.accelerometers["a"], rig.collector, np.array([frequency]))[0])
        worst = max(worst, abs(found - wanted))
    measured("response of the measurement chain in the stop band, absolute", worst, "1e-3")
    assert worst < 1e-3


def test_rig_impulse__equals_the_analytic_response() -> None:
    """The transform of the response to one interval of acceleration is H(f) over the whole band, past the resonance."""
    rig = load_rig({"accelerometers": {"a": {**QUIET, "lower_frequency": "100 Hz"}}, "collector": {**FINE}})
    fast = 1e5 * 64
    means = np.zeros(64 * 10_000)
    means[64 * 10 : 64 * 11] = 1e3  # one collector interval: its transform is a sinc, known
    record = apply_chain(means, fast, rig)
    f = np.fft.rfftfreq(10_000, 1e-5)[1:-1]
    pulse = 1e3 * 1e-5 * np.sinc(f * 1e-5) * np.exp(-2j * np.pi * f * 10.5e-5)
    found = np.fft.rfft(record.channel("a.recorded").values)[1:-1] * 1e-5 / pulse
    wanted = chain_response(rig.accelerometers["a"], rig.collector, f)
    below = f < 20e3  # beyond, what folds back from above 80 kHz adds up to 2 %
    assert np.max(np.abs(found - wanted)[below]) < 2e-3


def test_quantisation_error_has_the_variance_of_a_uniform_one(measured: Measured) -> None:
    """q^2 / 12 for a signal of many steps (Widrow), within five standard errors of 10^5 samples."""
    generator = np.random.default_rng(5)
    means = np.repeat(generator.normal(0.0, 100.0, 100_000), 8)
    rig = load_rig({"accelerometers": {"a": QUIET}, "collector": {"bits": 12}})
    record = apply_chain(means, 8e5, rig)
    error = record.channel("a.counts").values - record.channel("a.voltage").values / rig.collector.quantum
    ratio = float(np.var(error)) * 12.0
    measured("variance of the quantisation error over q^2/12, minus 1", abs(ratio - 1.0), "1.4e-2")
    assert np.max(np.abs(error)) <= 0.5 + 1e-9
    assert abs(ratio - 1.0) < 5.0 * math.sqrt(0.8 / 100_000)  # var(e^2) = (1/80 - 1/144) q^4
    assert abs(np.mean(error)) < 5.0 / math.sqrt(12.0 * 100_000)


@pytest.mark.parametrize("kind", ["butterworth", "none"])
@pytest.mark.parametrize("sensor", [{"noise_density": "2e-4 m/s^2/Hz^0.5"}, {"resolution": "0.02 m/s^2"}])
def test_noise_has_the_density_that_is_stated(kind: str, sensor: dict[str, str], measured: Measured) -> None:
    """Power of the record from 100 Hz to 30 kHz over its bandwidth, within five standard errors."""
    rig = load_rig({"accelerometers": {"a": sensor}, "collector": {**FINE, "filter": kind}})
    size = 200_000
    record = apply_chain(np.zeros(size * 8), 8e5, rig, seed=11).channel("a.recorded").values
    power = np.abs(np.fft.rfft(record)) ** 2 * 2.0 / (size * 1e5)  # one-sided density, (m/s^2)^2/Hz
    f = np.fft.rfftfreq(size, 1e-5)
    band = (f > 100.0) & (f < 30e3)
    stated = 2e-4 if "noise_density" in sensor else 0.02 / math.sqrt(9999.0)
    ratio = float(np.mean(power[band])) / stated**2
    measured("power density of the noise over the stated one, minus 1", abs(ratio - 1.0), "2.1e-2")
    limit = 5.0 / math.sqrt(np.count_nonzero(band)) + 2e-3  # periodogram values vary by their mean
    assert abs(ratio - 1.0) < limit


@pytest.fixture(scope="module")
def fine_record() -> tuple[Rig, dict[str, Floats], float]:
    """Record, with a converter that shows small motion (fine steps, no noise), the the article's rig."""
    rig = load_rig({"accelerometers": {"a": QUIET}, "collector": FINE})
    record = measure(load_case("han2021"), rig, duration=0.5, transient=0.5)
    named = {which: record.channel(f"a.{which}").values for which in ("acceleration", "recorded", "voltage")}
    return rig, named, record.channels[0].start


def test_a_simulated_record_is_the_ideal_acceleration_seen_through_the_response(
    fine_record: tuple[Rig, dict[str, Floats], float], measured: Measured
) -> None:
    """In 20 Hz .. 5 kHz, windowed: recorded - H(f) ideal is below 0.1 % of the ideal, rms."""
    rig, record, start = fine_record
    assert start == 0.5
    window = np.hanning(record["recorded"].size)
    ideal, recorded = (np.fft.rfft(record[which] * window) for which in ("acceleration", "recorded"))
    f = np.fft.rfftfreq(window.size, 1e-5)
    band = (f >= 20.0) & (f <= 5e3)
    through = ideal * chain_response(rig.accelerometers["a"], rig.collector, f)
    error = np.linalg.norm((recorded - through)[band]) / np.linalg.norm(ideal[band])
    measured("simulated record against ideal acceleration through the response, rms", float(error), "1e-3")
    assert np.linalg.norm(ideal[band]) > 0.0
    assert error < 1e-3
    plain = np.linalg.norm((np.abs(recorded) - np.abs(ideal))[band]) / np.linalg.norm(ideal[band])
    assert plain < 0.05  # what the sensor's data sheet promises


def test_the_articles_rig_differs_by_its_noise_and_steps_only(measured: Measured) -> None:
    """With the default collector the record adds noise and steps: in band their power, no more."""
    case = load_case("han2021")
    rough = measure(case, duration=0.5, seed=2)
    exact = measure(case, {"accelerometers": {"sensor": QUIET}, "collector": FINE}, duration=0.5)
    name = "sensor.acceleration"
    assert np.array_equal(rough.channel(name).values, exact.channel(name).values)
    added = rough.channel("sensor.recorded").values - exact.channel("sensor.recorded").values
    step = load_rig().collector.quantum / 1.02e-3
    assert np.max(np.abs(added)) < 0.5 * step + 6.0 * 5e-3 * math.sqrt(5.0)
    measured(
        "rms of what noise and converter add to a simulated record [m/s^2]", float(np.std(added)), "0.06"
    )
    assert np.std(added) < math.hypot(step / math.sqrt(12.0), 5e-3 * math.sqrt(5.0)) * 1.1


def test_a_record_repeats_for_a_seed_and_differs_for_another_and_another_member() -> None:
    case = load_case("han2021")
    fast = {"collector": {"bits": 24}}
    first, again, other = (measure(case, fast, duration=0.05, transient=0.05, seed=s) for s in (1, 1, 2))
    member = measure(case, fast, duration=0.05, transient=0.05, seed=1, member=1)
    for channel, same, changed in zip(first.channels, again.channels, other.channels, strict=True):
        assert np.array_equal(channel.values, same.values)
        assert np.array_equal(channel.values, changed.values) == channel.name.endswith("acceleration")
    assert first.attributes == again.attributes
    assert first.attributes["case_sha256"] == case.sha256
    assert first.attributes["case_title"] == case.title
    assert not np.array_equal(first.channels[0].values, member.channels[0].values)
