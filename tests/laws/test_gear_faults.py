"""Faults of gears with pairs of teeth: what each kind changes in pairs of its tooth, against closed forms, and in a motion."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PPoly
from scipy.optimize import minimize_scalar

from building import Document, Floats, case_of, merged, mesh_at, simulate_one
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import load_case
from gearplay.parts.mesh.geometry import P_D
from gearplay.parts.mesh.pairs.overlap import pair_overlap, pair_stiffness, teeth_of_pair
from gearplay.parts.mesh.pairs.tooth_rows import profile_pieces, steepness
from gearplay.parts.mesh.train.geometry import pair_of
from gearplay.parts.registry import MESH
from gearplay.toothing.cracks import Crack, crack_losses
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair
from gearplay.vocabulary.errors import InputError
from tooth_pairs import document_of, pairs_at

TEETH = (20, 60)
BORES = (0.03, 0.06)
NORMAL = math.cos(math.radians(20.0))


def document(faults: list[Document] | None = None, **more: Any) -> Document:
    """Return two gears 20/60 of module 4 mm, 10 mm wide, with bores and faults."""
    found = document_of(4e-3, TEETH, (0, 0), False, 1e-4, 0.01, **more)
    for name, bore in zip(("one", "two"), BORES, strict=True):
        found["rotors"][name]["bore"] = bore
    return {**found, "faults": faults or []}


def touching_at(packed: Packed, flank: int, place: float) -> Floats:
    """Return a state with the pair of slot 0 of a flank at a place of the driver's path [m], its involutes just in touch."""
    (mesh,) = packed.system.records[MESH]
    y = np.zeros(packed.state_size)
    forwards = 1.0 - 2.0 * flank
    for _ in range(3):
        pair = pair_overlap(mesh, packed.system, mesh_at(packed, 0, y), flank, 0)
        y[2] += forwards * (place - pair.place) / mesh.base_1
        y[5] -= forwards * mesh_at(packed, 0, y)[P_D + flank] / mesh.base_2
    return y


def passages(document: Document, x: float, gear: int = 0, flank: int = 0) -> Floats:
    """Return what each tooth of a gear does at x of its path, from 0 at the root end to 1 at the tip, whatever tooth it meets.

    Stiffness of its pair [N/m] and overlap [m], shape [tooth, 2].
    """
    case = case_of(document)
    packed, path = pack(case), pair_of(case, 0).path
    (mesh,) = packed.system.records[MESH]
    place = path.start + (x if gear == 0 else 1.0 - x) * path.length
    start = touching_at(packed, flank, place)
    found: dict[int, list[tuple[float, float]]] = {}
    for turned in range(60):  # three turns of the pinion, one of the wheel
        y = start.copy()
        y[2] += 2.0 * math.pi * turned / TEETH[0]
        y[5] -= 2.0 * math.pi * turned / TEETH[1]
        for pair in pairs_at(packed, y, flank):
            if abs(pair.place - place) < 1e-9:
                tooth = teeth_of_pair(mesh, flank, pair.number)[gear]
                stiffness, _, _ = pair_stiffness(mesh, packed.system, flank, pair)
                found.setdefault(tooth, []).append((stiffness, pair.p))
    assert sorted(found) == list(range(TEETH[gear]))
    each = np.array([found[tooth][0] for tooth in sorted(found)])
    for tooth, seen in found.items():
        assert np.allclose(seen, each[tooth], rtol=1e-9, atol=1e-12)
    return each


def changes(fault: Document, x: float, gear: int = 0, flank: int = 0, **more: Any) -> Floats:
    """Return the share of stiffness lost and the material missing [m] of each tooth of a gear by a fault, shape [tooth, 2]."""
    healthy, faulty = (passages(document(each, **more), x, gear, flank) for each in ([], [fault]))
    return np.column_stack([1.0 - faulty[:, 0] / healthy[:, 0], healthy[:, 1] - faulty[:, 1]])


def single(value: float, tooth: int, teeth: int = TEETH[0]) -> Floats:
    """Return a value for one tooth and 0 for the others."""
    return np.where(np.arange(teeth) == tooth, value, 0.0)


