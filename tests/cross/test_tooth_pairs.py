"""Random pairs of gears with pairs of teeth against a plain simulation in absolute coordinates, written apart from the package.

Complex numbers for the plane, every tooth of both gears at its absolute place; flanks by their base circles, corners by points of
the tips; SciPy's DOP853 in steps too short for its error estimate to matter.
"""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from building import Document, Floats, Measured, case_of, simulate_one
from depth import sized
from gearplay.parts.mesh.train.geometry import pair_of
from tooth_pairs import document_of


def random_case(rng: np.random.Generator) -> Document:
    """Return a loaded or rattling pair, external or internal, on springs."""
    while True:
        ring = bool(rng.integers(2))
        teeth = int(rng.integers(17, 30)), int(rng.integers(50, 80))
        shifts = float(rng.uniform(0.0, 0.4)), float(rng.uniform(-0.1, 0.3))
        document = document_of(3e-3, teeth, shifts, ring, float(rng.uniform(2e-5, 8e-5)), 0.01)
        pair = pair_of(case_of(document), 0)
        if pair.contact_ratio > 1.15 and pair.path.tip_of_second > 0.1 * pair.first.base_pitch:
            break
    document["supports"] = {}
    loaded = rng.random() < 0.6
    speed, torque = float(rng.uniform(60.0, 160.0)), float(rng.uniform(20.0, 60.0))
    for k, (name, mass, inertia) in enumerate((("one", 0.8, 4e-4), ("two", 2.5, 9e-3))):
        way = (1.0 if ring else -1.0) * teeth[0] / teeth[1] if k else 1.0
        rotor = document["rotors"][name]
        rotor |= {"mass": mass, "inertia": inertia, "initial": {"omega": way * speed, "theta": 0.0}}
        if loaded:
            given = torque if k == 0 else -torque / way
            rotor["drive"] = {"kind": "torque", "torque": given}
        elif k:
            rotor["initial"]["omega"] *= 1.05
        springs = {"stiffness": [8e7, 8e7], "damping": [float(rng.uniform(50.0, 400.0))] * 2}
        document["supports"][name] = springs
    document["run"] |= {"duration": 4.002e-3, "tolerance": 1e-11}
    return document


