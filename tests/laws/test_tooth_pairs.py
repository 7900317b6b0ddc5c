"""Pairs of teeth: trajectories of an independent simulation, gaps of outlines, load sharing, deviations, energy, cost."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

import gearplay as gp
from building import Document, Floats, Measured, case_of, merged, simulate_one
from depth import sized
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import load_case
from gearplay.parts.mesh.pairs.overlap import ON_FLANK, pair_overlap, stiffness_at
from gearplay.parts.mesh.train.geometry import pair_of
from gearplay.parts.registry import MESH
from gearplay.toothing.gear import DrawnGear
from gearplay.vocabulary.errors import InputError
from tooth_pairs import document_of, energy_audit, pairs_at, placed

# Planar gears on linear supports, each pair of teeth on its own, both flanks and corners, by SciPy's DOP853 with steps of 2 us at
# most; written apart from this package. Rotations count from a tooth, or a ring's space, on the line of centres; centres from
# their places. module, teeth, shifts, ring, backlash, facewidth, masses, inertias, support k, support c, torques, C, speeds,
# theta_2, tips [SI]; then x, y, theta of both after 6 ms, and how well two of its tolerances agree [rad].
OPEN: list[tuple[Any, ...]] = [
    (
        4e-3, (20, 60), (0, 0), False, 1e-4, 0.01, (1.0, 3.0), (1e-3, 2e-2), (1e8, 1e8), (500.0, 500.0), (60.0, 180.0), 300.0,
        (125.66370614359172, -41.88790204786391), 0.0004434074051982914, (0.044, 0.124),
        (-3.3067454653881707e-06, -8.432664718970612e-06, 0.7542904857104787,
         1.4275948151953877e-06, 3.881349771821734e-06, -0.25082517761545625), 5e-11,
    ),
    (
        3e-3, (12, 24), (0.6, 0.36), False, 6e-5, 0.015, (0.6, 1.8), (2e-4, 3e-3), (5e7, 8e7), (200.0, 200.0), (0.0, 0.0), 100.0,
        (94.24777960769379, -45.623889803846886), 0.0002956049367988378, (0.02242, 0.0397),
        (-1.1175080488865479e-07, -3.147080193728587e-07, 0.5503820613649859,
         -1.4261730923725846e-06, -7.912599129450739e-07, -0.275461682723769), 2e-8,
    ),
    (
        3e-3, (16, 40), (0, 0.5), True, 8e-5, 0.012, (0.8, 2.5), (3e-4, 8e-3), (1e8, 1e8), (300.0, 300.0), (40.0, -100.0), 200.0,
        (157.07963267948966, 62.83185307179586), -0.0007094518483172635, (0.027, 0.0585),
        (-9.143127351868285e-06, -2.0824838710097408e-05, 0.9447764846783571,
         1.314097269872363e-05, 2.7900227517738662e-05, 0.37605535997716943), 5e-11,
    ),
    (
        4e-3, (20, 70), (0.2, 0.2), True, 5e-5, 0.01, (1.0, 4.0), (6e-4, 3e-2), (5e7, 5e7), (100.0, 100.0), (0.0, 0.0), 50.0,
        (62.83185307179586, 17.151958020513103), -0.00015202539606798404, (0.0448, 0.1368),
        (6.792250372145148e-07, -3.170284802426954e-06, 0.36373148031534636,
         8.00724085559672e-07, 3.0456514410645836e-06, 0.10368792897691763), 2e-8,
    ),
]  # fmt: skip


def open_case(row: tuple[Any, ...]) -> tuple[Document, float]:
    """Return a case of `OPEN` and the angle of the second gear at which its drive flanks just touch."""
    (
        module,
        teeth,
        shifts,
        ring,
        backlash,
        width,
        masses,
        inertias,
        k,
        c,
        torques,
        damping,
        speeds,
        theta,
        tips,
    ) = row[:15]
    base = 0.5 * module * teeth[1] * math.cos(math.radians(20.0))
    touching = (-0.5 if ring else 0.5) * backlash / base
    document = document_of(module, teeth, shifts, ring, backlash, width)
    document["meshes"][0]["damping"] = {"kind": "constant", "value": damping}
    document["run"]["duration"] = 6.002e-3
    document["supports"] = {}
    for i, name in enumerate(("one", "two")):
        rotor = document["rotors"][name]
        rotor |= {"mass": masses[i], "inertia": inertias[i], "tip_diameter": 2.0 * tips[i]}
        rotor["initial"] = {"omega": speeds[i], "theta": (0.0, theta - touching)[i]}
        if torques[i]:
            rotor["drive"] = {"kind": "torque", "torque": torques[i]}
        document["supports"][name] = {"stiffness": [k[i], k[i]], "damping": [c[i], c[i]]}
    return document, touching


@pytest.mark.parametrize(
    "row", OPEN, ids=["external-loaded", "external-rattling", "internal-loaded", "internal-back-flank"]
)
def test_trajectories__agree_with_an_independent_simulation(row: tuple[Any, ...], measured: Measured) -> None:
    document, touching = open_case(row)
    run = simulate_one(document)
    found = np.array(
        [run.signal(word, name)[6000] for name in ("one", "two") for word in ("x", "y", "theta")]
    )
    found[5] += touching
    off = np.abs(found - np.array(row[15]))
    measured(
        "pairs of teeth: positions against an independent simulation, m",
        float(off[[0, 1, 3, 4]].max()),
        "1e-9",
    )
    assert off[[0, 1, 3, 4]].max() < 1e-9
    assert off[[2, 5]].max() < max(1e-9, row[16])


def random_pair(rng: np.random.Generator) -> Document:
    """Return a random external or internal pair of gears of a contact ratio of 1 at least."""
    while True:
        ring = bool(rng.integers(2))
        teeth = int(rng.integers(17, 40)), int(rng.integers(60, 110))
        shifts = float(rng.uniform(-0.1, 0.4)), float(rng.uniform(-0.2, 0.4))
        document = document_of(3e-3, teeth, shifts, ring, 0.0, 0.01)
        try:
            pair = pair_of(case_of(document), 0)
        except ValueError:
            continue
        if pair.contact_ratio > 1.1 and pair.path.tip_of_second > 0.3 * pair.first.base_pitch:
            return document


def _tip_distance(gear: DrawnGear, angle: float, point: complex) -> float:
    """Return the distance [m] of a point from the involute flank of a gear that starts at an angle [rad], by minimisation."""
    base = gear.base_radius

    def away(t: float) -> float:
        return abs(point - base * math.sqrt(1.0 + t * t) * np.exp(1j * (angle - (t - math.atan(t)))))

    best = min(np.linspace(0.01, 1.6, 400), key=away)
    found = minimize_scalar(
        away, bounds=(best - 0.01, best + 0.01), method="bounded", options={"xatol": 1e-13}
    )
    return float(found.fun)


def test_gaps__are_distances_of_the_outlines(measured: Measured) -> None:
    """50 random pairs: corners before and after the path against the distance of the tip's point from the other flank."""
    worst, corners = 0.0, 0
    for seed in range(sized(50, 12)):
        case = case_of(random_pair(np.random.default_rng([31, seed])))
        packed, pair = pack(case), pair_of(case, 0)
        first, second, pitch = pair.first, pair.second, pair.first.base_pitch
        for at in (-0.25, -0.1, -0.02, 0.3, 0.7, 1.02, 1.1, 1.25):
            place = pair.path.start + at * pair.path.length if 0.0 < at < 1.0 else (
                pair.path.start + at * pitch if at < 0.0 else pair.path.end + (at - 1.0) * pitch
            )  # fmt: skip
            found = pairs_at(packed, placed(packed, place, 0.0))[0]
            if found.touching == ON_FLANK:
                worst = max(worst, abs(found.p))
                continue
            corners += 1
            zeta_1 = place / first.base_radius - pair.working_angle
            line = pair.base_tangent
            rho_2 = place + line if second.internal else line - place
            zeta_2 = rho_2 / second.base_radius - pair.working_angle
            tip_1 = first.tip * np.exp(1j * (zeta_1 - _inv(first)))
            tip_2 = second.tip * np.exp(1j * (zeta_2 - _inv(second)))
            before = at < 0.0
            if second.internal:
                point = tip_2 - pair.distance if before else tip_1 + pair.distance
            else:
                point = pair.distance - (tip_2 if before else tip_1)
            gap = _tip_distance(first, zeta_1, point) if before else _tip_distance(second, zeta_2, point)
            worst = max(worst, abs(gap + found.p))
    measured("pairs of teeth: gap against distance of outlines, m", worst, "1e-9")
    assert worst < 1e-9
    assert corners > 20


