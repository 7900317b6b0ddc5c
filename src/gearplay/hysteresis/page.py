"""Report page of lost motion: the statement, the figure, the tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.hysteresis.cycle import ARCMIN
from gearplay.hysteresis.result import LostMotion
from gearplay.pictures.pages import render_page

if TYPE_CHECKING:
    import xarray as xr


def report_page(found: LostMotion, title: str, picture: bytes) -> str:
    """Return the page of a result, with its figure as PNG."""
    ds = found.ds
    return render_page(
        "gearplay.hysteresis",
        "report.html",
        figures={"curve": picture},
        title=f"Lost motion of {ds.attrs.get('title') or title}",
        message=found.message,
        rows=list(found.rows()),
        over=[_table(ds, name) for name in ("position", "member", "temperature") if name in ds.dims],
        measured=bool(ds.attrs.get("measured")),
        about={
            key: ds.attrs[key]
            for key in ("at", "hold", "confidence", "samples", "rows_left_out")
            if key in ds.attrs
        },
        rated=float(ds.attrs["rated_torque"]),
    )


def _table(ds: xr.Dataset, name: str) -> dict[str, Any]:
    """Return the quantiles of the numbers over a dimension."""
    rows = []
    for field, words, factor in (
        ("lost_motion", "lost motion [arcmin]", ARCMIN),
        ("backlash", "backlash [arcmin]", ARCMIN),
        ("torsional_stiffness", "stiffness above 15 % [N m/arcmin]", 1.0 / ARCMIN),
    ):
        values = factor * ds[f"{field}_by_{name}"].values
        rows.append((words, *(float(each) for each in np.quantile(values, [0.0, 0.05, 0.5, 0.95, 1.0]))))
    return {"name": name, "count": ds.sizes[name], "rows": rows}
