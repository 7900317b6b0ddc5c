"""The superblock of an HDF5 file: where the file says that it ends."""

import struct
from pathlib import Path
from typing import Final

from gearplay.output.measurements.recognise import HDF5_MARK
from gearplay.output.measurements.refusing import damaged

USER_BLOCKS: Final = (0, 512, 1024, 2048)
"""Where the superblock may begin [bytes]; MAT files of version 7.3 have 512 bytes before it."""

_OPEN_FOR_WRITING: Final = 1
_HEAP: Final = b"GCOL"


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


def check_heaps(path: Path) -> None:
    """Raise `MeasurementError` where a global heap, which holds texts, has an object that leads nowhere.

    The library follows the sizes of a heap's objects without end where one is zero. A heap is a mark, a version, its
    size, and objects of 16 bytes (number, references, size) and content; number 0 is the free space. HDF5 File Format
    Specification, III.E.
    """
    content = path.read_bytes()
    place = content.find(_HEAP)
    while place >= 0:
        version = content[place + 4 : place + 5]
        (size,) = struct.unpack("<Q", content[place + 8 : place + 16].ljust(8, b"\0"))
        # the four letters may stand in samples by chance: then no version and no size follow that fit
        if version == b"\1" and size >= 16 and place + size <= len(content):
            _check_heap(path, content, place + 16, place + size)
        place = content.find(_HEAP, place + 4)


def _check_heap(path: Path, content: bytes, place: int, end: int) -> None:
    while place + 16 <= end:
        number, size = struct.unpack("<H6xQ", content[place : place + 16])
        step = 16 + size + -size % 8 if number else size
        if step < 16 or place + step > end:
            raise damaged(
                path, f"an object of {size} bytes in its heap of texts leads out of the heap or nowhere"
            )
        place += step
