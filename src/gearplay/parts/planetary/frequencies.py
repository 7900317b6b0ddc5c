"""Characteristic frequencies of planetary sets."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gearplay.parts.mesh.train import rolling
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


@dataclass(frozen=True)
class SetFrequencies:
    """Characteristic frequencies [Hz] of a planetary set of N planets at nominal speed.

    ``mesh`` is the mesh frequency z_s |f_s - f_c|, the same for all meshes. One tooth of the sun meets planets at ``sun``,
    N |f_s - f_c|, one of the ring at ``ring``, N |f_r - f_c|; one tooth of a planet meets the sun at ``planet``, mesh / z_p.
    ``carrier`` is |f_c|, ``carrier_passing`` N |f_c|, at which planets pass a fixed place on the ground. f_s, f_r and f_c are
    turns per second of sun, ring and carrier.
    """

    mesh: float
    sun: float
    planet: float
    ring: float
    carrier: float
    carrier_passing: float

    def orders(self) -> dict[str, float]:
        """Return the expected spectral lines [Hz] by name, with the mesh sidebands at the carrier passing frequency."""
        lines = {
            "carrier": self.carrier,
            "carrier passing": self.carrier_passing,
            "planet": self.planet,
            "sun": self.sun,
            "ring": self.ring,
            "mesh": self.mesh,
            "mesh - carrier passing": self.mesh - self.carrier_passing,
            "mesh + carrier passing": self.mesh + self.carrier_passing,
        }
        return {name: frequency for name, frequency in lines.items() if frequency > 0.0}


def set_frequencies(case: Train, name: str) -> SetFrequencies:
    """Return the characteristic frequencies of the planetary set called ``name``.

    Raises ``KeyError`` for an unknown set, `InputError` where prescribed speeds contradict each other.
    """
    table = case.planetary[name]
    speeds = dict(zip(case.rotors, rolling.nominal_speeds(case), strict=True))
    sun, ring, carrier = (
        float(speeds[f"{name}.{member}"]) / (2.0 * math.pi) for member in ("sun", "ring", "carrier")
    )
    count, mesh = table.planets.count, table.sun.teeth * abs(sun - carrier)
    return SetFrequencies(
        mesh=mesh,
        sun=count * abs(sun - carrier),
        planet=mesh / table.planets.teeth,
        ring=count * abs(ring - carrier),
        carrier=abs(carrier),
        carrier_passing=count * abs(carrier),
    )


def set_findings(case: Train) -> Iterator[Finding]:
    """Yield the characteristic frequencies of every set that turns."""
    for name in case.planetary:
        found = set_frequencies(case, name)
        if found.mesh > 0.0:
            yield Finding(
                "note",
                f"planetary.{name}",
                f"mesh frequency {found.mesh:.6g} Hz; a tooth of the sun meets planets at {found.sun:.6g} Hz, of a planet the "
                f"sun at {found.planet:.6g} Hz, of the ring planets at {found.ring:.6g} Hz; the carrier turns at "
                f"{found.carrier:.6g} Hz{_passing(found)}.",
            )


def _passing(found: SetFrequencies) -> str:
    """Return the text on mesh sidebands that a sensor on the ground records; empty for a carrier that does not turn."""
    if found.carrier_passing == 0.0:
        return ""
    return (
        f", planets pass a place on the ground at {found.carrier_passing:.6g} Hz, sidebands "
        f"{found.mesh:.6g} ± {found.carrier_passing:.6g} Hz"
    )
