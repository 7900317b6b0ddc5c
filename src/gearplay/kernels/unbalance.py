"""A rotor whose mass is not on its axis: exact accelerations of a planar body, and their slopes (docs/theory, section 4).

With U = m e, u the direction of the eccentricity, n across it, F the sum of forces and M that of torques about the axis, h
gravity less the housing's acceleration, w = 1/m or 0 for a centre that is held:

    a = w (F + U (omega^2 u - alpha n)),  alpha (J - w U^2) = M + U (u x h) - w U (u x F).
"""

import math

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.housing_motion import pull
from gearplay.kernels.layout import System, omega_of, spin_of, theta_of, turn_of, vx_of, vy_of

# Columns of a row of slopes: direction u, the pull along it, the force along it, speed [rad/s], acceleration [rad/s^2].
U_X, U_Y, PULL, FORCE, SPIN, ALPHA = range(6)
COLUMNS = 6


@compiled_once
def accelerate(system: System, i: int, t: float, y: Floats, force: Rows, dy: Floats) -> None:
    """Fill rotor i's accelerations in ``dy`` from the sums of forces on it; a prescribed rotation keeps the one it has there."""
    r = system.rotors[i]
    psi, spin = turn_of(system, i, t, y) + r.unbalance_phase, spin_of(system, i, y)
    u_x, u_y, moment = math.cos(psi), math.sin(psi), r.unbalance
    f_x, f_y, w = force[i, 0], force[i, 1], r.inv_mass
    if r.inv_inertia > 0.0:
        h_x, h_y = pull(system, t)
        torque = force[i, 2] + moment * ((u_x * h_y - u_y * h_x) - w * (u_x * f_y - u_y * f_x))
        dy[omega_of(system, i)] = torque / (r.inertia - w * moment * moment)
    alpha = dy[omega_of(system, i)]
    dy[vx_of(system, i)] = w * (f_x + moment * (spin * spin * u_x + alpha * u_y))
    dy[vy_of(system, i)] = w * (f_y + moment * (spin * spin * u_y - alpha * u_x))


@compiled_once
def linearise_unbalance(system: System, i: int, t: float, y: Floats, force: Rows, row: Floats) -> None:
    """Fill rotor i's row of slopes at (t, y), ``force`` the sums of forces there."""
    r = system.rotors[i]
    psi, spin = turn_of(system, i, t, y) + r.unbalance_phase, spin_of(system, i, y)
    u_x, u_y, moment, w = math.cos(psi), math.sin(psi), r.unbalance, r.inv_mass
    f_x, f_y = force[i, 0], force[i, 1]
    h_x, h_y = pull(system, t)
    row[U_X], row[U_Y], row[SPIN], row[ALPHA] = u_x, u_y, spin, 0.0
    row[PULL], row[FORCE] = u_x * h_x + u_y * h_y, u_x * f_x + u_y * f_y
    if r.inv_inertia > 0.0:
        torque = force[i, 2] + moment * ((u_x * h_y - u_y * h_x) - w * (u_x * f_y - u_y * f_x))
        row[ALPHA] = torque / (r.inertia - w * moment * moment)


@compiled_once
def change_accelerations(system: System, i: int, row: Floats, z: Floats, force: Rows, dz: Floats) -> None:
    """Fill rotor i's accelerations in ``dz`` from the change of the sums of forces on it by a change z of the state."""
    r = system.rotors[i]
    u_x, u_y, spin, moment, w = row[U_X], row[U_Y], row[SPIN], r.unbalance, r.inv_mass
    turn, f_x, f_y = z[theta_of(i)], force[i, 0], force[i, 1]
    alpha = 0.0
    if r.inv_inertia > 0.0:
        torque = force[i, 2] - moment * (turn * row[PULL] + w * (u_x * f_y - u_y * f_x - turn * row[FORCE]))
        alpha = torque / (r.inertia - w * moment * moment)
    along = 2.0 * spin * z[omega_of(system, i)] + row[ALPHA] * turn
    across = spin * spin * turn - alpha
    dz[vx_of(system, i)] = w * (f_x + moment * (along * u_x - across * u_y))
    dz[vy_of(system, i)] = w * (f_y + moment * (along * u_y + across * u_x))
    dz[omega_of(system, i)] = alpha
