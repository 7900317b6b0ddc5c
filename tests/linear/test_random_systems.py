"""Linear analysis: contacts without gap and load, soft modes beside stiff ones, sets that a torque drives, random systems."""

import math
from fractions import Fraction

import numpy as np
import pytest

import gearplay as gp
from building import Document, Measured
from depth import sized

Wide = np.ndarray  # of extended precision
Exact = list[list[Fraction]]


def test_a_mesh_without_gap_and_load_acts_on_both_sides() -> None:
    """Field row 02: motor, 1:1 pair and two discs; against the eigenvalues of the matrices written down."""
    found = gp.modes(
        {
            "rotors": {
                "motor": {"mass": 1.0, "inertia": 4e-4},
                "g1": {"teeth": 40, "mass": 0.1, "inertia": 2.5e-5},
                "g2": {"teeth": 40, "mass": 0.1, "inertia": 2.5e-5},
                "da": {"mass": 1.0, "inertia": 7e-4},
                "db": {"mass": 1.0, "inertia": 7e-4, "position": [0.0, 0.0]},
            },
            "couplings": [
                {"between": ["motor", "g1"], "torsional_stiffness": 1e4},
                {"between": ["g2", "da"], "torsional_stiffness": 5e3},
                {"between": ["g1", "db"], "torsional_stiffness": 5e3},
            ],
            "meshes": [
                {
                    "driver": "g1", "driven": "g2", "module": 1e-3, "backlash": 0.0,
                    "stiffness": {"kind": "harmonic", "mean": 1e12},
                }
            ],
            "run": {"duration": 0.1},
        }
    )  # fmt: skip
    moving = found.ds["frequency"].values[1:4]
    np.testing.assert_allclose(moving, [425.358, 634.07, 3247.19], atol=5e-3)
    assert "act on both sides of zero: g1-g2:drive" in found.message
    shares = found.ds["strain_energy_share"].sel(element="mesh g1-g2").values
    assert shares[4] == pytest.approx(1.0, abs=1e-4)


def test_a_soft_mode_is_no_free_motion() -> None:
    """Field row 34: 1e8 times below the highest frequency; sqrt(k (1/10 + 1/18)) / 2 pi, gears all but massless."""
    found = gp.modes(
        {
            "rotors": {
                "rotor": {"mass": 10.0, "inertia": 10.0, "drive": {"kind": "torque", "torque": 30.0}},
                "wheel": {"teeth": 90, "mass": 1.0, "inertia": 1e-9},
                "pinion": {"teeth": 30, "mass": 1.0, "inertia": 1e-9},
                "gen": {"mass": 2.0, "inertia": 2.0, "load": {"torque": 10.0}},
            },
            "couplings": [
                {"between": ["rotor", "wheel"], "torsional_stiffness": 1.2e6},
                {"between": ["pinion", "gen"], "torsional_stiffness": 8e5},
            ],
            "meshes": [
                {
                    "driver": "wheel", "driven": "pinion", "module": 1e-2, "backlash": 1e-5,
                    "stiffness": {"kind": "harmonic", "mean": 1e13},
                }
            ],
            "run": {"duration": 0.1},
        }
    )  # fmt: skip
    tooth = 1e13 * (0.45 * math.cos(math.radians(20.0))) ** 2
    k = 1.0 / (1.0 / 1.2e6 + 1.0 / tooth + 1.0 / (9.0 * 8e5))
    expected = math.sqrt(k * (1.0 / 10.0 + 1.0 / 18.0)) / (2.0 * math.pi)
    assert expected == pytest.approx(63.6620, abs=5e-5)
    assert found.ds["frequency"].values[0] == 0.0
    assert found.ds["frequency"].values[1] == pytest.approx(expected, rel=1e-9)
    springs = np.array(
        [1.0 / tooth, 1.0 / 1.2e6, 1.0 / (9.0 * 8e5)]
    )  # one torque: shares are those of the compliances
    shares = found.ds["strain_energy_share"].values
    np.testing.assert_allclose(shares[1], springs / springs.sum(), rtol=1e-6)
    assert [words.endswith("no strain") for _, words in found.rows()] == [True, False, False, False]
    assert np.all(shares[0] == 0.0)