def _inv(gear: DrawnGear) -> float:
    angle = math.acos(gear.base_radius / gear.tip)
    return math.tan(angle) - angle


def shares(packed: Packed, force: float, place: float) -> tuple[float, Floats]:
    """Return the deflection [m] of rigid bodies under a force [N], and the share of each pair in it."""
    (mesh,) = packed.system.records[MESH]
    start = placed(packed, place, 0.0)

    def forces(overlap: float) -> Floats:
        y = start.copy()
        y[5] -= overlap / (mesh.s * mesh.base_2)
        found = pairs_at(packed, y)
        return np.array([stiffness_at(mesh, packed.system, p.place)[0] * max(p.p, 0.0) for p in found])

    deflection = float(brentq(lambda overlap: forces(overlap).sum() - force, 0.0, 2e-4, xtol=1e-15))
    return deflection, np.sort(forces(deflection))[::-1] / force


@pytest.mark.parametrize(
    ("force", "place", "deflection", "largest", "second", "rel"),
    [
        (2000.0, -0.05, 13.646891, 0.892372, 0.107628, 0.02),
        (2000.0, 0.0, 9.012647, 0.585768, 0.414232, 3e-4),
        (2000.0, 0.2, 8.598573, 0.533032, 0.466968, 2e-7),
        (2000.0, 0.69, 9.297392, 0.605847, 0.394153, 2e-7),
        (2000.0, 0.8, 15.214375, 1.0, 0.0, 2e-7),
        (20000.0, 0.8, 103.475849, 0.680119, 0.319881, 2e-7),
    ],
)
def test_sharing__at_rest(
    force: float, place: float, deflection: float, largest: float, second: float, rel: float
) -> None:
    """20/60, module 4 mm, 10 mm wide: numbers of an independent calculation; the entering pair ``place`` pitches from A.

    Beyond the ends of the path tips carry by their corners. The calculation takes a corner's gap before the deflection, which
    turns the entering tip; `gearplay.toothing.load_sharing` does so too.
    """
    packed = pack(case_of(document_of(4e-3, (20, 60), (0, 0), False, 1e-4, 0.01)))
    path = pair_of(case_of(document_of(4e-3, (20, 60), (0, 0), False, 1e-4, 0.01)), 0)
    found, part = shares(packed, force, path.path.start + place * path.first.base_pitch)
    assert 1e6 * found == pytest.approx(deflection, rel=rel)
    assert part[:2] == pytest.approx([largest, second], abs=max(rel, 2e-6))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "with_relief", "without"),
    [(500.0, 1.803375, 1.700907), (2000.0, 6.863305, 6.755947), (8000.0, 26.664868, 26.787499)],
)
def test_tip_relief__in_the_transmission_error_at_rest(
    force: float, with_relief: float, without: float
) -> None:
    """Peak to peak over a pitch; linear relief of 20 um over 4 mm of the path of both gears; independent numbers."""
    relief = {"tip_relief": {"amount": 20e-6, "length": 4e-3}}
    for more, expected in (
        ({}, without),
        ({"rotors": {"one": relief, "two": relief}}, with_relief),
    ):
        document = document_of(4e-3, (20, 60), (0, 0), False, 1e-4, 0.01, **more)
        packed, pair = pack(case_of(document)), pair_of(case_of(document), 0)
        places = pair.path.start + pair.first.base_pitch * np.linspace(0.0, 1.0, 201)[:-1]
        found = [shares(packed, force, float(place))[0] for place in places]
        assert 1e6 * float(np.ptp(found)) == pytest.approx(expected, abs=0.01 * expected)


