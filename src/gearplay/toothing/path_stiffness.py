"""Mesh stiffness K over the path of contact: the sum over the pairs of teeth that are in contact, and its periodic table.

ISO 6336-1 gives the largest stiffness c' of a pair of teeth and the mean c_gamma of their sum. One parabola over the path
has both: k = c' b (1 - kappa u^2), kappa = 0.75 (1 - 1/eps_alpha), u = -1 .. 1 from A to E. Along the oblique lines of contact
of helical gears it is integrated over the facewidth in closed form, cubic in both ends; the mean stays c_gamma.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.iso6336 import STEEL, light_load_factor, parabola, single_stiffness
from gearplay.toothing.pair import GearPair
from gearplay.toothing.potential_energy import pair_stiffness

Floats = NDArray[np.float64]
Method = Literal["iso6336", "potential-energy"]
RAMP: Final = 0.02
"""Part of a base pitch over which a pair of spur teeth takes up its stiffness in the table, about A and E."""
NODES: Final = 32
"""Further pieces of the table over a base pitch, of stiffness that is no polynomial."""
CLOSEST: Final = 1e-6
"""Least length of a piece of the table, in base pitches."""
NEARLY_EQUAL: Final = 1.2
"""Ratio of the numbers of teeth below which the driver counts as the pinion of ISO 6336-1."""


def by_size(first: DrawnGear, second: DrawnGear) -> tuple[DrawnGear, DrawnGear]:
    """Return pinion and wheel of ISO 6336-1: the smaller gear first; of nearly equal gears in the given order."""
    if second.internal or second.teeth * NEARLY_EQUAL > first.teeth:
        return first, second
    return second, first


@dataclass(frozen=True)
class PathStiffness:
    """Stiffness of a pair of gears over places on the path of contact, at its centre distance.

    Parameters
    ----------
    pair
        The gears, with facewidths.
    method
        ``iso6336`` or ``potential-energy``.
    modulus, poisson
        E [Pa], nu.
    line_load
        Nominal F_t/b [N/m], of ``iso6336``.

    """

    pair: GearPair
    method: Method
    modulus: float
    poisson: float
    line_load: float

    @cached_property
    def width(self) -> float:
        """Common facewidth b [m]."""
        assert self.pair.facewidth is not None, "validated"
        return self.pair.facewidth

    @cached_property
    def peak(self) -> float:
        """Largest stiffness c' b of a pair of teeth by ISO 6336-1 [N/m], modulus and light load included."""
        c = single_stiffness(*by_size(self.pair.first, self.pair.second))
        return 1e9 * c * self.width * self.modulus / STEEL * light_load_factor(self.line_load)

    @property
    def reach(self) -> tuple[float, float]:
        """Places [m] of the middle of the facewidth between which a pair of teeth is in contact."""
        half = 0.5 * self.pair.overlap
        return self.pair.path.start - half, self.pair.path.end + half

    def single(self, places: Floats) -> Floats:
        """Return the stiffness [N/m] of one pair of teeth at places [m] of the middle of the facewidth, 0 out of contact."""
        low, high = self.reach
        inside = (places >= low) & (places <= high)
        return np.where(inside, self.held(places), 0.0)

    def held(self, places: Floats) -> Floats:
        """Return the stiffness [N/m] of one pair of teeth at places [m], beyond the path that at its ends."""
        return self._curve(np.clip(places, *self.reach))

    def _curve(self, places: Floats) -> Floats:
        path = self.pair.path
        if self.method == "potential-energy":
            distinct, at = np.unique(places, return_inverse=True)  # those beyond the path are its ends
            each = [_energy(self.pair, place, self.modulus, self.poisson) for place in distinct.tolist()]
            return np.array(each)[at].reshape(np.shape(places))
        kappa = parabola(self.pair.contact_ratio)
        middle, half = 0.5 * (path.start + path.end), 0.5 * path.length
        if self.pair.overlap == 0.0:
            return self.peak * (1.0 - kappa * ((places - middle) / half) ** 2)
        shift = 0.5 * self.pair.overlap

        def integral(place: Floats) -> Floats:
            return place - kappa * (place - middle) ** 3 / (3.0 * half * half)

        ends = (
            integral(np.minimum(places + shift, path.end)),
            integral(np.maximum(places - shift, path.start)),
        )
        return self.peak / self.pair.overlap * (ends[0] - ends[1])

    def _ramped(self, places: Floats) -> Floats:
        """Return `single` with ramps about A and E instead of jumps; of helical teeth there are none."""
        if self.pair.overlap > 0.0:
            return self.single(places)
        low, high = self.reach
        width = RAMP * self.pair.first.base_pitch
        into = _step((places - low) / width + 0.5) * _step((high - places) / width + 0.5)
        return np.where(into > 0.0, into * self.held(places), 0.0)

    def total(self, phases: Floats) -> Floats:
        """Return K [N/m] at phases in base pitches from where a pair passes the pitch point."""
        return self._sum(self.single, phases)

    def pairs_in_contact(self, phases: Floats) -> NDArray[np.int64]:
        """Return how many pairs of teeth are in contact at phases in base pitches."""
        low, high = self.reach
        return np.rint(
            self._sum(lambda places: ((places >= low) & (places <= high)).astype(np.float64), phases)
        ).astype(np.int64)

    def _sum(self, curve: Callable[[Floats], Floats], phases: Floats) -> Floats:
        pitch, middle = self.pair.first.base_pitch, self.pair.pitch_place
        low, high = self.reach
        first, last = math.floor((low - middle) / pitch) - 2, math.ceil((high - middle) / pitch) + 2
        within = np.asarray(phases) % 1.0
        each = [curve(middle + (within + j) * pitch) for j in range(first, last + 1)]
        return np.asarray(np.sum(each, axis=0))

    @cached_property
    def table(self) -> Floats:
        """K over the mesh phase as pieces of a periodic cubic: rows (start [rad], c0, c1, c2, c3), shape [piece, 5].

        0 is where a pair passes the pitch point; the phase rises with the place on the path. Of ISO 6336-1 pieces are exact, but
        for the ramps of spur gears.
        """
        pitch, middle = self.pair.first.base_pitch, self.pair.pitch_place
        path, shift = self.pair.path, 0.5 * max(self.pair.overlap, RAMP * pitch)
        ends = [end + sign * shift for end in (path.start, path.end) for sign in (-1.0, 1.0)]
        starts = sorted(((end - middle) / pitch) % 1.0 for end in ends)
        if self.method == "potential-energy":
            starts = sorted([*starts, *(np.arange(NODES) / NODES).tolist()])
        kept = [starts[0]]
        kept += [
            start for start in starts[1:] if start - kept[-1] > CLOSEST and start - kept[0] < 1.0 - CLOSEST
        ]
        left = np.array(kept)
        widths = np.diff(np.append(left, left[0] + 1.0))
        at = cubic_places(left, widths)
        values = self._sum(self._ramped, at.ravel()).reshape(at.shape)
        values[:, 3] = np.roll(values[:, 0], -1)
        return np.column_stack([2.0 * np.pi * left, cubics(values, 2.0 * np.pi * widths)])


