"""Names of the lines of a spectrum and of an envelope spectrum."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.bearing_combs import ORDERS, SIDEBANDS, Key
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.shaft_speed import FoundSpeed, floor_of

Floats = NDArray[np.float64]

FOUND: Final = 4.0
"""Amplitude over the median around, from which a line is there."""
STRONGEST: Final = 12
"""Strongest peaks that are named, too."""
MOST_TURNS: Final = 40
"""Highest multiple of a shaft's turn by which a peak is named."""
APART: Final = 8
"""Bins between multiples of a turn, from which on a peak is named by one: chance puts a quarter of peaks on one."""
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


def spectrum_names(machine: Machine, f: float) -> dict[str, float]:
    """Return the lines of interest of a spectrum [Hz]: meshes with sidebands, shafts, hunting teeth, planetary orders."""
    found: dict[str, float] = {}
    for mesh in machine.meshes:
        for h in (1, 2, 3):
            found[_times(h, mesh.name)] = h * mesh.order * f
        for k in mesh.gears:
            gear = machine.gears[k]
            found[f"{mesh.name} - {gear.name}"] = (mesh.order - gear.order) * f
            found[f"{mesh.name} + {gear.name}"] = (mesh.order + gear.order) * f
        found[f"hunting tooth of {mesh.name}"] = machine.hunting(mesh) * f
    for shaft in machine.shafts:
        for h in (1, 2):
            found[_times(h, f"turn of {shaft.name}")] = h * shaft.order * f
    found |= {name: order * f for name, order in machine.others.items()}
    return found | _planet_lines(machine, f, (1, 2, 3))


def _planet_lines(machine: Machine, f: float, harmonics: Sequence[int]) -> dict[str, float]:
    """Return the lines of planetary sets that passing planets leave [Hz], but the mesh and those at the carrier passing."""
    return {
        _sideband(each.name, h, n): order * f
        for each in machine.sets
        for h in harmonics
        for order in each.alike(h)
        if (n := round(order / each.carrier) - h * each.teeth) not in (0, each.planets, -each.planets)
    }


def _sideband(name: str, h: int, n: int) -> str:
    return f"{_times(h, f'mesh {name}')} {'+' if n > 0 else '-'} {_times(abs(n), f'carrier of {name}')}"


def envelope_names(machine: Machine, f: float, placed: Mapping[Key, float] | None = None) -> dict[str, float]:
    """Return the lines of interest of an envelope spectrum [Hz]: bearings with multiples and modulation, shafts, meshes.

    ``placed`` has frequencies [Hz] of parts of bearings as they were found, in place of the kinematic ones.
    """
    found: dict[str, float] = {}
    for k, bearing in enumerate(machine.bearings):
        turn, ring = bearing.order * f, "BPFI" if bearing.turning == "inner" else "BPFO"
        suffix = f" of {bearing.name}" if len(machine.bearings) > 1 else ""
        lines = bearing.orders.frequencies(turn)
        lines |= {ORDERS[part].upper(): at for (where, part), at in (placed or {}).items() if where == k}
        for name in ("BPFO", "BPFI", "BSF", "FTF"):
            for h in (1, 2, 3, 4):
                found[_times(h, name) + suffix] = h * lines[name]
        for h in (1, 2, 3, 4):
            found[f"{_times(h, ring)} - turn{suffix}"] = h * lines[ring] - turn
            found[f"{_times(h, ring)} + turn{suffix}"] = h * lines[ring] + turn
        found[f"2 x BSF - FTF{suffix}"] = 2.0 * lines["BSF"] - lines["FTF"]
        found[f"2 x BSF + FTF{suffix}"] = 2.0 * lines["BSF"] + lines["FTF"]
    for shaft in machine.shafts:
        for h in (1, 2, 3, 4):
            found[_times(h, f"turn of {shaft.name}")] = h * shaft.order * f
    for gear in machine.gears:
        if gear.shaft is None:
            found[f"tooth of {gear.name}"] = gear.order * f
    found |= {_times(h, mesh.name): h * mesh.order * f for mesh in machine.meshes for h in (1, 2)}
    return found


def _times(h: int, name: str) -> str:
    return name if h == 1 else f"{h} x {name}"


