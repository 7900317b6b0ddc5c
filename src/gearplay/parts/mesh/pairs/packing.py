"""Packing of pairs of teeth: geometry of both gears, stiffness over the path of contact, deviations, numbers of teeth."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.mesh.drawn_gears import deviates
from gearplay.parts.mesh.pairs.record import FLANKS, SPARE
from gearplay.parts.mesh.pairs.slopes import COLUMNS, LEADING
from gearplay.parts.mesh.pairs.tooth_rows import steepness, tooth_rows
from gearplay.parts.mesh.teeth_stiffness import stiffness_over_path
from gearplay.parts.mesh.train import geometry
from gearplay.parts.protocol import Packing
from gearplay.toothing.gear import DrawnGear, inv
from gearplay.toothing.iso6336 import parabola
from gearplay.toothing.pair import GearPair
from gearplay.toothing.path_stiffness import PathStiffness, cubic_places, cubics

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train
    from gearplay.parts.rotor.gear import Gear
    from gearplay.parts.rotor.schema import Rotor


def _pack_gear(
    m: Any, ending: str, gear: DrawnGear, given: "Gear | Rotor", ends: tuple[float, float], number: int
) -> None:
    tip, relief = gear.tip, given.tip_relief
    values = {
        "base": gear.base_radius,
        "tip": tip,
        "tip_length": gear.length_to_tip,
        "tip_involute": inv(math.acos(min(1.0, gear.base_radius / tip))),
        "teeth": float(gear.teeth),
        "relief": relief.amount if relief is not None else 0.0,
        "relief_length": relief.length if relief is not None else 1.0,
        "relief_power": relief.power if relief is not None else 1.0,
        "low": ends[0],
        "high": ends[1],
        "toothing": -1,
        "rows": 1,
        "number": number,
    }
    for name, value in values.items():
        setattr(m, f"{name}_{ending}", value)


def _half_angles(case: "Train", j: int, pair: GearPair) -> tuple[float, float]:
    """Return the half angles of both gears at their base circles [rad]; a backlash that is given thins both alike."""
    thinner = 0.25 * (geometry.working_backlash(case, j) - pair.backlash)
    first = pair.first.half_angle - thinner / pair.first.base_radius
    second = pair.second.half_angle - pair.second.sign * thinner / pair.second.base_radius
    return first, second


def pack_pairs(packing: Packing, j: int, m: Any, numbers: tuple[int, int]) -> None:
    """Fill the fields of mesh j's record for pairs of teeth; add their stiffness to the curves and deviations to the terms.

    A mesh with one stiffness has them where its teeth deviate: their envelope acts.

    ``numbers`` are those of driver's and driven tooth at the line of centres where nothing has turned.
    """
    case: Train = packing.train
    mesh = case.meshes[j]
    if mesh.contact != "pairs" and not deviates(case, j):
        return
    m.envelope = int(mesh.contact != "pairs")
    found = None if m.envelope else stiffness_over_path(case, j)
    pair, working = geometry.installed_pair(case, j), geometry.pair_of(case, j)
    path, line = pair.path, pair.base_tangent
    m.ring_drives = int(mesh.driver == geometry.ring_of(case, mesh))
    m.base_pitch = pair.first.base_pitch
    m.half_angle = _half_angles(case, j, working)[m.ring_drives]
    m.shift = line if m.ring_drives else 0.0
    low, high = path.start - 0.5 * pair.overlap, path.end + 0.5 * pair.overlap
    m.pairs = math.ceil((high - low) / pair.first.base_pitch) + SPARE
    m.middle = 0.5 * (low + high)
    m.fades = int(pair.overlap > 0.0)
    m.oblique, m.path_start, m.path_end = 0.5 * pair.overlap, path.start, path.end
    m.corners = int(mesh.tip_contact and not m.fades)
    m.start, m.end = (-math.inf, math.inf) if m.corners else (low, high)
    ends = (path.start, path.end), (line - path.end, line - path.start)
    if pair.internal:
        ends = ends[0], (line + path.end, line + path.start)
    numbers = numbers[::-1] if m.ring_drives else numbers
    slope = bend = 0.0
    for k, (ending, gear, name) in enumerate(
        zip("12", (pair.first, pair.second), geometry.gears_of_pair(case, j), strict=True)
    ):
        given, width = geometry.gear_of(case, name), abs(ends[k][1] - ends[k][0])
        _pack_gear(m, ending, gear, given, ends[k], numbers[k])
        if (relief := given.tip_relief) is not None:
            slope += relief.power * relief.amount / relief.length
            bend += (relief.power - 1.0) * 2.0 * relief.amount / relief.length**2
        rows = tooth_rows(case, name, pair, found, k, packing.member, packing.spline)
        if rows is not None:
            first, count = packing.add_terms(rows.tolist())
            setattr(m, f"toothing_{ending}", first)
            setattr(m, f"rows_{ending}", count // (2 * gear.teeth))
            steepest, most_curved = steepness(rows, gear.teeth, packing.spline)
            slope += steepest / width
            bend += most_curved / width**2
    m.deviation_slope, m.deviation_curvature = slope, bend
    m.varies = int(m.fades and slope > 0.0)
    if found is None:
        return
    if m.varies:
        m.density, m.kappa = found.peak / pair.overlap, parabola(pair.contact_ratio)
    table = single_table(found)
    m.stiffest = float(np.max(found.held(np.linspace(low, high, 401))))
    m.stiffness_start, m.stiffness_count = len(packing.spline), len(table)
    packing.spline.extend(table.tolist())


def more_columns(m: Any) -> tuple[int, int]:
    """Return the numbers of modes and of columns of slopes that a mesh's pairs of teeth add to those of every mesh.

    A sense of sliding for each slot; the slopes of each pair, with an envelope of the lead and the next of each flank.
    """
    if m.pairs == 0:
        return 0, 0
    stored = LEADING if m.envelope else m.pairs
    return 0 if m.envelope else FLANKS * m.pairs, FLANKS * COLUMNS * stored


NODES = 32
"""Pieces of the path of contact over which stiffness that is no polynomial is interpolated."""


def single_table(found: PathStiffness) -> NDArray[np.float64]:
    """Return the stiffness of one pair of teeth over its place [m] as rows (start, c0..c3), [piece + 1, 5]; the last its end.

    Of ISO 6336-1 the pieces are exact; of the potential energy shape-preserving cubics.
    """
    low, high = found.reach
    if found.method == "potential-energy":
        from scipy.interpolate import PchipInterpolator

        knots = np.linspace(low, high, NODES + 1)
        pieces = PchipInterpolator(knots, found.held(knots)).c[::-1].T
    else:
        path, half = found.pair.path, 0.5 * found.pair.overlap
        knots = np.unique([low, high, path.start + half, path.end - half] if half > 0.0 else [low, high])
        widths = np.diff(knots)
        at = cubic_places(knots[:-1], widths)
        pieces = cubics(found.held(at.ravel()).reshape(at.shape), widths)
    return np.vstack([np.column_stack([knots[:-1], pieces]), [knots[-1], 0.0, 0.0, 0.0, 0.0]])
