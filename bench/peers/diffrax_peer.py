"""diffrax (JAX on the CPU, double precision, compiled) with the pair's formulas written anew in JAX."""

import time
from functools import lru_cache

import numpy as np

from bench.peers._flat import OUTSIDE, SMALLEST_RELATIVE, largest_difference
from bench.peers._pair import involute_coefficients, numbers
from bench.problem import STATES

NAME = ["Tsit5", "Dopri5", "Dopri8"]
STEP_LIMIT = 1_000_000


def missing():
    """Return what to install, None if nothing."""
    try:
        import diffrax  # noqa: F401
    except ImportError:
        return "pip install diffrax"
    return None


def make_rate(problem):
    """Return the derivative f(t, y) of the pair in JAX; docs/theory.md, T1 to T14."""
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    p, series = numbers(problem), involute_coefficients(problem)
    outside = jnp.asarray(OUTSIDE * problem.packed.natural)
    alpha0 = np.arccos(p["c0"] / p["A0"])

    def arm(gear, t, theta):
        angle = p[gear + "_nominal_speed"] * t + theta + p[gear + "_eccentricity_phase"]
        return p[gear + "_eccentricity"] * jnp.cos(angle), p[gear + "_eccentricity"] * jnp.sin(angle)

    def rate(t, y):
        x_p, y_p, th_p, x_r, y_r, th_r, vx_p, vy_p, om_p, vx_r, vy_r, om_r = (y[i] for i in range(STATES))
        spin_p, spin_r = p["pinion_nominal_speed"] + om_p, p["ring_nominal_speed"] + om_r

        # sleeve, T10 without dissipation
        distance = jnp.sqrt(x_r * x_r + y_r * y_r)
        deep = jnp.maximum(distance - p["clearance"], 0.0)
        push = p["sleeve_stiffness"] * deep * jnp.sqrt(deep) / jnp.where(distance > 0.0, distance, 1.0)

        # vector of toothing centres and its rate
        px, py = arm("pinion", t, th_p)
        rx, ry = arm("ring", t, th_r)
        along, across = p["A0"] + x_p + px - x_r - rx, y_p + py - y_r - ry
        v_x, v_y = vx_p - spin_p * py - vx_r + spin_r * ry, vy_p + spin_p * px - vy_r - spin_r * rx
        square = along * along + across * across
        A = jnp.sqrt(square)
        e_x, e_y = along / A, across / A
        cosine = p["c0"] / A
        sine = jnp.sqrt(jnp.maximum(1.0 - cosine * cosine, 0.0))

        # change of the involute angles: power series near the nominal distance, closed form elsewhere
        u = square / p["A0"] ** 2 - 1.0
        total = 0.0
        for coefficient in series[::-1]:
            total = total * u + coefficient
        tangent = sine / cosine
        far = tangent - jnp.arctan(tangent) - (np.tan(alpha0) - alpha0)
        opening = p["c0"] * jnp.where(jnp.abs(u) < p["u_series"], total * u, far)

        # penetrations, T2, and their rates
        psi = p["z_driver"] * (p["pinion_nominal_speed"] * t + th_p)
        c, s = jnp.cos(psi), jnp.sin(psi)
        error = p["e_cos"] * s + p["e_sin"] * c
        error_rate = (p["e_cos"] * c - p["e_sin"] * s) * p["z_driver"] * spin_p
        lever = p["rho_a"] + p["rho_b"]
        w = p["rho_a"] * th_r + p["rho_b"] * th_p - lever * jnp.arctan2(across, along) + error
        w_rate = p["rho_a"] * om_r + p["rho_b"] * om_p - lever * (v_y * e_x - v_x * e_y) / A + error_rate
        opening_rate = sine * (v_x * e_x + v_y * e_y)
        stiffness = p["k_m"] + p["k_cos"] * c - p["k_sin"] * s

        def flank(depth, depth_rate):
            ramp = jnp.clip(depth / p["depth"], 0.0, 1.0)
            force = stiffness * depth + p["C_m"] * ramp * ramp * (3.0 - 2.0 * ramp) * depth_rate
            return jnp.where(depth > 0.0, jnp.maximum(force, 0.0), 0.0)

        drive = flank(w + opening, w_rate + opening_rate)
        back = flank(-w + opening - p["backlash"], -w_rate + opening_rate)

        # forces, T4, on the pinion; the ring gets the opposite
        both, difference = (drive + back) * sine, (drive - back) * cosine
        f_x, f_y = -both * e_x + difference * e_y, -both * e_y - difference * e_x
        torque_p = p["pinion_torque"] - p["pinion_drag"] * spin_p
        torque_p += -(drive - back) * p["rho_b"] + px * f_y - py * f_x
        torque_r = p["ring_torque"] - p["ring_drag"] * spin_r
        torque_r += -(drive - back) * p["rho_a"] - rx * f_y + ry * f_x
        dy = jnp.stack([
            vx_p, vy_p, om_p, vx_r, vy_r, om_r,
            p["pinion_inv_mass"] * f_x, p["pinion_inv_mass"] * f_y, p["pinion_inv_inertia"] * torque_p,
            p["ring_inv_mass"] * (-f_x - push * x_r), p["ring_inv_mass"] * (-f_y - push * y_r),
            p["ring_inv_inertia"] * torque_r,
        ])  # fmt: skip
        return jnp.where(jnp.abs(2.0 * A - p["A_min"] - p["A_max"]) < p["A_max"] - p["A_min"], dy, outside)

    return rate


def check(problem):
    """Return the largest relative difference from the common right-hand side."""
    import jax

    return largest_difference(problem, jax.jit(make_rate(problem)))


@lru_cache
def compiled(problem, method):
    """Return a compiled run(start, span, tolerance) on states in units of their natural sizes."""
    import diffrax
    import jax
    import jax.numpy as jnp

    rate = make_rate(problem)
    natural = jnp.asarray(problem.packed.natural)
    term = diffrax.ODETerm(lambda t, z, _: rate(t, z * natural) / natural)
    solver = getattr(diffrax, method)()

    @jax.jit
    def run(start, span, tolerance):
        controller = diffrax.PIDController(rtol=SMALLEST_RELATIVE, atol=tolerance)
        answer = diffrax.diffeqsolve(
            term, solver, 0.0, span, None, start, stepsize_controller=controller, max_steps=STEP_LIMIT,
            throw=False, saveat=diffrax.SaveAt(t1=True), adjoint=diffrax.ForwardMode(),
        )  # fmt: skip
        good = answer.result == diffrax.RESULTS.successful
        return jnp.where(good, answer.ys[-1], jnp.nan), answer.stats["num_steps"]

    return run


def solve(problem, member, method, tolerance):
    """Return the final state, the seconds the call took and None: diffrax counts steps, not evaluations."""
    import jax

    run = compiled(problem, method)
    start = problem.start(member) / problem.packed.natural
    jax.block_until_ready(run(start, 1e-6, tolerance))
    began = time.perf_counter()
    end, _ = jax.block_until_ready(run(start, problem.span, tolerance))
    return np.asarray(end) * problem.packed.natural, time.perf_counter() - began, None