def _more_names(machine: Machine, f: float) -> dict[str, float]:
    """Return further lines by which peaks of a spectrum are named: high mesh harmonics with sidebands, shaft orders."""
    found: dict[str, float] = {}
    for mesh in machine.meshes:
        for h in range(1, 16):
            at = h * mesh.order * f
            found[_times(h, mesh.name)] = at
            for k in mesh.gears:
                for m in (1, 2, 3):
                    gear = machine.gears[k]
                    found[f"{_times(h, mesh.name)} - {_times(m, gear.name)}"] = at - m * gear.order * f
                    found[f"{_times(h, mesh.name)} + {_times(m, gear.name)}"] = at + m * gear.order * f
    for each in machine.sets:
        near = [n for n in range(-2 * each.planets, 2 * each.planets + 1) if n]
        found |= {
            _sideband(each.name, h, n): each.carrier * (h * each.teeth + n) * f
            for h in range(1, 9)
            for n in near
        }
    for shaft in machine.shafts:
        found |= {_times(h, f"turn of {shaft.name}"): h * shaft.order * f for h in range(1, 11)}
    return found


def named_spectrum(
    frequency: Floats, amplitude: Floats, machine: Machine, speed: FoundSpeed
) -> list[NamedLine]:
    """Return the lines of interest of an amplitude spectrum, and its strongest peaks with their names."""
    f = speed.frequency
    slip = 0.0 if speed.known else 0.02
    wanted = spectrum_names(machine, f)
    lines = _named(
        frequency,
        amplitude,
        wanted,
        wanted | _more_names(machine, f),
        "spectrum",
        dict.fromkeys(wanted, slip),
        slip,
    )
    return _with_turns(lines, machine, f, float(frequency[1] - frequency[0]))


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
    lines = _named(frequency, amplitude, wanted, places, "envelope", slips, 0.01, places)
    f, resolution = speed.frequency, float(frequency[1] - frequency[0])
    return _with_turns(_with_multiples(lines, machine, f, resolution, placed or {}), machine, f, resolution)


def _with_turns(lines: list[NamedLine], machine: Machine, f: float, resolution: float) -> list[NamedLine]:
    """Return lines with the peaks without a name named that are multiples of a shaft's turn, where these are well apart."""
    turns = [
        (shaft.name, shaft.order * f) for shaft in machine.shafts if shaft.order * f >= APART * resolution
    ]
    named = []
    for line in lines:
        found = line
        for name, turn in turns if line.name == UNNAMED else ():
            h = round(line.frequency / turn)
            if 0 < h <= MOST_TURNS and abs(line.frequency - h * turn) <= resolution:
                found = replace(line, name=_times(h, f"turn of {name}"), expected=h * turn)
                break
        named.append(found)
    return named


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
            seen = [h for h in (1, 2, 3, 4) if _times(h, name) + suffix in at]
            if len(seen) > 1:
                base = at[_times(seen[-1], name) + suffix] / seen[-1]
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
                    beside = f" {'+' if m > 0 else '-'} {_times(abs(m), 'turn')}" if m else ""
                    found = replace(line, name=_times(h, name) + beside + suffix, expected=place)
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
    known: dict[str, float],
    domain: str,
    slips: dict[str, float],
    slip: float,
    places: dict[str, float] | None = None,
) -> list[NamedLine]:
    """Return the lines of ``wanted``, sought near ``places`` where these differ, and the strongest peaks by ``known`` names."""
    sought = wanted if places is None else places
    resolution = float(frequency[1] - frequency[0])
    power = amplitude**2
    level = np.sqrt(floor_of(power))
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
    names, near = list(known), np.array(list(known.values())) if known else np.zeros(0)
    tops = [k for k in range(2, amplitude.size - 1) if amplitude[k - 1] < amplitude[k] >= amplitude[k + 1]]
    tops = sorted((k for k in tops if amplitude[k] >= FOUND * level[k]), key=lambda k: -amplitude[k])[
        :STRONGEST
    ]
    for k in tops:
        at_frequency = float(frequency[k])
        if at_frequency in taken:
            continue
        name, expected = UNNAMED, math.nan
        if near.size:
            nearest = int(np.argmin(np.abs(near - at_frequency)))
            if abs(near[nearest] - at_frequency) <= max(1.5 * resolution, slip * at_frequency):
                name, expected = names[nearest], float(near[nearest])
        lines.append(
            NamedLine(
                name, domain, expected, at_frequency, float(amplitude[k]), float(amplitude[k] / level[k])
            )
        )
    return lines
