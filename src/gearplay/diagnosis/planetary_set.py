"""Lines of a planetary set at a fixed sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class PlanetarySet:
    """A planetary set with evenly spaced planets, of which the sun or the ring stands: orders of its lines at a fixed sensor.

    ``teeth`` meshes pass in a turn of the carrier; ``carrier`` are its turns in one of the first shaft, ``sun`` and ``planet``
    those of sun and planets relative to it; ``gears`` are the places of sun, planet and ring, ``shaft`` that of the carrier.

    The teeth of N planets that pass a sensor one after another leave, of the lines h z f_c + n f_c, those with h z + n a multiple
    of N where the planets are alike (McFadden and Smith, Proc. IMechE C 199 (1985) 65); uneven ones fill the rest. An
    eccentric sun has lines at h z f_c + n f_c -+ f_s, f_s relative to the carrier, with h z + n -+ 1 a multiple of N; an
    eccentric planet at h z f_c + n f_c -+ f_p, f_p relative to the carrier, with every n.
    """

    name: str
    planets: int
    teeth: int
    carrier: float
    sun: float
    planet: float
    gears: tuple[int, int, int]
    shaft: int

    def alike(self, h: int) -> list[float]:
        """Return the orders around harmonic h of the mesh that planets which are alike leave."""
        return [self.carrier * (h * self.teeth + n) for n in self._near(h, 0)]

    def uneven(self, h: int) -> list[float]:
        """Return the orders around harmonic h of the mesh that planets which are alike do not have."""
        own = self._near(h, 0)
        return [self.carrier * (h * self.teeth + n) for n in self._all() if n not in own]

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
        return [n for n in self._all() if (h * self.teeth + n + shift) % self.planets == 0]
