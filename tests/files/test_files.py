"""Files: complete or absent, never replaced without consent; damaged results are refused."""

import errno
import os
import signal
import socket
import stat
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from depth import sized
from gearplay.files import netcdf, sandbox
from gearplay.files.atomic import check_new, make_folder, replacing, write_bytes, write_text
from gearplay.files.netcdf import check_file, netcdf_bytes, read_dataset, write_dataset
from gearplay.files.sandbox import Reader, Request
from gearplay.vocabulary.errors import InputError

pytestmark = pytest.mark.hostile
DAMAGED = sized(4000, 300, torture=10_000)


def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("x")
    with pytest.raises(InputError, match="out = ") as caught:
        write_text(blocked / "below" / "result.txt", "text")
    assert "\n" not in str(caught.value)


@pytest.fixture
def umask() -> Iterator[Callable[[int], int]]:
    """Set the umask; it is as before after the test."""
    before = os.umask(0o022)
    os.umask(before)
    yield os.umask
    os.umask(before)


def mode_of(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_a_new_file_has_the_mode_of_the_umask_and_a_replaced_one_its_own(
    tmp_path: Path, umask: Callable[[int], int]
) -> None:
    target = tmp_path / "result.txt"
    umask(0o077)
    write_text(target, "new")
    assert mode_of(target) == 0o600
    target.chmod(0o640)
    umask(0o022)
    write_text(target, "again")
    assert (mode_of(target), target.read_text()) == (0o640, "again")
    write_text(tmp_path / "other.txt", "new")
    assert mode_of(tmp_path / "other.txt") == 0o644


def special(kind: str, folder: Path) -> Path:
    """Return something in a folder that is no plain file of our own."""
    path = folder / "it"
    if kind == "device":
        return Path("/dev/null")
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "link":
        (folder / "target").write_text("theirs")
        path.symlink_to("target")
    elif kind == "dangling link":
        path.symlink_to("nowhere")
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(str(path))
    elif kind == "somebody else's":
        path.write_text("theirs")
        try:
            os.chown(path, 12345, 12345)
        except PermissionError:
            pytest.skip("only root gives files away")
    return path


KINDS = ("device", "pipe", "folder", "link", "dangling link", "socket", "somebody else's")


@pytest.mark.parametrize("kind", KINDS)
def test_only_a_plain_file_of_our_own_is_replaced(kind: str, tmp_path: Path) -> None:
    place = special(kind, tmp_path)
    before = os.lstat(place)
    for attempt in (lambda: check_new(place, overwrite=True), lambda: write_text(place, "ours")):
        with pytest.raises(
            InputError, match=kind.split()[-1] if kind != "somebody else's" else "somebody else's"
        ):
            attempt()
    after = os.lstat(place)
    assert (after.st_ino, after.st_mode, after.st_uid) == (before.st_ino, before.st_mode, before.st_uid)
    assert kind != "link" or (tmp_path / "target").read_text() == "theirs"


def test_of_two_that_write_the_same_new_name_one_wins(tmp_path: Path) -> None:
    target, ready = tmp_path / "result.txt", threading.Barrier(8)
    ended: list[int] = []
    refused: list[str] = []

    def write(number: int) -> None:
        try:
            with replacing(target, overwrite=False) as temporary:
                temporary.write_text(f"{number}")
                ready.wait()
            ended.append(number)
        except InputError as error:
            refused.append(str(error))

    threads = [threading.Thread(target=write, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(ended) == 1
    assert len(refused) == 7
    assert all("meanwhile" in words for words in refused)
    assert target.read_text() == f"{ended[0]}"
    assert os.listdir(tmp_path) == ["result.txt"]


def test_a_file_that_does_not_fit_is_refused_before_it_is_made(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="MB free"):
        check_new(tmp_path / "large.nc", overwrite=False, size=1e18)


@pytest.mark.parametrize("name", ["x" * 300, "a\0b"])
def test_a_name_that_cannot_be_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="out = "):
        check_new(tmp_path / name, overwrite=True)


STEPS = [(step, old) for step in ("open", "write", "fsync") for old in (False, True)]
STEPS += [("link and replace", False), ("chmod", True), ("replace", True)]


@pytest.mark.parametrize(("step", "old"), STEPS)
def test_each_step_may_fail_and_the_old_file_stays(
    step: str, old: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "result.txt"
    if old:
        target.write_text("old")

    def fail(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as broken:
        for name in step.split(" and "):
            broken.setattr(*((Path, "write_bytes") if name == "write" else (os, name)), fail)
        with pytest.raises(InputError, match="No space left"):
            write_bytes(target, b"new", overwrite=old)
    assert os.listdir(tmp_path) == (["result.txt"] if old else [])
    assert not old or target.read_text() == "old"


def test_a_disk_that_is_read_only_from_the_sync_on_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not even the temporary file can be removed."""

    def fail(*_: object, **__: object) -> None:
        raise OSError(errno.EROFS, "Read-only file system")

    with monkeypatch.context() as broken:
        for name in ("fsync", "unlink"):
            broken.setattr(os, name, fail)
        with pytest.raises(InputError, match="Read-only file system"):
            write_bytes(tmp_path / "result.nc", b"new")


def no_links(*_: object, **__: object) -> None:
    raise OSError(errno.EPERM, "Operation not permitted")


@pytest.mark.parametrize(("step", "links"), [("close", True), ("close", False), ("replace", False)])
@pytest.mark.parametrize("when", ["before", "after"])
def test_ctrl_c_between_two_steps_leaves_the_whole_file_or_nothing(
    when: str, step: str, links: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As soon as a file is created, and, where there are no links, between its name and its content."""
    do = getattr(os, step)

    def interrupted(*words: object) -> None:
        if when == "after":
            do(*words)
        signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patched:
        patched.setattr(os, step, interrupted)
        if not links:
            patched.setattr(os, "link", no_links)
        with pytest.raises(KeyboardInterrupt):
            write_bytes(tmp_path / "result.nc", b"content", overwrite=False)
    held = {each.name: each.read_bytes() for each in tmp_path.iterdir()}
    assert held == ({"result.nc": b"content"} if (step, when) == ("replace", "after") else {})


def test_without_links_a_name_that_is_taken_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", no_links)
    write_bytes(tmp_path / "result.nc", b"old", overwrite=False)
    with pytest.raises(InputError, match="meanwhile"):
        write_bytes(tmp_path / "result.nc", b"new", overwrite=False)
    assert [each.read_bytes() for each in tmp_path.iterdir()] == [b"old"]


def a_result() -> xr.Dataset:
    values = np.random.default_rng(1).normal(size=(2, 800))
    return xr.Dataset(
        {"x": (("rotor", "time"), values, {"units": "m"}), "n": ("rotor", [3, 4])},
        coords={"time": np.arange(800) * 1e-3, "rotor": ["pinion", "ring"]},
        attrs={"gearplay_kind": "run", "words": "ä"},
    )


def test_result__is_read_back_as_written(tmp_path: Path) -> None:
    write_dataset(a_result(), tmp_path / "run.nc")
    xr.testing.assert_identical(read_dataset(check_file(tmp_path / "run.nc")), a_result())
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as elsewhere:  # by any reader of netCDF
        assert elsewhere.x.equals(a_result().x)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_no_damage_goes_unseen(tmp_path: Path, tried: Callable[[int], None]) -> None:
    """Flips, cuts, swaps and growth of a result file: refused in one sentence, or the very same numbers."""
    whole, generator = netcdf_bytes(a_result()), np.random.default_rng(5)
    said: list[str] = []
    place = tmp_path / "damaged.nc"
    for turn in range(DAMAGED):
        content = bytearray(whole)
        at = int(generator.integers(len(content)))
        kind = turn % 5
        if kind == 0:
            content[at] ^= 1 << int(generator.integers(8))
        elif kind == 1:
            del content[at:]
        elif kind == 2:
            content[at : at + 64] = bytes(64)
        elif kind == 3:
            content += bytes(generator.integers(0, 256, 48, dtype=np.uint8))
        else:
            content[at:] = content[at:][::-1]
        place.write_bytes(content)
        try:
            found = read_dataset(check_file(place))
        except InputError as error:
            said.append(str(error))
        else:
            xr.testing.assert_identical(found, a_result())
    assert len(said) > 0.7 * DAMAGED
    tried(DAMAGED)
    assert not [words for words in said if "\n" in words]


def test_numbers_that_a_file_cannot_hold_are_refused(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "bomb.nc", "w") as file:
        file.create_dataset("x", (200_000_000_000,), dtype="f8", chunks=(1_000_000,), fillvalue=1.0)
    with pytest.raises(InputError, match="declares"):
        read_dataset(check_file(tmp_path / "bomb.nc"))


@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_special_file__is_not_read(kind: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no plain file"):
        read_dataset(check_file(special(kind, tmp_path)))


def test_a_folder_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="out = "):
        make_folder(tmp_path / "file" / "below")


@pytest.mark.slow
def test_sandbox__a_hang_or_crash_of_the_reader_is_contained(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    a_result().to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    begin = """import sys; ready = lambda: print('{"sizes": []}', flush=True); ready(); sys.stdin.readline(); ready(); """
    for child, patience in (("import time; time.sleep(60)", 0.5), ("import os; os.abort()", 30.0)):
        monkeypatch.setattr(sandbox, "TIME_LIMIT", patience)
        monkeypatch.setattr(netcdf, "READER", Reader(begin + child))
        with pytest.raises(InputError, match="HDF5 library crashes on it or does not return"):
            read_dataset(check_file(tmp_path / "old.nc"))


@pytest.mark.slow
def test_a_reader_that_is_interrupted_while_it_starts_answers_the_next_question(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    child = (
        f"import os, time; first = not os.path.exists({str(begun)!r}); open({str(begun)!r}, 'w').close(); "
    )
    child += "time.sleep(10.0 * first); from gearplay.files.sandbox import serve; serve()"
    reader = Reader(child)
    ours = signal.getsignal(signal.SIGINT)
    assert ours is signal.default_int_handler

    def interrupt() -> None:
        while not begun.exists():
            ended.wait(0.01)
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)

    ended = threading.Event()
    threading.Thread(target=interrupt, daemon=True).start()
    request = Request(tmp_path / "nowhere.nc", 9)
    with pytest.raises(KeyboardInterrupt):
        reader.read("gearplay.files.netcdf", request)
    for _ in range(2):
        with pytest.raises(InputError, match=r"nowhere\.nc"):
            reader.read("gearplay.files.netcdf", request)
    reader.close()


def test_a_foreign_file_has_a_limit_on_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """4 GB of numbers that nobody wrote, for 2 GB of memory."""
    with h5py.File(tmp_path / "bomb.nc", "w") as file:
        file.create_dataset("x", shape=(500_000_000,), dtype="f8", chunks=(1 << 20,), compression="gzip")
    limited = "from gearplay.files import sandbox, netcdf; netcdf.MOST_PER_BYTE = 1e9; "
    limited += "sandbox.MOST_MEMORY = 2 << 30; sandbox.serve()"
    monkeypatch.setattr(netcdf, "READER", Reader(limited))
    with pytest.raises(InputError, match=r"bomb\.nc.*needs more than 2\.\d+ GB of memory"):
        read_dataset(check_file(tmp_path / "bomb.nc"))


def test_a_dataset_in_chunks_is_written_whole(tmp_path: Path) -> None:
    """Its numbers are computed when they are asked for, which writing does not do of itself."""
    whole = a_result()
    write_dataset(whole.chunk(), tmp_path / "run.nc")
    assert read_dataset(check_file(tmp_path / "run.nc")).identical(whole)
