"""Damaged binary measurement files: the message for each kind of damage."""

import struct
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from gearplay.files import sandbox
from gearplay.files.measurements import hdf5, read_measurement, tdms, write_record
from gearplay.files.measurements.building import Request
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import MeasurementError
from hostile.test_damaged_measurements import (
    write_binary_uff,
    write_integer_wav,
    write_mdf4,
    write_plain_hdf5,
    write_tdms,
)

pytestmark = pytest.mark.hostile

Change = Callable[[bytes], bytes]
RECORD = Record(
    (
        Channel("acc", np.random.default_rng(1).normal(size=300), 12800.0, "m/s^2"),
        Channel("force", np.ones(300), 12800.0, "N"),
    )
)


def put(place: int, layout: str, *values: object) -> Change:
    def change(content: bytes) -> bytes:
        piece = struct.pack(layout, *values)
        return content[:place] + piece + content[place + len(piece) :]

    return change


def swap(old: bytes, new: bytes, count: int = 1) -> Change:
    def change(content: bytes) -> bytes:
        assert old in content
        return content.replace(old, new, count)

    return change


def after(mark: bytes, offset: int, layout: str, *values: object) -> Change:
    return lambda content: put(content.index(mark) + offset, layout, *values)(content)


def cut(length: int) -> Change:
    return lambda content: content[:length]


LIBRARY = r"must be a readable \w|crashes on it or does not return|of memory to read it|declares \d+|declares more numbers"
"""A library refuses the file, crashes, hangs or asks for too much."""


def refused(path: Path, change: Change, words: str = LIBRARY) -> None:
    read_measurement(path)  # sound before
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(MeasurementError, match=words) as caught:
        read_measurement(path)
    assert str(caught.value).startswith(f"{path.name}: ")
    assert str(caught.value).isprintable()
    assert caught.value.exit_code == 6


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sandbox, "TIME_LIMIT", 5.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (cut(-100), r"declares 1244 bytes in its RIFF header and holds 1144"),
        (lambda c: c + bytes(2), r"declares 1244 bytes in its RIFF header and holds 1246"),
        (cut(10), "must start as RIFF/WAVE"),
        (swap(b"RIFF", b"RF64"), "must start as RIFF/WAVE"),
        (after(b"data", 4, "<I", 2**32 - 1), r"chunk 'data' declares 4294967295 bytes"),
        (after(b"data", 4, "<I", 0), r"chunk .* declares \d+ bytes"),
        (put(20, "<H", 2), "ADPCM"),
        (put(22, "<H", 3), "contradicts itself: 3 channels|readable WAV"),
    ],
)
def test_wav(change: Change, words: str, tmp_path: Path) -> None:
    write_integer_wav(tmp_path / "run.wav", RECORD)
    refused(tmp_path / "run.wav", change, words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (after(b"fact", 8, "<I", 301), "declares 301 samples a channel and holds 300"),
        (swap(b'"names"', b'"nam3s"'), "chunk of channel names"),
        (swap(b'["acc", "force"]', b'["acc,  force" ]'), "names 1 channels and holds 2"),
    ],
)
def test_our_wav(change: Change, words: str, tmp_path: Path) -> None:
    write_record(RECORD, tmp_path / "run.wav")
    refused(tmp_path / "run.wav", change, words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (cut(-100), r"segment 2 declares to end at byte \d+, the file has"),
        (cut(20), "segment 1 must begin with a lead-in of 28 bytes"),
        (lambda content: content + b"TDSx" + bytes(30), "segment 3 must begin with a lead-in"),
        (lambda content: content + b"TDSm", "segment 3 must begin with a lead-in"),
        (put(12, "<Q", 2**64 - 1), "segment 1 was never finished"),
        (put(4, "<I", 0xFFFF), "segment 1 declares to end"),
        (put(8, "<I", 1), "Unrecognised version"),
        (after(b"/'rig'/'acc'", 24, "<Q", 2**40), "not a multiple of the chunk size"),
        (
            swap(struct.pack("<d", 1 / 12800.0), struct.pack("<d", -1.0), -1),
            "positive sampling rate, wf_increment",
        ),
    ],
)
def test_tdms(change: Change, words: str, tmp_path: Path) -> None:
    write_tdms(tmp_path / "run.tdms", RECORD)
    refused(tmp_path / "run.tdms", change, words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (cut(40), "identification of 64 bytes, 40 found"),
        (swap(b"MDF     ", b"UnFinMF "), "never finalised"),
        (put(60, "<H", 1), "never finalised"),
        (swap(b"4.10", b"3.30"), "must be MDF 4, version '3.30'"),
        (after(b"##CG", 80, "<Q", 2**40), "declares 26388279066624 bytes of records"),
        (after(b"##CG", 80, "<Q", 299), "declares 7176 bytes of records and holds 7200"),
        (after(b"##CG", 80, "<Q", 301), "declares 7224 bytes of records and holds 7200"),
        (swap(b"##DT", b"##XX"), "declares 300 samples and holds 0"),
    ],
)
def test_mdf4(change: Change, words: str, tmp_path: Path) -> None:
    write_mdf4(tmp_path / "run.mf4", RECORD)
    refused(tmp_path / "run.mf4", change, words)


