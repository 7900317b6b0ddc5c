"""Helical pairs with tip relief against a plain simulation with Gauss's rule over the facewidth."""

import itertools
import math

import numpy as np
import pytest

from building import Document, Floats, Measured, case_of, simulate_one
from cross.test_tooth_pairs import Plain
from depth import sized
from gearplay.parts.mesh.train.geometry import pair_of
from helical_pairs import Width, helical

GAUSS = list(zip(*(each.tolist() for each in np.polynomial.legendre.leggauss(3)), strict=True))


class PlainHelical(Plain):
    """Two planar gears, each pair of teeth a line of contact; without corners."""

    def __init__(self, document: Document) -> None:
        self.width = Width(document)
        (mesh,) = document["meshes"]
        transverse = mesh["backlash"] / math.cos(self.width.pair.first.base_helix)
        super().__init__({**document, "meshes": [{**mesh, "backlash": transverse}]})
        self.pair = self.width.pair
        self.peak = self.width.peak

    def contacts(self, state: Floats) -> list[tuple[float, complex, complex]]:
        """Return forces [N], directions on the second gear and points in the middle of the facewidth of all pairs in touch."""
        o_1, o_2 = complex(*state[0:2]), complex(*state[3:5])
        line = o_1 - o_2 if self.ring else o_2 - o_1
        distance, phi = abs(line), math.atan2(line.imag, line.real)
        s = 1.0 if self.ring else -1.0
        alpha = math.acos((self.base[1] - s * self.base[0]) / distance)
        found = []
        for flank in (1.0, -1.0):
            a_1, a_2 = flank * (state[2] - phi), flank * (state[5] + self.zero - phi)
            near = -round(a_1 * self.z[0] / (2.0 * math.pi))
            for j in range(near - 5, near + 6):
                zeta_1 = a_1 + 2.0 * math.pi * j / self.z[0] + self.sigma[0]
                if self.ring:
                    zeta_2 = a_2 + 2.0 * math.pi * j / self.z[1] + self.sigma[1]
                else:
                    zeta_2 = a_2 - 2.0 * math.pi * (j + 0.5) / self.z[1] + self.sigma[1]
                rho = self.base * (np.array([zeta_1, zeta_2]) + alpha)
                inv = math.tan(alpha) - alpha
                overlap = self.base[0] * zeta_1 - self.base[1] * zeta_2 + (self.base[1] - self.base[0]) * inv
                if not self.ring:
                    overlap = (
                        self.base[0] * zeta_1 + self.base[1] * zeta_2 - (self.base[1] + self.base[0]) * inv
                    )
                if overlap <= 0.0:
                    continue
                force = self.force(overlap, float(rho[0]), float(rho[1]))
                if force == 0.0:
                    continue
                foot = self.base[0] * complex(math.cos(alpha), -math.sin(alpha))
                point = foot + rho[0] * complex(math.sin(alpha), math.cos(alpha))
                normal = complex(math.sin(alpha), math.cos(alpha))
                if flank < 0.0:
                    normal, point = normal.conjugate(), point.conjugate()
                turn = complex(math.cos(phi), math.sin(phi))
                found.append((force, normal * turn, o_1 + point * turn))
        return found

    def force(self, overlap: float, rho_1: float, rho_2: float) -> float:
        """Return the force of a pair of teeth [N]: between kinks of the relief and zeros of the overlap by Gauss's rule."""
        width, total = self.width, 0.0
        low, high = width.ends(rho_1)
        if low >= high:
            return 0.0
        starts = (min(max(x, low), high) for x in width.relief_starts(rho_1, rho_2))
        knots = np.array(sorted([low, high, *starts]))
        thirds = np.stack([knots[:-1], 0.5 * (knots[:-1] + knots[1:]), knots[1:]])
        overlaps = overlap - width.missing(thirds, rho_1, rho_2)
        for start, end, p in zip(knots[:-1].tolist(), knots[1:].tolist(), overlaps.T.tolist(), strict=True):
            at = [0.0, *zeros_of(*p), 1.0]
            for one, other in itertools.pairwise(at):
                half = 0.5 * (other - one)
                for node, weight in GAUSS:
                    t = one + half * (1.0 + node)
                    pressed = p[0] + t * (
                        4.0 * p[1] - 3.0 * p[0] - p[2] + t * 2.0 * (p[0] - 2.0 * p[1] + p[2])
                    )
                    place = rho_1 + start + t * (end - start)
                    total += half * (end - start) * weight * width.stiffness_at(place) * max(pressed, 0.0)
        return total


