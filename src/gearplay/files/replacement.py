"""Atomic replacement of an output folder through a staging directory."""

import os
import shutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TypeVar

from gearplay.files.atomic import make_folder, shown_path, write_text
from gearplay.files.folder_lock import locked
from gearplay.vocabulary.errors import ResourceError, TakenError

Done = TypeVar("Done")

PLACE, OF, WHOLE = ".new", ".of", ".whole"
"""Name of the staging directory; of the file with the identity of an unfinished result; of the mark of a complete result."""


def renewal(
    folder: Path,
    *,
    overwrite: bool,
    of: str,
    whole: Sequence[str],
    forget: Callable[[Path], None],
    anew: bool = False,
) -> Path:
    """Return the working directory of a folder locked by the caller: itself, or a staging directory if its result is complete.

    ``of`` identifies the plan: unfinished work of the same plan, not yet passed to `replace_old`, is resumed in either place. A
    result is complete where a file of the names ``whole`` exists; ``forget`` removes a folder's result. A complete result that is
    still in staging replaces the old one first. With ``anew`` nothing is resumed: see `renewed`.
    """
    settle(folder, forget)
    if not overwrite or (_is_of(folder, of) and not anew):
        return folder
    if not any((folder / name).exists() for name in whole):
        (folder / OF).unlink(missing_ok=True)  # first: a half removed result must not be resumed
        forget(folder)
        write_text(folder / OF, of)
        return folder
    place = folder / PLACE
    if anew or not _is_of(place, of):
        shutil.rmtree(place, ignore_errors=True)
        make_folder(place)
        write_text(place / OF, of)
    return place


def _is_of(place: Path, of: str) -> bool:
    try:
        return (place / OF).read_text(encoding="utf-8") == of
    except (OSError, ValueError):
        return False


def renewed(
    begin: Callable[..., Path], work: Callable[[Path], Done], *, overwrite: bool
) -> tuple[Path, Done]:
    """Return the directory of ``work`` and its result; ``begin`` is `renewal`, repeated with ``anew`` after a `TakenError`.

    `TakenError` means that the unfinished result cannot be resumed: it is damaged, or belongs to another plan.
    """
    place = begin()
    try:
        return place, work(place)
    except TakenError:
        if not overwrite:
            raise
    place = begin(anew=True)
    return place, work(place)


def replace_old(folder: Path, place: Path, forget: Callable[[Path], None]) -> None:
    """Move a complete result from the staging directory into its folder, if any, and end the renewal."""
    if place != folder:
        write_text(place / WHOLE, "")
        settle(folder, forget)
    with suppress(OSError):  # the result is in its place, whatever the disk does now
        (folder / OF).unlink(missing_ok=True)


def settle_alone(folder: Path, forget: Callable[[Path], None]) -> None:
    """Do what `settle` does for a folder that the caller does not hold, alone in it; nothing where there is nothing to do."""
    if (folder / PLACE / WHOLE).exists():
        with locked(folder):
            settle(folder, forget)


def settle(folder: Path, forget: Callable[[Path], None]) -> None:
    """Put a new whole result into the place of the old one, where there is such; a kill on the way only puts it off.

    Raises `ResourceError` where the disk fails, which puts it off too.
    """
    try:
        _settle(folder, forget)
    except OSError as error:
        raise ResourceError(
            f"out = {shown_path(folder)}: the new result could not be put into its place ({error.strerror or error}). "
            f"It is whole in {PLACE} there: see to the disk, then the same command goes on."
        ) from None


def _settle(folder: Path, forget: Callable[[Path], None]) -> None:
    place = folder / PLACE
    if not (place / WHOLE).exists():
        return
    names = sorted(
        each.name for each in place.iterdir() if each.name not in (OF, WHOLE) and each.suffix != ".part"
    )
    if (place / OF).exists():
        forget(folder)
        os.replace(place / OF, folder / OF)  # from here on only moves are left
    for name in names:
        if (place / name).is_dir():
            shutil.rmtree(folder / name, ignore_errors=True)
        os.replace(place / name, folder / name)
    shutil.rmtree(place)
