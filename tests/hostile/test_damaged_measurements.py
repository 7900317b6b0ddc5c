"""Damaged measurement files, 100 of each format: no crash, no hang, every truncation reported."""

import contextlib
import os
import signal
import struct
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import h5py
import numpy as np
import pytest
from scipy.io import savemat, wavfile

from gearplay.files import sandbox
from gearplay.files.measurements import read_measurement, write_record
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import InputError, MeasurementError

pytestmark = pytest.mark.hostile

FORMATS = ("csv", "uff", "tdms", "mdf4", "wav", "mat", "hdf5", "netcdf", "numpy")
SUFFIXES = {
    "csv": ".csv",
    "uff": ".uff",
    "tdms": ".tdms",
    "mdf4": ".mf4",
    "wav": ".wav",
    "mat": ".mat",
    "hdf5": ".h5",
}
SUFFIXES["netcdf"] = ".nc"
SUFFIXES["numpy"] = ".npz"
TRUNCATIONS, FLIPS, BLOCKS, OTHERS = 50, 25, 15, 10
TOTAL = TRUNCATIONS + FLIPS + BLOCKS + OTHERS
SAMPLES = 300
RATE = 12800.0
HANG = 60  # s: a guard against hanging, far above what any refusal takes


class HangError(BaseException):
    """Passes through `except Exception`, as a hang must not look like a refusal."""


def sound_record() -> Record:
    random = np.random.default_rng(7)
    values = np.round(random.normal(size=(2, SAMPLES)), 6)
    return Record((Channel("acc", values[0], RATE, "m/s^2"), Channel("force", values[1], RATE, "N")), "sound")


