"""Outputs of a frequency response: displacements, torques of couplings, forces of bearings and meshes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.linear.system import LinearSystem
from gearplay.parts.registry import COUPLING, KINDS
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]

BEARINGS = {"force_x": 0, "force_y": 1}


class Output(NamedTuple):
    """Output as rows on displacements and velocities, shapes [coordinate], with its unit; ``error`` are the derivatives of a
    mesh's output by the error of its teeth and by the rate of the error.
    """

    by_place: Floats
    by_rate: Floats
    unit: str
    mesh: str = ""
    error: tuple[float, float] = (0.0, 0.0)


def output_of(system: LinearSystem, name: str) -> Output:
    """Return an output by its name. Raises `InputError` for an unknown one."""
    none = np.zeros(len(system.coordinates))
    if name in system.coordinates:
        row = none.copy()
        row[system.coordinates.index(name)] = 1.0
        return Output(row, none, "rad" if name.endswith(".theta") else "m")
    label, _, kind = name.rpartition(".")
    labels = system.linear.smooth.packed.labels
    if kind == "torque" and label in labels.get("coupling", ()):
        n = labels["coupling"].index(label)
        on = int(system.linear.system.records[COUPLING][n]["a"])
        place, rate = system.linear.force_rows(_element(system, COUPLING, n), on, 2)
        return Output(-place, -rate, "N m")
    if kind == "force" and label in [mesh.label for mesh in system.case.meshes]:
        gradient, stiffness, damping = system.line_of_action(label)
        return Output(stiffness * gradient, damping * gradient, "N", label, (stiffness, damping))
    if kind in BEARINGS and f"{label}.x" in system.coordinates:
        on = list(labels["rotor"]).index(label)
        place, rate = none.copy(), none.copy()
        for which in KINDS:
            for n, held in enumerate(labels.get(which.name, ()) if hasattr(which.file, "mounts") else ()):
                if held == label:
                    more = system.linear.force_rows(_element(system, which.file.KIND, n), on, BEARINGS[kind])
                    place, rate = place + more[0], rate + more[1]
        return Output(place, rate, "N")
    rule = (
        "must be a coordinate that is free to move, the torque of a coupling, the force of a mesh, or that of the sleeve and "
        "support of a rotor whose centre is free"
    )
    named = [f"{each}.torque" for each in labels.get("coupling", ())]
    named += [f"{mesh.label}.force" for mesh in system.case.meshes]
    named += [f"{each[:-2]}.force_x" for each in system.coordinates if each.endswith(".x")]
    raise InputError.of("at", name, rule, f"There are: {', '.join([*system.coordinates, *named])}")


def _element(system: LinearSystem, kind: int, n: int) -> int:
    return int(system.linear.system.records[kind][n]["element"])
