"""The superblock of an HDF5 file: where the file says that it ends."""

import struct
from pathlib import Path
from typing import Final

from gearplay.files.measurements.recognise import HDF5_MARK
from gearplay.files.measurements.refusing import damaged

USER_BLOCKS: Final = (0, 512, 1024, 2048)
"""Where the superblock may begin [bytes]; MAT files of version 7.3 have 512 bytes before it."""

_OPEN_FOR_WRITING: Final = 1


def check_superblock(path: Path, size: int) -> None:
    """Raise `MeasurementError` where an HDF5 file ends before its declared end or was not closed by its writer.

    Versions 0 and 1 state the sizes of addresses in bytes 13 and 14 and the end of the file as the third address;
    versions 2 and 3 in bytes 9 and 10, the state of the writer in byte 11. HDF5 File Format Specification, II.A.

    Parameters
    ----------
    path
        The file.
    size
        Its size [bytes].

    """
    with path.open("rb") as file:
        head = file.read(USER_BLOCKS[-1] + 128)
    begin = next((at for at in USER_BLOCKS if head[at : at + 8] == HDF5_MARK), None)
    if begin is None:
        if head.startswith(b"CDF"):
            raise damaged(
                path, "must be netCDF-4, classic netCDF found", "Convert it: nccopy -k nc4 in.nc out.nc"
            )
        raise damaged(path, "must begin with the mark of HDF5")
    head = head[begin:]
    if len(head) < 48:
        raise damaged(path, f"must have a superblock of 48 bytes or more, {len(head)} found")
    version = head[8]
    if version > 3:
        raise damaged(path, f"has an unknown superblock version {version}")
    width, first = (head[13], 24 + 4 * version) if version < 2 else (head[9], 12)
    if width != 8:
        raise damaged(
            path, f"must have addresses of 8 bytes, {width} found", "Repack it: h5repack in.h5 out.h5"
        )
    (end,) = struct.unpack("<Q", head[first + 16 : first + 24])
    if end > size:
        raise damaged(path, f"declares {end} bytes and holds {size}")
    if version == 3 and head[11] & _OPEN_FOR_WRITING:
        raise damaged(
            path, "was not closed by the program that wrote it", "Close it there, or run h5clear -s on a copy"
        )
