"""Discs that springs, couplings and excitation act on, for tests of the reference against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cross.reference import Reference

MASS, INERTIA = 0.8, 2e-3
TIMES = np.linspace(0.0, 0.02, 21)


def disc(**fields: Any) -> dict[str, Any]:
    """Return a case of one disc of MASS and INERTIA; base, gravity and support go into its own tables."""
    tables = {name: fields.pop(name) for name in ("base", "gravity") if name in fields}
    support = fields.pop("support", None)
    case = {"rotors": {"disc": {"mass": MASS, "inertia": INERTIA, **fields}}, **tables}
    return case | ({"supports": {"disc": support}} if support is not None else {})


def pair_of(one: dict[str, Any], two: dict[str, Any], **tables: Any) -> dict[str, Any]:
    """Return a case of two discs, the second of 3 times the inertia."""
    return {
        "rotors": {
            "one": {"mass": MASS, "inertia": INERTIA, **one},
            "two": {"mass": 0.5, "inertia": 3.0 * INERTIA, **two},
        },
        **tables,
    }


def moments(reference: Reference, motion: dict[str, np.ndarray]) -> np.ndarray:
    """Return linear and angular momentum about the origin at every time, unbalances included."""
    rows = []
    for t, state in zip(motion["t"], motion["state"], strict=True):
        total = np.zeros(3)
        for i, rotor in enumerate(reference.rotors):
            each = reference.body(i, float(t), state.tolist())
            ux, uy = reference._moment(i, each.theta)
            px, py = rotor.mass * each.vx - each.omega * uy, rotor.mass * each.vy + each.omega * ux
            x, y = rotor.position[0] + each.x, rotor.position[1] + each.y
            spin = rotor.inertia * each.omega + ux * each.vy - uy * each.vx
            total += px, py, spin + x * py - y * px
        rows.append(total)
    return np.array(rows)


def energies(reference: Reference, motion: dict[str, np.ndarray]) -> np.ndarray:
    """Return the mechanical energy [J] at every time."""
    return np.array(
        [reference.energy(y, float(t)) for y, t in zip(motion["state"], motion["t"], strict=True)]
    )


def decayed(t: np.ndarray, rate: float, damping: float, start: float) -> np.ndarray:
    """Return the free motion of a damped oscillator that starts at rest beside its zero."""
    swing = math.sqrt(rate**2 - damping**2)
    return start * np.exp(-damping * t) * (np.cos(swing * t) + damping / swing * np.sin(swing * t))
