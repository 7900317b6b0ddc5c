"""Curves made of a case's numbers: rules, bounds and peaks hold for the curve, not for its points alone."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Floats, case_of, pair_case, pair_document, simulate_one
from depth import sized
from gearplay.model.pack import Packed, pack
from gearplay.parts.drive.terms import TorqueTable
from gearplay.parts.mesh.mesh_stiffness import pack_stiffness
from gearplay.parts.mesh.tooth_stiffness import mesh_stiffness, stiffness_slope
from gearplay.parts.registry import MESH
from gearplay.schema.records import cubic_pieces, extremes
from gearplay.vocabulary.errors import InputError


def table(phases: Any, values: Any) -> Document:
    """Return a stiffness table."""
    return {
        "kind": "table",
        "phase": [float(p) for p in phases],
        "stiffness": [float(k) for k in values],
    }


def curve(packed: Packed, psi: Floats) -> tuple[Floats, Floats]:
    """Return the kernel's stiffness [N/m] and its slope [N/m] at mesh phases [rad]."""
    mesh, system = packed.system.records[MESH][0], packed.system
    found = [
        (
            mesh_stiffness(mesh, system, p, math.cos(p), math.sin(p), 0),
            stiffness_slope(mesh, system, p, math.cos(p), math.sin(p)),
        )
        for p in psi.tolist()
    ]
    return np.array(found).T[0], np.array(found).T[1]


