"""Animated figures: GIF by Pillow, MP4 by ffmpeg where installed."""

import io
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

RATE = 20
"""Frames a second."""
DPI = 100
COLOURS = 64
Show = Callable[[int], Any]


def has_mp4() -> bool:
    """Return whether MP4 can be written: whether ffmpeg is installed."""
    from matplotlib.animation import FFMpegWriter

    return bool(FFMpegWriter.isAvailable())


def gif_bytes(figure: Any, count: int, show: Show, *, typical: int = 0) -> bytes:
    """Return an endless GIF of a figure that ``show(i)`` changes, for i from 0 to ``count`` - 1.

    Its colours are those of frame ``typical``.
    """
    from PIL import Image

    grab = _grabber(figure)
    show(typical)
    palette = Image.fromarray(grab()).quantize(COLOURS)
    frames = []
    for i in range(count):
        show(i)
        frames.append(Image.fromarray(grab()).quantize(palette=palette, dither=Image.Dither.NONE))
    buffer = io.BytesIO()
    frames[0].save(
        buffer, format="GIF", save_all=True, append_images=frames[1:], duration=1000 // RATE, loop=0
    )
    return buffer.getvalue()


def mp4_bytes(figure: Any, count: int, show: Show) -> bytes:
    """Return a film (H.264) of a figure that ``show(i)`` changes; ffmpeg must be installed."""
    from matplotlib.animation import FFMpegWriter

    _grabber(figure)
    writer = FFMpegWriter(fps=RATE, codec="h264", extra_args=["-pix_fmt", "yuv420p"])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "motion.mp4"
        with writer.saving(figure, str(path), DPI):
            for i in range(count):
                show(i)
                writer.grab_frame()
        return path.read_bytes()


def _grabber(figure: Any) -> Callable[[], Any]:
    """Return a function that draws the figure and returns its pixels; the layout is computed once."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.set_dpi(DPI)
    width, height = (
        2 * round(0.5 * DPI * each) for each in figure.get_size_inches()
    )  # H.264 requires even numbers
    figure.set_size_inches(width / DPI, height / DPI)
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    figure.set_layout_engine("none")

    def grab() -> Any:
        canvas.draw()
        return np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[:, :, :3])

    return grab
