"""Mesh stiffness from terms, square wave, table, ISO 6336-1 or the teeth as drawn."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.mesh.teeth_stiffness import stiffness_table
from gearplay.parts.mesh.tooth_stiffness import STIFFNESS_FOURIER, STIFFNESS_SPLINE, STIFFNESS_SQUARE
from gearplay.parts.mesh.train.geometry import gears_of, pair_of
from gearplay.schema.records import extremes
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.iso6336 import STEEL, mean_factor, single_stiffness
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

FINEST = 1024.0
"""Highest order per mesh period that a table makes the step resolve, that of 4096 equal steps."""


class PackedStiffness(NamedTuple):
    """Mesh stiffness K(psi) in the layout of the kernels."""

    kind: int
    mean: float  # N/m; of a square wave the value with two pairs in mesh
    single: float  # N/m, square wave only
    duty: float  # share of the mesh period with two pairs
    phase: float  # rad
    rows: NDArray[np.float64]  # terms (order, amplitude, phase) or spline pieces (start, c0..c3)

    @property
    def average(self) -> float:
        """Mean over one mesh period [N/m]."""
        if self.kind == STIFFNESS_SQUARE:
            return self.duty * self.mean + (1.0 - self.duty) * self.single
        return self.mean

    def at(self, psi: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return K [N/m] at mesh phases [rad]."""
        if self.kind == STIFFNESS_FOURIER:
            order, amplitude, phase = self.rows.T
            return self.mean + np.asarray(np.cos(np.multiply.outer(psi, order) + phase) @ amplitude)
        turned = (psi + self.phase) % (2.0 * np.pi)
        if self.kind == STIFFNESS_SQUARE:
            return np.where(turned < 2.0 * np.pi * self.duty, self.mean, self.single)
        piece = np.searchsorted(self.rows[:, 0], turned, side="right") - 1
        x = (turned - self.rows[piece, 0]) % (2.0 * np.pi)
        c = self.rows[piece, 1:]
        return np.asarray(c[:, 0] + x * (c[:, 1] + x * (c[:, 2] + x * c[:, 3])))

    @property
    def highest(self) -> float:
        """An upper bound [N/m]; of a table its maximum."""
        if self.kind == STIFFNESS_FOURIER:
            return self.mean + float(np.sum(np.abs(self.rows[:, 1])))
        if self.kind == STIFFNESS_SPLINE:
            return extremes(self.rows[:, 1:], _widths(self.rows[:, 0]))[1]
        return max(self.mean, self.single)

    @property
    def highest_order(self) -> float:
        """The highest order per mesh period that a step must resolve."""
        if self.kind == STIFFNESS_FOURIER:
            return float(np.max(self.rows[:, 0], initial=0.0))
        return _order_of_table(self.rows) if self.kind == STIFFNESS_SPLINE else 1.0


def iso6336_mesh_stiffness(
    pinion: DrawnGear, wheel: DrawnGear, contact_ratio: float, facewidth: float, modulus: float
) -> float:
    """Return the mean mesh stiffness k_m = c_gamma b [N/m], ISO 6336-1 method B, c_gamma = c' (0.75 eps_alpha + 0.25).

    Solid discs, line load above 100 N/mm: at the light loads of small mechanisms the true value is lower. ``facewidth`` in m,
    ``modulus`` in Pa.

    >>> gears = DrawnGear(teeth=20, module=4e-3), DrawnGear(teeth=60, module=4e-3, internal=True)
    >>> f"{iso6336_mesh_stiffness(*gears, 1.95, 0.006, 206e9):.3g}"
    '1.46e+08'
    """
    single = single_stiffness(pinion, wheel) * modulus / STEEL
    return single * mean_factor(contact_ratio) * 1e9 * facewidth


