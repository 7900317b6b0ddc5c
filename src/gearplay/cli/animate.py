"""`gearplay animate RUN.nc`: the mechanism of a stored result in motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gearplay.cli.interrupts import interruptible
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.plot import Run, Window, result_in, window_of
from gearplay.cli.progress import progress_bar

if TYPE_CHECKING:
    import threading

    from gearplay.results.result import Result
    from gearplay.results.staging import Motion
    from gearplay.vocabulary.progress import Progress

FORMS = {".html": 900, ".gif": 120, ".mp4": 240}
"""Extensions of the formats, with the default number of frames."""
MOST = 2000


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(animate)


def animate(
    run: Run,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="A .html, .gif or .mp4 (by ffmpeg) [default: RUN-motion.html]."),
    ] = None,
    window: Window = None,
    at: Annotated[
        str | None, typer.Option("--at", help="The rotor or mesh to look at closely.", show_default=False)
    ] = None,
    magnify: Annotated[
        float, typer.Option("--magnify", help="Draw small motions so many times larger than usual.")
    ] = 1.0,
    frames: Annotated[
        int | None, typer.Option("--frames", min=2, max=MOST, help="How many; 900, of a film fewer.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")] = False,
    json: Json = False,
) -> None:
    """Show a result's mechanism in motion: a page, a GIF or a film.

    A GIF or a film shows some mesh periods about the largest force, if --window does not say more.
    """
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.results.choice import time_window
    from gearplay.results.staging import loud_window, motion_in
    from gearplay.vocabulary.errors import Fault, InputError

    place = out or Path(run).with_name(f"{Path(run).stem}-motion.html")
    form = place.suffix.lower()
    if form not in FORMS:
        raise InputError(
            Fault("--out", place.name, f"must end in {', '.join(FORMS)}", "Choose another ending")
        )
    if form == ".mp4" and not _has_mp4():
        rule = "needs ffmpeg, which is not installed"
        raise InputError(Fault("--out", place.name, rule, "Install ffmpeg, or write a .gif or a .html"))
    if not 0.001 <= magnify <= 1000.0:
        raise InputError(
            Fault("--magnify", magnify, "must lie between 0.001 and 1000", "Write 2 for twice as large")
        )
    check_new(place, overwrite=overwrite)
    result = result_in(run)
    span = time_window(result, window_of(window))
    if window is None and form != ".html":
        span = loud_window(result, span)
    motion = motion_in(result, span, at=at, frames=frames or FORMS[form])
    with interruptible() as stop, progress_bar(quiet=json) as report:
        draw = _page if form == ".html" else _film
        content = draw(motion, magnify, form, result, report, stop)
    write_bytes(place, content, overwrite=overwrite)
    count = len(motion.frames["t"])
    if json:
        print_json({"status": "done", "out": str(place), "window": list(span), "frames": count})
    else:
        size = f"{len(content) / 1e6:.2g} MB"
        print_text(f"Wrote {place}: {count} frames, {span[0]:.6g} to {span[1]:.6g} s, {size}")


def _has_mp4() -> bool:
    from gearplay.pictures.moving import has_mp4

    return has_mp4()


def _page(motion: Motion, magnify: float, form: str, result: Result, *_: Any) -> bytes:
    from gearplay.web.view import result_page

    return result_page(result, motion, magnify).encode("utf-8")


def _film(
    motion: Motion, magnify: float, form: str, result: Result, report: Progress | None, stop: threading.Event
) -> bytes:
    from gearplay.pictures.moving import gif_bytes, mp4_bytes
    from gearplay.results.staging import stage_of

    stage, count = stage_of(motion, magnify), len(motion.frames["t"])

    def show(i: int) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stage.show(i)
        if report is not None:
            report("drawing", i + 1.0, float(count))

    if form == ".mp4":
        return mp4_bytes(stage.figure, count, show)
    return gif_bytes(stage.figure, count, show, typical=stage.loudest())
