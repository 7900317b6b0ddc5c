"""What a figure must hold whatever it shows: ink in all axes, no text cut off or over another, names and units at the axes."""

import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import combinations, product
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg

DPI = 100
"""Dots an inch that numbers of pixels are meant for."""
LEAST_INK = 30
"""Dark pixels within the axes of a figure."""
DARK = 0.82
"""A pixel whose darkest channel is below it is ink; grids are lighter."""
EDGE = 3
"""Pixels along the axes' border that are frame and ticks."""
NUMBER = re.compile(r"[-−+0-9.,eE ×%]+|\$.*\$")
PURE = ("number", "order", "share", "factor", "member", "rank", "probability", "trial", "coherence", "ratio")
"""Words of what has no unit."""


def looked_at(draw: Callable[[Any, str], bytes], figure: Any, form: str) -> tuple[bytes, list[str]]:
    """Return a figure as ``draw`` exports it, and what is wrong with it; a PNG is not drawn again for that."""
    with _recorded() as texts:
        drawn = draw(figure, form)
    renderer = getattr(figure.canvas, "renderer", None) if form == "png" else None
    return drawn, faults_of(figure) if renderer is None else _faults(figure, texts, renderer)


def faults_of(figure: Any) -> list[str]:
    """Return what is wrong with a figure, as sentences."""
    before, canvas_before = figure.dpi, figure.canvas
    figure.set_dpi(DPI)
    canvas = FigureCanvasAgg(figure)
    try:
        with warnings.catch_warnings(), _recorded() as texts:
            warnings.filterwarnings("ignore", message="Glyph")  # a name in a script that the font lacks
            canvas.draw()  # finds the layout
            texts.clear()
            canvas.draw()
        return _faults(figure, texts, canvas.get_renderer())
    finally:
        figure.set_dpi(before)
        figure.set_canvas(canvas_before)


@contextmanager
def _recorded() -> Iterator[dict[int, Any]]:
    """Record the texts that are drawn on pixels meanwhile."""
    texts: dict[int, Any] = {}
    draw_text = RendererAgg.draw_text

    def record(self: Any, gc: Any, x: Any, y: Any, s: str, *more: Any, **named: Any) -> None:
        text = named.get("mtext")
        if text is not None and s.strip():
            texts[id(text)] = text
        draw_text(self, gc, x, y, s, *more, **named)

    RendererAgg.draw_text = record  # type: ignore[method-assign]
    try:
        yield texts
    finally:
        RendererAgg.draw_text = draw_text  # type: ignore[method-assign]


def _faults(figure: Any, texts: dict[int, Any], renderer: Any) -> list[str]:
    """Return what is wrong with a figure that was drawn on a renderer, with the texts that were drawn."""
    before = figure.dpi
    figure.set_dpi(renderer.dpi)
    try:
        drawn = list(texts.values())
        pixels = np.asarray(renderer.buffer_rgba())[::-1, :, :3]
        boxes = [(text, text.get_window_extent(renderer)) for text in drawn]
        found = _cut(figure, boxes) + _overlaps(boxes, figure.dpi / DPI) + _blank(figure, pixels)
        return found + _offsets(figure, drawn) + _alike(figure) + _unnamed(figure, set(texts))
    finally:
        figure.set_dpi(before)


def _shown(text: Any) -> str:
    return repr(text.get_text()[:40])


def _cut(figure: Any, boxes: list[tuple[Any, Any]]) -> list[str]:
    whole, found = figure.bbox, []
    for text, box in boxes:
        room = whole
        if text.get_clip_on() and text.get_clip_box() is not None:
            room = text.get_clip_box()
        out = max(room.x0 - box.x0, box.x1 - room.x1, room.y0 - box.y0, box.y1 - room.y1)
        if out > 2.0 * figure.dpi / DPI:
            found.append(f"{_shown(text)} is cut off by {out:.0f} pixels")
    return found


def _overlaps(boxes: list[tuple[Any, Any]], dots: float) -> list[str]:
    found = []
    for (a, one), (b, other) in combinations(boxes, 2):
        wide = min(one.x1, other.x1) - max(one.x0, other.x0)
        high = min(one.y1, other.y1) - max(one.y0, other.y0)
        if (
            wide > 2.0 * dots
            and high > 2.5 * dots
            and not {a.get_rotation() % 90.0, b.get_rotation() % 90.0} - {0.0}
        ):
            found.append(f"{_shown(a)} lies over {_shown(b)}")
    return found


