"""Report page of a sweep: axes, outcomes, reductions, figures."""

import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.files.atomic import write_figures, write_text
from gearplay.model.toml_files import write_toml
from gearplay.pictures.pages import data_uri, number, render_page
from gearplay.pictures.words import shown_in
from gearplay.results.outcomes import Account
from gearplay.sweeps.report.conclusion import conclusion_of
from gearplay.sweeps.report.drawable import FIRM, MEMBER, SAMPLE, Along, View, along_of
from gearplay.sweeps.report.figures import Picture, pictures_of
from gearplay.sweeps.running.evaluate import Sweep

if TYPE_CHECKING:
    import xarray as xr

MOST_REASONS = 20
MOST_LISTED = 8  # values of an axis written out


def write_sweep_report(sweep: Sweep, dataset: "xr.Dataset", folder: Path) -> None:
    """Write ``report.html``, one page that needs nothing else, and its pictures as ``figures/*.png`` into ``folder``.

    Every file is whole or absent.

    Raises `InputError` where the folder cannot be written.
    """
    pictures = pictures_of(sweep, dataset)
    figures = {picture.name: picture.png for picture in pictures}
    write_figures(folder, figures)
    write_text(folder / "report.html", render(sweep, dataset, pictures))


def render(sweep: Sweep, dataset: "xr.Dataset", pictures: Sequence[Picture]) -> str:
    """Return the report as one self-contained HTML page."""
    failures = failures_of(dataset)
    account = Account.of(dataset["status"].values, dataset["reason"].values)
    return render_page(
        "gearplay.sweeps.report",
        "page.html",
        title=sweep.plan.title or "Sweep",
        plan=sweep.plan,
        base=sweep.template.base,
        varied=varied_of(sweep, dataset),
        account=account,
        failures=failures[:MOST_REASONS],
        reasons=len(failures),
        rows=summary_of(dataset),
        conclusion=conclusion_of(View(sweep, dataset)),
        pictures=[(p, data_uri(p.png)) for p in pictures],
        document=plan_text(sweep),
        version=dataset.attrs.get("gearplay_version", ""),
        digest=dataset.attrs.get("base_case_sha256", sweep.template.base.sha256),
    )


def plan_text(sweep: Sweep) -> str:
    """Return the plan as TOML, which `load_sweep` reads back to an equal one; empty tables and lists are left out."""
    document = sweep.plan.model_dump(mode="json", exclude_none=True)
    for table in (
        document,
        *document["axes"],
        document.get("design", {}),
        *document.get("design", {}).get("parameters", []),
    ):
        for key in [key for key, value in table.items() if value in ([], {}, "")]:
            del table[key]
    return write_toml(document)


def varied_of(sweep: Sweep, dataset: "xr.Dataset") -> list[dict[str, Any]]:
    """Return a row for each dimension and drawn parameter: name, paths, unit, number of values and the values as text."""
    drawn = sweep.plan.design.parameters if sweep.plan.design else ()
    paths = {each.name: (each.path, *each.also) for each in (*sweep.plan.axes, *drawn)}
    found = []

    def add(name: str, distribution: str = "") -> None:
        axis = along_of(dataset[name], ordered=False)
        text = f"{distribution}, {_range(axis)}" if distribution else _listed(axis)
        row = {"name": name, "paths": paths.get(name, ()), "unit": "" if axis.labels else axis.unit}
        found.append(row | {"count": len(axis.values), "values": text, "scaled": axis.scaled})

    for dim in map(str, dataset["status"].dims):
        if dim == SAMPLE:
            for p in drawn:
                add(p.name, p.distribution)
        elif dim == MEMBER:
            words = "members of the ensemble, each with its own initial state"
            row = {"name": dim, "paths": (), "unit": "", "count": dataset.sizes[dim]}
            found.append(row | {"values": words, "scaled": False})
        else:
            add(dim)
    return found


def _range(axis: Along) -> str:
    return f"{number(axis.values.min())} to {number(axis.values.max())}"


def _listed(axis: Along) -> str:
    words = axis.labels or tuple(number(v) for v in axis.values)
    if len(words) <= MOST_LISTED:
        return ", ".join(words)
    if axis.labels:
        return ", ".join(words[:MOST_LISTED]) + f" and {len(words) - MOST_LISTED} more"
    return _range(axis) + (", logarithmic" if axis.log else "")


def failures_of(dataset: "xr.Dataset") -> list[tuple[str, int, str]]:
    """Return reasons of failed cases, the most frequent first: reason, count and where the first of them is."""
    status, reasons = dataset["status"].values, dataset["reason"].values
    places = np.argwhere(status > 0)
    named = [str(reasons[tuple(place)]) or _meaning(dataset, int(status[tuple(place)])) for place in places]
    first = {reason: at for at, reason in reversed(list(enumerate(named)))}
    dims = [str(d) for d in dataset["status"].dims]
    return [
        (reason, count, where(dataset, dims, places[first[reason]]))
        for reason, count in sorted(Counter(named).items(), key=lambda item: -item[1])
    ]


def _meaning(dataset: "xr.Dataset", status: int) -> str:
    attributes = dataset["status"].attrs
    words = str(attributes.get("flag_meanings", "")).split()
    meanings = dict(zip(np.atleast_1d(attributes.get("flag_values", [])).tolist(), words, strict=False))
    return str(meanings.get(status, f"status {status}")).replace("_", " ")


def where(dataset: "xr.Dataset", dims: Sequence[str], place: Sequence[int]) -> str:
    """Return a position in the dataset as text: ``speed 60 rpm, backlash 100 µm``."""
    words = []
    for dim, at in zip(dims, map(int, place), strict=True):
        if dim in (SAMPLE, MEMBER):
            words.append(f"{dim}{FIRM}{at}")
        elif dim in dataset.coords:
            words.append(along_of(dataset[dim], ordered=False).text(at))
        if dim == SAMPLE:
            drawn = [c for name, c in dataset.coords.items() if c.dims == (SAMPLE,) and name != SAMPLE]
            words += [along_of(coordinate, ordered=False).text(at) for coordinate in drawn]
    return ", ".join(words)


def summary_of(dataset: "xr.Dataset") -> list[dict[str, Any]]:
    """Return a row for each variable: least, median and greatest value in its unit, and where the extremes are."""
    rows = []
    for name, variable in dataset.data_vars.items():
        if variable.dtype.kind != "f":
            continue
        values, dims = variable.values, [str(d) for d in variable.dims]
        known = np.isfinite(values)
        largest = float(np.abs(values[known]).max()) if known.any() else 0.0
        unit, factor = shown_in(str(variable.attrs.get("units", "1")), largest)
        row: dict[str, Any] = {
            "name": str(name),
            "words": str(variable.attrs.get("long_name", "")),
            "count": int(known.sum()),
            "unit": unit,
            "median": factor * float(np.median(values[known])) if known.any() else math.nan,
        }
        for key, at in (
            ("low", np.argmin(np.where(known, values, np.inf))),
            ("high", np.argmax(np.where(known, values, -np.inf))),
        ):
            place = np.unravel_index(at, values.shape)
            row[key] = factor * float(values[place]) if known.any() else math.nan
            row[f"at_{key}"] = where(dataset, dims, [int(i) for i in place]) if known.any() else ""
        if row["low"] == row["high"]:
            row["at_low"] = row["at_high"] = "everywhere"
        rows.append(row)
    return rows
