"""Kernels compiled before they are needed: those of a case, by several processes at once.

What a case needs follows from its kinds of elements; anything else is compiled by the first call that needs it.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from gearplay.kernels.compiled import compiled_from
from gearplay.kernels.compiled_once import INTERPRETED, KERNELS
from gearplay.kernels.elements.table import DERIVATIVE, KINDS
from gearplay.kernels.tangent_state import make_tangent
from gearplay.model.case import Case
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import load_case
from gearplay.solver.course import Course
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.file_lock import try_lock
from gearplay.vocabulary.progress import Progress

MOST_HELPERS = 3
FEW = 6
"""So few kernels are not worth a word: the first call of each compiles it."""
LABEL = "Compiling the kernels, once after an installation"
_OF_DERIVATIVE = ("tangent", "tangent_state", "saltation", "slopes", "unbalance")
_SELDOM = ("accelerate", "applied_torque", "shaft_power", "fill_power_column", "mesh_powers", "friction_loss")
"""Kernels that few runs need, or that only look at one: the first call of each compiles it."""
_LINEAR = {
    "press", "act", "linearise", "add_change", "torque_of", "torques_of", "settle", "settle_modes", "judge_modes", "rates_of",
    "rate_of_change",
}  # fmt: skip
"""Questions that the matrices of the linear view need."""
_ELEMENTS = "gearplay.kernels.elements."
_ready: set[tuple[frozenset[str], bool, bool]] = set()  # what this process has seen to be compiled


def prepare(case: Case, *, derivative: bool = False, progress: Progress | None = None) -> None:
    """Compile what a case needs, on all cores, or see that it has been compiled: some 15 s once after an installation.

    Parameters
    ----------
    case
        What is to be simulated; its kinds of elements decide.
    derivative
        Whether the exact derivative of the motion is needed too.
    progress
        Told how many kernels are compiled, and of how many; without it a line on standard error says what takes so long.

    """
    prepare_packed(
        pack(case), fixed=case.run.fixed_step is not None, derivative=derivative, progress=progress
    )


def prepare_packed(
    packed: Packed, *, fixed: bool, derivative: bool = False, progress: Progress | None = None
) -> None:
    """Do what `prepare` does for a case that has been packed, and has a fixed step or not."""
    if INTERPRETED:
        return
    wanted = (_kinds(packed), fixed, derivative)
    if wanted not in _ready:
        _compile(_wanted(*wanted), progress)
        _ready.add(wanted)


def prepare_linear(packed: Packed, *, progress: Progress | None = None) -> None:
    """Do what `prepare` does for the matrices of the linear view alone."""
    if not INTERPRETED:
        wanted = _wanted(_kinds(packed), fixed=False, derivative=True)
        _compile([name for name in wanted if name.rpartition(".")[2] in _LINEAR], progress)


def prepare_all() -> None:
    """Compile every kernel that there is, on all cores."""
    _compile(_wanted(frozenset(kind.name for kind in KINDS), fixed=True, derivative=True), None)


def _kinds(packed: Packed) -> frozenset[str]:
    """Return the names of the kinds of elements of a mechanism."""
    return frozenset(KINDS[int(kind)].name for kind in set(packed.system.elements["kind"].tolist()))


def _wanted(kinds: frozenset[str], fixed: bool, derivative: bool) -> list[str]:
    """Return the names of the kernels that are needed, longest first."""
    all_of_them = len(kinds) == len(KINDS)
    wanted = []
    for name, kernel in KERNELS.items():
        module, _, question = name.rpartition(".")
        kind = module.removeprefix(_ELEMENTS).partition(".")[0] if module.startswith(_ELEMENTS) else "table"
        of_derivative = question in DERIVATIVE or module.rpartition(".")[2] in _OF_DERIVATIVE
        if (
            (kind in kinds or kind == "table")
            and (all_of_them or question not in _SELDOM)
            and (derivative or not of_derivative)
            and (fixed or "fixed_steps" not in module)
        ):
            wanted.append((-kernel.length, name))
    return [name for _, name in sorted(wanted)]


def _done() -> Path:
    """Return the folder that holds a file for each compiled kernel; it goes with the folder of compiled code."""
    return next(iter(KERNELS.values())).folder / f"done-{compiled_from()}"


def _compile(wanted: Sequence[str], progress: Progress | None) -> None:
    """Compile those kernels that have not been compiled; a few are left to the first call of each."""
    there = _done()
    lacking = [name for name in wanted if not (there / name).exists()]
    if len(lacking) < FEW:
        return
    if progress is None:
        sys.stderr.write(f"{LABEL}: up to half a minute.\n")
    else:
        progress(LABEL, 0, len(lacking))

    def report() -> None:
        if progress is not None:
            progress(LABEL, sum((there / name).exists() for name in lacking), len(lacking))

    with _alone(there, report):
        left = [name for name in lacking if not (there / name).exists()]
        if left:
            _know_types()
        with tempfile.TemporaryDirectory() as claims, _helpers(claims, left) as helpers:
            for _ in _share(Path(claims), left):
                report()
            while any(helper.poll() is None for helper in helpers):
                time.sleep(0.02)
    if progress is not None:
        progress(LABEL, len(lacking), len(lacking))


@contextmanager
def _alone(there: Path, report: Callable[[], None]) -> Iterator[None]:
    """Let one process at a time compile: others would compile the same, and need not any more when their turn comes."""
    handle = None
    with suppress(OSError):  # a folder that cannot be written to: each process for itself
        there.mkdir(parents=True, exist_ok=True)
        while (handle := try_lock(there / ".lock")) is None:
            report()
            time.sleep(0.1)
    try:
        yield
    finally:
        if handle is not None:
            os.close(handle)


def _know_types() -> None:
    """Make one of each group of arrays: their types are the same for every case."""
    case = load_case("han2021")
    packed = pack(case)
    course = Course(case, packed, np.zeros(packed.state_size))
    make_tangent(course.system, course.run, np.zeros((0, 0)))


def _share(claims: Path, wanted: Sequence[str]) -> Iterator[str]:
    """Compile those that nobody else has claimed in a folder; yield each."""
    there = _done()
    for name in wanted:
        try:
            (claims / name).touch(exist_ok=False)
        except FileExistsError:
            continue
        KERNELS[name].address()
        with suppress(OSError):  # a folder that cannot be written to holds no compiled code either
            (there / name).touch()
        yield name


@contextmanager
def _helpers(claims: str, wanted: Sequence[str]) -> Iterator[list["subprocess.Popen[bytes]"]]:
    """Start processes that share the work; end them if it ends early. Without any, where none can be started."""
    count = min(worker_count() - 1, MOST_HELPERS, len(wanted) // FEW) if sys.executable else 0
    words = [sys.executable, "-m", __name__, claims, *wanted]
    helpers = []
    try:
        with suppress(OSError):
            for _ in range(count):
                helpers.append(subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        yield helpers
    finally:
        for helper in helpers:
            helper.terminate()
            helper.wait()


if __name__ == "__main__":
    _know_types()
    for _ in _share(Path(sys.argv[1]), sys.argv[2:]):
        pass
