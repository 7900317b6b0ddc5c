"""Stored diagrams, maps and hysteresis curves as netCDF and CSV files."""

from typing import TYPE_CHECKING, Any

from gearplay.files.netcdf import netcdf_bytes
from gearplay.model.reading import load_case
from gearplay.results.provenance import provenance
from gearplay.vocabulary.errors import InputError
from gearplay.web.frames import unpack_frame

if TYPE_CHECKING:
    import xarray as xr


def file_of(frame: bytes, form: str) -> bytes:
    """Return a kept diagram, map or hysteresis curve as a file, ``nc`` or ``csv``; a line per point in the latter.

    Raises `InputError` for a run, which is saved from its case with all its samples, and for another form.
    """
    if form not in ("nc", "csv"):
        raise InputError.of("form", form, "must be nc or csv", "Choose one")
    dataset = dataset_of(unpack_frame(frame))
    if form == "nc":
        return netcdf_bytes(dataset)
    units = {
        name: variable.attrs["units"]
        for name, variable in dataset.variables.items()
        if "units" in variable.attrs
    }
    words = {"value": dataset["value"].attrs["long_name"]} if "value" in dataset else {}
    empty = [
        name
        for name in ("reason", "start")
        if name in dataset and not dataset[name].values.astype(bool).any()
    ]
    dataset = dataset.drop_vars(empty)
    table = dataset.to_dataframe().reset_index()
    table.columns = [
        f"{words.get(name, name)} [{units[name]}]" if name in units else str(name) for name in table.columns
    ]
    return str(table.to_csv(index=False, float_format="%.7g")).encode("utf-8")


def dataset_of(document: dict[str, Any]) -> "xr.Dataset":
    """Return the document of a diagram, map or hysteresis curve as a dataset, SI, its numbers as precise as 32 bits are.

    Raises `InputError` for a run.
    """
    import numpy as np
    import xarray as xr

    variables: dict[str, Any]
    more: dict[str, Any] = {}
    coordinates: dict[str, Any]
    if document["kind"] == "map":
        (across, up), units = document["paths"], document["units"]
        dims, shape = (up, across), np.shape(document["values"])
        words = {"units": document["unit"], "long_name": document["measure"]}
        variables = {"value": (dims, document["values"], words)}
        if document.get("members", 1) > 1:
            words = {"units": document["unit"], "long_name": "twice the standard error over the members"}
            variables["spread"] = (dims, document["spread"], words)
            words = {"units": "1", "long_name": "impacts of all members"}
            variables["impacts"] = (dims, document["impacts"], words)
            variables["doubtful"] = (
                dims,
                document["doubtful"],
                {"long_name": "1 where the value says little"},
            )
        more = {name: document[name] for name in ("members", "duration", "transient") if name in document}
        coordinates = {
            up: (up, document["y"], {"units": units[1]}),
            across: (across, document["x"], {"units": units[0]}),
        }
    elif document["kind"] == "bifurcation":
        path, sections = document["path"], np.stack([document["up"], document["down"]])
        dims, shape = ("direction", path), sections.shape[:2]
        variables = {document["signal"]: ((*dims, "section"), sections, {"units": document["unit"]})}
        coordinates = {
            "direction": ("direction", np.array(["up", "down"], dtype=object), {}),
            path: (path, document["x"], {"units": document["axis_unit"]}),
        }
    elif document["kind"] == "lost_motion":
        return _curve_of(document)
    else:
        rule = "must be a diagram, a map or a hysteresis curve"
        raise InputError.of("result", document["kind"], rule, "Save a run from its case")
    for name, field, long_name in (
        ("reason", "failures", "why a case failed"),
        ("start", "starts", "what a value began with, where not with the plain end of the one before it"),
    ):
        texts = np.full(shape, "", dtype=object)
        for *place, text in document.get(field, []):
            texts[tuple(place)] = text
        if name == "reason" or field in document:
            variables[name] = (dims, texts, {"long_name": long_name})
    return xr.Dataset(variables, coordinates, provenance(load_case(document["case"])) | more)


def _curve_of(document: dict[str, Any]) -> "xr.Dataset":
    """Return the dataset of a hysteresis curve: points in the order of the torque cycle, key numbers as attributes."""
    import numpy as np
    import xarray as xr

    torque, angle = np.hstack([document["branches"]["unloading"][:, ::-1], document["branches"]["loading"]])
    variables = {
        "torque": ("point", torque, {"units": "N m", "long_name": f"torque on {document['at']}"}),
        "angle": ("point", angle, {"units": "arcmin", "long_name": f"rotation of {document['at']}"}),
    }
    numbers = {
        name: document[name]
        for name in ("lost_motion", "backlash", "torsional_stiffness", "hysteresis_loss")
        if document[name] is not None
    }
    about = {"at": document["at"], "hold": document["hold"], "rated_torque": document["torque"]}
    return xr.Dataset(variables, attrs=provenance(load_case(document["case"])) | about | numbers)
