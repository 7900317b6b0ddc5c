"""Rows of terms of the teeth of a gear: deviations, given or drawn within a class, and faults (`parts.mesh.pairs.overlap`)."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.mesh import faults
from gearplay.parts.mesh.drawn_gears import tooth_faults
from gearplay.parts.mesh.pairs.deviations import FAULT_EDGE
from gearplay.parts.mesh.train import geometry
from gearplay.toothing.cracks import Crack, crack_losses, with_bore
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair
from gearplay.toothing.path_stiffness import PathStiffness
from gearplay.toothing.quality import draw_deviations

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

Floats = NDArray[np.float64]
WITH_FAULTS = 4
"""Rows of a flank of a tooth of a gear with faults."""
WITH_PROFILE = 5
"""Rows of a flank of a tooth of a gear with a worn profile."""
GONE = 0.1
"""Material that a missing tooth lacks [m]: more than any pair could overlap."""
WHOLE = (0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Rows without a fault: nothing is missing, spall and chip begin beyond the tip."""


def tooth_rows(
    case: "Train",
    name: str,
    pair: GearPair,
    stiffness: PathStiffness | None,
    which: int,
    member: tuple[int, int],
    spline: list[list[float]],
) -> Floats | None:
    """Return the rows of all teeth of a gear, two flanks a tooth, the clockwise one first; None for perfect teeth.

    Parameters
    ----------
    case, name
        Name of the gear in its mesh.
    pair
        Its pair.
    stiffness
        Of the pair, which cracks take from; None where no fault takes stiffness.
    which
        0 for the first gear of the pair, 1 for the second.
    member
        Seed of the run and number of the member, by which deviations are drawn.
    spline
        Pieces of cubics, to which those of worn profiles are added.

    """
    gear = (pair.first, pair.second)[which]
    deviating = _deviation_rows(case, name, gear, member, spread=pair.overlap > 0.0)
    broken = [fault for _, fault in tooth_faults(case, name)]
    if not broken:
        return deviating
    profiled = any(isinstance(fault, faults.WearFault) and fault.profile for fault in broken)
    count = WITH_PROFILE if profiled else WITH_FAULTS
    rows = np.tile(np.reshape(WHOLE[: 3 * count], (count, 3)), (gear.teeth, 2, 1, 1))
    if deviating is not None:
        rows[:, :, 0] = deviating.reshape(gear.teeth, 2, 3)
    counter = 0 if gear.internal else 1  # the left flank
    for fault in broken:
        flank = getattr(fault, "flank", "both")
        sides = [counter] * (flank != "right") + [1 - counter] * (flank != "left")
        if isinstance(fault, faults.WearFault) and fault.profile:
            pieces = profile_pieces(fault.profile)
            rows[:, sides, 4, :2] = len(spline), len(pieces) - 1
            spline.extend(pieces.tolist())
            continue
        for side in sides:
            _add_fault(rows, fault, side, gear, stiffness, which)
    return rows.reshape(-1, 3)


def _add_fault(
    rows: Floats,
    fault: faults.GearFault,
    side: int,
    gear: DrawnGear,
    stiffness: PathStiffness | None,
    which: int,
) -> None:
    """Write a fault of one flank into the rows [tooth, side, row, column]."""
    tooth = getattr(fault, "tooth", 0)
    if isinstance(fault, faults.CrackFault):
        assert stiffness is not None, "validated"
        rows[tooth, side, 3] = _losses(stiffness, which, Crack(fault.depth, fault.angle))
    elif isinstance(fault, faults.ChipFault):
        rows[tooth, side, 2, 1:] = fault.height, fault.share
    elif isinstance(fault, faults.SpallFault):
        rows[tooth, side, 1, 1:], rows[tooth, side, 2, 0] = (fault.start, fault.end), fault.depth
    elif isinstance(fault, faults.MissingToothFault):
        rows[tooth, side, 0, 0] += GONE
    elif isinstance(fault, faults.PitchFault):
        rows[tooth, side, 0, 0] += (1.0 - 2.0 * side) * math.cos(gear.transverse_angle) * fault.offset
    elif isinstance(fault, faults.WearFault):
        rows[:, side, 1, 0] += fault.depth or 0.0


def profile_pieces(profile: tuple[tuple[float, float], ...]) -> Floats:
    """Return a worn profile as shape-preserving cubics over height, rows (start, c0..c3), the last its end.

    ``profile`` is heights and depths [m]. The first and the last depth hold beyond them, so their slopes are 0 there.
    """
    from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

    x, depth = np.array(profile).T
    slopes = PchipInterpolator(x, depth).derivative()(x)
    if x[0] > 0.0:
        slopes[0] = 0.0
    if x[-1] < 1.0:
        slopes[-1] = 0.0
    pieces = np.column_stack([x[:-1], CubicHermiteSpline(x, depth, slopes).c[::-1].T])
    return np.vstack([pieces, [x[-1], 0.0, 0.0, 0.0, 0.0]])


