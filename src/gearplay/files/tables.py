"""Export of datasets: CSV with a column per signal, MAT with every variable."""

import csv
import io
import itertools
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

_MAT_HEADING: Final = "MATLAB 5.0 MAT-file, written by gearplay"


def mat_bytes(variables: Mapping[str, Any]) -> bytes:
    """Return the MAT file of version 5 of named values; the same bytes for the same values."""
    from scipy.io import savemat

    made = io.BytesIO()
    savemat(made, dict(variables), do_compression=True, oned_as="row", long_field_names=True)
    made.seek(0)  # the heading there holds the time
    made.write(_MAT_HEADING.ljust(116).encode("ascii"))
    return made.getvalue()


def dataset_as_mat(dataset: "xr.Dataset") -> bytes:
    """Return a dataset as MAT: its variables, and the structures ``units``, ``dimensions`` and ``attributes``.

    Where a name is none of MATLAB, as ``ring.ax``, it becomes ``ring_ax``, and the structure ``names`` has the own ones.
    """
    named = _matlab_names([str(name) for name in dataset.variables])
    held = {named[str(name)]: _plain(variable.values) for name, variable in dataset.variables.items()}
    about = {
        "units": {named[str(n)]: str(v.attrs.get("units", "")) for n, v in dataset.variables.items()},
        "dimensions": {named[str(n)]: " ".join(map(str, v.dims)) for n, v in dataset.variables.items()},
        **(
            {"names": {other: own for own, other in named.items()}}
            if any(a != b for a, b in named.items())
            else {}
        ),
        "attributes": {re.sub(r"\W", "_", str(k)): _plain(np.asarray(v)) for k, v in dataset.attrs.items()},
    }
    return mat_bytes(held | about)


def _matlab_names(names: list[str]) -> dict[str, str]:
    """Return names of MATLAB, all different, by the own ones.

    >>> _matlab_names(["time", "ring.ax", "ring-ax", "2nd.x"])
    {'time': 'time', 'ring.ax': 'ring_ax', 'ring-ax': 'ring_ax_2', '2nd.x': 'x2nd_x'}
    """
    found: dict[str, str] = {}
    for name in names:
        plain = re.sub(r"\W", "_", name, flags=re.ASCII)
        plain = plain if re.match("[A-Za-z]", plain) else f"x{plain}"
        unused = (plain if n == 1 else f"{plain}_{n}" for n in itertools.count(1))
        found[name] = next(each for each in unused if each not in found.values())
    return found


def _plain(values: Any) -> Any:
    """Return numbers as they are, and texts as a text or a cell of texts."""
    if values.dtype.kind not in "OUS":
        return values
    texts = np.array([str(each) for each in values.ravel()], dtype=object)
    return texts.reshape(values.shape) if values.ndim else str(values)


def dataset_as_csv(dataset: "xr.Dataset") -> bytes:
    """Return a dataset as CSV: rows along its longest dimension, time where it has one; a column for each label of the others
    that has a value.

    Variables without that dimension are named in a comment.
    """
    row = max(dataset.sizes, key=lambda name: (name == "time", dataset.sizes[name]), default="")
    columns: dict[str, Any] = {}
    left_out = []
    if row in dataset.coords:
        columns[_head(str(row), dataset[row])] = dataset[row].values
    for name, variable in dataset.data_vars.items():
        if row not in variable.dims:
            left_out.append(str(name))
            continue
        others = [dim for dim in variable.dims if dim != row]
        labels = [dataset[dim].values for dim in others]  # places, where a dimension has none
        for places in itertools.product(*(range(dataset.sizes[dim]) for dim in others)):
            label = ".".join([*(str(known[at]) for known, at in zip(labels, places, strict=True)), str(name)])
            chosen = variable.isel(dict(zip(others, places, strict=True)))
            if others and chosen.dtype.kind == "f" and np.isnan(chosen.values).all():
                continue
            columns[_head(label, variable)] = chosen.values
    text = io.StringIO()
    text.write(f"# rows = {dataset.sizes.get(row, 0)}\n")
    if left_out:
        text.write(f"# without the dimension {row}, in netCDF and MAT only: {' '.join(left_out)}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    return text.getvalue().encode()


def _head(name: str, variable: Any) -> str:
    unit = str(variable.attrs.get("units", ""))
    return f"{name} [{unit}]" if unit else name
