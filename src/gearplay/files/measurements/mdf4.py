"""MDF 4: the blocks are walked, then `mdf4_signals` reads in a process of its own."""

from gearplay.files.measurements.apart import read_apart
from gearplay.files.measurements.building import Request
from gearplay.files.measurements.mdf4_blocks import check_blocks
from gearplay.files.record import Record


def read(request: Request) -> Record:
    """Read an MDF 4 file: channels of numbers with no, a linear or a rational conversion.

    Raises `MeasurementError` where the file was never finalised, a block or link lies outside it, its records are
    more or fewer than declared, samples are marked invalid, the time is uneven, or asammdf crashes or hangs.
    """
    check_blocks(request.path, request.size)
    return read_apart(request, "mdf4", "asammdf")
