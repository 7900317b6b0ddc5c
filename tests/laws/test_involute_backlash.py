"""Backlash and flank penetrations against involute flanks that are unwound from their base circles here."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from building import dynamic_backlash, mesh_at, pair_case
from gearplay.model.pack import pack
from gearplay.parts.mesh.geometry import B_T
from gearplay.parts.registry import MESH

NANOMETRE = 1e-9


@dataclass(frozen=True)
class Flank:
    """One side of a tooth; at the pitch point it stands ``half_angle`` [rad] off the tooth's middle."""

    r_base: float
    r_pitch: float
    half_angle: float

    def unwound(self, t: float) -> tuple[float, float]:
        """Return radius [m] and polar angle [rad] of a string's end, unwound by t from the base circle."""
        x = math.cos(t) + t * math.sin(t)
        y = math.sin(t) - t * math.cos(t)
        return self.r_base * math.hypot(x, y), math.atan2(y, x)

    def unwinding(self, r: float) -> float:
        """Return the unwound angle [rad] whose string ends at radius r."""
        return math.sqrt((r / self.r_base) ** 2 - 1.0)

    def offset(self, t: float) -> tuple[float, float]:
        """Return radius and angle [rad] from the tooth's middle at unwound angle t."""
        r, angle = self.unwound(t)
        return r, self.half_angle + self.unwound(self.unwinding(self.r_pitch))[1] - angle

    def half_angle_at(self, r: float) -> float:
        """Return the angle from the tooth's middle at radius r."""
        return self.offset(self.unwinding(r))[1]


@dataclass(frozen=True)
class Pair:
    """Gear a has a tooth space on the line of centres, gear b a tooth in it with ``b0`` of normal play."""

    z_a: int
    z_b: int
    module: float
    alpha: float
    b0: float
    internal: bool

    def touching_rotations(self, d: NDArray[np.float64], theta_a: float) -> tuple[float, float]:
        """Turn gear b both ways until it touches; return the two rotations [rad] from its middle position."""
        r_a, r_b = 0.5 * self.module * self.z_a, 0.5 * self.module * self.z_b
        cosine = math.cos(self.alpha)
        space = Flank(r_a * cosine, r_a, 0.5 * math.pi / self.z_a)
        tooth = Flank(r_b * cosine, r_b, 0.5 * (0.5 * math.pi * self.module - self.b0 / cosine) / r_b)
        distance = r_a - r_b if self.internal else r_a + r_b
        centre_b = np.array([distance, 0.0]) + d
        pointing = 0.0 if self.internal else math.pi

        def rotation(t: float, side: float) -> float:
            """Return the rotation of b that brings its flank ``side`` to gear a's flank point t."""
            r, angle = space.offset(t)
            opening = angle if self.internal else math.pi / self.z_a - angle
            at = theta_a + (side if self.internal else -side) * opening
            p = r * np.array([math.cos(at), math.sin(at)]) - centre_b
            polar = math.remainder(math.atan2(p[1], p[0]) - pointing, 2.0 * math.pi)
            return polar - side * tooth.half_angle_at(math.hypot(p[0], p[1]))

        t_pitch, reach = space.unwinding(r_a), math.pi / self.z_a  # half a base pitch, unwound
        found = []
        for side in (1.0, -1.0):
            best = minimize_scalar(
                lambda t, side=side: side * rotation(t, side),
                bounds=(t_pitch - reach, t_pitch + reach),
                method="bounded",
                options={"xatol": 1e-10},
            )
            assert abs(best.x - t_pitch) < 0.99 * reach, "the flanks touch inside the part searched"
            found.append(side * best.fun)
        return found[0], found[1]

    def backlash(self, dx: float) -> float:
        """Return the total normal backlash [m] at centres moved apart by dx."""
        forward, backward = self.touching_rotations(np.array([dx, 0.0]), 0.0)
        return (forward - backward) * 0.5 * self.module * self.z_b * math.cos(self.alpha)


