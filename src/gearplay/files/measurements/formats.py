"""Registry of measurement formats: extensions, signatures, reading modules, recognition of a file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from gearplay.files.measurements.refusing import damaged


@dataclass(frozen=True)
class Format:
    """Kind of file: extensions, first bytes, module that reads it, library that decodes it and the name it is imported by."""

    suffixes: tuple[str, ...]
    marks: tuple[bytes, ...]
    module: str
    library: str = ""
    package: str = ""


HDF5_MARK: Final = b"\x89HDF\r\n\x1a\n"

FORMATS: Final = {
    "csv": Format((".csv", ".tsv", ".txt", ".asc"), (), "csv_file"),
    "uff": Format((".uff", ".unv", ".uf"), (), "uff", "pyuff", "pyuff"),
    "tdms": Format((".tdms",), (b"TDSm",), "tdms", "npTDMS", "nptdms"),
    "mdf4": Format((".mf4", ".mdf"), (b"MDF ", b"UnFinMF "), "mdf4", "asammdf", "asammdf"),
    "wav": Format((".wav", ".wave"), (b"RIFF", b"RIFX", b"RF64"), "wav", "SciPy", "scipy.io"),
    "mat": Format((".mat",), (b"MATLAB ",), "mat", "SciPy", "scipy.io"),
    "numpy": Format((".npy", ".npz"), (b"\x93NUMPY", b"PK\x03\x04"), "npy", "NumPy", "numpy"),
    "hdf5": Format((".h5", ".hdf5", ".hdf", ".he5"), (HDF5_MARK,), "hdf5", "the HDF5 library", "h5py"),
    "netcdf": Format(
        (".nc", ".nc4", ".cdf"), (b"CDF\x01", b"CDF\x02", b"CDF\x05"), "hdf5", "the HDF5 library", "h5py"
    ),
}
"""Kinds of files by name; all but tables of text are read in a process of its own."""

HEAD: Final = 600
"""Number of bytes at a file's start that are read to identify its format."""


def recognise(path: Path, head: bytes) -> str:
    r"""Return the kind of a file from its first bytes and its extension, one of `FORMATS`.

    Raises `MeasurementError` where neither identifies a format.

    >>> recognise(Path("a.csv"), b"TDSm..."), recognise(Path("a.dat"), b"t;acc\n0;1\n")
    ('tdms', 'csv')
    """
    by_name = next((kind for kind, known in FORMATS.items() if path.suffix.lower() in known.suffixes), "")
    if head.startswith(b"TDSh"):
        raise damaged(path, "is only the index of a TDMS file", "Give the .tdms file next to it")
    if head.startswith(FORMATS["netcdf"].marks):
        rule = "must be netCDF-4, classic netCDF found"
        raise damaged(path, rule, "Convert it: nccopy -k nc4 in.nc out.nc")
    if head.startswith(HDF5_MARK):
        return by_name if by_name in ("netcdf", "mat") else "hdf5"
    for kind, known in FORMATS.items():
        if head.startswith(known.marks):
            return kind
    lines = head.lstrip().splitlines()
    if lines and lines[0].strip() == b"-1":
        return "uff"
    if by_name not in ("csv", "uff") and _is_table(head):
        return "csv"
    if by_name:
        return by_name
    rule = "must be a measurement file; neither its first bytes nor its extension say of which kind"
    raise damaged(path, rule, f"Give the format: {', '.join(FORMATS)}")


def _is_table(head: bytes) -> bool:
    """Return whether bytes are lines of text with digits; a damaged binary file has control bytes among them."""
    plain = all(byte >= 32 or byte in b"\t\r\n\f" for byte in head)
    return plain and b"\n" in head and any(byte in head for byte in b"0123456789")
