"""Tip relief and profile deviations along the oblique lines of contact of helical pairs."""

import math

import numpy as np
import pytest

from building import Document, Floats, Measured, case_of, merged, mesh_at, simulate_one
from depth import sized
from gearplay.model.pack import Packed, pack
from gearplay.parts.mesh.geometry import P_D
from gearplay.parts.mesh.pairs.forces import oblique_sums
from gearplay.parts.mesh.pairs.overlap import AWAY, Pair, pair_overlap, pair_stiffness
from gearplay.parts.registry import MESH
from helical_pairs import Width, helical, random_helical
from tooth_pairs import document_of, energy_audit, pairs_at, placed

RELIEF: Document = {"amount": 2e-5, "length": 3e-3}


def force_of(packed: Packed, pair: Pair) -> float:
    """Return the elastic force [N] of a pair of a drive flank at rest."""
    (mesh,) = packed.system.records[MESH]
    if mesh.varies == 1:
        return float(oblique_sums(mesh, packed.system, 0, pair, 0.0, 0.0, 0.0, 0.0).force)
    return float(pair_stiffness(mesh, packed.system, 0, pair)[0] * pair.p)


def test_forces__are_integrals_over_the_facewidth(measured: Measured) -> None:
    """Random pairs against sums of 200 000 points: forces, and penetrations against the least that is missing."""
    worst, off, partly = 0.0, 0.0, 0
    for seed in range(sized(40, 8)):
        rng = np.random.default_rng([77, seed])
        document = random_helical(rng)
        packed, width = pack(case_of(document)), Width(document)
        (mesh,) = packed.system.records[MESH]
        for _ in range(3):
            place = mesh.path_start + rng.uniform(-0.6, 1.2) * (mesh.path_end - mesh.path_start)
            y = placed(packed, float(place), float(rng.uniform(0.0, 4e-5)))
            overlap = float(mesh_at(packed, 0, y)[P_D])
            for pair in pairs_at(packed, y):
                x, step = width.line(pair.place)
                if pair.touching == AWAY or step == 0.0:
                    continue
                missing = width.missing(x, pair.rho_1, pair.rho_2)
                off = max(off, abs(pair.p - (overlap - float(np.min(missing)))))
                if pair.p > 0.0:
                    expected = width.force(pair, overlap)
                    worst = max(worst, abs(force_of(packed, pair) - expected) / (expected + 1e-2))
                    partly += bool(0.0 < np.mean(missing < overlap) < 1.0)
    measured("helical relief: force against a sum over the facewidth, relative", worst, "1e-9")
    assert worst < 1e-9
    assert off < 1e-9  # the spacing of the points
    assert partly > 5


def test_vanishing_relief__is_none() -> None:
    """Relief of no amount has the same bits; of 1e-16 m the forces to 1e-10 of themselves, by the other integral."""
    plain = helical(0.3, 0.03)
    none = helical(0.3, 0.03, one={"tip_relief": {**RELIEF, "amount": 0.0}})
    little = helical(0.3, 0.03, one={"tip_relief": {**RELIEF, "amount": 1e-16}})
    packed = [pack(case_of(document)) for document in (plain, none, little)]
    path = packed[0].system.records[MESH][0]
    for share in np.linspace(-0.4, 1.4, 13):
        y = placed(packed[0], float(path.path_start + share * (path.path_end - path.path_start)), 2e-5)
        forces = [[force_of(each, pair) for pair in pairs_at(each, y)] for each in packed]
        assert forces[0] == forces[1]
        assert forces[2] == pytest.approx(forces[0], rel=1e-10, abs=1e-6)


@pytest.mark.parametrize("ring", [False, True], ids=["external", "internal"])
@pytest.mark.parametrize("shape", ["linear", "parabolic"])
def test_a_vanishing_helix_angle__has_the_forces_of_spur_gears(shape: str, ring: bool) -> None:
    relief = {"tip_relief": {**RELIEF, "shape": shape}, "deviations": {"slope": [3e-6] * 20}}
    other = {"tip_relief": {**RELIEF, "length": 2e-3}}
    found = []
    for helix in (0.0, 1e-5):
        document = helical(helix, 0.02, ring=ring, one=relief, two=other)
        document["meshes"][0]["tip_contact"] = False
        packed = pack(case_of(document))
        (mesh,) = packed.system.records[MESH]
        assert mesh.varies == (helix > 0.0)
        forces = []
        for share in np.linspace(0.02, 0.98, 23):
            place = mesh.path_start + share * (mesh.path_end - mesh.path_start)
            forces.append(force_of(packed, pairs_at(packed, placed(packed, float(place), 4e-5))[0]))
        found.append(np.array(forces))
    assert found[1] == pytest.approx(found[0], rel=1e-4)
    assert np.ptp(found[0]) > 0.2 * np.max(found[0])


