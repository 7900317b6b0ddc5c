"""Eccentric toothings, and the backlash that they leave."""

import cmath
from typing import TYPE_CHECKING

from gearplay.parts.mesh.drawn_gears import gear_faults
from gearplay.parts.mesh.faults import EccentricityFault
from gearplay.parts.mesh.train import geometry

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


def toothing_runout(case: "Train", name: str) -> tuple[float, float]:
    """Return eccentricity [m] and direction [rad] of a gear's toothing, faults included."""
    given = geometry.gear_of(case, name).runout
    faults = [fault for _, fault in gear_faults(case, name) if isinstance(fault, EccentricityFault)]
    if not faults:
        return given.amplitude, given.phase
    each = [(given.amplitude, given.phase), *((fault.amount, fault.phase) for fault in faults)]
    return cmath.polar(sum(cmath.rect(amount, phase) for amount, phase in each))


def runout_loss(case: "Train", j: int) -> float:
    """Return the transverse backlash [m] that mesh j loses where both eccentricities point into the mesh; NaN beyond all mesh."""
    both = sum(toothing_runout(case, name)[0] for name in geometry.signed_radii(case, j)[:2])
    if both == 0.0:
        return 0.0
    return geometry.installed_backlash(case, j) - geometry.installed_backlash(case, j, closer=both)
