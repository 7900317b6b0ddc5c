"""The library without Python: a C program follows bundled cases with it, here and on other platforms by their emulators."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.integrate import run as kernel
from gearplay.integrate import stepper
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import INTERPRETED
from gearplay.kernels.library import OWN, WHERE, find
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack

pytestmark = pytest.mark.skipif(INTERPRETED or sys.platform != "linux", reason="nothing is compiled here")
HOST = Path(__file__).with_name("host.c")
CASES = {
    "han2021": 0.5,
    "external-pair": 0.02,
    "planetary-reducer": 0.005,
    "two-stage-reducer": 0.01,
    "torsional-train": 0.05,
    "space-launch": 0.01,
}


def _members(value: Any) -> Iterator[Any]:
    """Yield the arrays and groups in a field, in the order of the table."""
    if isinstance(value, tuple):
        for part in value:
            yield from _members(part)
    else:
        yield value


class Image:
    """The memory of some groups in one block, with addresses relative to its begin."""

    def __init__(self, *groups: Group) -> None:
        self.bytes, self.addresses, self.places = bytearray(), dict[int, int](), list[int]()
        self.roots = [self._group(group) for group in groups]

    def _add(self, address: int, content: bytes) -> int:
        """Return the place of a piece of memory, which may be part of several groups."""
        if address not in self.addresses or not content:
            self.bytes += bytes(-len(self.bytes) % 16)
            self.addresses[address] = len(self.bytes)
            self.bytes += content
        return self.addresses[address]

    def _group(self, group: Group) -> int:
        words, at = group._table.copy(), 0  # type: ignore[attr-defined]
        relocated = []
        for value in (each for name in type(group).shapes() for each in _members(getattr(group, name))):
            if isinstance(value, Group):
                words[at] = self._group(value)
                relocated.append(at)
                at += 1
            else:
                if value.size:
                    words[at] = self._add(value.ctypes.data, value.tobytes())
                    relocated.append(at)
                at += 1 + value.ndim
        place = self._add(group._address, words.tobytes())
        self.places += [place + 8 * word for word in relocated]
        return place

    def write(self, file: Path) -> None:
        head = [len(self.bytes), len(self.places), *self.roots, *self.places]
        file.write_bytes(np.array(head, dtype="<i8").tobytes() + bytes(self.bytes))

    def array(self, file: Path, array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        """Return an array as a file that the program wrote has it."""
        place = self.addresses[array.ctypes.data]
        content = file.read_bytes()[place : place + array.nbytes]
        return np.frombuffer(content, dtype=array.dtype).reshape(array.shape)


def followed(
    case: str, span: float, command: Sequence[str], tmp_path: Path
) -> tuple[kernel.Run, dict[str, Any]]:
    """Return a run that this process has followed, and what a program made of the same one."""
    chosen = gp.load_case(case)
    packed = pack(chosen)
    run = kernel.make_run(
        packed.system,
        initial_state(chosen, packed),
        packed.natural,
        packed.restart_step,
        packed.stops,
        np.arange(0),
        np.empty((0, 0)),
        2000,
        chosen.run.tolerance,
    )
    run.clock[kernel.T_END] = span
    image, file = Image(packed.system, run), tmp_path / "image"
    image.write(file)
    subprocess.run([*command, str(file)], check=True, timeout=600)
    while stepper.advance(packed.system, run, 1000) == kernel.PAUSED:
        run.counts[kernel.LOGGED] = 0
    names = ("y", "counts", "tallies", "log")
    return run, {name: image.array(file, getattr(run, name)) for name in names}


def compiled_host(compiler: Sequence[str], folder: Path, *objects: Path) -> Path:
    made = folder / "host"
    header = Path(os.environ.get(WHERE) or OWN)
    words = [
        *compiler,
        "-O1",
        "-Wall",
        "-Werror",
        f"-I{header}",
        str(HOST),
        *map(str, objects),
        "-lm",
        "-o",
        str(made),
    ]
    subprocess.run(words, check=True, capture_output=True, text=True)
    return made


def test_c_program_follows_a_motion_without_python(tmp_path: Path) -> None:
    """By the header that the build writes; the same bits, and nothing of Python in the process."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    library = find(Path(os.environ.get(WHERE) or OWN))
    assert library is not None
    host = compiled_host([compiler], tmp_path, library)
    needed = subprocess.run(["ldd", host], check=True, capture_output=True, text=True).stdout
    assert {line.split()[0].split("/")[-1].split(".")[0] for line in needed.splitlines()} == {
        "linux-vdso", "libm", "libc", "ld-linux-x86-64" if "x86-64" in needed else "ld-linux-aarch64", library.name.split(".")[0]
    }  # fmt: skip
    for case, span in CASES.items():
        run, found = followed(case, span, [str(host)], tmp_path)
        for name, values in found.items():
            assert np.array_equal(values, getattr(run, name)), (case, name)


@pytest.fixture(scope="module")
def foreign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the libraries of two other platforms into a folder."""
    pytest.importorskip("ziglang")
    folder = tmp_path_factory.mktemp("foreign")
    words = [word for target in ("windows-x86_64", "linux-aarch64") for word in ("--target", target)]
    subprocess.run([sys.executable, "-m", "gearplay.build", "--folder", folder, *words], check=True)
    return folder


def zig(target: str) -> list[str]:
    return [sys.executable, "-m", "ziglang", "cc", "-target", target]


@pytest.mark.deep
def test_windows_library_follows_the_same_motion(foreign: Path, tmp_path: Path) -> None:
    """Under wine: its C library has other sines, and the last bits of a motion differ."""
    wine = shutil.which("wine64") or shutil.which("wine64", path="/usr/lib/wine")
    if wine is None:
        pytest.skip("no wine64")
    (library,) = (foreign / "windows-x86_64").glob("*.dll")
    host = compiled_host([*zig("x86_64-windows-gnu"), f"-I{foreign}"], tmp_path, library)
    shutil.copy2(library, tmp_path / "gearplay.dll")  # the name by which it was linked
    check_motions(
        [wine, str(host.with_suffix(".exe") if host.with_suffix(".exe").exists() else host)], tmp_path
    )


@pytest.mark.deep
def test_arm_library_follows_the_same_motion(foreign: Path, tmp_path: Path) -> None:
    """Under qemu, linked with all that it needs: the emulator has no C library of that processor."""
    qemu = shutil.which("qemu-aarch64")
    if qemu is None:
        pytest.skip("no qemu-aarch64")
    arm = 183  # of an ELF file's machines
    objects = [file for file in (foreign / "objects").glob("*.o") if file.read_bytes()[18] == arm]
    host = compiled_host([*zig("aarch64-linux-musl"), f"-I{foreign}", "-static"], tmp_path, *objects)
    check_motions([qemu, str(host)], tmp_path)


def check_motions(command: Sequence[str], folder: Path) -> None:
    for case, span in CASES.items():
        run, found = followed(case, span, command, folder)
        equal = all(np.array_equal(values, getattr(run, name)) for name, values in found.items())
        apart = abs(found["y"] - run.y).max()
        print(f"{case}: {'the same bits' if equal else f'up to {apart:.1e} apart'}")  # noqa: T201
        assert found["counts"][kernel.EVENTS] == run.counts[kernel.EVENTS], case
        # The choice between methods may turn by the last bit.
        assert found["counts"][kernel.STEPS] == pytest.approx(run.counts[kernel.STEPS], rel=0.05), case
        for i in range(found["y"].size // 6):
            assert np.allclose(
                found["y"][3 * i : 3 * i + 2], run.y[3 * i : 3 * i + 2], rtol=0.0, atol=1e-13
            ), case
