"""Shared parts of report pages: template environment, embedded pictures."""

import base64
import html
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.extremes import extremes


def render_page(
    package: str,
    template: str,
    *,
    filters: Mapping[str, Callable[..., Any]] | None = None,
    figures: Mapping[str, bytes] | None = None,
    **values: Any,
) -> str:
    """Return a page from a template of a package, which extends ``base.html``; values are escaped, a missing one is an error.

    ``figures``, PNGs by name, are ``images`` of the template: addresses that hold them. `number` and `fixed` are filters.
    """
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

    rooms = [PackageLoader(package, ""), PackageLoader("gearplay.pictures", "")]
    environment = Environment(
        loader=ChoiceLoader(rooms), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters.update({"number": number, "fixed": fixed, **(filters or {})})
    images = {name: data_uri(png) for name, png in (figures or {}).items()}
    return environment.get_template(template).render(images=images, **values)


def number(value: Any, digits: int = 4) -> str:
    """Return a number for a page, a dash where there is none.

    >>> number(0.12345), number(float("nan")), number(None)
    ('0.1235', '–', '–')
    """
    return f"{value:.{digits}g}" if is_number(value) else "–"


def fixed(value: Any, decimals: int = 1) -> str:
    """Return a number with ``decimals`` decimals for a page, a dash where there is none."""
    return f"{value:.{decimals}f}" if is_number(value) else "–"


def is_number(value: Any) -> bool:
    """Return whether a value is a finite number."""
    return isinstance(value, (int, float)) and math.isfinite(value)


def data_uri(png: bytes) -> str:
    """Return a PNG as a data URI, so that a page needs no other file.

    >>> data_uri(b"abc")
    'data:image/png;base64,YWJj'
    """
    return "data:image/png;base64," + base64.b64encode(png).decode()


def html_table(rows: Sequence[tuple[str, ...]], head: Sequence[str] = ()) -> str:
    """Return rows of text as a table, the first column as headings of its rows; nothing for no rows.

    >>> html_table([("order", "2 & more")])
    "<table><tr><th style='text-align:left'>order</th><td>2 &amp; more</td></tr></table>"
    """
    if not rows:
        return ""
    top = "".join(f"<th>{html.escape(name)}</th>" for name in head)
    lines = [f"<tr>{top}</tr>"] if head else []
    for name, *cells in rows:
        values = "".join(f"<td>{html.escape(cell)}</td>" for cell in cells)
        lines.append(f"<tr><th style='text-align:left'>{html.escape(name)}</th>{values}</tr>")
    return f"<table>{''.join(lines)}</table>"


def sparkline(values: NDArray[np.float64], title: str) -> str:
    """Return a small curve as SVG, its extremes kept; nothing for fewer than two finite values.

    >>> sparkline(np.array([0.0, 2.0, 1.0]), "speed")[-43:]
    '22.0"><title>speed</title></polyline></svg>'
    """
    width, height, known = 320, 44, values[np.isfinite(values)]
    if known.size < 2:
        return ""
    x, y = extremes(np.linspace(2.0, width - 2.0, known.size), known, width)
    span = float(np.ptp(y)) or 1.0
    points = " ".join(
        f"{a:.1f},{b:.1f}" for a, b in zip(x, 2.0 + (height - 4.0) * (y.max() - y) / span, strict=True)
    )
    line = f'<polyline fill="none" stroke="#0b5fa5" points="{points}"><title>{html.escape(title)}</title></polyline>'
    return f'<svg width="{width}" height="{height}" role="img" aria-label="{html.escape(title)}">{line}</svg>'