def test_pitch_deviations__move_the_whole_line() -> None:
    """An advanced tooth with relief: the penetration and the force of its pair are those of as much more overlap."""
    document = helical(0.3, 0.03, one={"tip_relief": RELIEF}, two={"tip_relief": RELIEF})
    pitch = [0.0] * 20
    pitch[0] = 4e-6
    more = merged(document, {"rotors": {"one": {"deviations": {"pitch": pitch}}}})
    packed = pack(case_of(document)), pack(case_of(more))
    (mesh,) = packed[0].system.records[MESH]
    seen = 0
    for share in np.linspace(-0.3, 1.3, 17):
        y = placed(packed[0], float(mesh.path_start + share * (mesh.path_end - mesh.path_start)), 1e-5)
        for a, b in zip(pairs_at(packed[0], y), pairs_at(packed[1], y), strict=True):
            if a.touching == AWAY or b.p == a.p:
                continue
            advanced = b.p - a.p
            assert advanced == pytest.approx(4e-6 * math.cos(pitch_angle(document)), rel=1e-6)
            if b.p > 0.0:
                seen += 1
                assert force_of(packed[1], b) == pytest.approx(
                    Width(document).force(a, 1e-5 + advanced), rel=1e-8
                )
    assert seen > 3


def pitch_angle(document: Document) -> float:
    """Return the transverse pressure angle [rad]."""
    return Width(document).pair.first.transverse_angle


@pytest.mark.parametrize(
    "damping",
    [{"maximum": 0.0}, {"maximum": 300.0, "depth": 2e-6}],
    ids=["conservative", "damped"],
)
def test_energy__closes(damping: Document, measured: Measured) -> None:
    """Helical gears on springs: energy changes by what relief and slopes put in and damping takes; the teeth's by brute force."""
    document = helical(0.3, 0.02, one={"deviations": {"slope": [2e-6] * 20}})
    document["meshes"][0] |= {"backlash": 3e-5, "damping": damping}
    widths: list[Width] = []

    def elastic(packed: Packed, out: Floats) -> float:
        (mesh,), energy = packed.system.records[MESH], 0.0
        widths.extend([] if widths else [Width(document)])
        assert mesh.varies == 1
        for flank in range(2):
            for slot in range(mesh.pairs):
                pair = pair_overlap(mesh, packed.system, out, flank, slot)
                if pair.touching != AWAY and pair.p > 0.0:
                    energy += 0.5 * widths[0].force(pair, float(out[P_D + flank]), 2)
        return energy

    run, _, stored, gaps = energy_audit(document, 2e6, elastic)
    worst = float(np.ptp(gaps) / np.max(stored))
    measured("energy audit of helical relief: largest gap over the largest energy", worst, "1e-7")
    assert worst < 1e-7
    assert (float(np.max(run.signal("mesh_power_loss", "one-two"))) > 0.1) == (damping["maximum"] > 0.0)


def test_envelope__touches_with_the_deepest_point_of_the_width() -> None:
    """One stiffness: tip relief of a wide pair takes nothing where a part of some line of contact is unrelieved."""
    longer = {"tip_relief": {**RELIEF, "length": 6e-3}}
    document = helical(0.4, 0.06, one=longer, two=longer)
    document["meshes"][0] |= {"contact": "mesh", "stiffness": {"kind": "harmonic", "mean": 2e8}}
    packed = pack(case_of(document))
    (mesh,) = packed.system.records[MESH]
    assert mesh.envelope == 1
    deepest = []
    for share in np.linspace(0.0, 1.0, 11):
        y = placed(packed, float(mesh.middle + share * mesh.base_pitch), 1e-5)
        deepest.append(max(pair.penetration for pair in pairs_at(packed, y)))
    assert deepest == pytest.approx([1e-5] * 11, abs=1e-12)
    spur = document_of(4e-3, (20, 60), (0.0, 0.1), False, 1e-4, 0.06)
    for name in ("one", "two"):
        spur["rotors"][name]["tip_relief"] = {**RELIEF, "length": 5e-3}
    spur["meshes"][0] |= {"contact": "mesh", "stiffness": {"kind": "harmonic", "mean": 2e8}}
    packed = pack(case_of(spur))
    y = placed(packed, float(packed.system.records[MESH][0].middle + 0.5 * mesh.base_pitch), 1e-5)
    assert max(pair.penetration for pair in pairs_at(packed, y)) < 8e-6


def test_mean_forces__balance_the_torque_with_and_without_relief() -> None:
    """A loaded pair in motion."""
    means = []
    for amount in (0.0, 1.5e-5):
        relief = {"tip_relief": {"amount": amount, "length": 3e-3}}
        document = helical(0.3, 0.02, one=relief, two=relief)
        document["rotors"]["one"]["drive"] = {"kind": "speed", "speed": 20.0}
        document["rotors"]["two"]["load"] = {"torque": 200.0}
        document["meshes"][0] |= {"damping": {"ratio": 0.3}}
        document["run"] |= {"transient": 0.04, "duration": 0.016, "sampling": 2e4, "tolerance": 1e-7}
        run = simulate_one(document)
        means.append(float(np.mean(run.signal("drive_force", "one-two"))))
    base = Width(helical(0.3, 0.02)).pair.second.base_radius
    assert means == pytest.approx([200.0 / base] * 2, rel=2e-3)
