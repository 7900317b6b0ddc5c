"""`view`: the mechanism of a case or a result in motion, in a notebook or as a page."""

from __future__ import annotations

import html
import os
from dataclasses import dataclass, field
from pathlib import Path

from gearplay.files.atomic import check_new, write_bytes
from gearplay.model.reading import Source
from gearplay.results.choice import time_window
from gearplay.results.result import Result
from gearplay.results.simulate import simulate
from gearplay.results.staging import Motion, motion_in
from gearplay.results.titles import window_words
from gearplay.web.player import player_page

FRAMES = 900


@dataclass(frozen=True)
class View:
    """A page that plays a motion; a notebook shows it in place.

    Attributes
    ----------
    html : str
        The page, which needs no other file.

    """

    html: str = field(repr=False)

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Write the page; `InputError` where the file exists and ``overwrite`` is false, or it cannot be written."""
        check_new(Path(path), overwrite=overwrite)
        write_bytes(Path(path), self.html.encode("utf-8"), overwrite=overwrite)

    def _repr_html_(self) -> str:
        style = "width: 100%; height: 36em; border: 0"
        return (
            f'<iframe title="mechanism in motion" style="{style}" srcdoc="{html.escape(self.html)}"></iframe>'
        )


def view(
    source: Source | Result,
    *,
    window: tuple[float | None, float | None] | None = None,
    at: str | None = None,
    magnify: float = 1.0,
) -> View:
    """Return the mechanism in motion, with play, slow motion and close-ups of sleeve and mesh.

    Parameters
    ----------
    source
        A `Result` that kept the signals of its rotors; or a case, which is simulated.
    window
        First and last time [s], None for an open end; the record if not given.
    at
        The rotor or mesh of the close-up.
    magnify
        Small motions are drawn so many times larger than usual, 0.001 to 1000.

    Returns
    -------
    View
        Shows itself in a notebook; ``.save(path)`` writes the page.

    Raises
    ------
    InputError
        For a result without the signals, a window or a place that is not there.

    Examples
    --------
    >>> import gearplay as gp
    >>> motion = gp.view("han2021", window=(0.5, 0.6))
    >>> motion.html.startswith("<!doctype html>")
    True

    """
    result = source if isinstance(source, Result) else simulate(source)
    motion = motion_in(result, time_window(result, window), at=at, frames=FRAMES)
    return View(result_page(result, motion, magnify))


def result_page(result: Result, motion: Motion, magnify: float) -> str:
    """Return the page of a motion of a result, HTML that needs no other file."""
    span = (motion.start, motion.start + float(motion.frames["t"][-1]))
    return player_page(
        motion.mechanism,
        motion.frames,
        model=result.case.backlash_model,
        title=motion.title,
        words=f"{window_words(span)}; clearances and small motions are drawn larger than they are",
        start=motion.start,
        magnify=magnify,
        look=motion.look,
    )
