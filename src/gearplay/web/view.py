"""`view`: the mechanism of a case or a result in motion, in a notebook, as a page, or as a film."""

from __future__ import annotations

import html
import json
import os
import threading
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from gearplay.files.atomic import check_new, write_bytes
from gearplay.model.reading import Source
from gearplay.pictures.pages import render_page
from gearplay.results.choice import time_window
from gearplay.results.result import Result
from gearplay.results.simulate import simulate
from gearplay.results.staging import Motion, motion_in, stage_of
from gearplay.results.titles import window_words
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.progress import Progress
from gearplay.web.bundle import script_of

FORMS: Final = (".html", ".gif", ".mp4")
DIGITS: Final = 6
"""Significant digits of numbers in a page."""


@dataclass(frozen=True, repr=False)
class View:
    """The mechanism of a result in motion; a notebook shows its page in place."""

    result: Result
    motion: Motion
    magnify: float = 1.0

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.motion.frames["t"])

    @cached_property
    def html(self) -> str:
        """The page, HTML that needs no other file."""
        motion, model = self.motion, self.result.case.backlash_model
        frames = {name: _numbers(values) for name, values in motion.frames.items()}
        shown = {
            "mechanism": motion.mechanism,
            "models": {model: {"frames": frames}},
            "start": motion.start,
            "magnify": self.magnify,
            "look": motion.look,
        }
        text = json.dumps(shown, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
        span = window_words((motion.start, motion.start + float(motion.frames["t"][-1])))
        words = f"{span}; clearances and small motions are drawn larger than they are"
        return render_page(
            "gearplay.web",
            "player.html",
            title=motion.title,
            words=words,
            result=text,
            script=script_of("player"),
        )

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        overwrite: bool = False,
        progress: Progress | None = None,
        stop: threading.Event | None = None,
    ) -> None:
        """Write the page, ``.html``, or a film, ``.gif`` or ``.mp4`` (by ffmpeg).

        ``progress`` and ``stop`` are those of `gearplay.simulate`, for films. Raises `InputError` for another extension, where
        ffmpeg is missing, the file exists and ``overwrite`` is false, or it cannot be written.
        """
        place = Path(path)
        form = check_form(place)
        check_new(place, overwrite=overwrite)
        content = self.html.encode("utf-8") if form == ".html" else self._film(form, progress, stop)
        write_bytes(place, content, overwrite=overwrite)

    def _film(self, form: str, progress: Progress | None, stop: threading.Event | None) -> bytes:
        from gearplay.pictures.moving import gif_bytes, mp4_bytes

        stage = stage_of(self.motion, self.magnify)

        def show(i: int) -> None:
            if stop is not None and stop.is_set():
                raise KeyboardInterrupt
            stage.show(i)
            if progress is not None:
                progress("drawing", i + 1.0, float(self.frames))

        if form == ".mp4":
            return mp4_bytes(stage.figure, self.frames, show)
        return gif_bytes(stage.figure, self.frames, show, typical=stage.loudest())

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
    frames: int = 900,
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
        Factor on the usual magnification of small motions, 0.001 to 1000.
    frames
        Largest number of frames.

    Returns
    -------
    View
        Shows itself in a notebook; ``.html`` is the page, ``.save(path)`` writes it, or a film.

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
    return View(result, motion_in(result, time_window(result, window), at=at, frames=frames), magnify)


def check_form(path: Path) -> str:
    """Return the extension of a page or film; `InputError` for another one, or for a film where ffmpeg is missing."""
    form = path.suffix.lower()
    if form not in FORMS:
        rule = f"must end in {', '.join(FORMS)}"
        raise InputError.of("out", path.name, rule, "Choose another extension")
    if form == ".mp4":
        from gearplay.pictures.moving import has_mp4

        if not has_mp4():
            rule = "needs ffmpeg, which is not installed"
            raise InputError.of("out", path.name, rule, "Install ffmpeg, or write a .gif or a .html")
    return form


def _numbers(values: Any) -> list[float]:
    """Return an array flat, rounded to the digits of a drawing; NaN and infinities as 0."""
    flat = np.nan_to_num(np.asarray(values, dtype=float).ravel(), posinf=0.0, neginf=0.0)
    return [float(f"{value:.{DIGITS}g}") for value in flat]
