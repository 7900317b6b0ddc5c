"""The published test: Tables 3-6 of Han et al., Entropy 2021, 23, 834, as data with its faults marked."""

import csv
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

LINES = ("radial", "mesh_1x", "mesh_2x")
LINE_WORDS = {"radial": "f_r", "mesh_1x": "f_m", "mesh_2x": "2 f_m"}
PRINTED_TOLERANCE = 0.011  # per cent points: printed errors are rounded to two places, some cut instead


@dataclass(frozen=True)
class Condition:
    """One test condition: pinion speed [rpm], radial clearance of the driven sleeve [um], backlash [um]."""

    speed_rpm: float
    radial_clearance_um: float
    backlash_um: float

    @property
    def mesh_frequency(self) -> float:
        """Mesh frequency f_m [Hz] of the 20-tooth pinion."""
        return 20.0 * self.speed_rpm / 60.0

    @property
    def label(self) -> str:
        """Short name: ``120 rpm, 100/100 um``."""
        return f"{self.speed_rpm:g} rpm, {self.radial_clearance_um:g}/{self.backlash_um:g} um"


@dataclass(frozen=True)
class PrintedRow:
    """One row of Tables 3-6. Values in Hz, or as printed for amplitudes; errors in per cent of the test value."""

    table: int
    condition: Condition
    line: str
    quantity: str  # frequency_hz or amplitude_as_printed
    test: float
    coupled: float
    coupled_error_printed: float
    uncoupled: float
    uncoupled_error_printed: float
    note: str

    def recomputed_error(self, model: str) -> float:
        """Return the error [%] that follows from the printed values, ``model`` "coupled" or "uncoupled"."""
        value = self.coupled if model == "coupled" else self.uncoupled
        return 100.0 * abs(value - self.test) / self.test

    def printed_error(self, model: str) -> float:
        """Return the error [%] as printed."""
        return self.coupled_error_printed if model == "coupled" else self.uncoupled_error_printed

    def printed_error_follows(self, model: str) -> bool:
        """Return whether the printed error follows from the printed values."""
        return abs(self.printed_error(model) - self.recomputed_error(model)) <= PRINTED_TOLERANCE


@lru_cache(maxsize=1)
def printed_rows() -> tuple[PrintedRow, ...]:
    """Return the 36 rows of Tables 3-6 in print order."""
    text = files("gearplay.published").joinpath("han2021_tables.csv").read_text(encoding="utf-8")
    return tuple(
        PrintedRow(
            table=int(row["table"]),
            condition=Condition(
                float(row["speed_rpm"]), float(row["radial_clearance_um"]), float(row["backlash_um"])
            ),
            line=row["line"],
            quantity=row["quantity"],
            test=float(row["test"]),
            coupled=float(row["coupled"]),
            coupled_error_printed=float(row["coupled_error_printed_pct"]),
            uncoupled=float(row["uncoupled"]),
            uncoupled_error_printed=float(row["uncoupled_error_printed_pct"]),
            note=row["note"],
        )
        for row in csv.DictReader(text.splitlines())
    )


@lru_cache(maxsize=1)
def conditions() -> tuple[Condition, ...]:
    """Return the six test conditions in print order."""
    return tuple(dict.fromkeys(row.condition for row in printed_rows()))


def printed(condition: Condition, line: str, quantity: str) -> PrintedRow:
    """Return one row; `KeyError` where the article has none."""
    for row in printed_rows():
        if (row.condition, row.line, row.quantity) == (condition, line, quantity):
            return row
    raise KeyError((condition, line, quantity))
