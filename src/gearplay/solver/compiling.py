"""Compilation of the kernels of a case in advance, by several processes.

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

from gearplay.integrate.dispatch import DERIVATIVE
from gearplay.integrate.tangent_state import make_tangent
from gearplay.kernels.compiled import INTERPRETED
from gearplay.kernels.compiled_files import code_folder, make_folder, not_kept
from gearplay.kernels.compiled_once import KERNELS
from gearplay.model.case import Case
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import load_case
from gearplay.parts.registry import KINDS
from gearplay.solver.integration import Course, refuse_fixed_steps
from gearplay.solver.pace import duration_words, note_pace, seconds_for, share_of_cores
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.file_lock import try_lock
from gearplay.vocabulary.progress import Progress

MOST_HELPERS = 3
FEW = 6
"""Number of kernels below which nothing is reported: the first call of each compiles it."""
OFTEN = 20.0  # s between words where there is no bar
_OF_DERIVATIVE = ("tangent", "tangent_state", "saltation", "slopes", "unbalance", "linear")
_SELDOM = ("accelerate", "applied_torque", "shaft_power", "fill_powers", "mesh_powers")
"""Kernels that few runs need, or that only evaluate a finished run: the first call of each compiles it."""
_OF_JOINED = ("integrate_joined", "fill_joined_states", "joined_torque")
"""Kernels outside `gearplay.kernels.joined` that only rotors behind springs need."""
_LINEAR = {
    "contact_kinematics", "apply_forces", "linearise", "add_change", "torque_of", "torques_of", "initialise",
    "initialise_modes", "update_modes", "rates_of", "rate_of_change", "rates_at", "matrix_at", "strain_energies",
}  # fmt: skip
"""Functions that the matrices of the linear analysis need."""
_not_kept_told = False
_ready: set[tuple[frozenset[str], bool, bool]] = set()  # what this process has seen to be compiled
_ready_linear: set[frozenset[str]] = set()


def prepare(case: Case, *, derivative: bool = False, progress: Progress | None = None) -> None:
    """Compile the kernels that a case needs, on all cores, unless compiled already: some 15 s once after an installation.

    Parameters
    ----------
    case
        What is to be simulated; its kinds of elements decide.
    derivative
        Whether the exact derivative of the motion is needed too.
    progress
        Progress callback with the compiled amount, the total and a label with the expected duration; without it progress is
        reported on standard error.

    Raises `InputError` where the derivative of a run with fixed steps is requested.

    """
    if derivative:
        refuse_fixed_steps(case)
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
    kinds = _kinds(packed)
    if not INTERPRETED and kinds not in _ready_linear:
        wanted = _wanted(kinds, fixed=False, derivative=True)
        _compile([name for name in wanted if name.rpartition(".")[2] in _LINEAR], progress)
        _ready_linear.add(kinds)


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
        own = _kinds_of(module)
        room = module.rpartition(".")[2]
        of_derivative = question in DERIVATIVE or room in _OF_DERIVATIVE or question == "move_change"
        of_joined = room == "joined" or question in _OF_JOINED
        if (
            (not own or own & kinds)
            and (all_of_them or question not in _SELDOM)
            and (not of_joined or kinds & {"coupling", "support"})
            and (derivative or not of_derivative)
            and (fixed or "fixed_steps" not in module)
        ):
            wanted.append((-kernel.length, name))
    return [name for _, name in sorted(wanted)]


def _kinds_of(module: str) -> set[str]:
    """Return the kinds of elements whose law is a module, or else is in the same folder; empty for a module of no part."""
    own = {kind.name for kind in KINDS if f"{module}.".startswith(f"{kind.file.__name__}.")}
    return own or {kind.name for kind in KINDS if module.startswith(kind.file.__name__.rpartition(".")[0])}


def _lacking(names: Sequence[str]) -> list[str]:
    """Return those kernels that have not been compiled, by this process or into a folder that is kept."""
    there = code_folder()
    kept = set() if there is None else {file.name for file in there.glob("*.code")}
    return [name for name in names if not KERNELS[name].found and f"{name}.code" not in kept]


def _compile(wanted: Sequence[str], progress: Progress | None) -> None:
    """Compile those kernels that have not been compiled; a few are left to the first call of each."""
    there = code_folder()
    lacking = _lacking(wanted)
    if len(lacking) < FEW:
        return
    total, cores = _length(lacking), worker_count()
    processes = 1 + _helper_count(lacking)
    notes = None if there is None else there.parent
    seconds = seconds_for(total, processes, cores, notes)
    once = "once after an installation" if processes > 1 or notes is not None else "at every start"
    label = f"Compiling {_words_for(lacking)}, {once}, about {duration_words(seconds)}"
    told = progress or _said()
    told(label, 0, total)

    def report() -> None:
        told(label, total - _length(_lacking(lacking)), total)

    with _alone(there, report):
        left = _lacking(lacking)
        began, shared = time.monotonic(), share_of_cores(processes, cores)
        if left:
            _know_types()
        with tempfile.TemporaryDirectory() as claims, _helpers(claims, left) as helpers:
            for _ in _share(Path(claims), left):
                report()
            while any(helper.poll() is None for helper in helpers):
                time.sleep(0.02)
        if notes is not None and len(left) == len(lacking):
            note_pace(notes, total, time.monotonic() - began, shared)
    told(label, total, total)
    _tell_not_kept()


def _tell_not_kept() -> None:
    """Warn once, on standard error, that compiled code cannot be cached, with the cure."""
    global _not_kept_told
    if not_kept and not _not_kept_told:
        _not_kept_told = True
        sys.stderr.write(
            f"Compiled code cannot be kept ({not_kept[0]}), so every start compiles anew. "
            "Free or name a folder: set NUMBA_CACHE_DIR to one that can be written to.\n"
        )


def _length(names: Sequence[str]) -> int:
    return sum(KERNELS[name].length for name in names)


def _words_for(names: Sequence[str]) -> str:
    """Return the label of a compilation: number of kernels, and number of those for the derivative of the motion."""
    derivative = [
        name for name in names
        if name.rpartition(".")[2] in DERIVATIVE or name.rpartition(".")[0].rpartition(".")[2] in _OF_DERIVATIVE
    ]  # fmt: skip
    if len(derivative) == len(names):
        return f"{len(names)} kernels of the motion's derivative"
    beside = f", {len(derivative)} of them of its derivative" if derivative else ""
    return f"{len(names)} kernels of the motion{beside}"


def _said() -> Progress:
    """Return a callback that reports progress on standard error, one line at once and one every `OFTEN` seconds."""
    began = last = time.monotonic()

    def tell(label: str, done: float, total: float) -> None:
        nonlocal last
        now = time.monotonic()
        if done == 0 and now - began < 1.0:
            sys.stderr.write(f"{label}.\n")
        elif now - last > OFTEN and 0 < done < total:
            last = now
            left = duration_words((now - began) * (total - done) / done)
            sys.stderr.write(f"{100 * done / total:.0f} % compiled, about {left} left.\n")

    return tell


@contextmanager
def _alone(there: Path | None, report: Callable[[], None]) -> Iterator[None]:
    """Let one process at a time compile: others would compile the same, and need not any more when their turn comes."""
    handle = None
    if there is None:
        yield
        return
    with suppress(OSError):  # a folder that cannot be written to: each process for itself
        make_folder(there)
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
    """Compile the kernels that no other process has claimed in a folder; yield each."""
    for name in wanted:
        try:
            (claims / name).touch(exist_ok=False)
        except FileExistsError:
            continue
        KERNELS[name].address()
        yield name


def _helper_count(wanted: Sequence[str]) -> int:
    """Return the number of helper processes: none where their compiled code could not be cached."""
    possible = sys.executable and code_folder() is not None and not not_kept
    return min(worker_count() - 1, MOST_HELPERS, len(wanted) // FEW) if possible else 0


@contextmanager
def _helpers(claims: str, wanted: Sequence[str]) -> Iterator[list["subprocess.Popen[bytes]"]]:
    """Start processes that share the work; end them if it ends early. Without any, where none can be started."""
    count = _helper_count(wanted)
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