LOSSES = [
    (0.5e-3, (0.130, 0.291, 0.695)),
    (1.0e-3, (0.613, 1.543, 4.019)),
    (1.5e-3, (1.245, 3.248, 8.603)),
    (2.0e-3, (1.786, 4.825, 13.360)),
    (2.5e-3, (2.412, 6.639, 18.823)),
]
"""Depth of a crack of a pinion tooth under 45 deg [m]; percent of stiffness lost at root end, middle and tip of its path."""


@pytest.mark.parametrize("method", ["iso6336", "potential-energy"])
@pytest.mark.parametrize(("depth", "losses"), LOSSES)
def test_crack__takes_stiffness_from_its_tooth(depth: float, losses: tuple[float, ...], method: str) -> None:
    stiffness = {"kind": "teeth", "method": method, "line_load": 1e6}
    meshes = [{**document()["meshes"][0], "stiffness": stiffness}]
    crack = {"kind": "crack", "at": "one", "tooth": 3, "depth": depth, "angle": math.radians(45.0)}
    for x, lost in zip((0.0, 0.5, 1.0), losses, strict=True):
        found = changes(crack, x, meshes=meshes)
        assert 100.0 * found[:, 0] == pytest.approx(single(lost, 3), abs=0.01)
        assert found[:, 1] == pytest.approx(np.zeros(TEETH[0]), abs=1e-12)


def test_crack__of_the_driven_gear_goes_by_its_own_path() -> None:
    first, second = (
        DrawnGear(teeth=z, module=4e-3, facewidth=0.01, bore=bore)
        for z, bore in zip(TEETH, BORES, strict=True)
    )
    pair = GearPair(first, second, 0.16)
    ends = np.array([pair.path.end, pair.path.start])  # root end and tip of the wheel's tooth
    expected = crack_losses(pair, 1, Crack(2e-3, math.radians(45.0)), ends, 206e9, 0.3)
    crack = {"kind": "crack", "at": "two", "tooth": 41, "depth": 2e-3}
    for x, lost in zip((0.0, 1.0), expected, strict=True):
        assert changes(crack, x, 1)[:, 0] == pytest.approx(single(lost, 41, TEETH[1]), abs=1e-9)
    assert expected[1] > 4.0 * expected[0]


def test_crack__of_one_flank_leaves_the_other() -> None:
    crack = {"kind": "crack", "at": "one", "tooth": 3, "depth": 2e-3}
    for side, lost in (("left", (True, False)), ("right", (False, True)), ("both", (True, True))):
        found = [changes({**crack, "flank": side}, 0.7, 0, flank)[3, 0] > 0.01 for flank in (0, 1)]
        assert found == list(lost)


def test_chip__takes_its_share_above_its_height() -> None:
    chip = {"kind": "chip", "at": "one", "tooth": 7, "share": 0.4, "height": 0.6}
    for x, lost in ((0.0, 0.0), (0.6, 0.2), (0.62, 0.4), (1.0, 0.4)):
        for flank in (0, 1):
            assert changes(chip, x, 0, flank)[:, 0] == pytest.approx(single(lost, 7), abs=1e-7)


def test_spall__is_missing_between_its_ends_of_one_flank() -> None:
    spall = {"kind": "spall", "at": "two", "tooth": 11, "depth": 20e-6, "start": 0.3, "end": 0.5}
    for x, missing in ((0.28, 0.0), (0.3, 10e-6), (0.4, 20e-6), (0.52, 0.0)):
        for flank in (0, 1):  # both gears drive by their counter-clockwise flanks, the left ones
            side, other = ("left", "right") if flank == 0 else ("right", "left")
            found = changes({**spall, "flank": side}, x, 1, flank)[:, 1]
            assert found == pytest.approx(single(missing, 11, TEETH[1]), abs=1e-11)
            assert np.all(np.abs(changes({**spall, "flank": other}, x, 1, flank)[:, 1]) < 1e-12)


def test_missing_tooth__never_touches() -> None:
    missing = {"kind": "missing-tooth", "at": "one", "tooth": 5}
    for x in (0.05, 0.5, 0.95):
        for flank in (0, 1):
            overlap = passages(document([missing]), x, 0, flank)[:, 1]
            assert overlap[5] < -0.05
            assert np.delete(overlap, 5) == pytest.approx(np.zeros(TEETH[0] - 1), abs=1e-12)