@pytest.mark.parametrize("seed", range(sized(100)))
def test_a_table_stays_between_neighbouring_points(seed: int) -> None:
    """Through its points, monotone between them, periodic, of continuous slope; values and distances over four decades."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 12))
    gaps = 10.0 ** rng.uniform(-4.0, 0.0, count)
    phases = np.cumsum(gaps) * 2.0 * math.pi / np.sum(gaps) - 2.0 * math.pi * gaps[0] / np.sum(gaps)
    values = 10.0 ** rng.uniform(5.0, 9.0, count)
    values[1] = values[0] if seed % 3 == 0 else values[1]
    packed = pack(pair_case(mesh={"stiffness": table(phases, values)}))
    ends, nexts = np.append(phases[1:], phases[0] + 2.0 * math.pi), np.roll(values, -1)
    for turn in (0.0, -2.0 * math.pi):
        assert np.allclose(curve(packed, phases + turn + 1e-13)[0], values, rtol=1e-6)
    for start, end, low, high in zip(phases, ends, values, nexts, strict=True):
        psi = start + (end - start) * np.linspace(1e-6, 1.0 - 1e-6, 25)
        k, _ = curve(packed, psi)
        assert np.all(k >= min(low, high) * (1.0 - 1e-12))
        assert np.all(k <= max(low, high) * (1.0 + 1e-12))
        assert np.all(np.diff(k) * np.sign(high - low) >= -1e-12 * max(low, high))
    rows = packed.system.spline
    widths = ends - phases
    at_end = rows[:, 2] + widths * (2.0 * rows[:, 3] + 3.0 * widths * rows[:, 4])
    steepest = np.maximum(np.abs(nexts - values), np.abs(values - np.roll(values, 1))) / widths
    assert np.all(np.abs(at_end - np.roll(rows[:, 2], -1)) <= 1e-9 * np.maximum(steepest, 1.0))
    assert pack_stiffness(pair_case(mesh={"stiffness": table(phases, values)}), 0).highest == pytest.approx(
        np.max(values), rel=1e-12
    )


STEEP = [0.0, 1.0, 1.1, 3.0, 3.1, 5.0], [1e8, 1e8, 1.6e8, 1.6e8, 1e8, 1e8]


def pressed(stiffness: Document, tolerance: float) -> Document:
    """Return a driven pair under a load, 5 N m at 40 teeth of 2 mm."""
    wheel = {"teeth": 40, "mass": 1.0, "inertia": 4e-3, "load": {"torque": 5.0}}
    pinion = {"teeth": 20, "mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": 100.0}}
    mesh = {
        "driver": "a",
        "driven": "b",
        "module": 2e-3,
        "backlash": 1e-4,
        "stiffness": stiffness,
        "damping": {"ratio": 0.07},
    }
    run = {"duration": 0.05, "transient": 0.1, "sampling": 1e5, "tolerance": tolerance}
    return {"rotors": {"a": pinion, "b": wheel}, "meshes": [mesh], "run": run}


def test_steep_table__force_balances_the_load() -> None:
    """A spline of continuous curvature falls to -0.9e8 N/m between these points; the mean force is T / r_b."""
    run = simulate_one(pressed(table(*STEEP), 1e-7))
    force = run.signal("drive_force", "a-b")
    assert run.success
    assert np.min(force) > 0.0
    assert np.mean(force) == pytest.approx(5.0 / (0.04 * math.cos(math.radians(20.0))), rel=2e-3)


def test_a_step_resolves_the_narrowest_peak() -> None:
    """By steps as wide as a peak from its rise to its fall; equal steps by a quarter of the points, rises by no more."""

    def order(phases: Any, values: Any) -> float:
        packed = pack(pair_case(mesh={"stiffness": table(phases, values)}))
        return float(packed.system.records[MESH][0].highest_order)

    assert order(*STEEP) == pytest.approx(1.5)
    peak = [0.0, 1.0, 1.01, 1.02, 3.0, 5.0], [1e8, 1e8, 1.6e8, 1e8, 1e8, 1e8]
    assert order(*peak) == pytest.approx(0.5 / 0.01)
    around = [0.005, 0.01, 3.0, 2.0 * math.pi - 0.005], [1.6e8, 1e8, 1e8, 1e8]
    assert order(*around) == pytest.approx(0.5 / 0.0075)
    dip_of_two_points = [0.0, 0.01, 0.02, 3.0, 5.0], [2e8, 1.5e8, 1e8, 1e8, 2e8]
    assert order(*dip_of_two_points) == pytest.approx(1.25)
    rattling = 2.0 * math.pi * np.arange(24) / 24.0, 1e8 + 1e7 * (-1.0) ** np.arange(24)
    assert order(*rattling) == pytest.approx(6.0)
    plain = 2.0 * math.pi * np.arange(64) / 64.0
    assert order(plain, 1e8 + 1e7 * np.cos(plain)) == pytest.approx(16.0)


def test_a_narrow_peak_is_not_stepped_over() -> None:
    """At a loose tolerance each peak of 1 % of the period gives the pair the impulse that it gives at a tight one."""
    phases, values = [0.0, 3.0, 3.03, 3.06, 4.0, 5.0], [1e8, 1e8, 4e8, 1e8, 1e8, 1e8]
    loose, tight = (
        simulate_one(pressed(table(phases, values), tolerance)).signal("drive_force", "a-b")
        for tolerance in (1e-4, 1e-9)
    )
    assert np.max(np.abs(loose - tight)) < 0.02 * np.max(tight)


def test_points_that_are_too_close_are_refused() -> None:
    """Closer than 1e-9 rad, also from the last point around to the first."""
    near = 2.0 * math.pi - 1e-12
    for phases in ([0.0, 1.0, 1.0 + 1e-12, 3.0], [0.0, 1.0, 2.0, near]):
        with pytest.raises(InputError, match=r"stiffness\.phase.*1e-09 rad"):
            gp.load_case(pair_document(mesh={"stiffness": table(phases, [1e8, 2e8, 1e8, 2e8])}))


def fourier(*amplitudes: float, phase: float = 0.0) -> Document:
    """Return a Fourier stiffness of mean 1e8 N/m and amplitudes over it."""
    terms = [{"order": k, "amplitude": 1e8 * a, "phase": phase} for k, a in enumerate(amplitudes, start=1)]
    return {"kind": "fourier", "mean": 1e8, "terms": terms}


def test_the_terms_of_a_positive_curve_are_taken() -> None:
    """1 + 0.8 cos psi + 0.3 cos 2 psi is lowest at cos psi = -2/3: 1 - 0.3 - 0.8^2 / 2.4 + ... > 0, though 1.1 > 1."""
    packed = pack(pair_case(mesh={"stiffness": fourier(0.8, 0.3)}))
    psi = np.linspace(0.0, 2.0 * math.pi, 2001)
    assert np.min(curve(packed, psi)[0]) == pytest.approx(1e8 * (0.7 - 0.64 / 2.4), rel=1e-5)


@pytest.mark.parametrize("amplitudes", [(1.0,), (0.8, -0.21), (0.9, 0.5, 0.9), (0.0, 0.0, 0.0, 1.01)])
def test_terms_whose_curve_reaches_zero_are_refused(amplitudes: tuple[float, ...]) -> None:
    """The message names the lowest value and where it lies."""
    with pytest.raises(InputError, match=r"stiffness\.terms.*positive: at a mesh phase of .* deg it is"):
        gp.load_case(pair_document(mesh={"stiffness": fourier(*amplitudes)}))


def test_bounds_of_an_error_do_not_depend_on_its_sign() -> None:
    """An amplitude of -5 um is one of 5 um half a wave later, also for what bounds its slope and curvature."""
    signs = ((5e-6, 0.4, 1e-6, 0.0), (-5e-6, 0.4 + math.pi, -1e-6, math.pi))
    records = []
    for a, phase, b, other in signs:
        errors = [
            {"order": 1, "amplitude": a, "phase": phase},
            {"order": 3, "amplitude": b, "phase": other},
        ]
        records.append(pack(pair_case(mesh={"transmission_error": errors})).system.records[MESH][0])
    for field in ("error_slope", "error_curvature"):
        assert records[0][field] == pytest.approx(records[1][field], rel=1e-12)
        assert records[0][field] > 0.0


@pytest.mark.parametrize("seed", range(20))
def test_extremes_are_those_of_the_curve(seed: int) -> None:
    """Against 2001 samples a piece, of pieces with and without turning points, cubic, square and straight."""
    rng = np.random.default_rng(seed)
    pieces = rng.normal(size=(5, 4)) * (rng.random((5, 4)) > 0.3)
    widths = rng.uniform(0.1, 2.0, 5)
    u = np.linspace(0.0, 1.0, 2001)[:, None] * widths
    samples = sum(pieces[:, k] * u**k for k in range(4))
    low, high = extremes(pieces, widths)
    assert low == pytest.approx(np.min(samples), abs=1e-5)
    assert low <= np.min(samples) + 1e-12
    assert high == pytest.approx(np.max(samples), abs=1e-5)
    assert high >= np.max(samples) - 1e-12


def test_a_table_of_torque_peaks_between_its_values() -> None:
    """`check` states the largest torque of the curve, of terms and of the table, and that zeros excite nothing."""
    values = [0.0, 0.0, 4.0, 4.0, 0.0, 0.0]
    peak = TorqueTable.model_validate({"values": values, "sampling": 100.0}).largest()
    assert peak > 4.4
    u = np.linspace(0.0, 1.0, 2001)[:, None] ** np.arange(4)
    assert peak == pytest.approx(np.max(np.abs(u @ cubic_pieces(np.array(values)).T)), rel=1e-6)
    document = pressed({"kind": "harmonic", "mean": 1e8}, 1e-6)
    document["run"]["transient"] = 0.0
    document["rotors"]["b"]["load"]["table"] = {"values": values, "sampling": 100.0}
    document["rotors"]["b"]["load"]["terms"] = [{"order": 1, "amplitude": -2.0}]
    found = [f.message for f in gp.check_case(case_of(document)) if f.path == "run.transient"]
    assert f"torques of up to {5.0 + 2.0 + peak:.4g} N m" in found[0]
    document["rotors"]["b"]["load"] = {"table": {"values": [0.0] * 4, "sampling": 100.0}}
    assert any("nothing excites" in str(f) for f in gp.check_case(case_of(document)))


def test_a_first_blow_is_a_finding_for_every_kind_of_stiffness() -> None:
    """Teeth that meet at v = omega r_b: v sqrt(k m), with the mean of the curve also where the case names none."""
    r_a, r_b = 0.02 * math.cos(math.radians(20.0)), 0.04 * math.cos(math.radians(20.0))
    blow = 100.0 * r_a * math.sqrt(1e8 * 4e-3) / r_b
    for stiffness in ({"kind": "harmonic", "mean": 1e8}, table([0, 1, 2, 4], [1e8] * 4)):
        document = pressed(stiffness, 1e-6)
        document["run"]["transient"] = 0.0
        document["rotors"]["b"]["initial"] = {"omega": 0.0}
        found = [
            str(f)
            for f in gp.check_case(case_of(document))
            if f.path == "meshes.0" and f.severity == "warning"
        ]
        assert len(found) == 1
        assert f"meet at the start with up to {blow:.4g} N" in found[0]
