"""Dispatch of the functions that only the exact derivative needs, by kind of element, as in `table`."""

from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.elements import coupling, excitation, housing, mesh, positioner, servo, sleeve, support
from gearplay.kernels.elements.table import (
    COUPLING,
    EXCITATION,
    HOUSING,
    MESH,
    POSITIONER,
    SLEEVE,
    SUPPORT,
)
from gearplay.kernels.layout import Branch, Loads, System


@compiled_inline
def linearise(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill element e's row of slopes at (t, y); return 1 where its geometry fails."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == SLEEVE:
        return sleeve.linearise(system, n, t, y, branch, loads, row)
    if kind == MESH:
        return mesh.linearise(system, n, t, y, branch, loads, row)
    if kind == COUPLING:
        return coupling.linearise(system, n, t, y, branch, loads, row)
    if kind == SUPPORT:
        return support.linearise(system, n, t, y, branch, loads, row)
    if kind == EXCITATION:
        return excitation.linearise(system, n, t, y, branch, loads, row)
    if kind == HOUSING:
        return housing.linearise(system, n, t, y, branch, loads, row)
    if kind == POSITIONER:
        return positioner.linearise(system, n, t, y, branch, loads, row)
    return servo.linearise(system, n, t, y, branch, loads, row)


@compiled_inline
def add_change(
    system: System, e: int, row: Floats, z: Floats, branch: Branch, force: Floats, dz: Floats
) -> None:
    """Add to ``force`` [rotor, (N, N, N m)], and fill in ``dz``, what a change z changes when element e acts."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == SLEEVE:
        sleeve.add_change(system, n, row, z, branch, force, dz)
    elif kind == MESH:
        mesh.add_change(system, n, row, z, branch, force, dz)
    elif kind == COUPLING:
        coupling.add_change(system, n, row, z, branch, force, dz)
    elif kind == SUPPORT:
        support.add_change(system, n, row, z, branch, force, dz)
    elif kind == EXCITATION:
        excitation.add_change(system, n, row, z, branch, force, dz)
    elif kind == HOUSING:
        housing.add_change(system, n, row, z, branch, force, dz)
    elif kind == POSITIONER:
        positioner.add_change(system, n, row, z, branch, force, dz)
    else:
        servo.add_change(system, n, row, z, branch, force, dz)


@compiled_inline
def crossing(system: System, e: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return what a change z changes in switch function s of element e (its touches: the penetrations) and in its rate, and
    that rate.
    """
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == SLEEVE:
        return sleeve.crossing(system, n, s, row, z)
    if kind == MESH:
        return mesh.crossing(system, n, s, row, z)
    if kind == COUPLING:
        return coupling.crossing(system, n, s, row, z)
    if kind == SUPPORT:
        return support.crossing(system, n, s, row, z)
    if kind == EXCITATION:
        return excitation.crossing(system, n, s, row, z)
    if kind == HOUSING:
        return housing.crossing(system, n, s, row, z)
    if kind == POSITIONER:
        return positioner.crossing(system, n, s, row, z)
    return servo.crossing(system, n, s, row, z)


@compiled_inline
def jump(system: System, e: int, before: Ints, modes: Ints) -> int:
    """Return the switch at which element e's force has just jumped, by its modes before and now; -1 for none."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == MESH:
        return mesh.jump(system, n, before, modes)
    if kind == COUPLING:
        return coupling.jump(system, n, before, modes)
    return -1


@compiled_inline
def carry_sample(system: System, e: int, before: Rows, branch: Branch, z: Floats) -> None:
    """Carry a change z of the state over a sample that element e has just taken, ``before`` the memories until then."""
    if system.elements[e].kind == POSITIONER:
        positioner.carry_sample(system, system.elements[e].index, before[e], branch, z)
