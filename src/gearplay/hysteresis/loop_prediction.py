"""Limit cycles of a position loop by harmonic balance: two inertias with a stiffness that depends on the amplitude."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.hysteresis.balance_path import Train
from gearplay.hysteresis.held import Held
from gearplay.model.case import Case
from gearplay.parts.drive.loops import LoopDrive

Floats = NDArray[np.float64]

ROUNDS = 20
"""Repetitions of the frequency at which the loss acts as damping."""


@dataclass(frozen=True)
class Prediction:
    """Growth rate [1/s] and frequency [Hz] of the loop over the amplitude of the twist, and its limit cycles.

    A cycle is (period [s], amplitude of the twist, amplitude of the output [rad], 1 where it is stable).
    """

    growth: Floats
    frequency: Floats
    cycles: list[tuple[float, float, float, float]]


def predicted(
    case: Case, whole: Held, rated: float, amplitudes: Floats, harmonic: Callable[[float], complex]
) -> Prediction | None:
    """Return the prediction for the position loop on a held rotor, None without one.

    ``harmonic`` returns the describing function [N m/rad] at an amplitude [rad]; ``rated`` [N m] closes the contacts.
    """
    from scipy.optimize import brentq

    matrix_at = _loop_matrix(case, whole, rated)
    if matrix_at is None:
        return None

    def leading(at: float) -> tuple[complex, Floats]:
        given, omega = harmonic(at), 0.0
        k, d = given.real, given.imag
        for _ in range(ROUNDS if d > 0.0 else 1):
            values, vectors = np.linalg.eig(matrix_at(k, d / omega if omega > 0.0 else 0.0))
            best = int(np.argmax(np.where(values.imag > 1e-9, values.real, -np.inf)))
            omega = float(values[best].imag)
            if omega <= 0.0:
                break
        if omega <= 0.0:
            return complex(-math.inf, 0.0), np.zeros(0)
        return complex(values[best]), vectors[:, best]

    growth = np.array([leading(a)[0] for a in amplitudes])
    cycles = []
    for k in range(amplitudes.size - 1):
        one, other = growth[k].real, growth[k + 1].real
        if not (math.isfinite(one) and math.isfinite(other)) or one * other >= 0.0:
            continue
        at = brentq(lambda a: leading(a)[0].real, amplitudes[k], amplitudes[k + 1], rtol=1e-13)
        value, shape = leading(at)
        output = at * abs(shape[2]) / abs(shape[0] - shape[2])
        cycles.append((2.0 * math.pi / value.imag, float(at), float(output), float(one > 0.0)))
    rates = np.where(np.isfinite(growth.real), growth.real, np.nan)
    return Prediction(rates, growth.imag / (2.0 * math.pi), cycles)


def _loop_matrix(case: Case, whole: Held, rated: float) -> Callable[[float, float], Floats] | None:
    """Return the matrix of the loop by stiffness [N m/rad] and damping [N m s/rad], both at the output; None without a loop.

    States are rotation and speed of the input and of the output, both as rotations of the output, and the integral.
    """
    hot = case.operating
    names = list(hot.rotors)
    loops = [(n, drive) for n in whole.hold if isinstance(drive := hot.rotors[n].drive, LoopDrive)]
    if not loops or not np.any(whole.ratios):
        return None
    name, drive = loops[0]
    turns = dict(zip(names, whole.ratios.tolist(), strict=True))
    sensor, speed_sensor = drive.sensor or name, drive.measures_speed_of(name)
    loop = drive.loop(turns[speed_sensor] / turns[sensor])
    train = Train(whole)
    train.friction = {}
    train.load(rated)
    shape = train.shape() / train.compliance()
    inertia = [
        sum(hot.rotors[n].inertia * turns[n] ** 2 for n in whole.hold),
        float(shape @ (train.linear.mass * shape)),
    ]
    drag = [sum(hot.rotors[n].load.drag * turns[n] ** 2 for n in part) for part in
            (whole.hold, [n for n in names if n not in whole.hold])]  # fmt: skip
    sense = math.copysign(1.0, turns[sensor] / turns[name])
    turned = math.copysign(1.0, turns[speed_sensor] / turns[sensor])
    place, speed_place = (0 if n in whole.hold else 2 for n in (sensor, speed_sensor))

    def matrix_at(k: float, d: float) -> Floats:
        made = np.zeros((5, 5))
        error, speed = np.zeros(5), np.zeros(5)
        error[place], speed[speed_place + 1] = -turns[sensor], turned * turns[speed_sensor]
        push = sense * turns[name] * (loop.proportional_gain * error - loop.derivative_gain * speed)
        push[4] = sense * turns[name] * loop.integral_gain
        made[0, 1] = made[2, 3] = 1.0
        joint = np.array([k, d, -k, -d, 0.0])
        made[1] = (push - joint) / inertia[0]
        made[1, 1] -= drag[0] / inertia[0]
        made[3] = joint / inertia[1]
        made[3, 3] -= drag[1] / inertia[1]
        if loop.integral_gain > 0.0:
            made[4] = error - loop.share * speed
        return made

    return matrix_at
