"""First-order form of the equations of motion at one state: matrix, and strain energies of the elements."""

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import ActiveSet
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.slopes import Slopes, linearise, rate_of_change
from gearplay.integrate.switches import initialise_modes
from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import Branch, Loads, System


@compiled_once
def rates_at(
    system: System, active_set: ActiveSet, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Fill ``dy`` with the derivative of a state at t = 0, contacts closed where they penetrate; 1 where a pair cannot mesh."""
    for e in range(system.elements.size):
        if dispatch.contact_kinematics(system, e, 0.0, y, branch, loads) != 0:
            return 1
    initialise_modes(system, 0.0, y, branch, loads)
    return rates_of(system, active_set, 0.0, y, branch, dy, loads)


@compiled_once
def matrix_at(
    system: System, active_set: ActiveSet, y: Floats, branch: Branch, slopes: Slopes, loads: Loads, z: Floats, matrix: Rows
) -> int:  # fmt: skip
    """Fill column s of ``matrix``, shape [state + impact speed] squared, with the rate of change by state s; 1 where it fails.

    `rates_at` has been there; ``matrix`` is stored by columns, ``z`` is scratch of its size.
    """
    if linearise(system, active_set, 0.0, y, branch, slopes, loads) != 0:
        return 1
    for s in range(z.size):
        z[s] = 0.0
    for s in range(y.size):
        z[s] = 1.0
        rate_of_change(system, active_set, branch, slopes, z, matrix[s])
        z[s] = 0.0
    return 0


@compiled_once
def strain_energies(
    system: System, branch: Branch, slopes: Slopes, shapes: Rows, dz: Floats, energies: Rows
) -> None:
    """Fill the strain energy [J] of each element, shape [mode, element], in displacements ``shapes``.

    Their shape is [mode, state + impact speed]; `matrix_at` has filled the slopes.
    """
    force, n = slopes.force, system.rotors.size
    for m in range(shapes.shape[0]):
        for e in range(system.elements.size):
            for i in range(n):
                for axis in range(3):
                    force[i, axis] = 0.0
            dispatch.add_change(system, e, slopes.elements[e], shapes[m], branch, force, dz)
            energy = 0.0
            for i in range(n):
                for axis in range(3):
                    energy -= 0.5 * shapes[m, 3 * i + axis] * force[i, axis]
            energies[m, e] = energy
