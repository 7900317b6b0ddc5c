"""Hysteresis curve of one torque cycle, and the numbers that catalogues state of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.hysteresis.balance_path import Train
from gearplay.vocabulary.errors import SimulationError

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

ARCMIN = 180.0 * 60.0 / np.pi
"""Minutes of arc per radian."""
SMALL = 0.03
"""Torque of the lost motion, of the rated one."""
LINEAR = 0.15
"""Torque from which on torsional stiffness is counted, of the rated one."""
POINTS = 20
"""Points of each sign of the torque besides those that the numbers need."""
FAINT, FINER, LIMITS = 1e-3, 4.0, 4
"""First torque of the limit at zero load, of the rated one, the ratio of the next ones, and their number."""
NO_PLAY = 1e-13
"""Width [rad] that is rounding."""
COARSE = (SMALL, 0.1, 0.2, 0.4, 0.7, 1.0)


class Curve(NamedTuple):
    """One torque cycle: rotation of the output [rad], shape [2, torque], unloading (from the positive end) and loading.

    ``torque`` rises from -T_r to T_r and has 0 [N m]; ``tangent`` is the slope of torque over rotation [N m/rad], shape
    [2, torque], infinite where the output sticks and NaN in the play; ``loss`` the work of one cycle that friction takes [J].
    """

    torque: Floats
    angle: Floats
    tangent: Floats
    loss: float

    def at(self, branch: int, torque: float) -> float:
        """Return the rotation at a torque of the grid [rad], linear between its points."""
        return float(np.interp(torque, self.torque, self.angle[branch]))


class Numbers(NamedTuple):
    """Key numbers of a curve: rad, N m/rad, J; ``stages`` are K1, K2, K3."""

    lost_motion: float
    backlash: float
    stiffness: float
    stages: tuple[float, ...]
    loss: float


def limit_at_zero(train: Train, rated: float, sign: float) -> float:
    """Return the limit of the rotation [rad] as a torque of a sign goes to 0; train without friction, loaded with that sign.

    Deflections of linear springs go with T, those of Hertz contacts with T^(2/3): Richardson's extrapolation removes the first,
    Aitken's the other. Where something preloads the train so that this sequence does not converge, or forces of fainter torques
    are rounding of those between the teeth, its last rotation.
    """
    torques = sign * FAINT * rated * FINER ** -np.arange(float(LIMITS))
    found = [train.load(float(torques[0]))]
    try:
        found += [train.load(torque) for torque in torques[1:].tolist()]
    except SimulationError:
        return found[-1]
    angles = np.array(found)
    linear = (FINER * angles[1:] - angles[:-1]) / (FINER - 1.0)
    first, last = float(linear[1] - linear[0]), float(linear[2] - linear[1])
    if abs(last) < 1e-15 or abs(last) >= abs(first):
        return float(linear[2] if abs(last) < abs(first) or abs(last) < 1e-15 else angles[-1])
    return float(linear[2] - last**2 / (last - first))


def torque_cycle(
    train: Train, rated: float, marks: Sequence[float], *, cycles: int = 2, points: int = POINTS
) -> Curve:
    """Return the curve of the last of several cycles of the torque, 0 -> T_r -> -T_r -> T_r [N m], at ``marks`` and between."""
    shares = np.linspace(0.0, rated, points + 1)[1:]
    rising = np.unique(np.concatenate([shares, [SMALL * rated, LINEAR * rated, *marks]]))
    return _with_friction(train, rising, cycles) if train.friction else _single_valued(train, rising)


def _single_valued(train: Train, rising: Floats) -> Curve:
    n = rising.size
    torque = np.concatenate([-rising[::-1], [0.0], rising])
    angle, tangent = np.zeros((2, 2 * n + 1)), np.full((2, 2 * n + 1), np.nan)
    for branch, sign in enumerate((1.0, -1.0)):
        train.reset()
        for k in reversed(range(n)):
            place = n + int(sign) * (k + 1)
            angle[:, place] = train.load(float(sign * rising[k]))
            tangent[:, place] = _stiffness(train)
        angle[branch, n] = limit_at_zero(train, float(rising[-1]), sign)
    return Curve(torque, angle, tangent, 0.0)


def _with_friction(train: Train, rising: Floats, cycles: int) -> Curve:
    n = rising.size
    torque = np.concatenate([-rising[::-1], [0.0], rising])
    angle, tangent = np.zeros((2, 2 * n + 1)), np.zeros((2, 2 * n + 1))
    train.reset()
    for each in rising.tolist():
        train.load(each)
    before = 0.0
    for _ in range(max(1, cycles - 1)):
        before = train.dissipated
        for branch, order in ((0, range(2 * n, -1, -1)), (1, range(2 * n + 1))):
            for place in order:
                angle[branch, place] = train.load(float(torque[place]))
                tangent[branch, place] = _stiffness(train)
    return Curve(torque, angle, tangent, train.dissipated - before)


def _stiffness(train: Train) -> float:
    compliance = train.compliance()
    return 1.0 / compliance if compliance > 0.0 else np.inf


def numbers_of(curve: Curve, rated: float, stages: Sequence[float]) -> Numbers:
    """Return the key numbers; each is the mean of both signs of the torque.

    Lost motion is between the middles of both branches at +-3 % of the rated torque, backlash between the branches at 0.
    Slopes are secants of a branch on which the torque moves away from 0, for K1 of one on which it returns to 0, so that
    neither play nor the reversal is in them.
    """
    first, second = stages
    centre = 0.5 * (curve.angle[0] + curve.angle[1])
    small = SMALL * rated
    lost = float(np.interp(small, curve.torque, centre) - np.interp(-small, curve.torque, centre))
    backlash = curve.at(0, 0.0) - curve.at(1, 0.0)

    def slope(low: float, high: float, *, back: bool) -> float:
        sides = [(1.0, 0 if back else 1), (-1.0, 1 if back else 0)]
        twist = sum(sign * (curve.at(b, sign * high) - curve.at(b, sign * low)) for sign, b in sides)
        return 2.0 * (high - low) / twist if twist > 0.0 else np.inf

    steps = (slope(0.0, first, back=True), slope(first, second, back=False), slope(second, rated, back=False))
    return Numbers(lost, backlash, slope(LINEAR * rated, rated, back=False), steps, curve.loss)


def drawn_branch(ds: xr.Dataset, name: str) -> tuple[Floats, Floats]:
    """Return torque [N m] and rotation [arcmin] of a branch as it is drawn, shape [point].

    The crossing of the play at no torque belongs to the branch that crosses it.
    """
    branches = [str(each) for each in ds["branch"].values]
    k, torque, angle = branches.index(name), ds["torque"].values, ARCMIN * ds["angle"].values
    zero = int(np.flatnonzero(torque == 0.0)[0])
    if np.isfinite(ds["tangent_stiffness"].values[0, zero]) or ds.attrs.get("measured"):
        return torque, angle[k]
    at = zero if k == 0 else zero + 1
    return np.insert(torque, at, 0.0), np.insert(angle[k], at, angle[1 - k, zero])


def lost_motion_of(train: Train, rated: float) -> float:
    """Return the lost motion [rad] alone, from the fewest equilibria."""
    small = SMALL * rated
    if train.friction:
        curve = _with_friction(train, rated * np.array(COARSE), 2)
        centre = 0.5 * (curve.angle[0] + curve.angle[1])
        return float(np.interp(small, curve.torque, centre) - np.interp(-small, curve.torque, centre))
    ends = []
    for sign in (1.0, -1.0):
        train.reset()
        ends.append(train.load(sign * small))
    return ends[0] - ends[1]


def half_width_of(train: Train, rated: float) -> float:
    """Return half the width of the play without friction [rad]."""
    friction, train.friction = train.friction, {}
    ends = []
    for sign in (1.0, -1.0):
        train.reset()
        train.load(sign * rated)
        ends.append(limit_at_zero(train, rated, sign))
    train.friction = friction
    train.reset()
    width = ends[0] - ends[1]
    return 0.5 * width if width > NO_PLAY else 0.0
