"""Lines of a planetary set at a fixed sensor."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Final

LOUD: Final = 0.5
"""Sum of the planets' waves at a line, over that of waves in phase, from which planets that are alike leave it."""
SILENT: Final = 0.05
"""Sum below which they do not."""


@dataclass(frozen=True)
class PlanetarySet:
    """A planetary set of which the sun or the ring stands: orders of its lines at a fixed sensor.

    ``teeth`` meshes pass in a turn of the carrier; ``carrier`` are its turns in one of the first shaft, ``sun`` and ``planet``
    those of sun and planets relative to it; ``angles`` [rad] are the places of the planets in the direction in which the carrier
    turns; ``gears`` are the places of sun, planet and ring, ``shaft`` that of the carrier.

    Planets that are alike pass a sensor with one wave after another, also between unequal angles: the teeth of the standing gear
    set its phase by the place. Of the lines m f_c, m = h z + n, they leave |sum_i exp(j m psi_i)| / N; of N evenly spaced ones
    those with m a multiple of N (McFadden and Smith, Proc. IMechE C 199 (1985) 65). Uneven planets fill the rest. An eccentric
    sun has lines at m f_c -+ f_s, f_s relative to the carrier, with the sum at m -+ 1; an eccentric planet at m f_c -+ f_p, f_p
    relative to the carrier, with every m.
    """

    name: str
    angles: tuple[float, ...]
    teeth: int
    carrier: float
    sun: float
    planet: float
    gears: tuple[int, int, int]
    shaft: int

    @property
    def planets(self) -> int:
        """Number of planets."""
        return len(self.angles)

    def sum_at(self, m: int) -> float:
        """Return the sum of the waves of planets that are alike at order m of the carrier, over that of waves in phase.

        >>> third = 2.0 * math.pi / 3.0
        >>> even = PlanetarySet("a", (0.0, third, 2.0 * third), 91, 0.2, 0.8, 0.5, (0, 1, 2), 0)
        >>> [round(even.sum_at(m), 9) for m in (90, 91, 93)]
        [1.0, 0.0, 1.0]
        """
        return abs(sum(cmath.exp(1j * m * angle) for angle in self.angles)) / self.planets

    def alike(self, h: int) -> list[float]:
        """Return the orders around harmonic h of the mesh that planets which are alike leave."""
        return [self.carrier * (h * self.teeth + n) for n in self._near(h, 0)]

    def uneven(self, h: int) -> list[float]:
        """Return the orders around harmonic h of the mesh that planets which are alike do not have."""
        orders = [h * self.teeth + n for n in self._all()]
        return [self.carrier * m for m in orders if self.sum_at(m) <= SILENT]

    def eccentric_sun(self, h: int) -> list[float]:
        """Return the orders around harmonic h of the mesh that an eccentric sun has."""
        lines = [(n, side) for side in (-1, 1) for n in self._near(h, -side)]
        return [self.carrier * (h * self.teeth + n) + side * self.sun for n, side in lines]

    def eccentric_planet(self, h: int) -> list[float]:
        """Return the orders around harmonic h of the mesh that an eccentric planet has."""
        return [
            self.carrier * (h * self.teeth + n) + side * self.planet for side in (-1, 1) for n in self._all()
        ]

    def apart(self, member: str) -> float:
        """Return the least distance, as an order, of lines of an eccentric "sun", "planet" or "uneven" planets from others."""
        places = {"uneven": (0.0,), "sun": (self.sun, -self.sun), "planet": (self.planet, -self.planet)}
        own = places.pop(member)[0]
        others = [place for every in places.values() for place in every]
        return min(self.carrier, *(abs(math.remainder(own - other, self.carrier)) for other in others))

    def _all(self) -> range:
        return range(-self.planets, self.planets + 1)

    def _near(self, h: int, shift: int) -> list[int]:
        return [n for n in self._all() if self.sum_at(h * self.teeth + n + shift) >= LOUD]