def test_segments_of_tdms_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.tdms"
    write_tdms(path, RECORD)
    with path.open("ab") as file:
        file.write(3 * (b"TDSm" + struct.pack("<IIQQ", 0, 4713, 0, 0)))
    monkeypatch.setattr(tdms, "MOST_NODES", 4)
    with pytest.raises(MeasurementError, match="more than 4 segments"):
        tdms.read(Request(path, path.stat().st_size))


def test_mdf4_invalid_samples_are_counted(tmp_path: Path) -> None:
    from asammdf import MDF, Signal

    path, marks = tmp_path / "run.mf4", np.array([False, True, False, True])
    file = MDF(version="4.10")
    file.append([Signal(np.arange(4.0), np.arange(4.0), name="acc", invalidation_bits=marks)])
    file.save(path)
    file.close()
    with pytest.raises(MeasurementError, match="'acc' marks 2 of 4 samples as invalid"):
        read_measurement(path)


@pytest.mark.slow
def test_mdf4_formulas_are_left_out(tmp_path: Path) -> None:
    from asammdf import MDF, Signal

    path, time = tmp_path / "run.mf4", np.arange(5) / 10.0
    rules = {"plain": None, "formula": {"formula": "X1 * 3"}}
    file = MDF(version="4.10")
    file.append([Signal(np.arange(5.0), time, name=name, conversion=rule) for name, rule in rules.items()])
    file.save(path)
    file.close()
    found = read_measurement(path)
    assert (found.names, found.attributes["left out"]) == (("plain",), "formula")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (cut(-1000), "must enclose each data set in marks -1"),
        (cut(-6), "must enclose each data set in marks -1"),
        (lambda c: c[: c.index(b"\n    -1") + 8], "declares 2 channels and holds 1"),
        (lambda c: c + b"rubbish\n", "must enclose each data set in marks -1"),
        (swap(b"         4       300", b"         9       300"), "declares 2 channels and holds 1"),
        (swap(b"  7.81250e-05", b"  0.00000e+00"), "positive time increment"),
        (after(b"0.00000e+00\n", 400, "<14s", b"    -1\n    -1\n"), "5 marks of 3 data sets"),
    ],
)
def test_binary_uff(change: Change, words: str, tmp_path: Path) -> None:
    write_binary_uff(tmp_path / "run.uff", RECORD)
    refused(tmp_path / "run.uff", change, words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c[:2000] + c[2081:], "data set 1 declares 300 ordinates and holds 29"),
        (swap(b"       300", b"       301"), "declares 301 ordinates and holds 300"),
        (swap(b"e-01", b"x-01"), "readable UFF file"),
    ],
)
def test_text_uff(change: Change, words: str, tmp_path: Path) -> None:
    write_record(RECORD, tmp_path / "run.uff")
    refused(tmp_path / "run.uff", change, words)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (put(0, "<4s", b"CDF\1"), "classic netCDF found"),
        (put(96, "<Q", 2**40), "readable HDF5 file"),
    ],
)
def test_hdf5(change: Change, words: str, tmp_path: Path) -> None:
    write_plain_hdf5(tmp_path / "run.h5", RECORD)
    refused(tmp_path / "run.h5", change, words)


