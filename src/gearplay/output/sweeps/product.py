"""The product of a sweep: one dataset with a dimension per axis, the same bytes wherever its points were computed."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.field_units import unit_at
from gearplay.output.files import write_with
from gearplay.solver.status import Status
from gearplay.study.sweeps.evaluate import REFUSED, Sweep
from gearplay.vocabulary.errors import ResourceError
from gearplay.vocabulary.optional import load_optional
from gearplay.vocabulary.version import VERSION

if TYPE_CHECKING:
    import xarray as xr

MISSING = -1
LARGEST = 4e9
"""Largest product that is made in one piece [bytes]."""


def product_bytes(sweep: Sweep) -> float:
    """Return the size of the product in memory [bytes]."""
    return float(len(sweep.template.points)) * (8.0 * sweep.reducer.size + 10.0)


def to_product(sweep: Sweep, rows: Mapping[bytes, tuple[int, str, bytes]]) -> "xr.Dataset":
    """Return the dataset of a sweep from its rows (status, reason, row) by address; what is missing has status -1 and NaN.

    Dimensions are the axes, ``sample`` and ``member`` where there are any, and one for each reduction that has its own.
    Coordinates are in SI, drawn parameters along ``sample``. Every variable has ``units`` and ``long_name``.

    Raises `ResourceError` for a product too large for one piece.
    """
    import xarray as xr

    if product_bytes(sweep) > LARGEST:
        raise ResourceError(
            f"sweep: a product of {product_bytes(sweep) / 1e9:.2g} GB is more than the limit of {LARGEST / 1e9:.0f} GB. "
            "Keep fewer numbers per case, or coarsen an axis."
        )
    points, reducer = sweep.template.points, sweep.reducer
    count = len(points)
    table = np.full((count, reducer.size), np.nan)
    status = np.full(count, MISSING, dtype=np.int16)
    reasons = np.full(count, "", dtype=object)
    for index in range(count):
        found = rows.get(sweep.template.address_of(index))
        if found is not None:
            status[index], reasons[index] = found[0], found[1]
            table[index] = np.frombuffer(found[2], dtype=np.float64)
    variables: dict[str, Any] = {}
    coordinates = _coordinates(sweep)
    at = 0
    for kept in reducer.layout:
        block = table[:, at : at + kept.size].reshape((*points.shape, *((kept.size,) if kept.along else ())))
        at += kept.size
        dims = (*points.dims, *((kept.along,) if kept.along else ()))
        variables[kept.name] = (dims, block, {"units": kept.unit, "long_name": kept.long_name})
        if kept.along:
            attributes = {"units": kept.along_unit, "long_name": kept.along.rpartition("_")[2]}
            coordinates[kept.along] = (kept.along, np.array(kept.grid), attributes)
    flags = {int(s): s.name.lower() for s in Status} | {MISSING: "missing", REFUSED: "refused"}
    variables["status"] = (
        points.dims,
        status.reshape(points.shape),
        {
            "long_name": "how the case ended",
            "flag_values": np.array(sorted(flags), dtype=np.int16),
            "flag_meanings": " ".join(flags[k] for k in sorted(flags)),
        },
    )
    variables["reason"] = (points.dims, reasons.reshape(points.shape), {"long_name": "why a case failed"})
    attributes = {
        "title": sweep.plan.title,
        "Conventions": "CF-1.11",
        "plan": sweep.plan.model_dump_json(exclude_none=True),
        "base_case": json.dumps(sweep.template.base.resolved()),
        "base_case_sha256": sweep.template.base.sha256,
        "gearplay_version": VERSION,
    }
    return xr.Dataset(variables, coords=coordinates, attrs=attributes)


def _coordinates(sweep: Sweep) -> dict[str, Any]:
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
    """Write a product as netCDF-4, atomically, the same bytes for the same content.

    It is made in memory: HDF5 that meets a full disk prints tracebacks and may bring the process down at its end.
    """
    packed = {
        name: {"zlib": True, "complevel": 1, "shuffle": True}
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind in "fi" and variable.size > 1000
    }
    content = dataset.to_netcdf(engine="h5netcdf", encoding=packed)
    write_with(path, lambda temporary: temporary.write_bytes(content))


def write_zarr(dataset: "xr.Dataset", path: Path) -> None:
    """Write a product as a Zarr store, beside and renamed; an export that can be made again, never the source of truth."""
    import os
    import shutil

    load_optional("zarr", "cluster")
    beside = path.with_name(f".{path.name}.part")
    shutil.rmtree(beside, ignore_errors=True)
    dataset.to_zarr(beside, mode="w", consolidated=False)
    shutil.rmtree(path, ignore_errors=True)
    os.replace(beside, path)
