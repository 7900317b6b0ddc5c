"""Figure of a diagnosis."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.pictures.canvas import SMALL, make_figure, set_title
from gearplay.pictures.extremes import extremes
from gearplay.pictures.style import CLEARANCE, COUPLED, MOST_POINTS, UNCOUPLED, mark_lines
from gearplay.pictures.words import plain, shown_unit

if TYPE_CHECKING:
    import xarray as xr

SHOWN = 6
"""Most hypotheses drawn."""
HAIRLINE = 0.02
"""Share of the largest line of a table below which an unnamed one does not widen the picture."""


def diagnosis_drawing(ds: xr.Dataset) -> Any:
    """Return the figure: confidences of the likeliest hypotheses, spectrum and envelope spectrum with named lines."""
    figure, axes = make_figure(3, 1, 8.6)
    bars, spectrum, envelope = axes[:, 0]
    _bars(bars, ds)
    unit = shown_unit(str(ds["spectrum"].attrs["units"]))
    _spectrum(
        spectrum,
        ds["frequency"].values,
        ds["spectrum"].values,
        _marks(ds, "spectrum"),
        f"spectrum [{unit}]",
        _highest(ds, "spectrum"),
    )
    low, high = ds.attrs["envelope_low"], ds.attrs["envelope_high"]
    _spectrum(envelope, ds["envelope_frequency"].values, ds["envelope"].values, _marks(ds, "envelope"),
              f"envelope, {low:.0f} to {high:.0f} Hz [{unit}]", _highest(ds, "envelope"))  # fmt: skip
    set_title(figure, plain(f"{ds.attrs['title']}: {ds['hypothesis'].values[0]}"))
    return figure


def _bars(ax: Any, ds: xr.Dataset) -> None:
    shares = ds["confidence"].values[:SHOWN][::-1]
    names = [plain(str(name)) for name in ds["hypothesis"].values[:SHOWN]][::-1]
    ax.barh(range(len(names)), shares, color=COUPLED, height=0.6)
    ax.axvline(float(ds.attrs["stated_confidence"]), color=UNCOUPLED, linewidth=1.0, linestyle="--")
    ax.set_yticks(range(len(names)), names, fontsize=SMALL)
    ax.set_xlim(0.0, 1.0)
    ax.set_xlabel("confidence [1]; dashed: from here on it is stated", fontsize=SMALL)


def _marks(ds: xr.Dataset, domain: str) -> dict[str, float]:
    """Return the lines that were found, highest first."""
    found: dict[str, float] = {}
    order = np.argsort(-ds["line_amplitude"].values)
    for k in order:
        frequency = float(ds["line_frequency"].values[k])
        name = str(ds["line_name"].values[k])
        if ds["line_domain"].values[k] == domain and np.isfinite(frequency) and name != "unnamed":
            found.setdefault(name, frequency)
    return found


def _highest(ds: xr.Dataset, domain: str) -> float:
    """Return the frequency [Hz] of the highest line of the table that is no hairline; infinity without any."""
    own = (ds["line_domain"].values == domain) & np.isfinite(ds["line_frequency"].values)
    frequency, amplitude = ds["line_frequency"].values[own], ds["line_amplitude"].values[own]
    return float(np.max(frequency[amplitude >= HAIRLINE * np.max(amplitude)])) if own.any() else np.inf


def _spectrum(
    ax: Any, frequency: Any, amplitude: Any, marks: dict[str, float], words: str, highest: float
) -> None:
    x, y = extremes(frequency, amplitude, MOST_POINTS // 2)
    ax.plot(x, y, color=COUPLED, linewidth=0.7)
    top = 1.15 * max(highest, *marks.values()) if marks else 1.15 * highest
    ax.set_xlim(0.0, min(float(frequency[-1]), top))
    ax.set_ylim(0.0, None)
    ax.set_xlabel("frequency [Hz]", fontsize=SMALL)
    ax.set_ylabel(words, fontsize=SMALL)
    ax.tick_params(colors=CLEARANCE, labelcolor="black")
    mark_lines(ax, marks)
