"""Combs of the parts of all bearings in the envelopes of a record, each without the lines of a stronger one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.envelope_combs import BandEnvelope, Comb, best_comb
from gearplay.diagnosis.machine import Bearing, Machine
from gearplay.diagnosis.shaft_speed import SEARCH, FoundSpeed, located
from gearplay.results.spectra import Spectrum

Floats = NDArray[np.float64]
Key = tuple[int, str]
"""A part of a bearing: the index of the bearing, and "outer", "inner", "element" or "cage"."""

SLIP: Final = 0.02
"""Relative half width of the search for lines of a bearing, whose elements slip."""
PARTS: Final = {"outer": "outer ring", "inner": "inner ring", "element": "rolling element", "cage": "cage"}
ORDERS: Final = {"outer": "bpfo", "inner": "bpfi", "element": "bsf", "cage": "ftf"}
MULTIPLES: Final = 12
"""Multiples of the frequency of a part, 0 among them, whose lines and sidebands are kept from the other parts."""
HAIRLINE: Final = 0.03
"""Line of an envelope, relative to its highest one, below which it does not place the turns."""
SIDEBANDS: Final = 5
"""Sidebands on either side of each of these: a narrow load zone has as many."""


def bearing_combs(
    bands: Sequence[BandEnvelope], machine: Machine, f: float, taken: Floats
) -> dict[Key, Comb]:
    """Return the comb of each part of each bearing; ``f`` is the speed of the first shaft, ``taken`` lines of other sources [Hz].

    The part whose comb stands highest has more lines than the few by which it is found: multiples, each with sidebands at
    the turn or the cage. One near the place of a line of another part is no evidence of that part: its combs are formed without
    these lines, but of parts whose strongest line lies at the place of its own, between which they do not decide.
    """
    found = {
        (k, part): _comb(bands, machine, (k, part), f, taken)
        for k in range(len(machine.bearings))
        for part in ORDERS
    }
    lead = max(found, key=lambda key: found[key].height, default=None)
    if lead is None or found[lead].height <= 1.0:
        return found
    own = _lines(machine.bearings[lead[0]], lead[1], found[lead].frequency, f)
    return {
        key: comb if coincide(machine, lead, key) else _comb(bands, machine, key, f, taken, own)
        for key, comb in found.items()
    }


def turns_of_envelopes(bands: Sequence[BandEnvelope], machine: Machine, given: FoundSpeed) -> FoundSpeed:
    """Return the speed at which the turns of the shafts stand in an envelope, ``given`` where they do not.

    A ring that turns under the load is hit harder once a turn, also where the shaft leaves no line in the spectrum.
    """
    pattern = [(h * shaft.order, 0.0) for shaft in machine.shafts for h in (1.0, 2.0, 3.0)]
    comb = best_comb(bands, given.frequency, pattern, search=SEARCH, balanced="multiples")
    if comb.height <= 1.0 or _is_hairline(bands, comb, pattern):
        return given
    found = _between_bins(bands, comb, pattern)
    if found is None:
        return given
    # One line alone may have been located, where the load differs from turn to turn to a tenth of a bin.
    least = 0.1 * bands[0].resolution / min(order for order, _ in pattern)
    return FoundSpeed(found[0], max(found[1], least), "envelope")


def _band_of(bands: Sequence[BandEnvelope], comb: Comb) -> BandEnvelope:
    """Return the envelope in which a comb was found."""
    return next(each for each in bands if (each.low, each.high) == (comb.low, comb.high))


def _is_hairline(bands: Sequence[BandEnvelope], comb: Comb, pattern: Sequence[tuple[float, float]]) -> bool:
    """Return whether the highest line of a comb is what the smeared lines of its envelope leave, in a record without noise."""
    band = _band_of(bands, comb)
    places = [round((k * comb.frequency + offset) / band.resolution) for k, offset in pattern]
    own = max(float(band.amplitude[p - 1 : p + 2].max()) for p in places if 1 <= p < band.amplitude.size - 1)
    return own < HAIRLINE * float(band.amplitude[3:].max())


def strongest_line(machine: Machine, key: Key) -> float:
    """Return the order of the strongest envelope line of a part of a bearing."""
    bearing = machine.bearings[key[0]]
    times = 2.0 if key[1] == "element" else 1.0
    return times * bearing.order * float(getattr(bearing.orders, ORDERS[key[1]]))


def coincide(machine: Machine, one: Key, other: Key) -> bool:
    """Return whether the strongest lines of two parts may coincide: within the slip, or as multiples; BPFO is Z times FTF."""
    if one[0] == other[0] and {one[1], other[1]} <= {"cage", "outer"}:
        return True
    ratio = strongest_line(machine, other) / strongest_line(machine, one)
    return any(abs(k * ratio - 1.0) < 1.25 * SLIP for k in (0.5, 1.0, 2.0))


def _comb(
    bands: Sequence[BandEnvelope],
    machine: Machine,
    key: Key,
    f: float,
    taken: Floats,
    peaks: Floats | None = None,
) -> Comb:
    bearing = machine.bearings[key[0]]
    line = f * bearing.order * float(getattr(bearing.orders, ORDERS[key[1]]))
    pattern = _pattern(bearing, key[1], f)
    comb = best_comb(bands, line, pattern, search=SLIP, without=taken, peaks=peaks, balanced="lines")
    found = _between_bins(bands, comb, pattern) if comb.height > 1.0 else None
    if found is None or abs(found[0] / line - 1.0) > SLIP:
        return comb
    return replace(comb, frequency=found[0], off=found[0] / line - 1.0)


def _between_bins(
    bands: Sequence[BandEnvelope], comb: Comb, pattern: Sequence[tuple[float, float]]
) -> tuple[float, float] | None:
    """Return frequency and uncertainty [Hz] of a comb from its multiples that stand out, None without any."""
    band = _band_of(bands, comb)
    places = np.arange(band.amplitude.size, dtype=np.float64) * band.resolution
    multiples = np.array([k for k, offset in pattern if offset == 0.0])
    return located(Spectrum(places, band.amplitude, "hann", "amplitude", "1"), multiples, comb.frequency)


def _pattern(bearing: Bearing, part: str, f: float) -> list[tuple[float, float]]:
    """Return the lines of a defect: multiples of its frequency, and modulation by shaft, cage or carrier as offsets [Hz]."""
    turn, carrier = bearing.order * f, bearing.carrier * f
    if carrier > 0.0 and part not in ("element", bearing.turning):
        return [(h, offset) for h in (1.0, 2.0, 3.0) for offset in (0.0, -carrier, carrier)]
    if part == bearing.turning:  # the load zone is passed once a turn
        return [(1.0, 0.0), (2.0, 0.0), (1.0, -turn), (1.0, turn), (2.0, -turn), (2.0, turn)]
    if part == "element":  # it meets both rings, its load changes with the cage
        cage = turn * bearing.orders.ftf
        return [(1.0, 0.0), (2.0, 0.0), (4.0, 0.0), (2.0, -cage), (2.0, cage), (4.0, -cage)]
    return [(float(k), 0.0) for k in (range(1, 7) if part == "cage" else range(1, 5))]


def _lines(bearing: Bearing, part: str, frequency: float, f: float) -> Floats:
    """Return the lines [Hz] that a defect at ``frequency`` [Hz] may have: multiples with sidebands at what modulates its load."""
    turn = bearing.order * f
    step = turn * bearing.orders.ftf if part == "element" else turn
    count = 0 if part == "cage" else SIDEBANDS
    places = np.arange(MULTIPLES)[:, None] * frequency + np.arange(-count, count + 1) * step
    return places[places > 0.0]
