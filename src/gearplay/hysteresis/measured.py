"""Lost motion of a measured hysteresis curve: fit of play, stiffness in stages and friction, with intervals.

Rate-independent model: the effective torque tau follows T by the play operator of half width M_f (friction), and
theta = theta_0 + sign(tau) (h + integral of dtau / K(tau)), with K1, K2, K3 between 0, T1, T2.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.hysteresis.cycle import LINEAR, POINTS, SMALL, Curve, Numbers, numbers_of
from gearplay.hysteresis.result import FIELDS, STAGE_NAMES, WORDS, LostMotion, dataset_of, in_arcmin
from gearplay.hysteresis.table_reading import Measured, read_curve
from gearplay.hysteresis.torques import positive_of, stages_of
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import TORQUE
from gearplay.vocabulary.version import VERSION

Floats = NDArray[np.float64]

CONFIDENCE = 0.95
"""Probability that all intervals hold together."""
TURN = 0.05
"""Change of the torque, of its range, that is a reversal and not noise."""
MOST_FRICTION, TRIALS = 0.4, 161
"""Largest friction that is tried, of the rated torque, and how many."""
NEAR = 0.01
"""Effective torque, of the rated one, within which a sample may be on its way across the play."""
NOISES = 4.0
"""Standard deviations of the torque's noise within which a sample may be on either side of a kink."""
NAMES = ("offset", "half_play", "c1", "c2", "c3", "friction")
"""Parameters: rad, rad, three compliances [rad/(N m)], N m."""


class Branches:
    """Torques of a record in runs between reversals."""

    def __init__(self, torque: Floats) -> None:
        self.torque = torque
        self.runs = _runs(torque, TURN * float(np.ptp(torque)))

    def effective(self, friction: float) -> Floats:
        """Return the effective torque [N m], shape [sample]."""
        T = self.torque
        tau = np.empty_like(T)
        last: float = float(T[0] - np.sign(T[0]) * friction) if abs(T[0]) > friction else 0.0
        for start, stop, sense in self.runs:
            part = T[start:stop]
            tau[start:stop] = (
                np.maximum(last, part - friction) if sense > 0 else np.minimum(last, part + friction)
            )
            # The end of a run without the noise of its single samples.
            end = float(np.max(part)) - friction if sense > 0 else float(np.min(part)) + friction
            last = max(last, end) if sense > 0 else min(last, end)
        return tau

    def to_slip(self, friction: float) -> Floats:
        """Return the distance of each sample from the transition of sticking to slipping [N m], shape [sample]."""
        tau, far = self.effective(friction), np.empty_like(self.torque)
        for start, stop, sense in self.runs:
            part = self.torque[start:stop] - sense * friction
            first = float(np.min(tau[start:stop])) if sense > 0 else float(np.max(tau[start:stop]))
            far[start:stop] = np.abs(part - first)
        return far


def _noise(torque: Floats) -> float:
    """Return the standard deviation of white noise on a slowly varying torque, from its second differences."""
    return float(np.median(np.abs(np.diff(torque, 2))) / (0.6745 * np.sqrt(6.0)))


def _runs(torque: Floats, least: float) -> list[tuple[int, int, int]]:
    """Return runs of rising (1) and falling (-1) torque as (start, stop, sense), reversals smaller than ``least`` ignored."""
    runs: list[tuple[int, int, int]] = []
    start, sense = 0, 0
    low = high = 0
    values = torque.tolist()
    for k, value in enumerate(values):
        if value > values[high]:
            high = k
        if value < values[low]:
            low = k
        if sense >= 0 and value < values[high] - least:
            if high > start or sense > 0:
                runs.append((start, high + 1, 1))
                start = high + 1
            sense, low = -1, k
            high = k
        elif sense <= 0 and value > values[low] + least:
            if low > start or sense < 0:
                runs.append((start, low + 1, -1))
                start = low + 1
            sense, high = 1, k
            low = k
    runs.append((start, len(values), sense or 1))
    return [run for run in runs if run[1] > run[0]]


def _basis(tau: Floats, side: Floats, ends: Sequence[float]) -> Floats:
    """Return the derivatives of the rotation by offset, half play and the three compliances, shape [sample, 5]."""
    size, (first, second) = np.abs(tau), ends
    stages = [
        np.minimum(size, first),
        np.clip(size - first, 0.0, second - first),
        np.maximum(size - second, 0.0),
    ]
    return np.stack([np.ones_like(tau), side, *(side * each for each in stages)], axis=1)


