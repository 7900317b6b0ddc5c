"""Deviations of teeth in a mesh with one stiffness: the envelope over its pairs."""

import math
from typing import Any

import numpy as np
import pytest

from building import Document, Floats, Measured, case_of, merged, mesh_at, simulate_one
from gearplay.model.pack import Packed, pack
from gearplay.parts.mesh.geometry import PSI
from gearplay.parts.mesh.pairs.overlap import ON_FLANK, pair_overlap
from gearplay.parts.mesh.tooth_stiffness import mesh_stiffness
from gearplay.parts.mesh.train.geometry import pair_of
from gearplay.parts.registry import MESH
from tooth_pairs import document_of, energy_audit, pairs_at, placed

HARMONIC: Document = {"kind": "harmonic", "mean": 1.6e8, "amplitude": 3e7}


def one_stiffness(*, ring: bool = False, **rotors: Any) -> Document:
    """Return a pair with one stiffness for all pairs of teeth; fields of both gears by name."""
    document = document_of(4e-3, (20, 60), (0.0, 0.3 if ring else 0.0), ring, 1e-4, 0.01)
    document["meshes"][0] |= {
        "contact": "mesh",
        "stiffness": HARMONIC,
        "damping": {"maximum": 300.0, "depth": 1e-6},
    }
    for name, more in rotors.items():
        document["rotors"][name] |= more
    return document


def overlaps_over_a_turn(packed: Packed, teeth: int, step: float) -> Floats:
    """Return the largest overlap of the drive flank [m] where its involutes touch, every ``step`` base pitches over ``teeth``."""
    (mesh,) = packed.system.records[MESH]
    start = placed(packed, float(mesh.middle), 0.0)
    found = []
    for ways in np.arange(0.0, teeth, step):
        y = start.copy()
        y[2] += ways * mesh.base_pitch / mesh.base_1
        y[5] += mesh.s * ways * mesh.base_pitch / mesh.base_2
        found.append(max(each.penetration for each in pairs_at(packed, y)))
    return np.array(found)