def test_a_tooth_that_is_advanced__carries_less() -> None:
    """5 um missing on the entering pair: a pitch deviation of one tooth, of the driver or of the driven gear."""
    plain = document_of(4e-3, (20, 60), (0, 0), False, 1e-4, 0.01)
    pair = pair_of(case_of(plain), 0)
    place = pair.path.start + 0.2 * pair.first.base_pitch
    entering = pairs_at(pack(case_of(plain)), placed(pack(case_of(plain)), place, 0.0))[0]
    assert entering.touching == ON_FLANK
    found = []
    for name, teeth in (("one", 20), ("two", 60)):
        for tooth in range(teeth):
            pitch = np.zeros(teeth)
            pitch[tooth] = -5e-6 / math.cos(math.radians(20.0))
            more = {"rotors": {name: {"deviations": {"pitch": pitch.tolist(), "flank": "left"}}}}
            packed = pack(case_of(merged(plain, more)))
            deflection, part = shares(packed, 2000.0, place)
            found.append((name, tooth, 1e6 * deflection, part[0]))
    changed = [each for each in found if abs(each[2] - 8.598573) > 1e-3]
    late = [each for each in changed if each[2] == pytest.approx(10.933414, abs=2e-6)]
    assert {each[0] for each in late} == {"one", "two"}
    assert all(each[3] == pytest.approx(0.677770, abs=2e-6) for each in late)
    assert len(changed) == 4  # two pairs in contact, a tooth of either gear each


