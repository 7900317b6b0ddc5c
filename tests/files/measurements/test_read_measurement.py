"""Reading measurements: arguments, kind by content, missing packages, size limits."""

import builtins
import importlib
import logging
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from gearplay.files.measurements import read_measurement, reading, refusing, write_record
from gearplay.files.measurements.building import Request, Samples, make_channel
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import InputError, MeasurementError, ResourceError
from gearplay.vocabulary.optional import cure_for
from hostile.test_damaged_measurements import write_binary_uff, write_mdf4, write_tdms

RECORD = Record(
    (
        Channel("acc", np.random.default_rng(1).normal(size=300), 12800.0, "m/s^2"),
        Channel("force", np.ones(300), 12800.0, "N"),
    )
)


@pytest.fixture
def csv_file(tmp_path: Path) -> Path:
    write_record(RECORD, tmp_path / "run.csv")
    return tmp_path / "run.csv"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"channels": ["ac"]}, "Did you mean 'acc'"),
        ({"channels": ["zzz"]}, "Channels: acc, force"),
        ({"channels": []}, "at least one channel"),
        ({"channels": ["acc", "acc"]}, "each once"),
        ({"sampling": 0.0}, "positive rate"),
        ({"sampling": float("nan")}, "positive rate"),
        ({"format": "xls"}, "must be one of csv"),
    ],
)
def test_read_measurement__invalid_options_are_refused(
    options: dict[str, object], words: str, csv_file: Path
) -> None:
    with pytest.raises(InputError, match=words):
        read_measurement(csv_file, **options)  # type: ignore[arg-type]


def test_channels__are_in_the_requested_order(csv_file: Path) -> None:
    assert read_measurement(csv_file, channels=("force", "acc")).names == ("force", "acc")


@pytest.mark.parametrize(
    ("name", "words"),
    [("none.csv", "No such file"), (".", "not a folder"), ("a\0b", "zero byte"), ("/dev/zero", "device")],
)
def test_paths_that_are_no_files(name: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        read_measurement(tmp_path / name)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".h5", ".wav", ".mat", ".nc", ".uff", ".csv"])
def test_the_content_tells_the_kind_before_the_extension(suffix: str, tmp_path: Path) -> None:
    write_record(RECORD, tmp_path / f"run{suffix}")
    renamed = tmp_path / "run.tdms"
    (tmp_path / f"run{suffix}").rename(renamed)
    assert read_measurement(renamed).names == ("acc", "force")
    assert read_measurement(renamed.rename(tmp_path / "run.dat")).names == ("acc", "force")


def test_a_format_that_is_forced(csv_file: Path) -> None:
    with pytest.raises(MeasurementError, match="RIFF"):
        read_measurement(csv_file, format="wav")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"\0\1\2\3", "neither its first bytes nor its extension"),
        (b"TDSh" + b"\0" * 30, "only the index"),
    ],
)
def test_content_of_no_kind(content: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / "run.bin").write_bytes(content)
    with pytest.raises(MeasurementError, match=words):
        read_measurement(tmp_path / "run.bin")


def test_files_over_the_limit_are_refused(csv_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "LARGEST_TEXT", 100)
    with pytest.raises(MeasurementError, match="at most 512 MiB"):
        read_measurement(csv_file)
    large = csv_file.with_name("large.wav")
    with large.open("wb") as file:
        file.truncate(refusing.LARGEST_FILE + 1)  # takes no room on the disk
    with pytest.raises(MeasurementError, match="at most 4 GiB"):
        read_measurement(large)
    monkeypatch.setattr(reading, "LARGEST_TEXT", 10**9)
    monkeypatch.setattr(refusing, "MOST_SAMPLES", 100)
    with pytest.raises(MeasurementError, match="declares 900 samples; at most 100"):
        read_measurement(csv_file)


