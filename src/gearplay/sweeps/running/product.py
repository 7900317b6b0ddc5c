"""Product of a sweep: one dataset with a dimension per axis, independent of the executor."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.files.atomic import write_bytes
from gearplay.files.netcdf import netcdf_bytes
from gearplay.model.field_units import unit_at
from gearplay.results.outcomes import MISSING
from gearplay.results.provenance import KIND, provenance
from gearplay.solver.status import Status
from gearplay.sweeps.running.evaluate import REDUCED, REFUSED, Sweep
from gearplay.sweeps.running.reduce import Kept

if TYPE_CHECKING:
    import xarray as xr

Rows = Mapping[bytes, tuple[int, str, bytes]]
"""Finished points by address: status, reason, and the bytes of the row."""


def to_product(sweep: Sweep, rows: Rows) -> "xr.Dataset":
    """Return the dataset of a sweep from its rows; missing cases have status -1 and NaN.

    Dimensions are the axes, ``sample`` and ``member`` where there are any, and one for each reduction that has its own.
    Coordinates are in SI, drawn parameters along ``sample``. Every variable has ``units`` and ``long_name``.

    Raises `ResourceError` for a product too large for one piece.
    """
    import xarray as xr

    sweep.check_size()
    whole = tuple(slice(0, length) for length in sweep.template.points.shape)
    return xr.Dataset(
        variables_of(sweep, rows, whole), coords=coordinates_of(sweep), attrs=attributes_of(sweep)
    )


def addresses_in(sweep: Sweep, where: Sequence[slice]) -> list[bytes]:
    """Return the addresses of the points of a block, in C order."""
    shape = sweep.template.points.shape
    places = np.ix_(*(np.arange(part.start, part.stop) for part in where))
    indices = np.ravel_multi_index(places, shape).ravel() if shape else [0]
    return [sweep.template.address_of(int(index)) for index in indices]


def variables_of(sweep: Sweep, rows: Rows, where: Sequence[slice]) -> dict[str, Any]:
    """Return the variables of a block of the product, as (dimensions, values, attributes) by name."""
    addresses, reducer = addresses_in(sweep, where), sweep.reducer
    shape = tuple(part.stop - part.start for part in where)
    table = np.full((len(addresses), reducer.size), np.nan)
    status = np.full(len(addresses), MISSING, dtype=np.int16)
    reasons = np.full(len(addresses), "", dtype=object)
    for at, address in enumerate(addresses):
        found = rows.get(address)
        if found is not None:
            status[at], reasons[at] = found[0], found[1]
            table[at] = np.frombuffer(found[2], dtype=np.float64)
    variables: dict[str, Any] = {}
    first = 0
    for kept in reducer.layout:
        values = table[:, first : first + kept.size].reshape((*shape, *((kept.size,) if kept.along else ())))
        first += kept.size
        variables[kept.name] = (
            dims_of(sweep, kept),
            values,
            {"units": kept.unit, "long_name": kept.long_name},
        )
    dims, flags = sweep.template.points.dims, _flags()
    meanings = {
        "long_name": "how the case ended",
        "flag_values": np.array(sorted(flags), dtype=np.int16),
        "flag_meanings": " ".join(flags[k] for k in sorted(flags)),
    }
    variables["status"] = (dims, status.reshape(shape), meanings)
    variables["reason"] = (dims, reasons.reshape(shape), {"long_name": "why a case failed"})
    return variables


def dims_of(sweep: Sweep, kept: Kept) -> tuple[str, ...]:
    """Return the dimensions of a variable of the product."""
    return (*sweep.template.points.dims, *((kept.along,) if kept.along else ()))


def _flags() -> dict[int, str]:
    return {int(s): s.name.lower() for s in Status} | {
        MISSING: "missing",
        REFUSED: "refused",
        REDUCED: "reduced",
    }


def attributes_of(sweep: Sweep) -> dict[str, str]:
    """Return the attributes of the product: its provenance."""
    return provenance(
        sweep.template.base,
        title=sweep.plan.title,
        name="base_case",
        plan=sweep.plan.model_dump_json(exclude_none=True),
        **{KIND: "sweep"},
    )


def coordinates_of(sweep: Sweep) -> dict[str, Any]:
    """Return the coordinates of the product, as (dimension, values, attributes) by name."""
    plan, points = sweep.plan, sweep.template.points
    found: dict[str, Any] = {}
    for axis, values in zip(plan.axes, points.values, strict=True):
        found[axis.name] = (axis.name, _array(values), _attributes(sweep, axis))
    if points.directions:
        words = {"long_name": "way along the carried axis"}
        found["direction"] = ("direction", np.array(points.directions, dtype=object), words)
    if plan.design is not None:
        found["sample"] = ("sample", np.arange(len(points.sample)), {"long_name": "drawn point"})
        for at, drawn in enumerate(plan.design.parameters):
            found[drawn.name] = ("sample", points.sample[:, at].copy(), _attributes(sweep, drawn))
    if points.members > 1:
        found["member"] = ("member", np.arange(points.members), {"long_name": "member of the ensemble"})
    for kept in sweep.reducer.layout:
        if kept.along:
            attributes = {"units": kept.along_unit, "long_name": kept.along.rpartition("_")[2]}
            found[kept.along] = (kept.along, np.array(kept.grid), attributes)
    return found


def _attributes(sweep: Sweep, varied: Any) -> dict[str, str]:
    unit = unit_at(sweep.template.base, varied.path) if varied.mode == "set" else "1"
    words = f"{varied.path}" if varied.mode == "set" else f"factor of {varied.path}"
    return {"units": unit, "long_name": words}


def _array(values: Iterable[Any]) -> NDArray[Any]:
    listed = list(values)
    if all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in listed):
        return np.array(listed)
    return np.array([v if isinstance(v, str) else json.dumps(v) for v in listed], dtype=object)


def write_product(dataset: "xr.Dataset", path: Path) -> None:
    """Write a product as netCDF-4, atomically, the same bytes for the same content."""
    write_bytes(path, netcdf_bytes(dataset))
