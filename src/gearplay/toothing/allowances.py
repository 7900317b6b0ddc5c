"""Allowances of tooth thickness, DIN 3967:1978, and of the centre distance, DIN 3964:1980 with the grades of ISO 286-1."""

import re
from bisect import bisect_left
from typing import Final

SERIES: Final = ("a", "ab", "b", "bc", "c", "cd", "d", "e", "f", "g", "h")
DIAMETERS: Final = (10.0, 50.0, 125.0, 280.0, 560.0, 1000.0)
"""Upper ends of the ranges of reference diameters [mm]."""
UPPER: Final = (
    (-100, -85, -70, -58, -48, -40, -33, -22, -10, -5, 0),
    (-135, -110, -95, -75, -65, -54, -44, -30, -14, -7, 0),
    (-180, -150, -125, -105, -85, -70, -60, -40, -19, -9, 0),
    (-250, -200, -170, -140, -115, -95, -80, -56, -26, -12, 0),
    (-330, -280, -230, -190, -155, -130, -110, -75, -35, -17, 0),
    (-450, -370, -310, -260, -210, -175, -145, -100, -48, -22, 0),
)
"""Upper allowances of the normal tooth thickness [um] by range of diameters and series."""
TOLERANCES: Final = (
    (3, 5, 8, 12, 20, 30, 50, 80, 130, 200),
    (5, 8, 12, 20, 30, 50, 80, 130, 200, 300),
    (6, 10, 16, 25, 40, 60, 100, 160, 250, 400),
    (8, 12, 20, 30, 50, 80, 130, 200, 300, 500),
    (10, 16, 25, 40, 60, 100, 160, 250, 400, 600),
    (12, 20, 30, 50, 80, 130, 200, 300, 500, 800),
)
"""Tolerances [um] by range of diameters, series 21 to 30."""
CLASS: Final = re.compile(r"(ab|bc|cd|[a-h])(2[1-9]|30)")
"""A DIN 3967 class: series of the allowance and of the tolerance."""

SIZES: Final = (
    3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150,
)  # fmt: skip
"""Upper ends of the ranges of ISO 286-1 [mm]."""
GRADES: Final = {
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27, 32, 36, 40, 47, 55, 65, 78, 96),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29, 32, 36, 40, 44, 50, 56, 66, 78, 92, 110, 135),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63, 70, 80, 90, 105, 125, 150, 175, 210),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72, 81, 89, 97, 110, 125, 140, 165, 195, 230, 280, 330),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115, 130, 140, 155, 175, 200, 230, 260, 310, 370, 440, 540),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185, 210, 230, 250, 280, 320, 360, 420, 500, 600, 700, 860),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290, 320, 360, 400, 440, 500, 560, 660, 780, 920, 1100, 1350),
}  # fmt: skip
"""Standard tolerances IT5 to IT11 [um] by range of sizes."""


def thickness_allowances(name: str, diameter: float) -> tuple[float, float] | None:
    """Return upper and lower allowance of the normal tooth thickness [m] of a DIN 3967 class at a reference diameter [m].

    None beyond 1000 mm, the end of its table.

    >>> [round(each, 9) for each in thickness_allowances("cd27", 0.1)]  # the standard's own example
    [-7e-05, -0.00017]
    """
    found = CLASS.fullmatch(name)
    assert found is not None, "validated"
    row = bisect_left(DIAMETERS, 1e3 * diameter * (1.0 - 1e-12))
    if row == len(DIAMETERS):
        return None
    upper = UPPER[row][SERIES.index(found[1])]
    return 1e-6 * upper, 1e-6 * (upper - TOLERANCES[row][int(found[2]) - 21])


def distance_allowance(grade: int, distance: float) -> float | None:
    """Return the allowance js of a centre distance [m], half the standard tolerance of its grade; None beyond 3150 mm.

    >>> distance_allowance(7, 0.078), distance_allowance(7, 0.19)
    (1.5e-05, 2.3e-05)
    """
    row = bisect_left(SIZES, 1e3 * distance * (1.0 - 1e-12))
    return None if row == len(SIZES) else round(0.5e-6 * GRADES[grade][row], 12)