def _widths(starts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the widths [rad] of the pieces of a periodic table that start at these mesh phases."""
    return np.diff(np.append(starts, starts[0] + 2.0 * np.pi))


def _pieces(phases: tuple[float, ...], values: tuple[float, ...]) -> NDArray[np.float64]:
    """Return the periodic shape-preserving cubic through the points (T8a): rows (start, c0, c1, c2, c3).

    Slopes of PCHIP depend on a point and its two neighbours, so two more points either side make it periodic.
    """
    from scipy.interpolate import PchipInterpolator

    x, period = np.array(phases), 2.0 * np.pi
    extended = np.concatenate([x[-2:] - period, x, x[:3] + period])
    curve = PchipInterpolator(extended, np.take(values, np.arange(-2, len(values) + 3), mode="wrap"))
    return np.column_stack([x, curve.c[::-1, 2:-2].T])


def _order_of_table(rows: NDArray[np.float64]) -> float:
    """Return the highest order of a table that a step must resolve: of its mean spacing, or for its narrowest peak or dip.

    A step, 0.5 / order of psi at most, is no longer than a peak (dip) is wide from the middle of its rise to that of its fall:
    then two stages or more lie within it, and the error estimate takes over. A monotone rise, however steep, shows in all
    stages behind it.
    """
    rise = np.sign(np.diff(np.append(rows[:, 1], rows[0, 1])))
    order = 0.25 * len(rows)
    ends = np.append(rows[1:, 0], rows[0, 0] + 2.0 * np.pi)
    runs: list[list[float]] = []  # direction, start and end of each monotone run
    for direction, start, end in zip(rise, rows[:, 0], ends, strict=True):
        if direction == 0.0:
            continue
        if runs and runs[-1][0] == direction:
            runs[-1][2] = end
        else:
            runs.append([direction, start, end])
    if len(runs) > 2 and runs[0][0] == runs[-1][0]:  # one run around the period
        runs[0][1] = runs.pop()[1] - 2.0 * np.pi
    if len(runs) > 1:
        middles = np.array([0.5 * (start + end) for _, start, end in runs])
        order = max(order, 0.5 / float(np.min(_widths(middles))))
    return min(order, max(FINEST, 0.25 * len(rows)))


def pack_stiffness(case: "Train", j: int) -> PackedStiffness:
    """Return mesh j's stiffness for the kernels, eq. (16) and the other kinds of docs/theory.

    Raises `InputError` where a square wave is given to teeth of a contact ratio of 2 or more.
    """
    mesh = case.meshes[j]
    given = mesh.stiffness
    none = np.zeros((0, 3))
    if given.kind == "harmonic":
        rows = np.array([[1.0, given.amplitude, given.phase]]) if given.amplitude else none
        return PackedStiffness(STIFFNESS_FOURIER, given.mean, 0.0, 1.0, 0.0, rows)
    if given.kind == "fourier":
        rows = np.array([[float(t.order), t.amplitude, t.phase] for t in given.terms]).reshape(-1, 3)
        return PackedStiffness(STIFFNESS_FOURIER, given.mean, 0.0, 1.0, 0.0, rows)
    if given.kind == "square":
        ratio = given.contact_ratio if given.contact_ratio is not None else pair_of(case, j).contact_ratio
        if ratio >= 2.0:
            raise InputError.of(
                f"meshes.{j}.stiffness.kind",
                "square",
                f"the wave is of one pair of teeth and two, but by a contact ratio of {ratio:.3g} there"
                " are always two",
                "Give stiffness.contact_ratio below 2, or the curve as kind table.",
            )
        duty = max(ratio - 1.0, 0.0)
        return PackedStiffness(STIFFNESS_SQUARE, given.double, given.single, duty, given.phase, none)
    if given.kind == "table":
        return _of_pieces(_pieces(given.phase, given.stiffness))
    if given.kind == "teeth":
        return _of_pieces(stiffness_table(case, j))
    pinion, wheel = sorted(gears_of(case, j), key=lambda gear: (gear.internal, gear.teeth))
    k_m = iso6336_mesh_stiffness(
        pinion, wheel, pair_of(case, j).contact_ratio, given.facewidth, given.modulus
    )
    rows = np.array([[1.0, given.amplitude_ratio * k_m, given.phase]]) if given.amplitude_ratio else none
    return PackedStiffness(STIFFNESS_FOURIER, k_m, 0.0, 1.0, 0.0, rows)


def _of_pieces(pieces: NDArray[np.float64]) -> PackedStiffness:
    widths = _widths(pieces[:, 0])
    powers = np.array([widths ** (i + 1) / (i + 1) for i in range(4)])
    mean = float(np.sum(pieces[:, 1:].T * powers) / (2.0 * np.pi))
    return PackedStiffness(STIFFNESS_SPLINE, mean, 0.0, 1.0, 0.0, pieces)
