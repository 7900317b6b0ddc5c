"""The compiled kernels: one shared library, named by its sources, loaded by the operating system's loader.

A wheel carries the library of its platform. Where there is none of these very sources, as after an edit, it is built on first
use by `gearplay.build` in a process of its own.
"""

import ctypes
import hashlib
import os
import stat
import subprocess
import sys
import threading
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final

from gearplay.vocabulary.errors import GearplayError

WHERE: Final = "GEARPLAY_LIBRARY"
"""Environment variable that names the folder of libraries, in place of the package's own and the user's cache."""
PACKAGE: Final = Path(__file__).parents[1]
OWN: Final = PACKAGE / "_library"
"""The folder of libraries within the package."""
SUFFIX: Final = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
DIGITS: Final = 16
"""Length of a digest within a file's name."""

_loading = threading.RLock()


class LibraryError(GearplayError):
    """The kernel library of this installation is missing and cannot be built, or must not be loaded."""


def source_files(package: Path = PACKAGE) -> list[Path]:
    """Return the source files of all kernels, and of what compiles them."""
    files = [file for room in ("build", "integrate", "kernels") for file in (package / room).rglob("*.py")]
    laws = (file for file in (package / "parts").rglob("*.py") if b"gearplay.kernels" in file.read_bytes())
    return sorted([*files, *laws])


def source_digest(package: Path = PACKAGE) -> str:
    """Return the digest of the kernels' sources: the only key of a library, and of a motion that it can follow."""
    whole = hashlib.sha256()
    for file in source_files(package):
        whole.update(file.relative_to(package).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return whole.hexdigest()[:DIGITS]


SOURCES: Final = source_digest()
"""The digest of the sources that this process has imported."""


def folders() -> list[Path]:
    """Return where libraries are, the first choice first."""
    if os.environ.get(WHERE):
        return [Path(os.environ[WHERE])]
    kept = os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME")
    home = kept or os.path.expanduser("~/Library/Caches" if sys.platform == "darwin" else "~/.cache")
    return [OWN] if home.startswith("~") else [OWN, Path(home) / "gearplay"]  # without a home there is none


def content_digest(content: bytes) -> str:
    """Return the digest that ends the name of a library's file."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def find(folder: Path, suffix: str = SUFFIX) -> Path | None:
    """Return the library of these sources in a folder; None if it is missing, or its content does not match its name.

    Raises `LibraryError` where another user could replace it.
    """
    for file in sorted(folder.glob(f"gearplay-{SOURCES}-*{suffix}")):
        check_owner(file)
        if file.stem.rpartition("-")[2] == content_digest(file.read_bytes()):
            return file
    return None


def check_owner(file: Path) -> None:
    """Raise `LibraryError` where somebody other than the user, the owner of the package and root may replace a file."""
    if os.name == "nt":
        return
    trusted = {0, os.geteuid(), PACKAGE.stat().st_uid}
    within = file.parent == OWN  # no easier to replace than the package's own sources
    allowed = stat.S_IMODE(PACKAGE.stat().st_mode) if within else 0
    for place in (file, file.parent):
        status = place.stat()
        others = status.st_mode & (stat.S_IWOTH | (0 if status.st_gid == os.getegid() else stat.S_IWGRP))
        if status.st_uid not in trusted or others & ~allowed:
            raise LibraryError(
                f"{file}: another user may replace this kernel library, so it is not loaded. Make {place} writable to yourself"
                f" alone, or name another folder: set {WHERE}."
            )


@cache
def _load() -> ctypes.CDLL:
    found = next(filter(None, map(find, folders())), None)
    if found is None:
        _build()
        found = next(filter(None, map(find, folders())), None)
    if found is None:
        raise LibraryError(f"The kernel library was built, but is not in {', '.join(map(str, folders()))}.")
    return ctypes.CDLL(str(found))


def library() -> ctypes.CDLL:
    """Return the kernel library, loaded or built on the first call.

    Raises `LibraryError` where there is none and it cannot be built.
    """
    with _loading:
        return _load()


def _build() -> None:
    """Build the library, in a process that shows its progress on standard error."""
    paths = [str(PACKAGE.parent), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    if not sys.executable:
        raise LibraryError(
            "There is no kernel library, and no Python program to build it: run `python -m gearplay.build`."
        )
    with subprocess.Popen(
        [sys.executable, "-m", "gearplay.build"], env=environment, stdout=subprocess.PIPE, text=True
    ) as builder:
        try:
            said, _ = builder.communicate()
        except BaseException:
            with suppress(OSError):
                builder.terminate()
            raise
    if builder.returncode != 0:
        lines = said.strip().splitlines() or [f"exit code {builder.returncode}"]
        raise LibraryError(f"The kernel library could not be built: {lines[-1]}")