@pytest.mark.parametrize(
    ("module", "suffix", "write"),
    [("pyuff", ".uff", write_binary_uff), ("nptdms", ".tdms", write_tdms), ("asammdf", ".mf4", write_mdf4)],
)
def test_a_missing_package_is_named_with_its_cure(
    module: str, suffix: str, write: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / f"run{suffix}"
    write(path, RECORD)  # type: ignore[operator]
    real = importlib.import_module

    def absent(name: str, package: str | None = None) -> ModuleType:
        if name == module:
            raise ImportError(name)
        return real(name, package)

    monkeypatch.setattr(refusing, "import_module", absent)
    kind = {".uff": "uff", ".tdms": "tdms", ".mf4": "mdf4"}[suffix]
    with pytest.raises(InputError) as caught:  # in another process it cannot be hidden
        reading.read(Request(path, path.stat().st_size, kind=kind))
    assert "is not installed" in str(caught.value)
    assert cure_for("measurements") in str(caught.value)


def test_other_formats_need_no_optional_package(csv_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def guarded(name: str, *rest: object, **options: object) -> object:
        assert name.split(".")[0] not in ("pyuff", "nptdms", "asammdf", "pickle5")
        return real(name, *rest, **options)  # type: ignore[arg-type]

    for module in ("pyuff", "nptdms", "asammdf"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    monkeypatch.setattr(builtins, "__import__", guarded)
    assert read_measurement(csv_file).names == ("acc", "force")


@pytest.mark.parametrize(
    ("error", "kind"), [(OSError(5, "I/O error"), InputError), (MemoryError(), ResourceError)]
)
@pytest.mark.hostile
def test_a_failing_disk_or_memory_is_a_sentence(
    error: Exception, kind: type[Exception], csv_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gearplay.files.measurements import csv_file as reader

    def fail(request: Request) -> Record:
        raise error

    monkeypatch.setattr(reader, "read", fail)
    with pytest.raises(kind, match=r"I/O error|more memory"):
        read_measurement(csv_file)


@pytest.mark.parametrize(
    ("values", "options", "words"),
    [
        (np.zeros(0), {}, "must hold samples"),
        (np.zeros((2, 2)), {}, "real numbers"),
        (np.zeros(2, complex), {}, "real numbers"),
        (np.array(["a"]), {}, "real numbers"),
        (np.array([1.0, np.nan]), {}, "1 of 2 samples"),
        (np.zeros(2), {"start": float("inf")}, "finite time"),
        (np.zeros(2), {"declared": [("fs", -1.0)]}, "positive sampling rate"),
    ],
)
def test_channels_are_finite_real_vectors(values: np.ndarray, options: dict[str, object], words: str) -> None:
    with pytest.raises(MeasurementError, match=words):
        make_channel(Request(Path("x"), 1), "acc", Samples(values, **({"declared": [("fs", 1.0)]} | options)))


def test_a_library_that_fails_is_one_sentence() -> None:
    words = r"readable X file \(ZeroDivisionError: by zero\)"
    with pytest.raises(MeasurementError, match=words), refusing.fenced(Path("a.x"), "X"):
        raise ZeroDivisionError("by zero")


def test_library_warning__is_a_refusal() -> None:
    complaints = refusing.Complaints("noisy")
    logging.getLogger("noisy.part").warning("read %d of %d", 3, 4)
    with pytest.raises(MeasurementError, match=r"readable X file \(read 3 of 4\)"):
        complaints.refuse(Path("a.x"), "X")


def test_a_record_shows_its_channels_and_not_its_samples() -> None:
    acc, force = Channel("acc", np.zeros(500), 1000.0, "m/s^2"), Channel("force", np.zeros(500), 1000.0)
    assert repr(acc) == "<gearplay channel acc: 500 samples at 1000 Hz, m/s^2>"
    assert (
        repr(Record((acc, force), source="run.h5"))
        == "<gearplay record run.h5: 2 channels, 0.5 s; channels acc, force>"
    )


def test_a_channel_of_several_must_be_named() -> None:
    record = Record(tuple(Channel(name, np.zeros(5), 10.0) for name in ("acc", "force")))
    with pytest.raises(
        InputError, match=r"channel: is required: the record has several channels\. Channels: acc, force\."
    ):
        record.channel()
