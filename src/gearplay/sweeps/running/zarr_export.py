"""Export of the product as a Zarr store, block by block, for products larger than memory."""

import math
import os
import shutil
import warnings
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gearplay.files.atomic import make_folder, shown_path
from gearplay.results.outcomes import MISSING, Account
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.product import (
    Rows,
    attributes_of,
    coordinates_of,
    variables_of,
)
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.optional import load_optional

if TYPE_CHECKING:
    import xarray as xr

BLOCK = 64e6
"""Size of a block in memory [bytes]."""
TEXT = np.dtypes.StringDType()


def write_cube(sweep: Sweep, rows: Rows, path: Path) -> Account:
    """Write the product of a sweep as a Zarr store, in a temporary folder that is renamed; missing cases have status -1 and NaN.

    It is an export that can be repeated, never the source of truth: a chunk that is lost later reads as missing too.

    Returns the account of its cases.

    Raises `InputError` where the folder cannot be written or is full.
    """
    load_optional("zarr", "cluster")
    make_folder(path.parent)
    tidy_cube(path)
    part, old = temporary_stores(path)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", module="zarr")  # text has no final specification in Zarr 3 yet
            ended = _write(sweep, rows, part)
        if path.exists():
            os.replace(path, old)
        os.replace(part, path)
    except OSError as error:
        rule = f"must be writable ({error.strerror or error})"
        raise InputError.of(
            "out", shown_path(path), rule, "Free some space or choose another place"
        ) from None
    finally:
        tidy_cube(path)
    return ended


def temporary_stores(path: Path) -> tuple[Path, Path]:
    """Return where the new store is made and the old one waits while it is replaced."""
    return path.with_name(f".{path.name}.part"), path.with_name(f".{path.name}.old")


def tidy_cube(path: Path) -> None:
    """Remove temporary stores of a killed process; where the new store was not renamed yet, restore the old one."""
    part, old = temporary_stores(path)
    shutil.rmtree(part, ignore_errors=True)
    if old.exists() and not path.exists():
        with suppress(OSError):  # it stays where it is
            os.replace(old, path)
    if path.exists():
        shutil.rmtree(old, ignore_errors=True)


def _write(sweep: Sweep, rows: Rows, path: Path) -> Account:
    import xarray as xr

    points = sweep.template.points
    pieces = blocks(points.shape, max(1, int(BLOCK / (8 * sweep.reducer.size + 10))))
    first = next(pieces)
    blank = _blank(sweep, tuple(part.stop - part.start for part in first))
    blank.to_zarr(
        path, mode="w", compute=False, consolidated=False, encoding={"status": {"fill_value": MISSING}}
    )
    parts = []
    for piece in chain([first], pieces):
        region = dict(zip(points.dims, piece, strict=True))
        block = xr.Dataset(variables_of(sweep, rows, piece))
        block["reason"] = block["reason"].astype(TEXT)
        block.to_zarr(path, mode="r+", region=region, consolidated=False)
        parts.append(Account.of(block["status"].values, block["reason"].values))
    zarr = load_optional("zarr", "cluster")
    zarr.consolidate_metadata(path)  # or xarray warns of every store that it opens
    return Account.sum(parts)


def blocks(shape: tuple[int, ...], most: int) -> Iterator[tuple[slice, ...]]:
    """Yield blocks that cover an array in C order, at most ``most`` values each, of equal shape except at the ends.

    >>> [[(part.start, part.stop) for part in block] for block in blocks((2, 3), 2)]
    [[(0, 1), (0, 2)], [(0, 1), (2, 3)], [(1, 2), (0, 2)], [(1, 2), (2, 3)]]
    """
    sizes, left = [1] * len(shape), most
    for at in reversed(range(len(shape))):
        sizes[at] = min(shape[at], max(1, left))
        left //= sizes[at]
    for place in np.ndindex(*(math.ceil(length / size) for length, size in zip(shape, sizes, strict=True))):
        yield tuple(
            slice(at * size, min((at + 1) * size, length))
            for at, size, length in zip(place, sizes, shape, strict=True)
        )


def _blank(sweep: Sweep, block: tuple[int, ...]) -> "xr.Dataset":
    """Return the dataset with all its names and none of its values, in chunks of the size of a block."""
    import xarray as xr

    lazy = load_optional("dask.array", "cluster")

    points = sweep.template.points
    empty = variables_of(sweep, {}, tuple(slice(0, 0) for _ in points.shape))
    found = {}
    lengths = {kept.name: kept.size for kept in sweep.reducer.layout if kept.along}
    for name, (dims, values, attributes) in empty.items():
        own = (lengths[name],) if name in lengths else ()
        fill = {"status": MISSING, "reason": ""}.get(name, np.nan)
        kind = TEXT if name == "reason" else values.dtype
        array = lazy.full((*points.shape, *own), fill, dtype=kind, chunks=(*block, *own))
        found[name] = (dims, array, attributes)
    return xr.Dataset(found, coords=coordinates_of(sweep), attrs=attributes_of(sweep))