def write_binary_uff(path: Path, record: Record) -> None:
    """UFF 58b byte by byte, since pyuff leaves its file open when it writes one."""
    with path.open("wb") as file:
        for place, channel in enumerate(record.channels, start=1):
            size = channel.values.size
            lines = [
                "    -1",
                f"    58b{1:6d}{2:6d}{11:12d}{8 * size:12d}{0:6d}{0:6d}{0:12d}{0:12d}",
                *(f"{text:<80}" for text in (channel.name, "NONE", "NONE", "NONE", f"channel {place} of 2")),
                f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':>10}{place:10d}{0:4d} {'NONE':>10}{0:10d}{0:4d}",
                f"{4:10d}{size:10d}{1:10d}{0.0:13.5e}{1 / channel.sampling:13.5e}{0.0:13.5e}",
                f"{17:10d}{0:5d}{0:5d}{0:5d} {'time':<20} {'s':<20}",
                f"{1:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {channel.unit:<20}",
                *(f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {'NONE':<20}" for _ in range(2)),
            ]
            file.write(
                ("\n".join(lines) + "\n").encode() + channel.values.astype("<f8").tobytes() + b"\n    -1\n"
            )


def write_tdms(path: Path, record: Record) -> None:
    from nptdms import ChannelObject, RootObject, TdmsWriter

    with TdmsWriter(path) as writer:
        for begin, end in ((0, SAMPLES // 3), (SAMPLES // 3, SAMPLES)):
            channels = [
                ChannelObject(
                    "rig",
                    channel.name,
                    channel.values[begin:end],
                    {"wf_increment": 1 / channel.sampling, "unit_string": channel.unit},
                )
                for channel in record.channels
            ]
            writer.write_segment([RootObject({"rig": "one"}), *channels])


def write_mdf4(path: Path, record: Record, *, compression: int = 0) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from asammdf import MDF, Signal
    file = MDF(version="4.10")
    file.append([Signal(c.values, c.time, name=c.name, unit=c.unit) for c in record.channels])
    file.save(path, overwrite=True, compression=compression)
    file.close()


def write_integer_wav(path: Path, record: Record) -> None:
    table = np.column_stack([channel.values for channel in record.channels])
    wavfile.write(path, int(RATE), (table * 5000).astype(np.int16))


def write_plain_mat(path: Path, record: Record) -> None:
    savemat(path, {"fs": RATE, **{channel.name: channel.values for channel in record.channels}})


def write_npz(path: Path, record: Record) -> None:
    np.savez(path, fs=RATE, **{channel.name: channel.values for channel in record.channels})


def write_hdf5_mat(path: Path, record: Record) -> None:
    write_plain_hdf5(path, record, userblock_size=512)
    content = path.read_bytes()
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + content[128:])


def write_plain_hdf5(path: Path, record: Record, **options: int) -> None:
    with h5py.File(path, "w", **options) as file:
        file["fs"] = RATE
        for channel in record.channels:
            file[channel.name] = channel.values[np.newaxis, :]


def write_comma_csv(path: Path, record: Record) -> None:
    rows = [
        f"{t};{a};{f}"
        for t, a, f in zip(record.channels[0].time, *(c.values for c in record.channels), strict=True)
    ]
    text = "\n".join(
        [f"# rows: {SAMPLES}", "Zeit;acc;force", "s;m/s^2;N", *(row.replace(".", ",") for row in rows), ""]
    )
    path.write_text(text, encoding="utf-8")


def packed_mdf4(path: Path, record: Record) -> None:
    write_mdf4(path, record, compression=2)


def ours(path: Path, record: Record) -> None:
    write_record(record, path)


WRITERS: dict[str, tuple[Callable[[Path, Record], None], ...]] = {
    "csv": (ours, write_comma_csv),
    "uff": (ours, write_binary_uff),
    "tdms": (write_tdms,),
    "mdf4": (write_mdf4, packed_mdf4),
    "wav": (ours, write_integer_wav),
    "mat": (ours, write_plain_mat, write_hdf5_mat),
    "hdf5": (ours, write_plain_hdf5),
    "netcdf": (ours,),
    "numpy": (write_npz,),
}


def flipped(content: bytes, random: np.random.Generator) -> bytes:
    damaged = bytearray(content)
    for place in random.integers(0, len(content), random.integers(1, 51)):
        damaged[place] ^= int(random.integers(1, 256))
    return bytes(damaged)


def blocked(content: bytes, random: np.random.Generator) -> bytes:
    begin = int(random.integers(0, len(content) - 1))
    end = min(len(content), begin + int(random.integers(8, 2048)))
    if random.random() < 0.5:
        zeroed = content[:begin] + bytes(end - begin) + content[end:]
        return zeroed if zeroed != content else blocked(content, random)
    return content[:end] + content[begin:end] + content[end:]


def huge(content: bytes, random: np.random.Generator) -> bytes:
    """Declare 2^40 or 2^32 - 1 of something, somewhere in the first kilobyte."""
    place = int(random.integers(0, min(len(content) - 8, 1024))) // 4 * 4
    sizes = (
        struct.pack("<Q", 2**40),
        struct.pack("<I", 2**32 - 1),
        struct.pack(">Q", 2**40),
        b"999999999999",
    )
    size = sizes[int(random.integers(0, len(sizes)))]
    while content[place : place + len(size)] == size:
        place += 4
    return content[:place] + size + content[place + len(size) :]


def damage(kind: str, number: int, sound: dict[str, list[bytes]], seed: int = 0) -> tuple[str, bytes, bytes]:
    """Return the name of the damage, the sound bytes and the damaged ones; the same ones each time."""
    random = np.random.default_rng([seed, FORMATS.index(kind), number])
    flavours = sound[kind]
    content = flavours[number % len(flavours)]
    if number < TRUNCATIONS:
        return "truncation", content, content[: int(random.integers(1, len(content)))]
    if number < TRUNCATIONS + FLIPS:
        return "flip", content, flipped(content, random)
    if number < TRUNCATIONS + FLIPS + BLOCKS:
        return "block", content, blocked(content, random)
    other = number - (TOTAL - OTHERS)
    if other < 2:
        return "garbage", content, content + random.bytes(int(random.integers(1, 3000)))
    if other < 7:
        return "huge", content, huge(content, random)
    if other == 7:
        return "empty", content, b""
    if other == 8:
        return "folder", content, b""
    stranger = FORMATS[(FORMATS.index(kind) + 3) % len(FORMATS)]
    return "stranger", sound[stranger][0], sound[stranger][0]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[bytes]]:
    return sound_files(tmp_path_factory.mktemp("sound"))


def sound_files(folder: Path) -> dict[str, list[bytes]]:
    record, result = sound_record(), {}
    for kind, writers in WRITERS.items():
        result[kind] = []
        for place, write in enumerate(writers):
            path = folder / f"{place}{SUFFIXES[kind]}"
            write(path, record)
            result[kind].append(path.read_bytes())
    return result


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give up sooner on a file on which a library never returns."""
    monkeypatch.setattr(sandbox, "TIME_LIMIT", 10.0)


@contextmanager
def guard_against_hanging() -> Iterator[None]:
    """Fail after `HANG` seconds, even where a library swallows the exception that ends the wait."""
    begin = time.monotonic()

    def fall_back(_: int, __: FrameType | None) -> None:
        raise HangError

    before = signal.signal(signal.SIGALRM, fall_back) if hasattr(signal, "SIGALRM") else None
    if before is not None:
        signal.setitimer(signal.ITIMER_REAL, HANG, 1.0)
    try:
        with contextlib.suppress(HangError):
            yield
    finally:
        if before is not None:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
    assert time.monotonic() - begin < HANG, f"still running after {HANG} s"


def place_file(folder: Path, kind: str, name: str, content: bytes) -> Path:
    path = folder / f"damaged{SUFFIXES[kind]}"
    if name == "folder":
        path.mkdir()
    else:
        path.write_bytes(content)
    return path


def outcome(path: Path) -> Record | str:
    try:
        return read_measurement(path)
    except (MeasurementError, InputError) as error:
        return str(error)


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("number", range(TOTAL))
@pytest.mark.parametrize("kind", FORMATS)
def test_a_damaged_file_is_a_record_or_one_sentence(
    kind: str, number: int, sound: dict[str, list[bytes]], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    name, whole, content = damage(kind, number, sound)
    path = place_file(tmp_path, kind, name, content)
    result: Record | str = ""
    with guard_against_hanging():
        result = outcome(path)
    assert capfd.readouterr() == ("", "")
    if isinstance(result, str):
        check_sentence(result)
        assert name != "stranger", result
        return
    assert name not in ("empty", "folder")
    assert all(np.isfinite(channel.values).all() and channel.values.size for channel in result.channels)
    assert all(channel.sampling > 0 for channel in result.channels)
    if name == "truncation":
        path.write_bytes(whole)
        same_samples(result, read_measurement(path))


def check_sentence(text: str) -> None:
    assert "damaged" in text.split(":")[0] or text.startswith(("file = ", "sampling = ")), text
    assert text.isprintable(), text
    assert text.endswith((".", "?")), text
    assert 20 < len(text) < 500, text
    assert "Traceback" not in text
    assert "MemoryError" not in text, text


def same_samples(found: Record, whole: Record) -> None:
    """Compare with the whole file: a truncation that passes may have lost nothing but padding or a line end."""
    assert found.names == whole.names
    for one, other in zip(found.channels, whole.channels, strict=True):
        np.testing.assert_array_equal(one.values, other.values)
        assert (one.sampling, one.unit, one.start) == (other.sampling, other.unit, other.start)


def test_a_named_pipe_is_refused_without_waiting(tmp_path: Path) -> None:
    path = tmp_path / "pipe.csv"
    os.mkfifo(path)
    with guard_against_hanging(), pytest.raises(InputError, match="regular file"):
        read_measurement(path)