def test_pitch__moves_one_tooth_counter_clockwise() -> None:
    """A counter-clockwise flank stands ahead by cos(20 deg) of the offset along the normal, a clockwise one behind."""
    for name, gear, teeth in (("one", 0, TEETH[0]), ("two", 1, TEETH[1])):
        pitch = {"kind": "pitch", "at": name, "tooth": 3, "offset": 8e-6}
        for flank in (0, 1):
            missing = (2.0 * flank - 1.0) * 8e-6 * NORMAL
            found = changes(pitch, 0.4, gear, flank)
            assert found[:, 1] == pytest.approx(single(missing, 3, teeth), abs=1e-11)
            assert np.all(np.abs(found[:, 0]) < 1e-12)


def test_wear__of_all_teeth_vanishes_at_half_of_the_path() -> None:
    wear = {"kind": "wear", "at": "one", "depth": 30e-6}
    for x in (0.0, 0.2, 0.5):
        expected = np.full(TEETH[0], 30e-6 * (2.0 * x - 1.0) ** 2)
        assert changes(wear, x)[:, 1] == pytest.approx(expected, abs=1e-11)
        assert np.all(np.abs(changes(wear, x, 0, 1)[:, 1]) < 1e-12)


PROFILE = [[0.1, 0.0], [0.3, 12e-6], [0.5, 3e-6], [0.6, 9e-6]]


def test_worn_profile__is_missing_at_its_points_and_held_beyond_them() -> None:
    """All teeth of the flank alike; it adds to wear by depth, and its cubics stay between their points."""
    worn = {"kind": "wear", "at": "two", "profile": PROFILE}
    for x, missing in ((0.0, 0.0), (0.1, 0.0), (0.3, 12e-6), (0.5, 3e-6), (0.6, 9e-6), (0.9, 9e-6)):
        assert changes(worn, x, 1)[:, 1] == pytest.approx(np.full(TEETH[1], missing), abs=1e-11)
        assert np.all(np.abs(changes(worn, x, 1, 1)[:, 1]) < 1e-12)
    assert 3e-6 < changes(worn, 0.4, 1)[0, 1] < 12e-6
    both = [worn, {"kind": "wear", "at": "two", "depth": 30e-6}]
    apart = passages(document(), 0.3, 1)[:, 1] - passages(document(both), 0.3, 1)[:, 1]
    assert apart == pytest.approx(np.full(TEETH[1], 12e-6 + 30e-6 * 0.16), abs=1e-11)


def test_steepness__of_a_worn_profile_is_that_of_its_cubics() -> None:
    pieces = profile_pieces(tuple((x, depth) for x, depth in PROFILE))
    rows = np.zeros((2, 5, 3))
    rows[1, 4, :2] = 0.0, len(pieces) - 1
    slope, bend = steepness(rows.reshape(-1, 3), 1, pieces.tolist())
    curve = PPoly(pieces[:-1, 4:0:-1].T, pieces[:, 0])
    x = np.linspace(0.1, 0.6, 200_001)
    assert slope == pytest.approx(np.max(np.abs(curve(x, 1))), rel=1e-6)
    assert bend == pytest.approx(np.max(np.abs(curve(x, 2))), rel=1e-3)
    assert curve([0.1, 0.6], 1) == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("contact", ["mesh", "pairs"])
def test_eccentricity__adds_to_runout_as_vectors(contact: str) -> None:
    meshes = [{**document()["meshes"][0], "contact": contact}]
    runout: Document = {"rotors": {"one": {"runout": {"amplitude": 3e-5, "phase": 0.0}}}}
    across = {"kind": "eccentricity", "at": "one", "amount": 4e-5, "phase": 0.5 * math.pi}
    both: Document = {"rotors": {"one": {"runout": {"amplitude": 5e-5, "phase": math.atan2(4.0, 3.0)}}}}
    records = [
        pack(case_of(each)).system.records[MESH][0]
        for each in (document([across], meshes=meshes, **runout), document(meshes=meshes, **both))
    ]
    found, expected = ([float(mesh[k]) for k in ("runout_a", "runout_phase_a")] for mesh in records)
    assert found == pytest.approx(expected, rel=1e-12)
    assert found[0] == pytest.approx(5e-5, rel=1e-12)