class Plain:
    """Two planar gears, each pair of teeth on its own."""

    def __init__(self, document: Document) -> None:
        pair = pair_of(case_of(document), 0)
        self.document, self.pair = document, pair
        self.names, self.ring = ("one", "two"), pair.internal
        backlash = document["meshes"][0]["backlash"]
        self.z = np.array([pair.first.teeth, pair.second.teeth])
        self.base = np.array([pair.first.base_radius, pair.second.base_radius])
        self.tip = np.array([pair.first.tip, pair.second.tip])
        self.length = np.sqrt(self.tip**2 - self.base**2)
        thinner = 0.25 * (backlash - pair.backlash) / self.base
        self.sigma = np.array([pair.first.half_angle, pair.second.half_angle]) - thinner * [
            1.0,
            1.0 - 2.0 * self.ring,
        ]
        # Rotations count from touching drive flanks: a tooth of the first gear, a space of the second less half the backlash.
        self.zero = 0.5 * backlash / self.base[1] * (-1.0 if self.ring else 1.0)
        ratio, path = pair.contact_ratio, pair.path
        self.middle, self.half = 0.5 * (path.start + path.end), 0.5 * path.length
        self.kappa = 0.75 * (1.0 - 1.0 / ratio)
        self.peak = self.stiffness()

    def stiffness(self) -> float:
        """Return the largest stiffness of a pair by ISO 6336-1, method B [N/m]."""
        z_1, z_2 = self.z
        x_1, x_2 = self.pair.first.profile_shift, 0.0 if self.ring else self.pair.second.profile_shift
        more = 0.0 if self.ring else 1.0 / z_2
        q = 0.04723 + 0.15551 / z_1 + 0.25791 * more - 0.00635 * x_1 - 0.11654 * x_1 / z_1
        q += -0.00193 * x_2 - 0.24188 * x_2 * more + 0.00529 * x_1**2 + 0.00182 * x_2**2
        return float(0.8 * (1.0 + 0.5 * (1.2 - 1.25)) / q * 1e9 * self.pair.first.facewidth)  # type: ignore[operator]

    def contacts(self, state: Floats) -> list[tuple[float, complex, complex]]:
        """Return overlap-forces [N], directions on the second gear and points of all pairs in touch."""
        o_1, o_2 = complex(*state[0:2]), complex(*state[3:5])
        line = o_1 - o_2 if self.ring else o_2 - o_1
        distance, phi = abs(line), math.atan2(line.imag, line.real)
        s = 1.0 if self.ring else -1.0
        c0 = self.base[1] - s * self.base[0]
        alpha = math.acos(c0 / distance)
        found = []
        for flank in (1.0, -1.0):
            a_1, a_2 = flank * (state[2] - phi), flank * (state[5] + self.zero - phi)
            near = -round(a_1 * self.z[0] / (2.0 * math.pi))
            for j in range(near - 3, near + 4):
                zeta_1 = a_1 + 2.0 * math.pi * j / self.z[0] + self.sigma[0]
                if self.ring:
                    zeta_2 = a_2 + 2.0 * math.pi * j / self.z[1] + self.sigma[1]
                else:
                    zeta_2 = a_2 - 2.0 * math.pi * (j + 0.5) / self.z[1] + self.sigma[1]
                rho = self.base * (np.array([zeta_1, zeta_2]) + alpha)
                if (
                    not -0.5
                    < rho[0] / self.pair.first.base_pitch
                    < self.length[0] / self.pair.first.base_pitch + 1.5
                ):
                    continue
                touch = self.touch(zeta_1, zeta_2, rho, distance, alpha, s)
                if touch is None or touch[0] <= 0.0:
                    continue
                u = min(1.0, max(-1.0, (rho[0] - self.middle) / self.half))
                overlap, tau, point = touch
                normal = complex(-math.sin(tau), math.cos(tau))
                if flank < 0.0:
                    normal, point = normal.conjugate(), point.conjugate()
                turn = complex(math.cos(phi), math.sin(phi))
                found.append(
                    (self.peak * (1.0 - self.kappa * u * u) * overlap, normal * turn, o_1 + point * turn)
                )
        return found

    def touch(
        self, zeta_1: float, zeta_2: float, rho: Floats, distance: float, alpha: float, s: float
    ) -> tuple[float, float, complex] | None:
        """Return overlap, angle of the normal's tangent point, and the point from the first centre along the line of centres."""
        beyond_2 = rho[1] < self.length[1] if self.ring else rho[1] > self.length[1]
        at_tip = np.tan(np.arccos(self.base / self.tip)) - np.arccos(self.base / self.tip)
        if beyond_2:
            z = zeta_2 - at_tip[1]
            tip = self.tip[1] * complex(math.cos(z), math.sin(z))
            point = tip - distance if self.ring else distance - tip
            away, tau = self.from_flank(point, zeta_1, self.base[0])
            return None if math.isnan(away) else (-away, tau, point)
        if rho[0] > self.length[0]:
            z = zeta_1 - at_tip[0]
            own = self.tip[0] * complex(math.cos(z), math.sin(z))
            seen = own + distance if self.ring else distance - own
            away, tau = self.from_flank(seen, zeta_2, self.base[1])
            return None if math.isnan(away) else (s * away, tau, own)
        inv = math.tan(alpha) - alpha
        gap = self.base[1] * zeta_2 - self.base[0] * zeta_1 - (self.base[1] - self.base[0]) * inv
        if not self.ring:
            gap = (self.base[1] + self.base[0]) * inv - self.base[0] * zeta_1 - self.base[1] * zeta_2
        foot = self.base[0] * complex(math.cos(alpha), -math.sin(alpha))
        return -gap, -alpha, foot + rho[0] * complex(math.sin(alpha), math.cos(alpha))

    @staticmethod
    def from_flank(point: complex, zeta: float, base: float) -> tuple[float, float]:
        """Return the signed distance of a point from an involute, and the angle of its base circle's tangent point."""
        if abs(point) <= base:
            return math.nan, 0.0
        angle, pressure = math.atan2(point.imag, point.real), math.acos(base / abs(point))
        return base * (angle - zeta + math.tan(pressure) - pressure), angle - pressure

    def rates(self, t: float, y: Floats) -> Floats:
        """Return the derivative of positions and speeds."""
        force = np.zeros(6)
        mesh = self.document["meshes"][0]
        mu = mesh.get("friction_coefficient", 0.0)
        for f, normal, point in self.contacts(y[:6]):
            one, two = (
                complex(*y[6 + k : 8 + k]) + 1j * y[8 + k] * (point - complex(y[k], y[k + 1])) for k in (0, 3)
            )
            pushed = normal
            if mu > 0.0:  # Coulomb's, along the flanks, against the second's sliding on the first
                along = 1j * normal
                u = min(1.0, max(-1.0, ((two - one) * along.conjugate()).real / mesh["friction_speed"]))
                pushed = normal - mu * (1.5 * u - 0.5 * u**3) * along
            for k, way in ((0, -f), (3, f)):
                arm = point - complex(y[k], y[k + 1])
                force[k : k + 3] += way * np.array(
                    [pushed.real, pushed.imag, arm.real * pushed.imag - arm.imag * pushed.real]
                )
        rotors = [self.document["rotors"][name] for name in self.names]
        for k, (name, rotor) in enumerate(zip(self.names, rotors, strict=True)):
            support, home = self.document["supports"][name], rotor["position"]
            for axis in range(2):
                force[3 * k + axis] -= support["stiffness"][axis] * (y[3 * k + axis] - home[axis])
                force[3 * k + axis] -= support["damping"][axis] * y[6 + 3 * k + axis]
            force[3 * k + 2] += rotor.get("drive", {}).get("torque", 0.0)
        masses = np.array([value for r in rotors for value in (r["mass"], r["mass"], r["inertia"])])
        return np.concatenate([y[6:], force / masses])

    def end(self, time: float, tolerance: float = 1e-12, longest: float = 4e-6) -> Floats:
        """Return positions at the end: x, y from home and theta of both gears; steps of at most ``longest`` [s]."""
        rotors = [self.document["rotors"][name] for name in self.names]
        places = [[*r["position"], r["initial"]["theta"]] for r in rotors]
        speeds = [[0.0, 0.0, r["initial"]["omega"]] for r in rotors]
        start = np.concatenate([np.ravel(places), np.ravel(speeds)])
        found: Any = solve_ivp(
            self.rates,
            (0.0, time),
            start,
            method="DOP853",
            rtol=tolerance,
            atol=0.01 * tolerance,
            max_step=longest,
        )
        return found.y[:6, -1] - np.ravel([[*r["position"], 0.0] for r in rotors])


@pytest.mark.slow
def test_random_pairs__follow_a_plain_simulation(measured: Measured) -> None:
    """Positions after 4 ms, of every second pair with friction; contacts of 20 random pairs at full depth."""
    worst, touched = 0.0, 0
    for seed in range(sized(20, 2)):
        document = random_case(np.random.default_rng([43, seed]))
        if seed % 2:
            document["meshes"][0] |= {"friction_coefficient": 0.1, "friction_speed": 0.05}
        run = simulate_one(document)
        plain = Plain(document)
        expected = plain.end(4e-3)
        found = np.array(
            [run.signal(word, name)[4000] for name in ("one", "two") for word in ("x", "y", "theta")]
        )
        off = np.abs(found - expected)
        worst = max(worst, float(off.max()))
        touched += int(run.statistics.impacts_per_second.max() > 0.0)
    measured("pairs of teeth: random pairs against a plain simulation, m and rad", worst, "1e-9")
    assert worst < 1e-9
    assert touched > 0
