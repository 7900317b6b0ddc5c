"""Which kind of file it is: by its first bytes, and only where they do not say, by its extension."""

from pathlib import Path
from typing import Final

from gearplay.files.measurements.refusing import damaged

FORMATS: Final = {
    "csv": (".csv", ".tsv", ".txt", ".asc"),
    "uff": (".uff", ".unv", ".uf"),
    "tdms": (".tdms",),
    "mdf4": (".mf4", ".mdf"),
    "wav": (".wav", ".wave"),
    "mat": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf", ".he5"),
    "netcdf": (".nc", ".nc4", ".cdf"),
}
"""Kinds of files and their extensions."""

HEAD: Final = 600
"""Bytes at a file's start that tell its kind."""

HDF5_MARK: Final = b"\x89HDF\r\n\x1a\n"

_MARKS: Final = (
    (b"TDSm", "tdms"),
    (b"MDF ", "mdf4"),
    (b"UnFinMF ", "mdf4"),
    (b"RIFF", "wav"),
    (b"RIFX", "wav"),
    (b"RF64", "wav"),
    (b"MATLAB ", "mat"),
    (b"CDF\x01", "netcdf"),
    (b"CDF\x02", "netcdf"),
    (b"CDF\x05", "netcdf"),
)


def recognise(path: Path, head: bytes) -> str:
    r"""Return the kind of a file from its first bytes and its extension, one of `FORMATS`.

    Raises `MeasurementError` where neither says.

    >>> recognise(Path("a.csv"), b"TDSm..."), recognise(Path("a.dat"), b"t;acc\n0;1\n")
    ('tdms', 'csv')
    """
    by_name = next((kind for kind, suffixes in FORMATS.items() if path.suffix.lower() in suffixes), "")
    if head.startswith(b"TDSh"):
        raise damaged(path, "is only the index of a TDMS file", "Give the .tdms file beside it")
    if head.startswith(HDF5_MARK):
        return by_name if by_name in ("netcdf", "mat") else "hdf5"
    for mark, kind in _MARKS:
        if head.startswith(mark):
            return kind
    lines = head.lstrip().splitlines()
    if lines and lines[0].strip() == b"-1":
        return "uff"
    if by_name in ("csv", "uff"):
        return by_name
    if _is_table(head):
        return "csv"
    if by_name:
        return by_name
    raise damaged(
        path,
        "must be a measurement file; neither its first bytes nor its extension say of which kind",
        f"Give the format: {', '.join(FORMATS)}",
    )


def _is_table(head: bytes) -> bool:
    """Tell whether bytes are lines of text with digits; a damaged binary file has control bytes among them."""
    plain = all(byte >= 32 or byte in b"\t\r\n\f" for byte in head)
    return plain and b"\n" in head and any(byte in head for byte in b"0123456789")
