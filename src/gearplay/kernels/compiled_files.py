"""Compiled kernels on disk: one folder per version of the package, one file per kernel, headed by its digest.

What is written is machine code: whoever may write into the folder may also write the package, and no file that a user is sent
comes from here.
"""

import hashlib
import json
import os
import shutil
import sys
import tempfile
import uuid
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Final

from gearplay.kernels.machine_code import Code, processor

VERSIONS: Final = 4
"""Folders of versions that stay, the latest: compiled code of a package that was updated is of no use."""
NAME: Final = "code-"
SIZE: Final = hashlib.sha256().digest_size
WHERE: Final = "NUMBA_CACHE_DIR"
"""The environment's variable that names where compiled code is kept."""
SETTINGS: Final = (
    "BOUNDSCHECK", "CPU_FEATURES", "CPU_NAME", "DEBUGINFO", "DISABLE_INTEL_SVML", "ENABLE_AVX", "ENABLE_PROFILING",
    "FORCE_ERROR_MODEL", "LLVM_REFPRUNE_FLAGS", "LLVM_REFPRUNE_PASS", "LOOP_VECTORIZE", "OPT", "SLP_VECTORIZE",
)  # fmt: skip
"""Of numba, which change the code: in the environment, or in a file of its own."""

not_kept: list[str] = []
"""Why compiled code could not be written, in words, once in a process; for the solver to report."""


def kernel_digest(folder: Path) -> str:
    """Return a digest of all sources in a folder and below that define kernels or what is compiled with them."""
    files = [file for file in sorted(folder.rglob("*.py")) if _has_kernels(file.relative_to(folder), file)]
    return hashlib.sha256(
        b"".join(str(f.relative_to(folder)).encode() + b"\0" + f.read_bytes() for f in files)
    ).hexdigest()


def _has_kernels(place: Path, file: Path) -> bool:
    """Return whether a module is of the kernels or the integration, or of a part's law."""
    room, *inner = place.parts
    return room in ("kernels", "integrate") or (
        room == "parts" and len(inner) > 1 and b"gearplay.kernels" in file.read_bytes()
    )


@cache
def compiled_from() -> str:
    """Return a digest of all that compiled code depends on: sources, compiler and its settings, Python, processor."""
    settings = [os.environ.get(f"NUMBA_{name}") for name in SETTINGS]
    with suppress(OSError):
        settings.append(Path(".numba_config.yaml").read_text(encoding="utf-8", errors="replace"))
    parts = (kernel_digest(Path(__file__).parents[1]), version("numba"), sys.version, *processor(), settings)
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def _places() -> list[Path]:
    """Return where compiled code may be kept, the best first: folders that hold nothing of anybody else's by such a name."""
    if os.environ.get(WHERE):
        return [Path(os.environ[WHERE]) / "gearplay"]
    kept = os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME")
    home = kept or os.path.expanduser("~/Library/Caches" if sys.platform == "darwin" else "~/.cache")
    at_home = [] if home.startswith("~") else [Path(home) / "gearplay"]  # without a home there is none
    return [Path(__file__).parent / "__pycache__", *at_home]


@cache
def code_folder() -> Path | None:
    """Return the folder of this version's compiled code; None, and a note, where no place can be written to."""
    for place in _places():
        with suppress(OSError):
            place.mkdir(parents=True, exist_ok=True)
            folder = place / f"{NAME}{compiled_from()}"
            with tempfile.TemporaryFile(dir=place):
                if folder.is_dir():
                    os.utime(folder)  # what is in use stays when old ones go
                return folder
    note("no folder that could be written to")
    return None


def make_folder(folder: Path) -> None:
    """Make a folder of compiled code, where it is not there, and remove old ones beside it."""
    if not folder.is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        forget_old(folder)


def file_of(name: str) -> Path | None:
    """Return the file of a kernel's compiled code, which may not be there; None where none is kept."""
    folder = code_folder()
    return None if folder is None else folder / f"{name}.code"


def load(file: Path, form: str) -> Code | None:
    """Return what was saved; None where there is nothing, or what is there is damaged, or of another form."""
    try:
        whole = file.read_bytes()
    except OSError:
        return None
    digest, rest = whole[:SIZE], whole[SIZE:]
    if hashlib.sha256(rest).digest() != digest:
        return None
    head, _, content = rest.partition(b"\n")
    symbol, needs, made_for = json.loads(head)
    return Code(symbol, needs, content) if made_for == form else None


def save(file: Path, code: Code, form: str) -> None:
    """Save what was compiled for a form (`Signed.form`); where that fails say why, once: the code runs all the same."""
    rest = json.dumps([code.symbol, code.needs, form]).encode() + b"\n" + code.content
    beside = file.with_name(f"{file.name}.{uuid.uuid4().hex[:16]}")
    try:
        make_folder(file.parent)
        beside.write_bytes(hashlib.sha256(rest).digest() + rest)
        os.replace(beside, file)
    except OSError as error:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        note(f"{file.parent.parent}: {error.strerror or error}")


def note(why: str) -> None:
    """Record the first reason why compiled code could not be written."""
    if not not_kept:
        not_kept.append(why)


def forget_old(newest: Path) -> None:
    """Remove folders of other versions beside one, but for the latest: another process that needs one compiles anew."""
    others = []
    with suppress(OSError):
        for folder in newest.parent.glob(f"{NAME}*"):
            if folder != newest and folder.is_dir() and not folder.is_symlink():
                others.append((folder.stat().st_mtime, folder))
    for _, folder in sorted(others)[: -(VERSIONS - 1)]:
        shutil.rmtree(folder, ignore_errors=True)