def planetary(drive: Document) -> Document:
    """Return field row t1: four planets, ring fixed, all centres on springs."""
    return {
        "planetary": {
            "s": {
                "module": 2e-3,
                "pressure_angle": 0.38,
                "backlash": 8e-5,
                "sun_planet": {"kind": "harmonic", "mean": 2e8},
                "planet_ring": {"kind": "harmonic", "mean": 3e8},
                "sun": {
                    "teeth": 27, "mass": 0.6, "inertia": 2e-4, "support": {"stiffness": [5e7, 5e7]}, "drive": drive
                },
                "planets": {"count": 4, "teeth": 35, "mass": 0.7, "inertia": 4e-4},
                "ring": {
                    "teeth": 97, "mass": 2.5, "inertia": 2.3e-2, "fixed": True, "support": {"stiffness": [1e8, 1e8]}
                },
                "carrier": {
                    "mass": 4.0, "inertia": 1.2e-2, "support": {"stiffness": [8e7, 8e7]}, "load": {"torque": 367.4}
                },
                "support": {"stiffness": [9e7, 9e7]},
            }
        },
        "run": {"duration": 0.01},
    }  # fmt: skip


def lin_parker_modes(carrier: float) -> np.ndarray:
    """Return the lowest frequencies [Hz] of field row t1 by Lin and Parker's matrices at nominal places, in the carrier's frame:
    M q'' + 2 Omega M J q' + (K - Omega^2 M) q = 0, the inertia forces of centres alone (J. Vib. Acoust. 121 (1999) 319).
    """
    c, s, a = math.cos(0.38), math.sin(0.38), 2e-3 * (27 + 35) / 2
    bases = [1e-3 * z * c for z in (27, 35)]
    matrix, mass = (
        np.zeros((20, 20)),
        np.array([0.6, 0.6, 2e-4, 2.5, 2.5, 4.0, 4.0, 1.2e-2, *[0.7, 0.7, 4e-4] * 4]),
    )

    def add(k: float, row: dict[int, float]) -> None:
        places, factors = list(row), np.array(list(row.values()))
        matrix[np.ix_(places, places)] += k * np.outer(factors, factors)

    for k in range(4):
        out = np.array([math.cos(0.5 * math.pi * k), math.sin(0.5 * math.pi * k)])
        ahead, p = np.array([-out[1], out[0]]), 8 + 3 * k
        x, y = -s * out - c * ahead  # sun at 0, ring at 3, carrier at 5
        add(2e8, {p: x, p + 1: y, 0: -x, 1: -y, 2: bases[0], p + 2: bases[1]})
        x, y = s * out - c * ahead
        add(3e8, {p: x, p + 1: y, 3: -x, 4: -y, p + 2: -bases[1]})
        for axis in range(2):
            add(9e7, {p + axis: 1.0, 5 + axis: -1.0, 7: -a * ahead[axis]})
    centres = [0, 3, 5, 8, 11, 14, 17]
    for at, k in ((0, 5e7), (3, 1e8), (5, 8e7)):
        matrix[at, at] += k
        matrix[at + 1, at + 1] += k
    turning = np.zeros((20, 20))
    for at in centres:
        turning[at, at + 1], turning[at + 1, at] = -carrier, carrier
    pull = matrix + mass[:, None] * (turning @ turning)
    whole = np.block(
        [[np.zeros((20, 20)), np.eye(20)], [-pull / mass[:, None], -2.0 * turning]],
    )
    values = np.linalg.eigvals(whole).imag
    return np.sort(values[values > 1.0]) / (2.0 * math.pi)


