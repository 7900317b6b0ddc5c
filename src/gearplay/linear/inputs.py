"""Inputs of a frequency response: forces, errors of teeth, unbalances, the housing's motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.linear.system import LinearSystem, places_of
from gearplay.parts.mesh.train import rolling
from gearplay.vocabulary.errors import InputError

Complex = NDArray[np.complex128]

FORCES = {"fx": ("x", "N"), "fy": ("y", "N"), "torque": ("theta", "N m")}
ERROR, UNBALANCE, BASE = "transmission_error", "unbalance", "base"
ACCELERATIONS = {"ax": 0, "ay": 1}


class Excitation(NamedTuple):
    """Forces on the coordinates by a harmonic input u of amplitude 1, by its first and by its second rate, shapes [coordinate].

    ``mesh`` is the mesh whose error it is, empty for another input.
    """

    by_value: Complex
    by_rate: Complex
    by_second_rate: Complex
    unit: str
    mesh: str = ""


def excitation_of(system: LinearSystem, force: str) -> Excitation:
    """Return the excitation of a unit input. Raises `InputError` for an unknown input."""
    label, _, kind = force.rpartition(".")
    none = np.zeros(len(system.coordinates), dtype=complex)
    if kind == ERROR:
        gradient, stiffness, damping = system.line_of_action(label)
        return Excitation(_complex(-stiffness * gradient), _complex(-damping * gradient), none, "m", label)
    if label == BASE and kind in ACCELERATIONS:
        axis, places = ACCELERATIONS[kind], system.linear.free
        return Excitation(np.where(places % 3 == axis, -system.mass, 0.0) + none, none, none, "m/s^2")
    if kind == UNBALANCE and label in system.case.rotors:
        x, y = places_of(system, [f"{label}.x", f"{label}.y"])
        speed = rolling.rolling_ratios(system.case)[1][list(system.case.rotors).index(label)]
        turning = (
            none.copy()
        )  # m e omega^2 (cos, sin): minus its second rate, y a quarter behind x, or before
        turning[x], turning[y] = -1.0, 1j if speed >= 0.0 else -1j
        return Excitation(none, none, turning, "kg m")
    if kind not in FORCES:
        rule = "must be a force or torque on a rotor, its unbalance, the error of a mesh, or the housing's acceleration"
        cure = (
            "Write rotor.fx, rotor.fy, rotor.torque, rotor.unbalance, driver-driven.transmission_error, "
            "base.ax or base.ay"
        )
        raise InputError.of("force", force, rule, cure)
    axis_name, unit = FORCES[kind]
    (place,) = places_of(system, [f"{label}.{axis_name}"])
    push = none.copy()
    push[place] = 1.0
    return Excitation(push, none, none, unit)


def _complex(values: NDArray[np.float64]) -> Complex:
    return values.astype(np.complex128)