def test_faults__of_one_tooth_add_up() -> None:
    """Losses multiply, material missing adds to the deviations of the gear."""
    pitch = (1e-6 * np.random.default_rng(3).standard_normal(TEETH[0])).tolist()
    deviating: Document = {"rotors": {"one": {"deviations": {"pitch": pitch}}}}
    crack = {"kind": "crack", "at": "one", "tooth": 3, "depth": 2e-3}
    chip = {"kind": "chip", "at": "one", "tooth": 3, "share": 0.4, "height": 0.6}
    wear = {"kind": "wear", "at": "one", "depth": 30e-6}
    offset = {"kind": "pitch", "at": "one", "tooth": 3, "offset": 8e-6}
    plain = passages(document(**deviating), 0.8)
    found = passages(document([crack, chip, wear, offset], **deviating), 0.8)
    lost = changes(crack, 0.8)[3, 0]
    assert found[3, 0] / plain[3, 0] == pytest.approx((1.0 - lost) * 0.6, rel=1e-9)
    missing = 30e-6 * 0.36 - single(8e-6 * NORMAL, 3)
    assert plain[:, 1] - found[:, 1] == pytest.approx(missing, abs=1e-11)


CRACK = {"kind": "crack", "at": "one", "tooth": 3, "depth": 1e-3}
HELICAL = {name: {"helix_angle": math.radians(10.0)} for name in ("one", "two")}


@pytest.mark.parametrize(
    ("second", "refused"),
    [
        ({**CRACK, "depth": 2e-3, "flank": "right"}, True),
        ({**CRACK, "tooth": 4}, False),
        ({**CRACK, "at": "two"}, False),
        ({"kind": "chip", "at": "one", "tooth": 3, "share": 0.2}, False),
    ],
)
def test_two_faults_of_one_kind__of_one_tooth_and_flank_are_refused(second: Document, refused: bool) -> None:
    found = document([CRACK, second])
    if not refused:
        assert len(load_case(found).faults) == 2
        return
    with pytest.raises(InputError, match=r"faults.1.tooth = 3: must not be that of faults.0, a crack"):
        load_case(found)


def test_two_worn_profiles__of_one_flank_are_refused() -> None:
    worn = {"kind": "wear", "at": "one", "profile": PROFILE}
    assert len(load_case(document([worn, {**worn, "flank": "right"}])).faults) == 2
    with pytest.raises(
        InputError, match=r'faults.1.profile = "4 points": must not be that of faults.0, a wear'
    ):
        load_case(document([worn, {**worn, "flank": "both"}]))


def test_fault_of_a_gear_in_no_mesh__is_refused() -> None:
    alone = {"teeth": 20, "mass": 1.0, "inertia": 1e-3, "position": [1.0, 0.0]}
    with pytest.raises(InputError, match=r"faults.0.at.*gear in a mesh"):
        load_case(document([{**CRACK, "at": "three"}], rotors={"three": alone}))


UNCOUPLED: Document = {
    "backlash_model": "uncoupled",
    "meshes": [{**document()["meshes"][0], "contact": "mesh"}],
}


@pytest.mark.parametrize(
    ("fault", "more", "words"),
    [
        ({**CRACK, "tooth": 20}, {}, r"faults.0.tooth.*less than 20"),
        ({**CRACK, "at": "three"}, {}, r"faults.0.at"),
        ({**CRACK, "at": "two"}, {"rotors": {"two": {"internal": True, "bore": None}}}, r"faults.0.at.*external"),
        (CRACK, {"meshes": [{**document()["meshes"][0], "contact": "mesh"}]}, r'faults.0.kind.*contact = "pairs"'),
        (CRACK, {"rotors": HELICAL, "meshes": [{**document()["meshes"][0], "center_distance": None}]}, r"faults.0.kind.*spur"),
        ({"kind": "pitch", "at": "one", "offset": 1e-5}, UNCOUPLED, r"faults.0.kind.*follow the centres"),
        ({**CRACK, "kind": "spall", "depth": 1e-5, "start": 0.6, "end": 0.5}, {}, r"faults.0.end.*above start"),
        ({**CRACK, "depth": -1e-3}, {}, r"faults.0.depth"),
        ({"kind": "wear", "at": "one"}, {}, r"faults.0.depth.*required, or a profile"),
        ({"kind": "wear", "at": "one", "depth": 1e-6, "profile": PROFILE}, {}, r"faults.0.profile.*together with depth"),
        ({"kind": "wear", "at": "one", "profile": PROFILE[:1]}, {}, r"faults.0.profile.*two points"),
        ({"kind": "wear", "at": "one", "profile": PROFILE[::-1]}, {}, r"faults.0.profile.1.*higher"),
    ],
)  # fmt: skip
def test_refusals__name_the_field(fault: Document, more: Document, words: str) -> None:
    with pytest.raises(InputError, match=words):
        load_case(document([fault], **more))


