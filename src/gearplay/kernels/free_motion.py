"""Closed-form free motion of a rotor without contact, under constant forces and linear damping.

Each of x, y, theta obeys v' = f - gamma v with constant f (a housing that shakes adds `shaken`). With a0 = f - gamma v0,
z = gamma tau,

    v = v0 + a0 tau phi1(z),  x = x0 + v0 tau + a0 tau^2 phi2(z),
    phi1 = (1 - exp(-z)) / z,  phi2 = (1 - phi1) / z.

Saturated dry friction is a constant torque; rotations are relative to the constant nominal speed (docs/theory, "Free motion").
"""

import math

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.decay import decay
from gearplay.kernels.housing_motion import COSINE, KIND, NONE, SINE, base_acceleration, shakes
from gearplay.kernels.housing_response import behind, is_closed, new_start
from gearplay.kernels.layout import DRIVE_SPEED, System, omega_of, spin_of, theta_of, vx_of, vy_of, x_of, y_of

NEVER = math.inf


@compiled_inline
def free_rates(system: System, i: int, v_x: float, v_y: float, omega: float) -> tuple[float, float, float]:
    """Return the accelerations [m/s^2, rad/s^2] of the free rotor i at these velocities (omega relative), housing at rest."""
    r = system.rotors[i]
    damping = r.radial_damping * r.inv_mass
    held = r.mass * r.inv_mass  # 1, or 0 for a centre that is held
    spin = r.nominal_speed + omega
    torque = r.torque - r.drag * spin
    if r.friction > 0.0:
        torque -= math.copysign(r.friction, spin)
    return (
        held * system.gravity[0] - damping * v_x,
        held * system.gravity[1] - damping * v_y,
        r.inv_inertia * torque,
    )


@compiled_inline
def shaken_rates(
    system: System, i: int, t: float, v_x: float, v_y: float, omega: float
) -> tuple[float, float, float]:
    """Evaluate `free_rates` with the motion of the housing at t [s]."""
    a_x, a_y, alpha = free_rates(system, i, v_x, v_y, omega)
    r = system.rotors[i]
    lag = r.mass * r.inv_mass * base_acceleration(system, t)
    return a_x - lag * system.base[COSINE], a_y - lag * system.base[SINE], alpha


@compiled_inline
def propagate(system: System, i: int, t: float, tau: float, origin: Floats, y: Floats) -> None:
    """Fill rotor i's six entries of ``y`` with its state a time tau [s] after it was ``origin``, at t [s]."""
    x, y_, theta = x_of(i), y_of(i), theta_of(i)
    vx, vy, omega = vx_of(system, i), vy_of(system, i), omega_of(system, i)
    r = system.rotors[i]
    a_x, a_y, alpha = free_rates(system, i, origin[vx], origin[vy], origin[omega])
    phi_1, phi_2 = decay(r.radial_damping * r.inv_mass * tau)
    y[x] = origin[x] + tau * (origin[vx] + a_x * tau * phi_2)
    y[y_] = origin[y_] + tau * (origin[vy] + a_y * tau * phi_2)
    y[vx], y[vy] = origin[vx] + a_x * tau * phi_1, origin[vy] + a_y * tau * phi_1
    if r.inv_mass > 0.0 and system.base[KIND] != NONE:
        way, speed = behind(system, r.radial_damping * r.inv_mass, t, tau)
        y[x] += way * system.base[COSINE]
        y[y_] += way * system.base[SINE]
        y[vx] += speed * system.base[COSINE]
        y[vy] += speed * system.base[SINE]
    phi_1, phi_2 = decay(r.drag * r.inv_inertia * tau)
    y[theta] = origin[theta] + tau * (origin[omega] + alpha * tau * phi_2)
    y[omega] = origin[omega] + alpha * tau * phi_1


@compiled_inline
def is_sprung(system: System, i: int) -> bool:
    """Return whether springs hold the centre of the free rotor i (`joined`)."""
    places = system.joined.places
    return bool(system.rotors[i].group >= 0 and (places[2 * x_of(i)] >= 0 or places[2 * y_of(i)] >= 0))


@compiled_inline
def must_be_integrated(system: System, i: int, t: float, y: Floats, ramping: int) -> bool:
    """Return whether rotor i has no closed form now: a ramp, dry friction within its band, unbalance, springs that are shaken.

    A rotor whose prescribed speed has pieces over time counts as one: the speed may jump, which no bound of advancement has.
    """
    r = system.rotors[i]
    if r.unbalance > 0.0 or r.set_points > 0:
        return True
    if r.inv_mass > 0.0 and shakes(system, t) and (is_sprung(system, i) or not is_closed(system)):
        return True
    if r.drive == DRIVE_SPEED and ramping == 1:
        return True
    if r.friction > 0.0 and r.inv_inertia > 0.0:
        # A little beyond the band, so that a closed form that ends on its edge does.
        return bool(abs(spin_of(system, i, y)) < (1.0 + 1e-9) * r.friction_speed)
    return False


@compiled_inline
def is_known(system: System, i: int, y: Floats, ramping: int) -> bool:
    """Return whether rotor i keeps its nominal motion under any force: held or prescribed, without ramp or ripple."""
    r = system.rotors[i]
    moves = y[vx_of(system, i)] != 0.0 or y[vy_of(system, i)] != 0.0 or y[omega_of(system, i)] != 0.0
    steady = ramping == 0 and r.varying == 0
    return bool(r.inv_mass == 0.0 and r.inv_inertia == 0.0 and steady and not moves)


@compiled_inline
def first_axis(system: System, i: int, y: Floats) -> int:
    """Return the first of rotor i's coordinates x, y, theta that can move: theta where its centre is held and at rest."""
    still = y[vx_of(system, i)] == 0.0 and y[vy_of(system, i)] == 0.0
    return 2 if system.rotors[i].inv_mass == 0.0 and still else 0


@compiled_inline
def closed_form_span(system: System, i: int, t: float, y: Floats) -> float:
    """Return how long [s] rotor i's closed form is used from t [s] on: up to the band of dry friction, or a new start."""
    span = friction_span(system, i, y)
    if system.rotors[i].inv_mass > 0.0 and shakes(system, t):
        return min(span, new_start(system))
    return span


@compiled_inline
def friction_span(system: System, i: int, y: Floats) -> float:
    """Return how long [s] it takes until rotor i's speed falls to the band of dry friction.

    The speed is monotonic in free motion, so one logarithm gives the time; ``NEVER`` without such an end.
    """
    r = system.rotors[i]
    if r.friction <= 0.0 or r.inv_inertia == 0.0:
        return NEVER
    spin = spin_of(system, i, y)
    _, _, alpha = free_rates(system, i, 0.0, 0.0, y[omega_of(system, i)])
    change = math.copysign(r.friction_speed, spin) - spin
    if alpha * change <= 0.0:
        return 0.0 if change == 0.0 else NEVER
    rate = r.drag * r.inv_inertia
    share = rate * change / alpha  # 1 - exp(-rate tau)
    if share >= 1.0:
        return NEVER
    return change / alpha if share < 1e-12 else -math.log1p(-share) / rate