def test_planetary_set__turns_by_the_ratio_of_its_fixed_member() -> None:
    """Willis: with the ring fixed the carrier turns 27/124 of the sun; translational modes part as when a speed drives it.

    657.664 and 748.050 Hz by Lin and Parker's matrices, which have no loads, and here where flanks keep their nominal places
    (``uncoupled``). The planets' centrifugal force puts them 43.4 um out, which changes the pressure angles and takes 0.195 and
    0.214 Hz away; the torque adds 0.03: 657.495 and 747.866 Hz, also by an own calculation (potential of springs on involute
    geometry, of loads and centrifugal forces, its minimum and second derivatives by differences). The row's 657.03 and 747.34
    follow from neither.
    """
    speed = 300.0 * (1.0 + 97.0 / 27.0)
    by_torque = gp.campbell(planetary({"kind": "torque", "torque": 80.0}), [0.5 * speed, speed]).ds
    by_speed = gp.campbell(planetary({"kind": "speed", "speed": speed}), [0.5 * speed, speed]).ds
    orders = dict(
        zip(
            by_torque["order"].values,
            2.0 * math.pi / speed * by_torque["order_frequency"].values[1],
            strict=True,
        )
    )
    assert orders["s.sun-s.planet1"] == pytest.approx(27.0 * (1.0 - 27.0 / 124.0), rel=1e-12)
    assert orders["s.carrier"] == pytest.approx(27.0 / 124.0, rel=1e-12)
    free, held = (np.sort(ds["frequency"].values[1]) for ds in (by_torque, by_speed))
    assert free[0] == 0.0  # the set turns
    np.testing.assert_allclose(free[1:5], [657.495, 747.866, 950.856, 1026.879], atol=6e-4)
    np.testing.assert_allclose(free[1:5], held[:4], rtol=1e-6)
    nominal = {**planetary({"kind": "torque", "torque": 80.0}), "backlash_model": "uncoupled"}
    found = np.sort(gp.modes(nominal, speed=speed).ds["frequency"].values)[1:]
    np.testing.assert_allclose(found[:6], lin_parker_modes(300.0)[:6], rtol=1e-6)  # translational


def test_the_bundled_set_of_lin_and_parker_turns_with_its_carrier() -> None:
    found = gp.campbell("lin-parker-1999", [10.0, 1000.0]).ds
    orders = dict(
        zip(found["order"].values, 2e-3 * math.pi * found["order_frequency"].values[1], strict=True)
    )
    assert orders["stage.carrier"] == pytest.approx(30.0 / 132.0, rel=1e-12)
    assert np.ptp(found["frequency"].values, axis=0).max() > 10.0


def jacobi(matrix: Wide) -> Wide:
    """Return the eigenvalues of a symmetric matrix by Jacobi's rotations, in its own precision."""
    a = matrix.copy()
    n = len(a)
    for _ in range(60):
        if np.abs(a - np.diag(np.diag(a))).max() == 0.0:
            break
        for p in range(n):
            for q in range(p + 1, n):
                if abs(a[p, q]) <= np.finfo(a.dtype).tiny or abs(a[p, q]) < 1e-30 * np.sqrt(
                    abs(a[p, p] * a[q, q])
                ):
                    a[p, q] = a[q, p] = 0.0
                    continue
                tau = (a[q, q] - a[p, p]) / (2.0 * a[p, q])
                t = (1.0 if tau >= 0.0 else -1.0) / (abs(tau) + np.sqrt(1.0 + tau * tau))
                c = 1.0 / np.sqrt(1.0 + t * t)
                turn = np.eye(n, dtype=a.dtype)
                turn[p, p] = turn[q, q] = c
                turn[p, q], turn[q, p] = c * t, -c * t
                a = turn.T @ a @ turn
    return np.sort(np.diag(a))


