"""Picture of a validation: deviations over their tolerances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.pictures.canvas import PALETTE, SMALL, legend_mark, make_figure, set_legend, set_title
from gearplay.pictures.style import CLEARANCE

if TYPE_CHECKING:
    from gearplay.validation.validate import Validation


def draw_deviations(found: Validation) -> Any:
    """Return the figure: one row of points for each comparison, its tolerances at 1."""
    ds = found.ds
    titles, topics = ds["title"].values.tolist(), ds["topic"].values.tolist()
    rows, colors = list(dict.fromkeys(titles)), dict(zip(dict.fromkeys(topics), PALETTE, strict=False))
    share = np.abs(ds["deviation"].values) / ds["tolerance"].values
    figure, axes = make_figure(1, 1, 0.26 * len(rows) + 1.5)
    ax = axes if not hasattr(axes, "flat") else axes.flat[0]
    places = [rows.index(title) for title in titles]
    ax.scatter(share, places, color=[colors[topic] for topic in topics], s=18)
    ax.axvline(1.0, color=CLEARANCE, linewidth=1.0, linestyle="--")
    ax.set_yticks(range(len(rows)), rows, fontsize=SMALL)
    ax.invert_yaxis()
    ax.set_xlim(-0.02, max(1.05, 1.05 * float(np.nanmax(share))))
    ax.set_xlabel("deviation from the published number over its tolerance [1]", fontsize=SMALL)
    set_legend(figure, {topic: legend_mark(color, marker="o") for topic, color in colors.items()})
    set_title(figure, found.message.split(". Beyond")[0].rstrip("."))
    return figure