@pytest.mark.parametrize("name", ["one", "two"])
@pytest.mark.parametrize("ring", [False, True], ids=["external", "internal"])
def test_a_tooth_with_more_material__shows_once_a_turn(name: str, ring: bool) -> None:
    """5 um along the line of action on one tooth: full between where it enters and leaves, nowhere else in the turn."""
    teeth, plus = {"one": 20, "two": 60}[name], 5e-6
    pitch = np.zeros(teeth)
    # Counter-clockwise the drive flanks of a ring that is driven lose material.
    pitch[teeth // 3] = (-1.0 if ring and name == "two" else 1.0) * plus / math.cos(math.radians(20.0))
    document = one_stiffness(ring=ring, **{name: {"deviations": {"pitch": pitch.tolist()}}})
    case = case_of(document)
    packed, pair = pack(case), pair_of(case, 0)
    found = np.roll(overlaps_over_a_turn(packed, teeth, 0.05), 10)
    found = np.roll(found, -int(np.argmin(found)))
    shows = found > 1e-9
    assert np.sum(np.diff(shows.astype(int)) == 1) == 1
    assert np.max(found) == pytest.approx(plus, rel=1e-6)
    assert np.sum(found > plus - 1e-9) * 0.05 == pytest.approx(pair.contact_ratio, abs=0.11)
    assert np.sum(shows) * 0.05 < pair.contact_ratio + 0.6
    assert np.min(found) > -1e-11


def test_no_deviations__have_the_same_bits() -> None:
    zero = {"deviations": {"pitch": [0.0] * 20}, "tip_relief": {"amount": 0.0, "length": 1e-3}}
    drive = {"drive": {"kind": "speed", "speed": 60.0}}
    plain, with_zero = one_stiffness(one=drive), one_stiffness(one=drive | zero)
    for document in (plain, with_zero):
        document["rotors"]["two"]["load"] = {"torque": 20.0}
        document["run"] |= {"sampling": 1e5, "tolerance": 1e-6}
    runs = [simulate_one(document) for document in (plain, with_zero)]
    for word in ("drive_penetration", "drive_force", "transmission_error_dynamic"):
        assert np.array_equal(*(run.signal(word, "one-two") for run in runs))
    # And of deviations that vanish the motion is that limit.
    small = merged(
        plain, {"rotors": {"one": {"deviations": {"pitch": [1e-13 * (-1) ** k for k in range(20)]}}}}
    )
    near = simulate_one(small)
    off = near.signal("transmission_error_dynamic", "one-two") - runs[0].signal(
        "transmission_error_dynamic", "one-two"
    )
    assert 0.0 < np.max(np.abs(off)) < 1e-10


@pytest.mark.parametrize("ring", [False, True], ids=["external", "internal"])
def test_light_load__has_the_transmission_error_of_pairs_and_of_the_envelope(
    ring: bool, measured: Measured
) -> None:
    """Both gears of class 6 on fixed centres, turned slowly: one pair carries, with either contact the one of most material."""
    drawn = {"quality": 6}
    document = one_stiffness(ring=ring, one=drawn | {"drive": {"kind": "speed", "speed": 2.0}}, two=drawn)
    document["rotors"]["two"] |= {"load": {"torque": 0.5}, "inertia": 1e-4}
    period = 2.0 * math.pi / 40.0
    document["run"] = {
        "transient": 0.2 * period,
        "duration": 1.5 * period,
        "sampling": 100.0 / period,
        "tolerance": 1e-7,
    }
    pairs = merged(document, {})
    pairs["meshes"] = [
        document["meshes"][0] | {"contact": "pairs", "stiffness": {"kind": "teeth", "method": "iso6336"}}
    ]
    runs = [simulate_one(each) for each in (document, pairs)]
    one, other = (run.signal("transmission_error_dynamic", "one-two") for run in runs)
    packed = pack(case_of(document))
    (mesh,) = packed.system.records[MESH]
    y = np.zeros(packed.state_size)
    speeds = packed.system.rotors["nominal_speed"]
    still = []
    for k in range(0, one.size, 10):
        t = float(runs[0].time[k])
        for i, name in enumerate(("one", "two")):
            y[3 * i + 2] = runs[0].signal("theta", name)[k] - speeds[i] * t
        out = mesh_at(packed, 0, y, t)
        deviation = max(
            pair_overlap(mesh, packed.system, out, 0, slot).penetration for slot in range(mesh.pairs)
        )
        still.append(one[k] - deviation)  # the rolled way at which the deepest pair just touches
    ripple = float(np.ptp(one))
    off = float(np.max(np.abs(one - other)))
    measured(
        "envelope: transmission error against that of pairs at light load, of its range", off / ripple, "0.05"
    )
    assert ripple > 3e-6
    assert off < 0.05 * ripple
    assert np.max(np.abs(np.array(still) - one[::10])) < 0.05 * ripple


@pytest.mark.parametrize(
    "changes",
    [{"damping": {"maximum": 0.0}}, {"friction_coefficient": 0.1, "friction_speed": 0.05}],
    ids=["conservative", "damping-and-friction"],
)
def test_energy__closes(changes: Document, measured: Measured) -> None:
    """Gears on springs: kinetic and elastic energy change by what deviations put in and damping and friction take.

    Powers jump where another pair leads, somewhere within a sample of the quadrature.
    """
    document = one_stiffness(one={"quality": 5}, two={"quality": 5})
    document["meshes"][0] |= {"backlash": 3e-5, **changes}
    cornered = 0

    def elastic(packed: Packed, out: Floats) -> float:
        nonlocal cornered
        (mesh,) = packed.system.records[MESH]
        k, energy = mesh_stiffness(mesh, packed.system, out[PSI], np.cos(out[PSI]), np.sin(out[PSI]), 0), 0.0
        for flank in range(2):
            each = [pair_overlap(mesh, packed.system, out, flank, slot) for slot in range(mesh.pairs)]
            lead = max(each, key=lambda pair: pair.penetration)
            energy += 0.5 * k * max(lead.penetration, 0.0) ** 2
            cornered += lead.penetration > 0.0 and lead.touching != ON_FLANK
        return energy

    run, power, stored, gaps = energy_audit(document, 1e7, elastic)
    jumps = np.abs(np.diff(power))
    sharp = jumps[1:-1] > 5.0 * np.maximum(jumps[:-2], jumps[2:])
    unknown = float(np.sum(jumps[1:-1][sharp])) / run.sampling  # J, what the places of the jumps leave open
    worst = (float(np.ptp(gaps)) - unknown) / float(np.max(stored))
    measured("energy audit of the envelope: largest gap over the largest energy", worst, "1e-7")
    assert unknown < 2e-6 * np.max(stored)
    assert worst < 1e-7
    assert cornered > 0
    assert (float(np.max(run.signal("mesh_power_loss", "one-two"))) > 1.0) == (
        "friction_coefficient" in changes
    )
