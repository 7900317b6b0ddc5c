"""What is written is read again: names, units, rates, starts and samples."""

import time
from pathlib import Path

import numpy as np
import pytest

from gearplay.files.measurements import FORMATS, read_measurement, write_record
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import InputError

RATE = 12800.0
SIZE = 300


def two_channels(start: float = 0.0) -> Record:
    values = np.round(np.random.default_rng(3).normal(size=(2, SIZE)), 6)
    first = Channel("acc", values[0], RATE, "m/s^2", start, {"sensor": "A 1"})
    return Record((first, Channel("force", values[1], RATE, "N", start)), "run", "simulated", {"rig": "one"})


@pytest.mark.parametrize("suffix", [".h5", ".nc", ".csv", ".wav", ".uff", ".mat"])
def test_written_records_are_read_again(suffix: str, tmp_path: Path) -> None:
    record, path = two_channels(start=0.25), tmp_path / f"run{suffix}"
    write_record(record, path)
    found = read_measurement(path)
    assert found.names == ("acc", "force")
    assert found.source == f"run{suffix}"
    assert suffix in FORMATS[found.format].suffixes
    for one, other in zip(found.channels, record.channels, strict=True):
        assert (one.unit, one.sampling) == (other.unit, other.sampling)
        assert one.start == pytest.approx(0.25, abs=1e-15)
        # UFF writes 13 digits
        np.testing.assert_allclose(one.values, other.values, rtol=1e-12 if suffix == ".uff" else 0, atol=0)
    if suffix in (".h5", ".nc"):
        assert dict(found.channel("acc").attributes) == {"sensor": "A 1"}
        assert dict(found.attributes) == {"rig": "one"}


@pytest.mark.slow
def test_a_record_gives_the_same_bytes_at_any_hour(tmp_path: Path) -> None:
    suffixes = (".h5", ".nc", ".csv", ".wav", ".uff", ".mat")

    def write(name: str) -> dict[str, bytes]:
        for suffix in suffixes:
            write_record(two_channels(), tmp_path / f"{name}{suffix}")
        return {suffix: (tmp_path / f"{name}{suffix}").read_bytes() for suffix in suffixes}

    first = write("first")
    time.sleep(1.1)  # a heading with the hour has seconds in it
    second = write("second")
    assert {suffix for suffix in suffixes if first[suffix] != second[suffix]} == set()


@pytest.mark.parametrize("suffix", [".h5", ".nc", ".mat", ".uff"])
def test_channels_may_differ_in_length_rate_and_start(suffix: str, tmp_path: Path) -> None:
    odd = Record((Channel("speed 1", np.arange(5.0), 10.0, "rad/s", 1.0), *two_channels().channels))
    write_record(odd, tmp_path / f"odd{suffix}")
    found = read_measurement(tmp_path / f"odd{suffix}")
    assert [(c.name, c.values.size, c.sampling, c.start) for c in found.channels] == [
        ("speed 1", 5, 10.0, 1.0),
        ("acc", SIZE, RATE, 0.0),
        ("force", SIZE, RATE, 0.0),
    ]


@pytest.mark.parametrize("suffix", [".h5", ".nc"])
def test_long_records_are_packed_with_checksums(suffix: str, tmp_path: Path) -> None:
    long = Record(
        (Channel("acc/x [1]", np.sin(np.arange(20_000.0)), 1e4, "g"), Channel("time", np.arange(3.0), 1.0))
    )
    write_record(long, tmp_path / f"long{suffix}")
    found = read_measurement(tmp_path / f"long{suffix}")
    assert found.names == ("acc/x [1]", "time")
    np.testing.assert_array_equal(found.channels[0].values, long.channels[0].values)


@pytest.mark.parametrize(
    ("name", "record", "words"),
    [
        ("run.xyz", two_channels(), "must end in one of .h5"),
        ("run.tdms", two_channels(), "must end in one of"),
        ("run.h5", Record(()), "at least one channel"),
        ("run.csv", Record((*two_channels().channels, Channel("x", np.zeros(3), 1.0))), "one length"),
        ("run.wav", Record((Channel("x", np.zeros(3), 0.5),)), "whole hertz"),
        ("run.uff", Record((Channel("x", np.zeros(1), 1.0),)), "2 samples"),
    ],
)
def test_unwritable_output__is_refused_and_leaves_no_file(
    name: str, record: Record, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        write_record(record, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_write_record__an_existing_file_is_kept_without_overwrite(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_record(two_channels(), path)
    with pytest.raises(InputError, match="must not exist yet"):
        write_record(two_channels(), path)
    write_record(two_channels(start=2.0), path, overwrite=True)
    assert read_measurement(path).channels[0].start == 2.0