def _losses(stiffness: PathStiffness, which: int, crack: Crack) -> Floats:
    """Return the shares of stiffness that a crack takes at the root end, the middle and the tip end of its tooth's path."""
    pair = stiffness.pair
    both = GearPair(with_bore(pair.first), with_bore(pair.second), pair.distance)
    places = np.array([pair.path.start, 0.5 * (pair.path.start + pair.path.end), pair.path.end])
    found = crack_losses(both, which, crack, places, stiffness.modulus, stiffness.poisson)
    return found if which == 0 else found[::-1]


def _deviation_rows(
    case: "Train", name: str, gear: DrawnGear, member: tuple[int, int], *, spread: bool
) -> Floats | None:
    """Return rows (pitch, slope, form) [m] of material missing, two a tooth; None without deviations.

    A flank that stands counter-clockwise of its place has less material where the tooth lies on the counter-clockwise side of it.
    Drawn for helical gears without form, whose sine along an oblique line of contact has no closed form, and without slope unless
    contact is ``spread`` over a facewidth.
    """
    given, zero = geometry.gear_of(case, name), np.zeros(gear.teeth)
    if given.quality is not None:
        seed = [*member, *geometry.full_name(case, name).encode()]
        forms = float(gear.helix_angle == 0.0)
        slopes = 1.0 if spread else forms
        drawn = draw_deviations(gear, given.quality, np.random.default_rng(seed))
        flanks = {
            side: np.column_stack([each.pitch, zero + slopes * each.slope, zero + forms * each.form])
            for side, each in (("left", drawn.left), ("right", drawn.right))
        }
    elif given.deviations is not None:
        found = given.deviations
        columns = [np.array(each) if each else zero for each in (found.pitch, found.slope, found.form)]
        table = np.column_stack(columns)
        flanks = {side: table if found.flank in (side, "both") else 0.0 * table for side in ("left", "right")}
    else:
        return None
    counter, clockwise = ("right", "left") if gear.internal else ("left", "right")
    rows = np.stack([flanks[clockwise], flanks[counter]], axis=1)
    rows[:, 0, 0] *= math.cos(gear.transverse_angle)
    rows[:, 1, 0] *= -math.cos(gear.transverse_angle)
    return rows.reshape(-1, 3)


def steepness(rows: Floats, teeth: int, spline: list[list[float]]) -> tuple[float, float]:
    """Return the largest slope and curvature [m] of the deviations over the path as unit; ``spline`` of `tooth_rows`."""
    each = rows.reshape(teeth, 2, -1, 3)
    slope = np.max(np.abs(each[:, :, 0, 1])) + math.pi * np.max(np.abs(each[:, :, 0, 2]))
    bend = math.pi**2 * np.max(np.abs(each[:, :, 0, 2]))
    if each.shape[2] > 1:
        bow, spall = np.max(np.abs(each[:, :, 1, 0])), np.max(np.abs(each[:, :, 2, 0]))
        slope += 4.0 * bow + 1.5 * spall / FAULT_EDGE
        bend += 8.0 * bow + 6.0 * spall / FAULT_EDGE**2
    if each.shape[2] > WITH_FAULTS:
        found = [
            _steepest(spline[int(first) : int(first + count) + 1])
            for first, count in each[0, :, 4, :2]
            if count > 0.0
        ]
        slope += max(steep for steep, _ in found)
        bend += max(curved for _, curved in found)
    return float(slope), float(bend)


def _steepest(pieces: list[list[float]]) -> tuple[float, float]:
    """Return the largest slope and curvature of a piecewise cubic: at ends of pieces, the slope also where curvature is 0."""
    c = np.array(pieces)
    width, (c_1, c_2, c_3) = np.diff(c[:, 0]), c[:-1, 2:].T
    with np.errstate(divide="ignore", invalid="ignore"):
        turning = np.where(c_3 != 0.0, np.clip(-c_2 / (3.0 * c_3), 0.0, width), 0.0)
    places = np.array([np.zeros_like(width), turning, width])
    slopes = c_1 + places * (2.0 * c_2 + 3.0 * places * c_3)
    return float(np.max(np.abs(slopes))), float(np.max(np.abs(2.0 * c_2 + 6.0 * places * c_3)))
