"""Figure of a data set: levels of its records by label."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.pictures.canvas import PALETTE, SMALL, legend_mark, make_figure, set_legend, set_title

if TYPE_CHECKING:
    import xarray as xr


def levels_figure(ds: xr.Dataset) -> Any:
    """Return the figure of the rms of every record over its label, coloured by part of the split."""
    figure, axes = make_figure(1, 1, 4.0)
    ax = axes[0, 0]
    labels = list(dict.fromkeys(str(each) for each in ds["label"].values))
    parts = [p for p in ("train", "validation", "test") if p in set(ds["split"].values)]
    level = next(str(name) for name in ds.data_vars if str(name).startswith("rms"))
    for number, part in enumerate(parts):
        chosen = ds["split"].values == part
        place = np.array([labels.index(str(each)) for each in ds["label"].values[chosen]], dtype=float)
        spread = 0.18 * (np.modf(0.618034 * np.arange(place.size))[0] - 0.5)
        ax.plot(
            place + 0.25 * (number - 0.5 * (len(parts) - 1)) + spread,
            ds[level].values[chosen],
            linestyle="none",
            marker=".",
            markersize=4,
            color=PALETTE[number],
        )
    ax.set_xticks(range(len(labels)), labels)
    ax.set_xlabel("label", fontsize=SMALL)
    ax.set_ylabel("rms of a record [m/s²]", fontsize=SMALL)
    if np.nanmin(ds[level].values) > 0.0:
        ax.set_yscale("log")
    set_legend(figure, {p: legend_mark(PALETTE[k], marker="o") for k, p in enumerate(parts)})
    set_title(figure, f"{ds.attrs.get('title') or 'Data set'}: levels of the records")
    return figure
