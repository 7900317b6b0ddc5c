"""Measured records: `read_measurement` reads eight kinds of files, `write_record` writes six."""

from gearplay.files.measurements.formats import FORMATS
from gearplay.files.measurements.reading import read_measurement
from gearplay.files.measurements.writing import check_record_path, write_record

__all__ = ["FORMATS", "check_record_path", "read_measurement", "write_record"]
