"""Diagrams and maps that are kept, as files: netCDF and CSV."""

import json
from typing import TYPE_CHECKING, Any

from gearplay.files.atomic import netcdf_bytes
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.version import VERSION
from gearplay.web.frames import unpack_frame

if TYPE_CHECKING:
    import xarray as xr


def file_of(frame: bytes, form: str) -> bytes:
    """Return a kept diagram or map as a file, ``nc`` or ``csv``; a line per point in the latter.

    Raises `InputError` for a run, which is saved from its case with all its samples, and for another form.
    """
    if form not in ("nc", "csv"):
        raise InputError(Fault("form", form, "must be nc or csv", "Choose one"))
    dataset = dataset_of(unpack_frame(frame))
    if form == "nc":
        return netcdf_bytes(dataset)
    units = {name: variable.attrs["units"] for name, variable in dataset.variables.items() if variable.attrs}
    words = {"value": dataset["value"].attrs["long_name"]} if "value" in dataset else {}
    table = dataset.to_dataframe().reset_index()
    table.columns = [
        f"{words.get(name, name)} [{units[name]}]" if name in units else str(name) for name in table.columns
    ]
    return str(table.to_csv(index=False, float_format="%.7g")).encode("utf-8")


def dataset_of(document: dict[str, Any]) -> "xr.Dataset":
    """Return the document of a diagram or map as a dataset, SI, its numbers as precise as 32 bits are.

    Raises `InputError` for a run.
    """
    import numpy as np
    import xarray as xr

    attributes = {
        "title": document["title"] or "",
        "Conventions": "CF-1.11",
        "case": json.dumps(document.get("case")),
        "gearplay_version": VERSION,
    }
    if document["kind"] == "map":
        (across, up), units = document["paths"], document["units"]
        words = {"units": document["unit"], "long_name": document["measure"]}
        coordinates = {
            up: (up, document["y"], {"units": units[1]}),
            across: (across, document["x"], {"units": units[0]}),
        }
        return xr.Dataset({"value": ((up, across), document["values"], words)}, coordinates, attributes)
    if document["kind"] == "bifurcation":
        path, signal = document["path"], document["signal"]
        sections = np.stack([document["up"], document["down"]])
        dims = ("direction", path, "section")
        coordinates = {
            "direction": ("direction", np.array(["up", "down"], dtype=object), {}),
            path: (path, document["x"], {"units": document["axis_unit"]}),
        }
        return xr.Dataset({signal: (dims, sections, {"units": document["unit"]})}, coordinates, attributes)
    rule = "must be a diagram or a map"
    raise InputError(Fault("result", document["kind"], rule, "Save a run from its case"))