FOUR: Final = np.array([0.0, 1.0, 2.0, 3.0])


def cubic_places(starts: Floats, widths: Floats) -> Floats:
    """Return the four places at which `cubics` takes the values of pieces, ends and thirds, shape [piece, 4]."""
    places: Floats = starts[:, None] + widths[:, None] * FOUR / 3.0
    return places


def cubics(values: Floats, widths: Floats) -> Floats:
    """Return c0 to c3 of the cubics through values at `cubic_places` of pieces of these widths, shape [piece, 4]."""
    by_power = np.linalg.inv(np.vander(FOUR / 3.0, 4, increasing=True))
    return np.asarray(values @ by_power.T / widths[:, None] ** np.arange(4))


def _step(x: Floats) -> Floats:
    bounded = np.clip(x, 0.0, 1.0)
    return bounded * bounded * (3.0 - 2.0 * bounded)


@lru_cache(maxsize=4096)
def _energy(pair: GearPair, place: float, modulus: float, poisson: float) -> float:
    return pair_stiffness(pair, place, modulus, poisson)


@lru_cache(maxsize=64)
def path_stiffness(
    pair: GearPair, method: Method, modulus: float, poisson: float, line_load: float
) -> PathStiffness:
    """Return the stiffness of a pair of gears over its path of contact, cached for the cases of a sweep."""
    return PathStiffness(pair, method, modulus, poisson, line_load)


def mirrored(table: Floats) -> Floats:
    """Return a periodic table over the phase of the other sign.

    >>> row = mirrored(np.array([[0.5, 1.0, 2.0, 0.0, 0.0], [1.5, 3.0, 0.0, 0.0, 0.0]]))
    >>> (row[:, 0] + 1.5).round(6) % 6.283185
    array([0., 1.])
    """
    turn = 2.0 * np.pi
    widths = np.diff(np.append(table[:, 0], table[0, 0] + turn))
    c = table[:, 1:]
    powers = widths[:, None] ** np.arange(4)
    values = np.sum(c * powers, axis=1)
    slopes = c[:, 1] + 2.0 * c[:, 2] * widths + 3.0 * c[:, 3] * widths**2
    curvatures = c[:, 2] + 3.0 * c[:, 3] * widths
    rows = np.column_stack([-(table[:, 0] + widths) % turn, values, -slopes, curvatures, -c[:, 3]])
    return np.asarray(rows[np.argsort(rows[:, 0])])
