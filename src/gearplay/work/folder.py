"""Output folders: exclusive lock, resumption, and atomic replacement through a staging directory."""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from gearplay.files.atomic import make_folder, shown_path, write_text
from gearplay.vocabulary.errors import InputError, ResourceError, TakenError
from gearplay.vocabulary.file_lock import try_lock

Done = TypeVar("Done")

LOCK = ".lock"
STAGING, IDENTITY, COMPLETE = ".new", ".of", ".whole"
"""Name of the staging directory; of the file with the identity of an unfinished result; of the mark of a complete result."""


@dataclass(frozen=True)
class OutputFolder:
    """A folder that holds the result of one plan, complete, or unfinished and resumable.

    ``is_complete`` returns whether the folder has a complete result; ``remove`` deletes a result, finished or not.
    """

    path: Path
    is_complete: Callable[[Path], bool]
    remove: Callable[[Path], None]

    def run(
        self, work: Callable[[Path], Done], *, identity: str, overwrite: bool = False, part: str = ""
    ) -> Done:
        """Return ``work(place)``, alone in the folder; ``place`` is where the result is made.

        That is the folder itself, or its staging directory where ``overwrite`` replaces a complete result, which stays until the
        new one is complete. ``identity`` is that of the plan: interrupted work of the same plan is resumed in either place.
        With ``part`` others work on their parts at the same time.

        Raises `InputError` where another process holds the folder, `TakenError` where it holds another result and ``overwrite``
        is false, `ResourceError` where the disk fails.
        """
        self.finish_replacement()
        with locked(self.path, part=part):
            place = self.place(identity, overwrite=overwrite)
            try:
                done = work(place)
            except TakenError:  # damaged, or of another plan
                if not overwrite:
                    raise
                place = self.place(identity, overwrite=True, anew=True)
                done = work(place)
            if not part:
                self.replace_with(place)
        return done

    def place(self, identity: str, *, overwrite: bool, anew: bool = False) -> Path:
        """Return the working directory of the folder, which the caller has locked: itself or its staging directory.

        A complete result that is still in staging replaces the old one first. With ``anew`` nothing is resumed.
        """
        self._move_in()
        if not overwrite or (self._is_of(self.path, identity) and not anew):
            return self.path
        if not self.is_complete(self.path):
            (self.path / IDENTITY).unlink(missing_ok=True)  # first: a half removed result must not be resumed
            self.remove(self.path)
            write_text(self.path / IDENTITY, identity)
            return self.path
        place = self.path / STAGING
        if anew or not self._is_of(place, identity):
            shutil.rmtree(place, ignore_errors=True)
            make_folder(place)
            write_text(place / IDENTITY, identity)
        return place

    def replace_with(self, place: Path) -> None:
        """Move a complete result from the staging directory into the folder, if it was made there."""
        if place != self.path:
            write_text(place / COMPLETE, "")
            self._move_in()
        with suppress(OSError):  # the result is in its place by now
            (self.path / IDENTITY).unlink(missing_ok=True)

    def finish_replacement(self) -> None:
        """Finish an interrupted replacement, as the only user of the folder; do nothing if there is none."""
        if (self.path / STAGING / COMPLETE).exists():
            with locked(self.path):
                self._move_in()

    @property
    def is_staging(self) -> bool:
        """Whether a new result is being made in the staging directory: the old one is still there."""
        return (self.path / STAGING).exists()

    @staticmethod
    def _is_of(place: Path, identity: str) -> bool:
        try:
            return (place / IDENTITY).read_text(encoding="utf-8") == identity
        except (OSError, ValueError):
            return False

    def _move_in(self) -> None:
        """Replace the old result by a complete one in staging, if there is one; a kill on the way only postpones it."""
        place = self.path / STAGING
        if not (place / COMPLETE).exists():
            return
        marks = (IDENTITY, COMPLETE)
        try:
            names = sorted(
                each.name for each in place.iterdir() if each.name not in marks and each.suffix != ".part"
            )
            if (place / IDENTITY).exists():
                self.remove(self.path)
                os.replace(place / IDENTITY, self.path / IDENTITY)  # from here on only moves are left
            for name in names:
                if (place / name).is_dir():
                    shutil.rmtree(self.path / name, ignore_errors=True)
                os.replace(place / name, self.path / name)
            shutil.rmtree(place)
        except OSError as error:
            raise ResourceError(
                f"out = {shown_path(self.path)}: the new result could not be moved to its place ({error.strerror or error}). "
                f"It is complete in {STAGING} there: check the disk, then the same command goes on."
            ) from None


@contextmanager
def locked(folder: Path, *, part: str = "") -> Iterator[None]:
    """Lock a folder, or with ``part`` one part of it independently; `InputError` where another process holds the lock.

    The system releases the lock with its process, so a killed process leaves no stale lock.
    """
    make_folder(folder)
    handles: list[int] = []
    try:
        handles.append(_lock(folder, LOCK, shared=bool(part)))
        if part:
            handles.append(_lock(folder, f"{LOCK}-{part}", shared=False))
        yield
    finally:
        for handle in handles:
            os.close(handle)


def _lock(folder: Path, name: str, *, shared: bool) -> int:
    try:
        handle = try_lock(folder / name, shared=shared)
    except OSError as error:
        rule = f"must be a folder that can be written ({error.strerror})"
        raise InputError.of("out", shown_path(folder), rule, "Choose another place") from None
    if handle is None:
        rule = "must not be in use by another process"
        raise InputError.of("out", shown_path(folder), rule, "Wait for it, or choose another folder")
    return handle