def test_faults_of_both_gears__meet_once_in_the_hunting_period() -> None:
    """17/18: what both teeth lack adds once in 306 pitches; alone each comes once a turn of its gear."""
    found = document_of(4e-3, (17, 18), (0.2, 0.2), False, 1e-4, 0.01)
    depths = 10e-6, 30e-6
    found["faults"] = [
        {"kind": "spall", "at": name, "tooth": tooth, "depth": depth, "start": 0.2, "end": 0.8}
        for name, tooth, depth in zip(("one", "two"), (4, 9), depths, strict=True)
    ]
    packed, path = pack(case_of(found)), pair_of(case_of(found), 0).path
    start = touching_at(packed, 0, path.start + 0.5 * path.length)
    seen = np.zeros(2 * 306)
    for turned in range(seen.size):
        y = start.copy()
        y[2] += 2.0 * math.pi * turned / 17
        y[5] -= 2.0 * math.pi * turned / 18
        seen[turned] = -max(
            pairs_at(packed, y), key=lambda pair: -abs(pair.place - path.start - 0.5 * path.length)
        ).p
    of_one = [int(k) for k in np.flatnonzero(np.isclose(seen % 20e-6, depths[0]))]
    of_two = [int(k) for k in np.flatnonzero(seen > 0.9 * depths[1])]
    both = [int(k) for k in np.flatnonzero(np.isclose(seen, sum(depths)))]
    assert np.isclose(seen, [0.0], atol=1e-12).sum() == seen.size - len(set(of_one) | set(of_two))
    assert set(np.diff(of_two)) == {18}
    assert len(both) == 2
    assert np.diff(both) == 306
    assert set(both) <= set(of_two)


def delay(time: Floats, first: Floats, second: Floats, expected: float, start: float, window: float) -> float:
    """Return by how much the second signal follows the first one [s], the least squares of their difference over a window."""
    chosen = (time >= start) & (time < start + window)
    later = CubicSpline(time, second)

    def off(lag: float) -> float:
        return float(np.sum((later(time[chosen] + lag) - first[chosen]) ** 2))

    lags = expected + np.linspace(-0.2, 0.2, 81) * expected
    best = min(lags, key=off)
    step = float(lags[1] - lags[0])
    found = minimize_scalar(
        off, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-10}
    )
    return float(found.x)


def test_cracked_pinion_tooth__yields_once_a_turn_of_the_pinion() -> None:
    """A loaded pair: the wheel falls back where the tooth carries, alike at each turn of the pinion, and nowhere else."""
    turn = 0.05
    loaded = {
        "rotors": {
            "one": {"drive": {"kind": "speed", "speed": 2.0 * math.pi / turn}},
            "two": {"inertia": 2e-2, "load": {"torque": 180.0}},
        },
        "run": {"duration": 3.2 * turn, "sampling": 5e4, "tolerance": 1e-8},
    }
    runs = []
    for faults in ([], [{"kind": "crack", "at": "one", "tooth": 8, "depth": 2.5e-3}]):
        found = document(faults)
        found["meshes"][0]["damping"] = {"kind": "constant", "value": 3000.0}
        runs.append(simulate_one(merged(found, loaded)))
    time, back = runs[0].time, runs[1].signal("theta", "two") - runs[0].signal("theta", "two")
    assert delay(time, back, back, turn, 1.05 * turn, turn) == pytest.approx(turn, abs=1e-7)
    # the wheel turns clockwise; tooth 8 is on the line of centres, along +x, after 12 of 20 pitches
    away = np.abs((time - 12.0 / 20.0 * turn + 0.5 * turn) % turn - 0.5 * turn)
    largest = float(np.max(np.abs(back)))
    assert 1e-7 < float(np.max(back)) == largest
    assert away[np.argmax(back)] < turn / 20.0
    assert np.max(np.abs(back[away > 2.0 * turn / 20.0])) < 0.1 * largest
