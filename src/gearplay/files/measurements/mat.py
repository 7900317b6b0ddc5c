"""MAT files of version 4, 5 and 7: arrays, structures and cells by SciPy; version 7.3 is HDF5."""

import warnings
from collections import Counter
from typing import Final

import numpy as np

from gearplay.files.measurements import hdf5
from gearplay.files.measurements.building import Request
from gearplay.files.measurements.formats import HDF5_MARK
from gearplay.files.measurements.named_arrays import NamedArrays, leaves
from gearplay.files.measurements.refusing import DENSEST, MOST_NODES, damaged, fenced, quoted
from gearplay.files.record import Record

RECORD: Final = "record"
"""Name of the structure array that `write_record` writes: name, unit, sampling, start, values of each channel."""

_HDF5_AT: Final = (0, 512)


def read(request: Request) -> Record:
    """Read a MAT file: vectors, columns of matrices, those in structures and cells; see `NamedArrays` for rates and units.

    Raises `MeasurementError` where the file is cut or damaged, or two variables have one name; checksums of packed variables
    also detect damaged samples.
    """
    path = request.path
    with path.open("rb") as file:
        for place in _HDF5_AT:
            file.seek(place)
            if file.read(len(HDF5_MARK)) == HDF5_MARK:
                return hdf5.read(request, kind="mat")
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import MatReadWarning

    with fenced(path, "MAT"), path.open("rb") as file:
        listed = whosmat(file)
        for name, count in Counter(name for name, _, _ in listed).items():
            if count > 1:
                rule = f"holds {count} variables named {quoted(name)}; MATLAB would keep the last"
                raise damaged(path, rule, "Save each under a name of its own")
        for name, shape, kind in listed:
            if np.prod(shape, dtype=np.float64) > DENSEST * request.size and kind != "sparse":
                rule = f"variable '{name}' declares more numbers than a file of {request.size} bytes can hold"
                raise damaged(path, rule)
        file.seek(0)
        warnings.simplefilter("error", MatReadWarning)
        found = loadmat(file, simplify_cells=True, chars_as_strings=True)
    variables = {name: value for name, value in found.items() if not name.startswith("__")}
    entries = list(leaves((), variables))
    if len(entries) > MOST_NODES:
        raise damaged(path, f"has more than {MOST_NODES} values", "Save fewer variables")
    return NamedArrays(request, entries, lambda entry: np.asarray(entry.value)).record("mat")