class Fit:
    """Parameters ``values``, shape [6] as `NAMES`, their ``covariance``, and the ``factor`` of a standard deviation."""

    def __init__(self, record: Measured, rated: float, ends: Sequence[float]) -> None:
        from scipy.optimize import least_squares, minimize_scalar

        self.rated, self.ends = rated, tuple(ends)
        branches, angle = Branches(record.torque), record.angle
        _check_coverage(record.torque, branches, ends)

        def misfit(friction: float) -> float:
            tau = branches.effective(friction)
            basis = _basis(tau, np.sign(tau), ends)
            found, *_ = np.linalg.lstsq(basis, angle, rcond=None)
            return float(np.sum((angle - basis @ found) ** 2))

        trials = np.linspace(0.0, MOST_FRICTION * rated, TRIALS)
        misfits = [misfit(each) for each in trials.tolist()]
        best = int(np.argmin(misfits))
        around = (float(trials[max(0, best - 1)]), float(trials[min(TRIALS - 1, best + 1)]))
        near = minimize_scalar(misfit, bounds=around, method="bounded", options={"xatol": 1e-4 * rated})
        friction = float(near.x) if near.fun < misfits[best] else float(trials[best])
        tau = branches.effective(friction)
        clear = max(NEAR * rated, NOISES * _noise(record.torque))
        kept = (np.abs(tau) > clear) & (branches.to_slip(friction) > NOISES * _noise(record.torque))
        side = np.sign(tau)[kept]
        first, *_ = np.linalg.lstsq(_basis(tau[kept], side, ends), angle[kept], rcond=None)

        def rotation(p: Floats) -> Floats:
            effective = branches.effective(max(0.0, float(p[5])))[kept]
            return _basis(effective * (side == np.sign(effective)), side, ends) @ p[:5]

        start = np.append(first, friction)
        scale = np.array([1.0, 1.0, 1.0 / rated, 1.0 / rated, 1.0 / rated, 0.0]) * float(np.ptp(angle))
        scale[5] = rated
        answer = least_squares(
            lambda z: (rotation(z * scale) - angle[kept]) / np.ptp(angle), start / scale, x_scale="jac",
            bounds=([-np.inf] * 5 + [0.0], [np.inf] * 6), xtol=1e-12, ftol=1e-12,
        )  # fmt: skip
        self.values: Floats = answer.x * scale
        left = np.ptp(angle) * answer.fun
        degrees = max(1, left.size - len(NAMES))
        jacobian = answer.jac / scale * np.ptp(angle)
        held = self.values[5] <= 0.0
        use = [k for k in range(len(NAMES)) if not (held and k == 5)]
        variance = float(left @ left) / degrees * _correlation_factor(left)
        self.covariance = np.zeros((6, 6))
        weight = scale[use]
        inner = np.linalg.pinv((jacobian[:, use] * weight).T @ (jacobian[:, use] * weight))
        self.covariance[np.ix_(use, use)] = variance * inner * np.outer(weight, weight)
        self.factor = _quantile(degrees, len(NAMES))
        self.deviation = float(np.sqrt(left @ left / degrees))
        if np.any(self.values[2:5] <= 0.0):
            stage = STAGE_NAMES[int(np.argmin(self.values[2:5]))]
            rule = f"must turn further with more torque, but in stage {stage} it does not"
            raise InputError.of(
                "columns", stage, rule, "Check the order and the signs of torque and rotation"
            )

    def curve(self, values: Floats) -> Curve:
        """Return the curve of one cycle between both rated torques."""
        rated, (first, second), friction = self.rated, self.ends, float(values[5])
        kinks = [friction, friction * (1.0 + 1e-9)] if friction > 0.0 else []  # both ends of the play
        even = np.linspace(0.0, rated, POINTS + 1)[1:]
        marks = np.unique([*even, *kinks, SMALL * rated, LINEAR * rated, first, second])
        torque = np.concatenate([-marks[::-1], [0.0], marks])
        angle, tangent = np.zeros((2, torque.size)), np.zeros((2, torque.size))
        slopes = 1.0 / values[2:5]
        for branch, tau in enumerate(
            (np.minimum(torque + friction, rated - friction), np.maximum(torque - friction, friction - rated))
        ):
            side = np.where(tau == 0.0, 1.0 - 2.0 * branch, np.sign(tau))
            angle[branch] = _basis(tau, side, self.ends)[:, 1:] @ values[1:5]
            tangent[branch] = slopes[np.digitize(np.abs(tau), self.ends)]
        loss = 4.0 * friction * float(angle[0, -1])
        return Curve(torque, angle, tangent, loss)

    def numbers(self, values: Floats) -> Numbers:
        """Return the key numbers at values of the parameters; the stages are those of the fit."""
        found = numbers_of(self.curve(values), self.rated, self.ends)
        return found._replace(stages=tuple((1.0 / values[2:5]).tolist()))

    def interval(self, quantity: Callable[[Floats], Any]) -> tuple[Floats, Floats]:
        """Return the value of a quantity of the parameters and its interval, shape [.., 2], by linear propagation."""
        value = np.atleast_1d(np.asarray(quantity(self.values), dtype=float))
        slopes = np.zeros((value.size, 6))
        for k in range(6):
            step = max(np.sqrt(self.covariance[k, k]), 1e-9 * abs(self.values[k]))
            if step > 0.0:
                moved = self.values.copy()
                moved[k] += 1e-3 * step
                slopes[:, k] = (np.atleast_1d(quantity(moved)) - value) / (1e-3 * step)
        reach = self.factor * np.sqrt(np.einsum("qk,kl,ql->q", slopes, self.covariance, slopes))
        return value, np.stack([value - reach, value + reach], axis=-1)


