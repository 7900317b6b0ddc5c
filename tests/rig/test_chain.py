"""The chain's own accounts: channels, saturation, quantisation, noise, refusals."""

import math
from typing import Any

import numpy as np
import pytest

from gearplay.files.record import Record
from gearplay.rig.chain import apply_chain, internal_factor
from gearplay.rig.instruments import convert, thin_out
from gearplay.rig.plan import Collector, load_rig
from gearplay.vocabulary.errors import InputError

FAST = 8e5  # Hz, internal rate of the default rig
QUIET: dict[str, Any] = {"noise_density": 0.0}


def rig_of(sensor: dict[str, Any] | None = None, **collector: Any) -> dict[str, Any]:
    return {"accelerometers": {"a": QUIET if sensor is None else sensor}, "collector": collector}


def tone_means(frequency: float, amplitude: float, size: int, sampling: float = FAST) -> np.ndarray:
    """Means of ``amplitude cos(2 pi f t)`` over each interval."""
    w = math.tau * frequency
    return amplitude * sampling / w * np.diff(np.sin(w * np.arange(size + 1) / sampling))


def values(record: Record, which: str, name: str = "a") -> np.ndarray:
    return record.channel(f"{name}.{which}").values


def test_channels_and_their_units() -> None:
    record = apply_chain(tone_means(1e3, 100.0, 16000), FAST, rig_of(), start=0.5, source="tone")
    assert [(c.name, c.unit) for c in record.channels] == [
        ("a.acceleration", "m/s^2"), ("a.voltage", "V"), ("a.counts", "count"), ("a.recorded", "m/s^2"),
    ]  # fmt: skip
    assert record.source == "tone"
    assert {c.values.size for c in record.channels} == {2000}
    assert {c.start for c in record.channels} == {0.5}
    counts, recorded = values(record, "counts"), values(record, "recorded")
    assert np.array_equal(counts, np.rint(counts))
    assert np.allclose(recorded, counts * (10.0 / 2**16) / 1.02e-3, rtol=1e-14)
    assert (
        load_rig(__import__("json").loads(record.attributes["rig"])).sha256 == record.attributes["rig_sha256"]
    )


def test_the_ideal_channel_is_the_acceleration_at_the_sampling_instants() -> None:
    t = np.arange(2000) / 1e5
    for frequency in (200.0, 5e3, 20e3, 36e3):
        found = thin_out(tone_means(frequency, 1.0, 16000), 8)
        error = found - np.cos(math.tau * frequency * t)
        assert np.max(np.abs(error[20:-20])) < 4e-3 * max(0.1, (frequency / 36e3) ** 2), frequency
    assert np.max(np.abs(thin_out(tone_means(70e3, 1.0, 16000), 8)[20:-20])) < 2e-4


@pytest.mark.parametrize("factor", [4, 5, 7, 8, 13])
def test_the_ideal_channel_has_no_delay_whatever_the_factor(factor: int) -> None:
    t = np.arange(400) / 1e5
    found = thin_out(tone_means(3e3, 1.0, 400 * factor, 1e5 * factor), factor)
    assert found.size == 400
    assert np.max(np.abs(found - np.cos(math.tau * 3e3 * t))[20:-20]) < 2e-3


@pytest.mark.parametrize(("peak", "flag"), [(4899.0, "no"), (4901.0, "yes")])
def test_saturation_is_flagged_exactly_when_the_range_is_exceeded(peak: float, flag: str) -> None:
    """A tone of 200 Hz, where the response is known to 1e-7: the recorded span peaks just below or above the range."""
    from gearplay.rig.instruments import sensor_response

    rig = load_rig(rig_of(range="10 V"))
    gain = float(np.abs(sensor_response(rig.accelerometers["a"], np.array([200.0])))[0])
    means = tone_means(200.0, peak / gain, 160_000)
    record = apply_chain(means, FAST, rig, settling=0.1)
    about = record.channel("a.counts").attributes
    assert about["sensor_saturated"] == flag
    assert about["converter_clipped"] == "no"
    if flag == "no":
        assert about["sensor_saturated_share"] == "0"
        assert about["sensor_saturated_first"] == "never"
    else:
        # A cosine is above 4900 / 4901 of its peak for 2 acos(4900 / 4901) of each half period.
        expected = 2.0 * math.acos(4900.0 / 4901.0) / math.pi
        assert float(about["sensor_saturated_share"]) == pytest.approx(expected, rel=0.03)
        first = float(about["sensor_saturated_first"].removesuffix(" s"))
        assert 0.0 <= first < 1.0 / 400.0


def test_a_saturated_sensor_gives_its_limit() -> None:
    record = apply_chain(
        tone_means(100.0, 2e4, 32000), FAST, rig_of(range="10 V", filter="none"), settling=0.01
    )
    assert np.max(np.abs(values(record, "voltage"))) == 1.02e-3 * 4900.0
    assert np.max(np.abs(values(record, "acceleration"))) > 1.9e4


