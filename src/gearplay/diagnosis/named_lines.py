"""Names of the lines of a spectrum and of an envelope spectrum."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.bearing_combs import ORDERS, SIDEBANDS, Key
from gearplay.diagnosis.line_names import envelope_names, further_names, spectrum_names, times
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.shaft_speed import FoundSpeed, floor_of

Floats = NDArray[np.float64]

FOUND: Final = 4.0
"""Amplitude over the median around, from which a line is there."""
STRONGEST: Final = 12
"""Strongest peaks that are named, too."""
NEAR: Final = 1.0
"""Most lines of the spectrum between a peak and the place by which it is named: half a line, and that of the speed."""
ENVELOPE_SLIP: Final = 0.01
"""Relative distance of a peak of an envelope from the place by which it is named: elements slip."""
UNNAMED: Final = "unnamed"


@dataclass(frozen=True)
class NamedLine:
    """A line: where it is expected (nan of a peak without a name) and found [Hz], its amplitude [unit] and prominence [1].

    Of a line that is not there, ``frequency`` is nan, and ``amplitude`` the largest value near where it should be.
    """

    name: str
    domain: str
    expected: float
    frequency: float
    amplitude: float
    prominence: float


def _with_names(
    lines: list[NamedLine], names: Mapping[str, float], resolution: float, slip: float = 0.0
) -> list[NamedLine]:
    """Return lines with the peaks without a name named by the nearest of ``names`` [Hz], within `NEAR` lines or the slip."""
    texts, places = list(names), np.array(list(names.values()))
    named = []
    for line in lines:
        nearest = (
            int(np.argmin(np.abs(places - line.frequency))) if line.name == UNNAMED and places.size else -1
        )
        if nearest >= 0 and abs(places[nearest] - line.frequency) <= max(
            NEAR * resolution, slip * line.frequency
        ):
            named.append(replace(line, name=texts[nearest], expected=float(places[nearest])))
        else:
            named.append(line)
    return named


def named_spectrum(
    frequency: Floats, amplitude: Floats, machine: Machine, speed: FoundSpeed
) -> list[NamedLine]:
    """Return the lines of interest of an amplitude spectrum, and its strongest peaks with their names."""
    slip, resolution = 0.0 if speed.known else 0.02, float(frequency[1] - frequency[0])
    wanted = spectrum_names(machine, speed.frequency)
    lines = _named(frequency, amplitude, wanted, wanted, "spectrum", dict.fromkeys(wanted, slip))
    names = wanted | further_names(machine, speed, resolution, "spectrum")
    return _with_names(lines, names, resolution, slip)


def named_envelope(
    frequency: Floats,
    amplitude: Floats,
    machine: Machine,
    speed: FoundSpeed,
    placed: Mapping[Key, float] | None = None,
) -> list[NamedLine]:
    """Return the lines of interest of an envelope spectrum, and its strongest peaks with their names; bearings slip.

    Lines of the parts in ``placed`` are sought where these were found [Hz], not within the slip, and have their peaks first.
    """
    wanted = envelope_names(machine, speed.frequency)
    plain = 0.0 if speed.known else 0.02
    slips = {name: 0.015 if any(word in name for word in ("BPF", "BSF", "FTF")) else plain for name in wanted}
    places = envelope_names(machine, speed.frequency, placed)
    slips |= {name: 0.002 for name, place in places.items() if place != wanted[name]}
    f, resolution = speed.frequency, float(frequency[1] - frequency[0])
    lines = _named(frequency, amplitude, wanted, places, "envelope", slips)
    lines = _with_multiples(
        _with_names(lines, places, resolution, ENVELOPE_SLIP), machine, f, resolution, placed or {}
    )
    return _with_names(lines, further_names(machine, speed, resolution, "envelope"), resolution)


def _with_multiples(
    lines: list[NamedLine], machine: Machine, f: float, resolution: float, placed: Mapping[Key, float]
) -> list[NamedLine]:
    """Return the lines of an envelope with peaks named that are further multiples or sidebands of a bearing's line as found.

    The line's frequency is that of the highest multiple found, of two at least, so that its slip does not matter. Peaks of
    other parts, which slip may put there, are those of a part in ``placed``.
    """
    at = {line.name: line.frequency for line in lines if not math.isnan(line.frequency)}
    bases: list[tuple[str, str, int, float, float, bool]] = []
    for k, bearing in enumerate(machine.bearings):
        suffix = f" of {bearing.name}" if len(machine.bearings) > 1 else ""
        ring = "BPFI" if bearing.turning == "inner" else "BPFO"
        for part in ("outer", "inner", "element"):
            name = ORDERS[part].upper()
            seen = [h for h in (1, 2, 3, 4) if times(h, name) + suffix in at]
            if len(seen) > 1:
                base = at[times(seen[-1], name) + suffix] / seen[-1]
                turn = bearing.order * f if name == ring else 0.0
                bases.append((name, suffix, seen[-1], base, turn, (k, part) in placed))
    bases.sort(key=lambda each: not each[-1])
    named = []
    for line in lines:
        found = line
        for name, suffix, most, base, turn, first in bases:
            other = any(word in found.name for word in ("BPF", "BSF", "FTF")) and name not in found.name
            if math.isnan(line.frequency) or not (found.name == UNNAMED or (first and other)):
                continue
            for h, m in _nearest(line.frequency, base, turn):
                place = h * base + m * turn
                if abs(line.frequency - place) <= max(1.5, 0.5 * h / most) * resolution:
                    beside = f" {'+' if m > 0 else '-'} {times(abs(m), 'turn')}" if m else ""
                    found = replace(line, name=times(h, name) + beside + suffix, expected=place)
                    break
        named.append(found)
        if found is not line and line.name != UNNAMED:
            named.append(replace(line, frequency=math.nan))
    return named


def _nearest(frequency: float, base: float, turn: float) -> list[tuple[int, int]]:
    """Return multiples with sidebands that may explain a peak, the nearest to the multiple first; `envelope_names` has others."""
    h = round(frequency / base)
    found = [(h, 0)] if h > 4 else []
    if turn > 0.0:
        near = [(k, round((frequency - k * base) / turn)) for k in (h, h + 1, h - 1) if k > 0]
        found += sorted(((k, m) for k, m in near if 0 < abs(m) <= SIDEBANDS), key=lambda each: abs(each[1]))
    return found


def _each_once(lines: list[NamedLine], wanted: dict[str, float], sought: dict[str, float]) -> list[NamedLine]:
    """Return the lines, each peak once: under a name that was placed, else under the one that was sought nearest."""

    def rank(line: NamedLine) -> tuple[bool, float]:
        place = sought[line.name]
        return place == wanted[line.name], abs(line.frequency - place)

    first: dict[float, NamedLine] = {}
    for line in lines:
        other = first.get(line.frequency)
        if other is None or rank(line) < rank(other):
            first[line.frequency] = line
    return [line for line in lines if math.isnan(line.frequency) or first[line.frequency] is line]


def _named(
    frequency: Floats,
    amplitude: Floats,
    wanted: dict[str, float],
    sought: dict[str, float],
    domain: str,
    slips: dict[str, float],
) -> list[NamedLine]:
    """Return the lines of ``wanted``, ``sought`` near their places [Hz], and the strongest other peaks without names."""
    resolution = float(frequency[1] - frequency[0])
    level = np.sqrt(floor_of(amplitude**2))
    lines = []
    for name, expected in wanted.items():
        place = sought[name]
        margin = max(1.5 * resolution, slips[name] * place)
        first, last = math.ceil((place - margin) / resolution), math.floor((place + margin) / resolution)
        if first < 2 or last > amplitude.size - 2:
            continue
        at = first + int(np.argmax(amplitude[first : last + 1]))
        height = float(amplitude[at] / level[at])
        is_peak = amplitude[at] >= amplitude[at - 1] and amplitude[at] >= amplitude[at + 1]
        there = height >= FOUND and is_peak
        lines.append(NamedLine(name, domain, expected, float(frequency[at]) if there else math.nan,
                               float(amplitude[at]), height))  # fmt: skip
    lines = _each_once(lines, wanted, sought)
    taken = {each.frequency for each in lines}
    tops = [k for k in range(2, amplitude.size - 1) if amplitude[k - 1] < amplitude[k] >= amplitude[k + 1]]
    tops = sorted((k for k in tops if amplitude[k] >= FOUND * level[k]), key=lambda k: -amplitude[k])[
        :STRONGEST
    ]
    return lines + [
        NamedLine(
            UNNAMED,
            domain,
            math.nan,
            float(frequency[k]),
            float(amplitude[k]),
            float(amplitude[k] / level[k]),
        )
        for k in tops
        if float(frequency[k]) not in taken
    ]
