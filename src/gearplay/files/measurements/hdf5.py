"""HDF5, netCDF-4 and MAT 7.3: the superblock is checked, then `hdf5_vectors` reads in a process of its own."""

from gearplay.files.measurements.apart import read_apart
from gearplay.files.measurements.building import Request
from gearplay.files.measurements.hdf5_superblock import check_superblock
from gearplay.files.record import Record


def read(request: Request, *, kind: str = "hdf5") -> Record:
    """Read the vectors of an HDF5, netCDF-4 or, of the kind ``mat``, MAT 7.3 file.

    Attributes ``units`` and ``sampling`` (or fs, dt ...) are kept; else the time axis of a vector or a vector called
    time in its group gives the rate. Tables and texts are left out. Raises `MeasurementError` where the file is cut, a
    vector holds fewer values than it declares, a checksum does not match, or the HDF5 library crashes or hangs.
    """
    check_superblock(request.path, request.size)
    return read_apart(request, kind, "the HDF5 library")