def _panels(figure: Any) -> list[Any]:
    """Return all visible axes, insets too, that have a frame."""
    every = list(figure.axes)
    for ax in figure.axes:
        every += [child for child in ax.child_axes if child not in every]
    return [ax for ax in every if ax.get_visible() and ax.axison]


def _blank(figure: Any, pixels: Any) -> list[str]:
    found, dots = [], figure.dpi / DPI
    edge = round(EDGE * dots)
    for ax in _panels(figure):
        box = ax.get_window_extent()
        rows = slice(int(box.y0) + edge, int(box.y1) - edge)
        inside = pixels[rows, int(box.x0) + edge : int(box.x1) - edge]
        if np.count_nonzero(inside.min(axis=2) < 255.0 * DARK) < LEAST_INK * dots**2:
            found.append(
                f"the axes {ax.get_title(loc='left') or ax.get_title() or ax.get_ylabel()!r} are blank"
            )
    return found


BLIND = {
    "all": np.eye(3),
    "those who lack red": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "those who lack green": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "those who lack blue": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
"""How linear red, green and blue are seen: Machado, Oliveira and Fernandes (2009), severity 1."""
XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
APART = 12.0
"""Least distance in CIE Lab of two lines that nothing but their colour tells apart."""


def seen_as(color: Any, eyes: Any) -> Any:
    """Return CIE Lab (D65) of a colour as it is seen."""
    from matplotlib.colors import to_rgb

    c = np.array(to_rgb(color))
    linear = np.clip(eyes @ np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4), 0.0, 1.0)
    t = XYZ @ linear / np.array([0.95047, 1.0, 1.08883])
    f = np.where(t > 0.008856, np.cbrt(t), 7.787 * t + 16.0 / 116.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


def _alike(figure: Any) -> list[str]:
    """Return pairs of colours of lines in one axes that somebody cannot tell apart, where style and marker are the same."""
    from matplotlib.colors import to_hex

    found = []
    for ax in _panels(figure):
        kinds: dict[Any, set[str]] = {}
        for line in ax.get_lines():
            if line.get_visible() and len(line.get_xdata()) > 2:
                kinds.setdefault((line.get_linestyle(), line.get_marker()), set()).add(
                    to_hex(line.get_color())
                )
        for colors in kinds.values():
            for (one, other), (words, eyes) in product(combinations(sorted(colors), 2), BLIND.items()):
                distance = float(np.linalg.norm(seen_as(one, eyes) - seen_as(other, eyes)))
                if distance < APART:
                    found.append(f"{one} and {other} are {distance:.0f} apart for {words}")
    return found


def _offsets(figure: Any, texts: list[Any]) -> list[str]:
    drawn = {id(text) for text in texts}
    offsets = [axis.offsetText for ax in _panels(figure) for axis in (ax.xaxis, ax.yaxis)]
    return [f"an axis has the offset {_shown(each)}" for each in offsets if id(each) in drawn]


def _unnamed(figure: Any, drawn: set[int]) -> list[str]:
    """Return the axes with numbers at which no name with a unit stands, nor at one in the same column or row."""
    found, panels = [], _panels(figure)
    insets = {id(child) for ax in figure.axes for child in ax.child_axes}
    for ax in panels:
        if id(ax) in insets:
            continue
        for way in "xy":
            axis = getattr(ax, f"{way}axis")
            labels = [label.get_text() for label in axis.get_ticklabels() if id(label) in drawn]
            if not labels or not all(NUMBER.fullmatch(label) for label in labels):
                continue
            beside = [each for each in panels if _same(ax, each, way)]
            names = [getattr(each, f"{way}axis").get_label().get_text() for each in beside]
            names.append(
                getattr(figure, f"_sup{way}label").get_text() if getattr(figure, f"_sup{way}label") else ""
            )
            words = " ".join(names)
            if not words.strip():
                found.append(f"the {way} axis of {ax.get_title(loc='left') or ax.get_title()!r} has no name")
            elif not any(mark in words for mark in "[%]°") and not any(
                word in words.lower() for word in PURE
            ):
                found.append(f"the {way} axis {words!r} has no unit")
    return found


def _same(one: Any, other: Any, way: str) -> bool:
    """Return whether two axes share a column (for x) or a row (for y)."""
    a, b = one.get_position(), other.get_position()
    if way == "x":
        return abs(a.x0 - b.x0) < 0.02 and abs(a.x1 - b.x1) < 0.02
    return abs(a.y0 - b.y0) < 0.02 and abs(a.y1 - b.y1) < 0.02
