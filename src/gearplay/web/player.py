"""A standalone page that plays the motion of a stored result."""

import json
import re
from collections.abc import Mapping
from importlib import resources
from typing import Any

import numpy as np

from gearplay.pictures.pages import render_page

MODULES = ("colors.js", "gears.js", "strokes.js", "labels.js", "painting.js", "mechanism.js", "player.js")
"""In the order in which they need each other."""
DIGITS = 6


def player_page(
    mechanism: Mapping[str, Any],
    frames: Mapping[str, Any],
    *,
    model: str,
    title: str,
    words: str,
    start: float = 0.0,
    magnify: float = 1.0,
    look: Mapping[str, str] | None = None,
) -> str:
    """Return the page, HTML that needs no other file.

    ``mechanism`` and ``frames`` are what `mechanism_of` and `frames_of` return, ``model`` names the backlash model, ``start``
    is the time [s] from which that of the frames counts, ``magnify`` how many times larger than usual small motions are drawn,
    ``look`` the ``sleeve`` and the ``mesh`` of the close-ups.
    """
    result = {
        "mechanism": mechanism,
        "models": {model: {"frames": {name: _numbers(values) for name, values in frames.items()}}},
        "start": start,
        "magnify": magnify,
        "look": dict(look or {}),
    }
    text = json.dumps(result, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return render_page("gearplay.web", "player.html", title=title, words=words, result=text, script=_script())


def _numbers(values: Any) -> list[float]:
    """Return an array flat, rounded to the digits of a drawing; NaN and infinities as 0."""
    flat = np.nan_to_num(np.asarray(values, dtype=float).ravel(), posinf=0.0, neginf=0.0)
    return [float(f"{value:.{DIGITS}g}") for value in flat]


def _script() -> str:
    """Return the modules of the drawing concatenated, without their imports from each other."""
    place = resources.files("gearplay.web") / "static"
    texts = [(place / name).read_text(encoding="utf-8") for name in MODULES]
    return "\n".join(
        re.sub(r"^export ", "", re.sub(r"^import .*;\n", "", text, flags=re.MULTILINE), flags=re.MULTILINE)
        for text in texts
    )
