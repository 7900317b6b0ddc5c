"""A folder whose whole result is to be replaced: the new one is made in a place of its own, the old one stays until then."""

import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from gearplay.files.atomic import make_folder, shown_path, write_text
from gearplay.vocabulary.errors import ResourceError

PLACE, OF, WHOLE = ".new", ".of", ".whole"
"""The place in the folder; in it, what it is of, and the mark that it is whole."""


def renewal(
    folder: Path, *, overwrite: bool, of: str, whole: Sequence[str], forget: Callable[[Path], None]
) -> Path:
    """Return where to work for a folder, which the caller holds: in it, or, to replace a whole result, in a place of its own.

    ``of`` tells plans apart: what was begun for the same one goes on. A result is whole where a file of the names ``whole`` is
    there; ``forget`` removes what a folder holds of a result. What was made whole and not put into its place is put there first.
    """
    settle(folder, forget)
    if not overwrite:
        return folder
    if not any((folder / name).exists() for name in whole):
        forget(folder)
        return folder
    place = folder / PLACE
    if not (place / OF).is_file() or (place / OF).read_text(encoding="utf-8") != of:
        shutil.rmtree(place, ignore_errors=True)
        make_folder(place)
        write_text(place / OF, of)
    return place


def replace_old(folder: Path, place: Path, forget: Callable[[Path], None]) -> None:
    """Put what was made in a place of its own into its folder; nothing where that is the folder itself."""
    if place != folder:
        write_text(place / WHOLE, "")
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
    names = sorted(each.name for each in place.iterdir() if each.name not in (OF, WHOLE))
    if (place / OF).exists():
        forget(folder)
        (place / OF).unlink()  # from here on only moves are left
    for name in names:
        if (place / name).is_dir():
            shutil.rmtree(folder / name, ignore_errors=True)
        os.replace(place / name, folder / name)
    shutil.rmtree(place)
