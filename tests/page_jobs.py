"""What tests of the page's jobs ask with: two fields with the ranges of their sliders, no progress, no stop."""

import threading

from gearplay.model.case import Case
from gearplay.web.controls import controls

STOP = threading.Event()
SPEED, CLEARANCE = "rotors.pinion.drive.speed", "sleeves.ring.radial_clearance"


def quiet(done: float, total: float) -> None:
    """Hear of no progress."""


def ranges_of(case: Case) -> dict[str, tuple[float, float]]:
    """Return the ends [SI] of the sliders of speed and clearance."""
    return {
        each["path"]: (each["low"] / each["factor"], each["high"] / each["factor"])
        for each in controls(case)
        if each["path"] in (SPEED, CLEARANCE)
    }
