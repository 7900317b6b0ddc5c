"""`gearplay animate RUN.nc`: the mechanism of a stored result in motion."""

from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.interrupts import interruptible
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.plot import Run, Window, result_in, window_of
from gearplay.cli.progress import progress_bar

FRAMES = {".html": 900, ".gif": 120, ".mp4": 240}
"""Default number of frames by the extension of the file."""
MOST = 2000


def animate(
    run: Run,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="A .html, .gif or .mp4 (by ffmpeg) [default: RUN-motion.html]."),
    ] = None,
    window: Window = None,
    at: Annotated[
        str | None, typer.Option("--at", help="Rotor or mesh of the close-up.", show_default=False)
    ] = None,
    magnify: Annotated[
        float,
        typer.Option(
            "--magnify", min=1e-3, max=1e3, help="Factor on the usual magnification of small motions."
        ),
    ] = 1.0,
    frames: Annotated[
        int | None, typer.Option("--frames", min=2, max=MOST, help="Number of frames; 900, fewer in a film.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")] = False,
    json: Json = False,
) -> None:
    """Show a result's mechanism in motion: a page, a GIF or a film.

    Without --window a GIF or a film shows a few mesh periods about the largest force.
    """
    import gearplay as gp
    from gearplay.files.atomic import check_new
    from gearplay.results.choice import time_window
    from gearplay.results.staging import loud_window
    from gearplay.web.view import check_form

    place = out or Path(run).with_name(f"{Path(run).stem}-motion.html")
    form = check_form(place)
    check_new(place, overwrite=overwrite)
    result = result_in(run)
    span = time_window(result, window_of(window))
    if window is None and form != ".html":
        span = loud_window(result, span)
    made = gp.view(result, window=span, at=at, magnify=magnify, frames=frames or FRAMES[form])
    with interruptible() as stop, progress_bar(quiet=json) as report:
        made.save(place, overwrite=overwrite, progress=report, stop=stop)
    if json:
        print_json({"status": "done", "out": str(place), "window": list(span), "frames": made.frames})
        return
    size = f"{place.stat().st_size / 1e6:.2g} MB"
    print_text(f"Wrote {place}: {made.frames} frames, {span[0]:.6g} to {span[1]:.6g} s, {size}")
