"""Selection of the figures of a sweep by axes and reductions, each with a caption."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from gearplay.files.atomic import write_bytes
from gearplay.pictures.scales import spread_places
from gearplay.sweeps.report.curves import PER_PAGE, carried_axis, hysteresis_figure, line_figure
from gearplay.sweeps.report.drawable import DIRECTION, View
from gearplay.sweeps.report.maps import map_figure
from gearplay.sweeps.report.scatter import parallel_figure, scatter_figure
from gearplay.sweeps.report.spectra import curves_figure, order_figure, waterfall_figure
from gearplay.sweeps.running.evaluate import Sweep

if TYPE_CHECKING:
    import xarray as xr

MOST = 24
MOST_MAPS, MOST_OWN, MOST_SCATTERS, MOST_PARALLEL = 8, 2, 4, 2
MOST_ALONG, MOST_PAGES = 3, 2  # axes with curves, pages of each
FROM_PARALLEL = 4  # axes and drawn parameters


@dataclass(frozen=True)
class Picture:
    """A PNG with its name, which is a file's, and one sentence."""

    name: str
    png: bytes
    caption: str

    def _repr_png_(self) -> bytes:
        return self.png

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the PNG, atomically."""
        write_bytes(Path(path), self.png)


def pictures_of(sweep: Sweep, dataset: "xr.Dataset") -> list[Picture]:
    """Return at most `MOST` pictures: hysteresis, maps, spectra, drawn parameters, parallel coordinates, curves."""
    view = View(sweep, dataset)
    kinds = (_hysteresis, _maps, _spectra, _scatters, _parallels, _lines)
    found = (
        Picture(name, png, caption) for kind in kinds for name, png, caption in kind(view) if png is not None
    )
    return list(islice(found, MOST))


Drawn = Iterator[tuple[str, bytes | None, str]]


def _pages(view: View) -> list[Sequence[str]]:
    """Return the variables in groups that share a picture."""
    return [view.scalars[at : at + PER_PAGE] for at in range(0, len(view.scalars), PER_PAGE)]


def _hysteresis(view: View) -> Drawn:
    along = carried_axis(view)
    if along is None:
        return
    category = next((name for name in view.categories if name != DIRECTION), "")
    ways = [{category: at} for at in spread_places(len(view.axes[category].values), 2)] if category else [{}]
    caption = (
        f"The same cases on the way up and down {view.axes[along].words}; bands: one standard error of the members; grey bars: "
        "means whose difference is beyond its 95 % interval (one in twenty is so by chance)."
    )
    for number, page in enumerate(_pages(view)[:MOST_PAGES], start=1):
        for way, place in enumerate(ways, start=1):
            name = f"hysteresis-{number}" + (f"-{way}" if category else "")
            yield name, hysteresis_figure(view, page, along, place), caption


def map_axes(view: View) -> tuple[str, str] | None:
    """Return the axes of maps: clearance and backlash of one mesh, else a speed and the longest other axis."""
    if len(view.numeric) < 2:
        return None
    paths = {name: {path for path, n, _ in view.sweep.template.fields if n == name} for name in view.numeric}
    for j, mesh in enumerate(view.sweep.template.base.meshes):
        sleeves = {f"sleeves.{rotor}.radial_clearance" for rotor in mesh.rotors}
        across = next((name for name in view.numeric if paths[name] & sleeves), None)
        up = next((name for name in view.numeric if f"meshes.{j}.backlash" in paths[name]), None)
        if across is not None and up is not None and across != up:
            return across, up
    return view.numeric[0], view.numeric[1]


def _maps(view: View) -> Drawn:
    axes = map_axes(view)
    if axes is None:
        return
    over = " and ".join(view.axes[name].words for name in axes)
    caption = (
        f"over {over}, one scale of colour for all panels; hatched: failed; grey: no number; beyond the jam line, where there is "
        "one, 2 sin α₀ times the sum of both radial clearances exceeds the backlash b₀."
    )
    for name in view.scalars[:MOST_MAPS]:
        yield f"map-{name}", map_figure(view, name, *axes), f"{_sentence(view, name)} {caption}"


def _sentence(view: View, name: str) -> str:
    words = str(view.dataset[name].attrs.get("long_name", name))
    return words[:1].upper() + words[1:]


def _spectra(view: View) -> Drawn:
    up = next(iter(view.numeric), None)
    for name in view.spectra[:MOST_OWN]:
        words = _sentence(view, name)
        if up is None:
            yield f"spectrum-{name}", curves_figure(view, name), f"{words}; some of the cases."
            continue
        over = view.axes[up].words
        yield (
            f"waterfall-{name}",
            waterfall_figure(view, name, up),
            f"{words}, as colour over frequency and {over}; dashed, where there is a mesh: orders 1, 2 and 3 of its frequency.",
        )
        yield (
            f"orders-{name}",
            order_figure(view, name, up),
            f"{words}, as colour over order, frequency divided by the mesh frequency, and {over}; grey: outside the band.",
        )
    for name in view.histories[:MOST_OWN]:
        yield f"history-{name}", curves_figure(view, name), f"{_sentence(view, name)}; some of the cases."


def _lines(view: View) -> Drawn:
    carried = carried_axis(view)
    axes = [name for name in view.numeric if name != carried] if view.numeric else []
    if not view.numeric:
        axes = sorted(view.categories, key=lambda name: -len(view.axes[name].values))[:1]
    for along in axes[:MOST_ALONG]:
        spread = f"; bands: {view.band_words}" if view.band_words else ""
        caption = (
            f"What was kept over {view.axes[along].words}, other axes at the values named above{spread}."
        )
        for number, page in enumerate(_pages(view)[:MOST_PAGES], start=1):
            yield f"lines-{along}-{number}", line_figure(view, page, along), caption


def _scatters(view: View) -> Drawn:
    if view.samples < 2 or not view.drawn:
        return
    for name in view.scalars[:MOST_SCATTERS]:
        caption = f"{_sentence(view, name)} against each drawn parameter, a dot for each drawn point."
        yield f"scatter-{name}", scatter_figure(view, name), caption


def _parallels(view: View) -> Drawn:
    if len(view.axes) + len(view.drawn) < FROM_PARALLEL:
        return
    for name in view.scalars[:MOST_PARALLEL]:
        caption = (
            f"Every line is a case across all that varies, coloured by {_sentence(view, name)[:1].lower()}"
            f"{_sentence(view, name)[1:]}; of many cases some are drawn at random, the same each time. Where a colour gathers "
            "on an axis, that quantity matters."
        )
        yield f"parallel-{name}", parallel_figure(view, name), caption