def _correlation_factor(left: Floats) -> float:
    """Return the inflation of a mean's variance by autocorrelation: (1 + r) / (1 - r), r at a lag of one sample."""
    square = float(left @ left)
    if square <= 0.0:
        return 1.0
    r = min(0.98, max(0.0, float(left[1:] @ left[:-1]) / square))
    return (1.0 + r) / (1.0 - r)


def _quantile(degrees: int, count: int) -> float:
    from scipy.stats import t

    return float(t.ppf(1.0 - 0.5 * (1.0 - CONFIDENCE) / count, degrees))


def _check_coverage(torque: Floats, branches: Branches, ends: Sequence[float]) -> None:
    """Raise `InputError` where a stage has no samples of either sign, or the torque never returns."""
    senses = {sense for start, stop, sense in branches.runs if stop - start > 1}
    if senses != {1, -1}:
        rule = "must rise and fall, from one sign to the other and back"
        raise InputError.of("columns", "torque", rule, "Record a whole cycle, in the order of the samples")
    edges = [0.0, *ends, np.inf]
    for name, low, high in zip(STAGE_NAMES, edges, edges[1:], strict=False):
        for sign in (1.0, -1.0):
            if np.sum((sign * torque > low) & (sign * torque <= high)) < 3:
                rule = (
                    f"must have three samples or more with {'+' if sign > 0 else '-'} torque in stage {name}"
                )
                raise InputError.of("stages", f"{low:.4g} N m", rule, "Change the stages, or record more")


def measured_lost_motion(
    path: Any, columns: Sequence[str] | None, *, torque: Any, stages: Sequence[Any] | None
) -> LostMotion:
    """Return the numbers of a measured curve with intervals; see `lost_motion`."""
    if not isinstance(path, (str, os.PathLike)):
        raise InputError.of(
            "case", path, "must be the path of a CSV file with columns", "Leave columns out of a case"
        )
    record = read_curve(path, columns)
    largest = float(np.max(np.abs(record.torque)))
    if largest == 0.0:
        raise InputError.of("columns", "torque", "must not be 0 throughout", "Name the column of the torque")
    rated = largest if torque is None else positive_of("torque", torque, TORQUE)
    if rated > 1.1 * largest:
        rule = f"must be reached by the record, whose largest torque is {largest:.4g} N m"
        raise InputError.of("torque", f"{rated:.4g} N m", rule, "Lower it, or leave it out")
    ends = stages_of(stages, rated)
    fit = Fit(record, rated, ends)
    attributes = {
        "title": Path(path).name,
        "rated_torque": rated,
        "measured": 1,
        "confidence": CONFIDENCE,
        "samples": record.torque.size,
        "rows_left_out": record.left_out,
        "residual": fit.deviation,
        "gearplay_version": VERSION,
    }
    return LostMotion(_with_intervals(fit, record, attributes))


def _number(fit: Fit, field: str, values: Floats) -> Any:
    return getattr(fit.numbers(values), field)


def _with_intervals(fit: Fit, record: Measured, attributes: dict[str, Any]) -> Any:
    found = fit.numbers(fit.values)
    ds = dataset_of(fit.curve(fit.values), found, fit.ends, fit.rated, {}, {}, attributes)
    words = f"simultaneous {100.0 * CONFIDENCE:g} % interval"
    for name, field in FIELDS.items():
        _, both = fit.interval(partial(_number, fit, field))
        dims = ("stage", "bound") if name == "stiffness" else ("bound",)
        both = both if name == "stiffness" else both[0]
        unit, title = WORDS[name]
        ds[f"{name}_interval"] = (dims, both, {"units": unit, "long_name": f"{title}, {words}"})
        small = in_arcmin(name, both)
        if small is not None:
            ds[f"{name}_arcmin_interval"] = (
                dims,
                small[0],
                {"units": small[1], "long_name": f"{title}, {words}"},
            )
    for name, unit, title, quantity in (
        ("play", "rad", "play, without friction", lambda values: 2.0 * values[1]),
        ("friction", "N m", "Coulomb friction at the output", lambda values: values[5]),
        ("offset", "rad", "rotation in the middle of the curve", lambda values: values[0]),
    ):
        value, both = fit.interval(quantity)
        ds[name] = ((), float(value[0]), {"units": unit, "long_name": title})
        ds[f"{name}_interval"] = (("bound",), both[0], {"units": unit, "long_name": f"{title}, {words}"})
    ds = ds.assign_coords(bound=("bound", ["low", "high"], {"long_name": "end of the interval"}))
    ds["measured_torque"] = (("sample",), record.torque, {"units": "N m", "long_name": "measured torque"})
    shifted = record.angle - fit.values[0]
    ds["measured_angle"] = (
        ("sample",),
        shifted,
        {"units": "rad", "long_name": "measured rotation, less the offset"},
    )
    return ds
