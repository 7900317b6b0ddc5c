"""The Python door: `simulate` a case, get a `Result`."""

from gearplay.api.result import Result, read_result, simulate

__all__ = ["Result", "read_result", "simulate"]
