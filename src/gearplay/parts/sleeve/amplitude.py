"""Bound of the acceleration within a clearance: the highest line that a motion of a sleeve's rotor can have."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from gearplay.parts.mesh.train.rolling import mesh_frequency
from gearplay.parts.sleeve.schema import Sleeve
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


def amplitude_bound(radial_clearance: float, frequency: float) -> float:
    """Return the highest line of acceleration within a clearance, (4/pi) c (2 pi f)^2 [m/s^2].

    Parameters
    ----------
    radial_clearance
        c [m]; a displacement within -c .. c has no line higher than that of a square wave, 4 c / pi.
    frequency
        f of the line [Hz].

    Examples
    --------
    >>> round(amplitude_bound(100e-6, 40.0), 3)
    8.042

    """
    return 4.0 / math.pi * radial_clearance * (2.0 * math.pi * frequency) ** 2


def amplitude_findings(case: "Train") -> Iterator[Finding]:
    """Yield the bound at the mesh frequencies of every rotor in a sleeve on the ground."""
    sleeves = ((name, part) for _, name, part in case.every_holder() if isinstance(part, Sleeve))
    for name, sleeve in sleeves:
        if (
            sleeve.on is not None or sleeve.radial_clearance == 0.0
        ):  # goes round with its carrier, or does not move
            continue
        mine = [index for index, mesh in enumerate(case.meshes) if name in mesh.rotors]
        for frequency in sorted({float(f"{mesh_frequency(case, index):.6g}") for index in mine} - {0.0}):
            yield Finding(
                "note",
                f"sleeves.{name}.radial_clearance",
                "the acceleration of a motion within the clearance has a line of at most "
                f"{amplitude_bound(sleeve.radial_clearance, frequency):.3g} m/s^2 at the mesh frequency, {frequency:.4g} Hz.",
            )