@pytest.mark.parametrize(
    ("internal", "moved", "expected"),
    [
        (False, 100e-6, 168.565e-6),
        (False, 200e-6, 237.451e-6),
        (True, -100e-6, 168.080e-6),
        (True, 50e-6, 65.717e-6),
    ],
)
def test_backlash_at_a_changed_centre_distance_is_that_of_real_flanks(
    internal: bool, moved: float, expected: float
) -> None:
    """b_t = b0 -/+ 2 c0 (inv alpha_w - inv alpha0): known values, unwound flanks and kernel agree to 1 nm."""
    z_a, z_b = (60, 20) if internal else (20, 60)
    alpha = math.radians(20.0)
    brute = Pair(z_a, z_b, 4e-3, alpha, 100e-6, internal).backlash(moved)
    A0 = 0.002 * (z_a - z_b if internal else z_a + z_b)
    law = dynamic_backlash(A0 + moved, A0, alpha, 100e-6, 1.0 if internal else -1.0)
    assert abs(brute - expected) < NANOMETRE
    assert abs(law - expected) < NANOMETRE
    assert abs(law - brute) < 1e-3 * NANOMETRE


def test_backlash_moves_by_twice_the_sine_of_the_working_pressure_angle() -> None:
    """D b_t / dA = -/+ 2 sin alpha_w: internal play shrinks, external play grows when the centres part."""
    alpha, A = math.radians(20.0), 0.0803
    for s in (1.0, -1.0):
        slope = (
            dynamic_backlash(A + 1e-7, 0.08, alpha, 0.0, s) - dynamic_backlash(A - 1e-7, 0.08, alpha, 0.0, s)
        ) / 2e-7
        sine = math.sqrt(1.0 - (0.08 * math.cos(alpha) / A) ** 2)
        assert slope == pytest.approx(-2.0 * s * sine, rel=1e-7)


@pytest.mark.parametrize("internal", [True, False])
@pytest.mark.parametrize("speed", [10.0, -10.0])
@pytest.mark.parametrize("driver_is_a", [True, False])
def test_penetrations_vanish_where_real_flanks_touch(internal: bool, speed: float, driver_is_a: bool) -> None:
    """p_d = 0 and p_b = 0 at the rotations at which unwound flanks touch, however displaced."""
    rng = np.random.default_rng(5)
    worst = 0.0
    for _ in range(6):
        z_b = int(rng.integers(24, 40))
        z_a = int(rng.integers(2 * z_b + 10, 120)) if internal else int(rng.integers(24, 80))
        module, alpha = float(rng.uniform(2e-3, 8e-3)), math.radians(float(rng.uniform(18.0, 26.0)))
        b0 = float(rng.uniform(0.02, 0.05)) * module
        pair = Pair(z_a, z_b, module, alpha, b0, internal)
        # an external pair's vector of centres goes from the driver to the driven gear
        a_drives = driver_is_a or not internal
        names = ("a", "b") if a_drives else ("b", "a")
        gears = {
            "a": {"teeth": z_a, "internal": internal, "mass": 1.0, "inertia": 1e-3, "floating": True},
            "b": {"teeth": z_b, "mass": 1.0, "inertia": 1e-3, "floating": True},
        }
        gears[names[0]]["drive"] = {"kind": "speed", "speed": speed}
        case = pair_case(
            rotors={"pinion": None, "ring": None, **gears},
            sleeves={"pinion": None, "ring": None},
            mesh={
                "driver": names[0],
                "driven": names[1],
                "module": module,
                "pressure_angle": alpha,
                "backlash": b0,
            },
        )
        packed = pack(case)
        mesh = packed.system.records[MESH][0]
        i_a, i_b = packed.rotor_names.index("a"), packed.rotor_names.index("b")
        assert (mesh.a, mesh.b) == (i_a, i_b)
        d = rng.uniform(-0.02, 0.02, 2) * module
        theta_a = float(rng.uniform(-0.2, 0.2)) / z_a
        forward, backward = pair.touching_rotations(d, theta_a)
        base = 0.5 * module * z_b * math.cos(alpha)
        # both senses start from p_d = 0, a backlash's half away from the middle
        middle = -mesh.sigma * 0.5 * b0 / base
        flanks = (forward, backward) if mesh.sigma > 0.0 else (backward, forward)
        for which, touching in enumerate(flanks):
            y = np.zeros(packed.state_size)
            y[3 * i_a + 2], y[3 * i_b + 2] = theta_a, touching + middle
            y[3 * i_b : 3 * i_b + 2] = d
            out = mesh_at(packed, 0, y)
            worst = max(worst, abs(out[which]))
            assert out[1 - which] == pytest.approx(-out[B_T], abs=NANOMETRE)
    assert worst < 0.01 * NANOMETRE
