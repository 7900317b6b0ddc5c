"""Building of the kernel library: one process at a time in a folder, complete or not at all."""

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from gearplay.build.archive import ARCHIVE, archive
from gearplay.build.header import header
from gearplay.build.linking import link
from gearplay.build.objects import forms_object, object_files
from gearplay.build.targets import TARGETS, host
from gearplay.kernels.compiled_once import KERNELS
from gearplay.kernels.library import SOURCES, WHERE, LibraryError, find, folders, source_digest
from gearplay.vocabulary.file_lock import try_lock

STAYING = 4
"""Libraries of other sources that stay in a folder, the latest."""
DAYS = 30.0
"""Days after which an object file that no build used goes."""


def build(
    targets: Sequence[str],
    progress: Callable[[int, int], None],
    *,
    folder: Path | None = None,
    static: bool = False,
    waiting: Callable[[Path], None] = lambda _: None,
) -> dict[str, Path]:
    """Build the libraries of these sources for some platforms where they are not there; return their files.

    ``folder`` is where they go, that of this installation where None; ``progress`` gets what is compiled of all
    that is compiled, ``waiting`` the folder where another process builds there first. ``static`` libraries are archives of object
    files, to be linked into others.

    Raises `LibraryError` where one cannot be built.
    """
    place = folder or next(filter(_takes_files, folders()), None)
    if place is None:
        tried = " or ".join(map(str, folders()))
        raise LibraryError(f"No folder for it can be written to ({tried}). Name one: set {WHERE}.")
    place.mkdir(parents=True, exist_ok=True)
    with _alone(place, waiting):
        places = {each: place if each == host() else place / each for each in targets}
        found = {each: find(places[each], ARCHIVE if static else TARGETS[each].suffix) for each in targets}
        if None in found.values():
            objects = object_files(place / "objects", targets, progress)
            if source_digest() != SOURCES:
                raise LibraryError("The kernels' sources changed while it was built. Start again.")
            (place / "gearplay.h").write_text(header(list(KERNELS.values())), encoding="ascii")
            for each, at in places.items():
                at.mkdir(exist_ok=True)
                if static:
                    found[each] = archive(
                        objects[each], sorted(kernel.symbol for kernel in KERNELS.values()), at
                    )
                else:
                    found[each] = link(each, [*objects[each], forms_object(place / "objects", each)], at)
            _forget_old(place)
    return {each: file for each, file in found.items() if file is not None}


def _takes_files(folder: Path) -> bool:
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    return False


@contextmanager
def _alone(folder: Path, waiting: Callable[[Path], None]) -> Iterator[None]:
    """Hold the lock of a folder, so that one process at a time builds there; ``waiting`` is called once where another has it."""
    handle = try_lock(folder / ".lock")
    if handle is None:
        waiting(folder)
    while handle is None:
        time.sleep(0.1)
        handle = try_lock(folder / ".lock")
    try:
        yield
    finally:
        os.close(handle)


def _forget_old(folder: Path) -> None:
    """Remove libraries of other sources except the latest, and object files unused for long."""
    others = [file for file in folder.glob("gearplay-*-*") if f"-{SOURCES}-" not in file.name]
    for file in sorted(others, key=lambda each: each.stat().st_mtime)[: -(STAYING - 1)]:
        file.unlink(missing_ok=True)
    for file in (folder / "objects").iterdir():
        if time.time() - file.stat().st_mtime > DAYS * 86400.0:
            file.unlink(missing_ok=True)