def zeros_of(p_0: float, p_1: float, p_2: float) -> list[float]:
    """Return where in (0, 1) a quadratic with three values at 0, 1/2, 1 is zero."""
    bend, slope = 2.0 * (p_0 - 2.0 * p_1 + p_2), 4.0 * p_1 - 3.0 * p_0 - p_2
    found = []
    if abs(bend) < 1e-9 * abs(slope):
        found = [-p_0 / slope]
    elif bend != 0.0 and slope * slope >= 4.0 * bend * p_0:
        root = math.sqrt(slope * slope - 4.0 * bend * p_0)
        found = sorted([(-slope - root) / (2.0 * bend), (-slope + root) / (2.0 * bend)])
    return [x for x in found if 0.0 < x < 1.0]


def random_case(rng: np.random.Generator) -> Document:
    """Return a loaded or rattling helical pair with tip relief on both gears, on springs."""
    ring = bool(rng.integers(2))
    document = helical(float(rng.uniform(0.1, 0.4)), float(rng.uniform(0.01, 0.03)), ring=ring)
    pair = pair_of(case_of(document), 0)
    document["supports"] = {}
    loaded = rng.random() < 0.7
    speed, torque = float(rng.uniform(60.0, 160.0)), float(rng.uniform(50.0, 200.0))
    for k, (name, mass, inertia) in enumerate((("one", 0.8, 4e-4), ("two", 2.5, 9e-3))):
        way = (1.0 if ring else -1.0) * 20.0 / 60.0 if k else 1.0
        rotor = document["rotors"][name]
        home = pair.distance if (k == 0) == ring else 0.0
        rotor |= {"mass": mass, "inertia": inertia, "position": [home, 0.0]}
        rotor["initial"] = {"omega": way * speed, "theta": 0.0}
        rotor["tip_relief"] = {
            "amount": float(rng.uniform(3e-6, 2e-5)),
            "length": float(rng.uniform(2e-3, 6e-3)),
            "shape": str(rng.choice(["linear", "parabolic"])),
        }
        if loaded:
            rotor["drive"] = {"kind": "torque", "torque": torque if k == 0 else -torque / way}
        elif k:
            rotor["initial"]["omega"] *= 1.05
        document["supports"][name] = {
            "stiffness": [8e7, 8e7],
            "damping": [float(rng.uniform(50.0, 400.0))] * 2,
        }
    document["run"] |= {"duration": 4.002e-3, "tolerance": 1e-11}
    return document


@pytest.mark.slow
def test_random_helical_pairs__follow_a_plain_simulation(measured: Measured) -> None:
    """Positions after 4 ms."""
    worst, touched = 0.0, 0
    for seed in range(sized(6, 1)):
        document = random_case(np.random.default_rng([48, seed]))
        run = simulate_one(document)
        expected = PlainHelical(document).end(4e-3, 1e-10, 2e-5)
        found = np.array(
            [run.signal(word, name)[4000] for name in ("one", "two") for word in ("x", "y", "theta")]
        )
        worst = max(worst, float(np.abs(found - expected).max()))
        touched += int(run.statistics.impacts_per_second.max() > 0.0)
    measured("helical pairs with relief against a plain simulation, m and rad", worst, "1e-9")
    assert worst < 1e-9
    assert touched > 0