@pytest.mark.parametrize("suffix", [".h5", ".nc"])
def test_damaged_samples_of_our_files_do_not_match_their_checksum(suffix: str, tmp_path: Path) -> None:
    write_record(RECORD, tmp_path / f"run{suffix}")
    piece = RECORD.channels[0].values[10:12].tobytes()
    refused(tmp_path / f"run{suffix}", swap(piece, piece[:8] + bytes(8)), "does not match the checksum")


def test_hdf5_that_declares_more_than_it_holds(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    for words, options in {
        "cannot hold": {"shape": (2**28,)},
        "declares 1000 blocks and holds 0|cannot hold": {"shape": (1000,), "chunks": (1,), "dtype": "i1"},
        "declares 8000 bytes and holds 0": {"shape": (1000,)},
        "at most 536870912": {"shape": (2**40,)},
        "lies in another file": {"shape": (10,), "external": [("other.raw", 0, 80)]},
    }.items():
        with h5py.File(path, "w") as file:
            file.create_dataset("acc", **({"dtype": "f8"} | options))
        with pytest.raises(MeasurementError, match=words):
            read_measurement(path, sampling=1.0)


def test_hdf5_groups_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["/".join("g" * 40)] = np.arange(4.0)
        file.attrs["fs"] = 2.0
    with pytest.raises(MeasurementError, match="nested more than 32 deep"):
        read_measurement(path)
    monkeypatch.setattr(hdf5, "MOST_NODES", 3)
    with pytest.raises(MeasurementError, match="more than 3 objects"):
        hdf5.read(Request(path, path.stat().st_size))


def test_hdf5_rates_axes_packing_and_links(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["g/acc"] = np.arange(4, dtype="i2")
        file["g/acc"].attrs.update({"scale_factor": 0.5, "add_offset": 1.0, "units": "g"})
        file["g/time"] = np.arange(4) * 0.5
        file["rated"] = np.arange(3.0)
        file["rated"].attrs["dt"] = 0.25
        file["table"] = np.zeros(3, dtype=[("a", "f8")])
        file["outside"] = h5py.ExternalLink("other.h5", "/x")
    found = read_measurement(path)
    assert [(c.name, c.sampling, c.unit) for c in found.channels] == [("g/acc", 2.0, "g"), ("rated", 4.0, "")]
    assert found.channel("g/acc").values.tolist() == [1.0, 1.5, 2.0, 2.5]
    assert found.attributes["left out"] == "table"
    with h5py.File(path, "a") as file:
        file["g/acc"].attrs["_FillValue"] = np.int16(3)
    with pytest.raises(MeasurementError, match="1 of 4 samples"):
        read_measurement(path)
    with h5py.File(path, "a") as file:
        file["g/acc"].attrs["scale_factor"] = "twice"
    with pytest.raises(MeasurementError, match="scale_factor and add_offset must be numbers"):
        read_measurement(path)


def test_a_channel_that_is_gone_from_our_file_is_missed(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_record(RECORD, path)
    with h5py.File(path, "a") as file:
        del file["force"]
    with pytest.raises(MeasurementError, match="declares 2 channels and holds 1"):
        read_measurement(path)


@pytest.mark.slow
def test_sandbox__a_reader_that_never_returns_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A heap of texts whose free space has the size 0: the library walks on by 0 bytes for ever."""
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["acc"] = np.arange(4.0)
        file["acc"].attrs["units"] = "m/s^2"
    monkeypatch.setattr(sandbox, "TIME_LIMIT", 10.0)
    assert read_measurement(path, sampling=1.0).channel().unit == "m/s^2"
    content = path.read_bytes()
    heap = content.index(b"GCOL")
    free = heap + 16 + 16 + 8
    assert content[free : free + 2] == b"\0\0"
    path.write_bytes(put(free + 8, "<Q", 0)(content))
    monkeypatch.setattr(sandbox, "TIME_LIMIT", 1.0)
    with pytest.raises(MeasurementError, match="crashes on it or does not return"):
        read_measurement(path, sampling=1.0)
    path.write_bytes(content)
    monkeypatch.setattr(sandbox, "TIME_LIMIT", 10.0)
    assert read_measurement(path, sampling=1.0).names == ("acc",)  # by a new process