def test_converter__clips_and_marks_samples_out_of_range() -> None:
    record = apply_chain(tone_means(100.0, 1000.0, 32000), FAST, rig_of(range="0.5 V", bits=8), start=2.0)
    counts, voltage = values(record, "counts"), values(record, "voltage")
    about = record.channel("a.counts").attributes
    assert (counts.min(), counts.max()) == (-128.0, 127.0)
    beyond = np.abs(voltage + 0.5 * 0.5 / 128) > 0.5  # half a step more below than above
    assert float(about["converter_clipped_share"]) == pytest.approx(np.mean(beyond), rel=1e-5)
    assert float(about["converter_clipped_first"][:-2]) == pytest.approx(2.0 + np.argmax(beyond) / 1e5)
    assert about["sensor_saturated"] == "no"


def test_counts_and_their_limits() -> None:
    collector = Collector(range=1.0, bits=4)  # steps of 0.125 V
    counts, beyond = convert(collector, np.array([-1.07, -1.05, -0.99, 0.0, 0.06, 0.07, 0.93, 0.94]))
    assert counts.tolist() == [-8.0, -8.0, -8.0, 0.0, 0.0, 1.0, 7.0, 7.0]
    assert beyond.tolist() == [True, False, False, False, False, False, False, True]


def test_each_sensor_has_its_own_noise_and_a_seed_repeats_it() -> None:
    rig = {"accelerometers": {"a": {}, "b": {}}, "collector": {"bits": 24}}
    records = [apply_chain(np.zeros(16000), FAST, rig, seed=seed) for seed in (3, 3, 4, [3, 1])]
    same, again, *others = (values(record, "counts") for record in records)
    assert np.array_equal(same, again)
    for other in (*others, values(records[0], "counts", "b")):
        assert abs(np.corrcoef(same, other)[0, 1]) < 0.1


def test_transverse_acceleration_leaks_by_its_share() -> None:
    across = np.column_stack((np.zeros(32000), tone_means(500.0, 100.0, 32000)))
    along = across[:, ::-1].copy()
    rig = rig_of({**QUIET, "transverse_sensitivity": "3 %"}, bits=32)
    leaked, direct = (values(apply_chain(a, FAST, rig), "voltage") for a in (across, along))
    assert np.allclose(leaked, 0.03 * direct, rtol=1e-9, atol=1e-15)
    assert np.all(values(apply_chain(across, FAST, rig), "acceleration") == 0.0)
    assert np.all(values(apply_chain(across, FAST, rig_of()), "voltage") == 0.0)


def test_settling_and_duration_cut_the_same_signal() -> None:
    means = tone_means(300.0, 50.0, 80_000)
    whole = values(apply_chain(means, FAST, rig_of()), "voltage")
    part = apply_chain(means, FAST, rig_of(), settling=0.02, duration=0.05, start=1.0)
    assert np.array_equal(values(part, "voltage"), whole[2000:7000])
    assert part.channels[0].start == 1.0


def test_internal_rate_follows_the_fastest_sensor() -> None:
    fast = {"accelerometers": {"a": {}, "b": {"kind": "352C33"}}}
    assert internal_factor(load_rig(fast)) == 8  # 16 samples per period of 50 kHz
    slow = {"collector": {"sampling": "4 kHz"}}
    assert internal_factor(load_rig(slow)) == 100  # 16 samples per period of 25 kHz
    own = {"kind": "own", "sensitivity": 0.01, "range": 500.0, "lower_frequency": 1.0, "upper_frequency": 1e3}
    assert internal_factor(load_rig({"accelerometers": {"a": {**own, "resonance": 2e5}}})) == 32


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"sampling": 1e5}, "sampling = 100000.0: must be a whole multiple, 4 or more, of the collector's rate, 100000 Hz."),
        ({"sampling": 8.5e5}, "sampling = 850000.0: must be a whole multiple"),
        ({"sampling": math.nan}, "sampling = nan: must be a whole multiple"),
        ({"settling": -1.0}, "settling = -1.0: must be a finite time, 0 s or more. Give seconds."),
        ({"settling": 0.02}, "settling = 0.02: must fit into the acceleration with at least one sample kept"),
        ({"duration": 0.02}, "duration = 0.02: must fit into the acceleration"),
        ({"duration": 0.0}, "duration = 0.0: must fit into the acceleration"),
        ({"start": math.inf}, "start = inf: must be a finite time"),
        ({"seed": -1}, "seed = -1: must be a whole number, 0 or more. Choose another."),
        ({"acceleration": {}}, "acceleration.a: is required. Give an array for every accelerometer."),
        ({"acceleration": np.zeros((3, 8000))}, 'acceleration.a = "float64 (3, 8000)": must be numbers of shape'),
        ({"acceleration": np.array(["x"] * 8000)}, "must be numbers of shape [time] or [time, 2]"),
        ({"acceleration": np.full(8000, np.nan)}, "acceleration.a = nan: must hold finite numbers only."),
        ({"rig": {"collector": {"bits": 0}}}, "collector.bits = 0: must be 2 or more."),
    ],
)  # fmt: skip
def test_bad_input_is_refused_in_one_sentence(arguments: dict[str, Any], says: str) -> None:
    given = {"acceleration": np.zeros(8000), "sampling": FAST, "rig": rig_of(), **arguments}
    positional = [given.pop(name) for name in ("acceleration", "sampling", "rig")]
    with pytest.raises(InputError) as caught:
        apply_chain(*positional, **given)
    assert says in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1