def test_deviations__repeat_with_each_gear_and_with_the_hunting_period() -> None:
    """At the same place on the path: the overlaps repeat after lcm(z1, z2) pitches and not before."""
    rng = np.random.default_rng(5)
    document = document_of(4e-3, (18, 60), (0, 0), False, 1e-4, 0.01)
    for name, teeth in (("one", 18), ("two", 60)):
        document["rotors"][name]["deviations"] = {"pitch": (1e-6 * rng.standard_normal(teeth)).tolist()}
    packed = pack(case_of(document))
    (mesh,) = packed.system.records[MESH]
    start = placed(packed, float(mesh.middle), 0.0)
    seen = []
    for turned in range(0, 361):
        y = start.copy()
        y[2] += 2.0 * math.pi * turned / 18.0
        y[5] -= 2.0 * math.pi * turned / 60.0
        seen.append(max(p.p for p in pairs_at(packed, y)))
    repeats = [k for k in range(1, 361) if np.allclose(seen[0], seen[k], atol=1e-12) and
               np.allclose(seen[1 : 361 - k], seen[1 + k : 361], atol=1e-12)]  # fmt: skip
    assert repeats[0] == math.lcm(18, 60)


def test_quality__draws_deviations_that_the_seed_repeats() -> None:
    document = document_of(4e-3, (20, 60), (0, 0), False, 1e-4, 0.01)
    document["rotors"]["one"]["quality"] = 7
    rows = [pack(case_of(merged(document, {"run": {"seed": seed}}))).system.terms for seed in (1, 1, 2)]
    assert np.array_equal(rows[0], rows[1])
    assert not np.array_equal(rows[0], rows[2])
    assert 5e-6 < np.ptp(rows[0][::2, 0]) < 4e-5


def test_quality__gives_each_member_teeth_of_its_own(tmp_path: Path) -> None:
    """A member alone, among others and read from a file has the same motion; members differ by their teeth."""
    case = {"rotors.pinion.quality": 6, "rotors.ring.quality": 6, "run.duration": 0.2, "run.transient": 0.0}
    case = gp.replace(gp.load_case("han2021-pairs"), case)
    both, alone = gp.simulate(case, members=[1, 2]), gp.simulate(case, members=[2])
    both.save(tmp_path / "both.nc")
    read = gp.read_result(tmp_path / "both.nc")
    for name in ("theta", "drive_penetration"):
        found = np.squeeze(both.ds[name].sel(member=2).values)
        assert np.array_equal(found, np.squeeze(alone.ds[name].values))
        assert np.array_equal(found, np.squeeze(read.ds[name].sel(member=2).values))
    terms = [pack(case, member=member).system.terms for member in (1, 2, 2)]
    assert np.array_equal(terms[1], terms[2])
    assert not np.array_equal(terms[0], terms[1])