def condensed(matrix: Exact, light: list[int]) -> Wide:
    """Return a stiffness matrix without massless coordinates, by exact elimination."""
    a = [row[:] for row in matrix]
    for s in light:
        for i, row in enumerate(a):
            if i != s and row[s]:
                factor = row[s] / a[s][s]
                a[i] = [x - factor * y for x, y in zip(row, a[s], strict=True)]
    kept = [i for i in range(len(a)) if i not in light]
    found = np.zeros((len(kept), len(kept)), dtype=np.longdouble)
    for i, row in enumerate(kept):
        for j, column in enumerate(kept):
            value = a[row][column]
            high = float(value)
            found[i, j] = np.longdouble(high) + np.longdouble(float(value - Fraction(high)))
    return found


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="needs extended precision for its reference")
def test_modes_of_random_systems_are_those_of_dense_matrices(measured: Measured) -> None:
    """Trees of shafts and meshes, springs to the ground over nine decades of stiffness, every other one with massless rotors;
    matrices written down here in exact fractions, condensed exactly, their eigenvalues in extended precision.
    """
    worst = 0.0
    for seed in range(sized(200, 20)):
        rng = np.random.default_rng([7, seed])
        n = int(rng.integers(3, 9))
        inertias = 10.0 ** rng.uniform(-3.0, -1.0, n)
        teeth = rng.integers(18, 60, n)
        if seed % 2:
            inertias[1:][np.random.default_rng([8, seed]).random(n - 1) < 0.4] = 0.0
        rotors = {
            f"r{i}": {"mass": 1.0, "inertia": float(inertias[i]), "teeth": int(teeth[i])} for i in range(n)
        }
        document: Document = {
            "rotors": rotors,
            "couplings": [],
            "meshes": [],
            "supports": {},
            "run": {"duration": 0.1},
        }
        stiffness: Exact = [[Fraction(0)] * n for _ in range(n)]

        def add(row: dict[int, float], k: float, into: Exact = stiffness) -> None:
            for i, first in row.items():
                for j, second in row.items():
                    into[i][j] += Fraction(k) * Fraction(first) * Fraction(second)

        for i in range(1, n):
            j, k = int(rng.integers(0, i)), float(10.0 ** rng.uniform(0.0, 9.0))
            if rng.random() < 0.5:
                ratio = float(rng.uniform(0.3, 3.0))
                document["couplings"].append(
                    {"between": [f"r{j}", f"r{i}"], "torsional_stiffness": k, "ratio": ratio}
                )
                add({j: 1.0, i: -ratio}, k)
            else:
                document["meshes"].append(
                    {
                        "driver": f"r{j}", "driven": f"r{i}", "module": 4e-3, "backlash": 0.0,
                        "stiffness": {"kind": "harmonic", "mean": 1e3 * k},
                    }
                )  # fmt: skip
                base = 2e-3 * math.cos(math.radians(20.0))
                add({j: base * int(teeth[j]), i: base * int(teeth[i])}, 1e3 * k)
        for i in np.flatnonzero(rng.random(n) < 0.3).tolist():
            k = float(10.0 ** rng.uniform(0.0, 9.0))
            document["supports"][f"r{i}"] = {"torsional_stiffness": k}
            add({i: 1.0}, k)
        found = gp.modes(document).ds["frequency"].values
        heavy = inertias > 0.0
        root = np.sqrt(inertias[heavy].astype(np.longdouble))
        squares = jacobi(condensed(stiffness, np.flatnonzero(~heavy).tolist()) / np.outer(root, root))
        assert len(found) == len(squares), seed
        free = 0 if document["supports"] else 1
        assert np.all(found[:free] == 0.0), seed
        expected = np.sqrt(squares[free:]).astype(float) / (2.0 * math.pi)
        np.testing.assert_allclose(found[free:], expected, rtol=1e-8, err_msg=str(seed))
        worst = max(worst, float(np.max(np.abs(found[free:] / expected - 1.0), initial=0.0)))
    measured("largest difference of a natural frequency", worst, "relative")
