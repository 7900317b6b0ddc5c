"""Names and places of lines of spectra and of envelope spectra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from gearplay.diagnosis.bearing_combs import ORDERS, Key
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.shaft_speed import FoundSpeed

MOST_TURNS: Final = 40
"""Highest multiple of a shaft's turn by which a peak is named."""
APART: Final = 8
"""Bins between multiples of a turn, from which on a peak is named by one: chance puts a quarter of peaks on one."""


def spectrum_names(machine: Machine, f: float) -> dict[str, float]:
    """Return the lines of interest of a spectrum [Hz]: meshes with sidebands, shafts, hunting teeth, planetary orders."""
    found: dict[str, float] = {}
    for mesh in machine.meshes:
        for h in (1, 2, 3):
            found[times(h, mesh.name)] = h * mesh.order * f
        for k in mesh.gears:
            gear = machine.gears[k]
            found[f"{mesh.name} - {gear.name}"] = (mesh.order - gear.order) * f
            found[f"{mesh.name} + {gear.name}"] = (mesh.order + gear.order) * f
        found[f"hunting tooth of {mesh.name}"] = machine.hunting(mesh) * f
    for shaft in machine.shafts:
        for h in (1, 2):
            found[times(h, f"turn of {shaft.name}")] = h * shaft.order * f
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
    return f"{times(h, f'mesh {name}')} {'+' if n > 0 else '-'} {times(abs(n), f'carrier of {name}')}"


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
                found[times(h, name) + suffix] = h * lines[name]
        for h in (1, 2, 3, 4):
            found[f"{times(h, ring)} - turn{suffix}"] = h * lines[ring] - turn
            found[f"{times(h, ring)} + turn{suffix}"] = h * lines[ring] + turn
        found[f"2 x BSF - FTF{suffix}"] = 2.0 * lines["BSF"] - lines["FTF"]
        found[f"2 x BSF + FTF{suffix}"] = 2.0 * lines["BSF"] + lines["FTF"]
    for shaft in machine.shafts:
        for h in (1, 2, 3, 4):
            found[times(h, f"turn of {shaft.name}")] = h * shaft.order * f
    for gear in machine.gears:
        if gear.shaft is None:
            found[f"tooth of {gear.name}"] = gear.order * f
    found |= {times(h, mesh.name): h * mesh.order * f for mesh in machine.meshes for h in (1, 2)}
    return found


def times(h: int, name: str) -> str:
    """Return the name of a multiple of a line.

    >>> times(1, "mesh"), times(2, "mesh")
    ('mesh', '2 x mesh')
    """
    return name if h == 1 else f"{h} x {name}"


def further_names(machine: Machine, speed: FoundSpeed, resolution: float, domain: str) -> dict[str, float]:
    """Return further lines by which peaks are named [Hz], none where the speed is not known.

    Multiples of the turns of shafts that are `APART` lines of the spectrum or more; of a "spectrum" high mesh harmonics with
    sidebands, too.
    """
    f, found = speed.frequency, dict[str, float]()
    if not speed.known:
        return found
    for mesh in machine.meshes if domain == "spectrum" else ():
        for h in range(1, 16):
            at = h * mesh.order * f
            found[times(h, mesh.name)] = at
            for k in mesh.gears:
                for m in (1, 2, 3):
                    gear = machine.gears[k]
                    found[f"{times(h, mesh.name)} - {times(m, gear.name)}"] = at - m * gear.order * f
                    found[f"{times(h, mesh.name)} + {times(m, gear.name)}"] = at + m * gear.order * f
    for each in machine.sets if domain == "spectrum" else ():
        near = [n for n in range(-2 * each.planets, 2 * each.planets + 1) if n]
        found |= {
            _sideband(each.name, h, n): each.carrier * (h * each.teeth + n) * f
            for h in range(1, 9)
            for n in near
        }
    for shaft in machine.shafts:
        if shaft.order * f >= APART * resolution:
            found |= {
                times(h, f"turn of {shaft.name}"): h * shaft.order * f for h in range(1, MOST_TURNS + 1)
            }
    return found