def test_energy__closes_with_corners_and_deviations(measured: Measured) -> None:
    """Undamped gears on springs: kinetic and elastic energy change by what varying stiffness and deviations put in."""
    document = document_of(4e-3, (20, 60), (0, 0), False, 3e-5, 0.01)
    for name in ("one", "two"):
        document["rotors"][name]["quality"] = 3
    cornered = 0

    def elastic(packed: Packed, out: Floats) -> float:
        nonlocal cornered
        (mesh,), energy = packed.system.records[MESH], 0.0
        for flank in range(2):
            for slot in range(mesh.pairs):
                pair = pair_overlap(mesh, packed.system, out, flank, slot)
                stiffness = stiffness_at(mesh, packed.system, pair.place)[0]
                energy += 0.5 * stiffness * max(pair.p, 0.0) ** 2
                cornered += pair.p > 0.0 and pair.touching != ON_FLANK
        return energy

    _, _, stored, gaps = energy_audit(document, 5e6, elastic)
    worst = float(np.ptp(gaps) / np.max(stored))
    measured("energy audit of pairs of teeth: largest gap over the largest energy", worst, "1e-7")
    assert worst < 1e-7
    assert cornered > 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"meshes": [{"stiffness": {"kind": "harmonic", "mean": 1e8}}]}, "stiffness"),
        (
            {
                "backlash_model": "uncoupled",
                "meshes": [{"contact": "mesh"}],
                "rotors": {"one": {"deviations": {"pitch": [1e-6] * 20}}},
            },
            r"rotors.one.deviations.*backlash_model",
        ),
        ({"backlash_model": "uncoupled"}, "contact"),
        (
            {
                "rotors": {
                    name: {
                        "helix_angle": 0.2,
                        "tip_relief": {"amount": 1e-6, "length": 1e-3},
                        "facewidth": None,
                    }
                    for name in ("one", "two")
                },
                "meshes": [{"contact": "mesh", "stiffness": {"kind": "harmonic", "mean": 1e8}}],
            },
            "facewidth.*tip relief.*helical",
        ),
        (
            {
                "rotors": {
                    name: {"helix_angle": 0.2, "deviations": {"form": [1e-6] * z}}
                    for name, z in (("one", 20), ("two", 60))
                }
            },
            r"deviations.form.*oblique",
        ),
        ({"rotors": {"one": {"deviations": {"pitch": [1e-6, 2e-6]}}}}, "one item for each of the 20 teeth"),
        ({"rotors": {"one": {"quality": 7, "deviations": {}}}}, "quality"),
    ],
)
def test_refusals__name_the_field(change: Document, words: str) -> None:
    document = document_of(4e-3, (20, 60), (0, 0), False, 1e-4, 0.01)
    mesh = {**document["meshes"][0], **change.pop("meshes", [{}])[0]}
    with pytest.raises(InputError, match=words):
        load_case(merged(merged(document, change), {"meshes": [mesh]}))


def test_many_pairs__share_the_load_at_once() -> None:
    """A wide helical pair: seven pairs in contact; slots, modes and slopes by the case; forces add up to the load."""
    document = document_of(4e-3, (40, 80), (0, 0), False, 1e-4, 0.15)
    for name in ("one", "two"):
        document["rotors"][name]["helix_angle"] = math.radians(25.0)
    del document["meshes"][0]["center_distance"]
    for name in ("one", "two"):
        del document["rotors"][name]["position"]
    document["rotors"]["one"] |= {"drive": {"kind": "speed", "speed": 20.0}}
    document["rotors"]["two"] |= {"load": {"torque": 500.0}}
    document["meshes"][0] |= {"damping": {"ratio": 0.3}, "friction_coefficient": 0.0}
    document["run"] |= {"transient": 0.05, "duration": 0.01, "sampling": 1e4, "tolerance": 1e-7}
    packed, pair = pack(case_of(document)), pair_of(case_of(document), 0)
    (mesh,) = packed.system.records[MESH]
    assert mesh.pairs > 6
    run = simulate_one(document)
    slots = [f"one-two:drive-{k}" for k in range(mesh.pairs)]
    forces = np.array([run.signal("pair_force", name) for name in slots])
    total = pair.contact_ratio + pair.overlap_ratio
    carrying = np.sum(forces > 0.0, axis=0)
    assert {int(np.min(carrying)), int(np.max(carrying))} <= {math.floor(total), math.ceil(total)}
    assert np.max(carrying) > 4
    assert np.mean(forces.sum(axis=0)) == pytest.approx(500.0 / pair.second.base_radius, rel=1e-3)


def test_pitch_deviation_of_a_helical_tooth__shifts_its_pair() -> None:
    """Constant along the oblique line of contact: the overlap of its pair alone changes by it, wherever the line is."""
    document = document_of(4e-3, (20, 60), (0, 0), False, 1e-4, 0.03)
    for name, z in (("one", 20), ("two", 60)):
        document["rotors"][name] |= {"helix_angle": 0.2, "teeth": z}
        del document["rotors"][name]["position"]
    del document["meshes"][0]["center_distance"]
    pitch = np.zeros(20)
    pitch[0] = -5e-6
    deviating = merged(document, {"rotors": {"one": {"deviations": {"pitch": pitch.tolist()}}}})
    transverse = pair_of(case_of(document), 0).first.transverse_angle
    seen = set()
    for share in np.linspace(0.0, 1.0, 9):
        plain = pack(case_of(document))
        path = pair_of(case_of(document), 0).path
        y = placed(plain, path.start + float(share) * path.length, 1e-5)
        off = [
            a.p - b.p for a, b in zip(pairs_at(pack(case_of(deviating)), y), pairs_at(plain, y), strict=True)
        ]
        seen.update(round(1e9 * each, 3) for each in off)
    assert seen <= {0.0, round(-5e3 * math.cos(transverse), 3), -0.0}
    assert len(seen) == 2
