"""Mesh stiffness of a case from its teeth as drawn, and its table for the kernels."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.mesh.stiffness import TeethStiffness
from gearplay.parts.mesh.tooth_loads import tooth_loads
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.toothing.path_stiffness import PathStiffness, mirrored, path_stiffness
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


def nominal_line_load(case: "Train", j: int) -> float | None:
    """Return F_t/b [N/m] of mesh j under the constant torques of the case, at the reference circle; None without a load."""
    pair = geometry.pair_of(case, j)
    force = float(tooth_loads(case)[j])
    if force == 0.0 or pair.facewidth is None:
        return None
    return force * math.cos(pair.first.transverse_angle) / pair.facewidth


def stiffness_over_path(case: "Train", j: int) -> PathStiffness:
    """Return the stiffness of mesh j over its path of contact at the nominal centres; its kind must be ``teeth``.

    Without a load ISO 6336-1 is taken above its light loads. Raises `InputError` where teeth are out of contact between pairs.
    """
    given = case.meshes[j].stiffness
    assert isinstance(given, TeethStiffness)
    pair = geometry.installed_pair(case, j)
    if not pair.contact_ratio >= 1.0:
        rule = (
            f"must be another at a contact ratio of {pair.contact_ratio:.4g}: between two pairs of teeth nothing is in contact, "
            "and the stiffness would be 0"
        )
        cure = "Correct the centre distance, profile shifts or tip diameters"
        raise InputError.of(f"meshes.{j}.stiffness.kind", "teeth", rule, cure)
    load = math.inf
    if given.method == "iso6336":
        load = given.line_load or nominal_line_load(case, j) or math.inf
    return path_stiffness(pair, given.method, given.modulus, given.poisson, load)


def forwards(case: "Train", j: int) -> bool:
    """Return whether the contact of drive flanks moves away from the first gear's base tangent point as the mesh phase rises."""
    mesh, names = case.meshes[j], list(case.rotors)
    moving = rolling.moving_speeds(case, rolling.nominal_speeds(case))
    frame = geometry.mesh_frame(case, j)
    turning = moving[names.index(mesh.rotors[0])] - (moving[names.index(frame)] if frame else 0.0)
    return (geometry.gears_of_pair(case, j)[0] == mesh.driver) == bool(turning >= 0.0)


def stiffness_table(case: "Train", j: int) -> NDArray[np.float64]:
    """Return K of mesh j over the mesh phase as rows (start, c0..c3) of a periodic cubic; see `PathStiffness.table`."""
    table = stiffness_over_path(case, j).table
    rows = table if forwards(case, j) else mirrored(table)
    starts = (rows[:, 0] - case.meshes[j].friction_phase) % (2.0 * np.pi)
    order = np.argsort(starts)
    return np.column_stack([starts, rows[:, 1:]])[order]
