"""`check` on teeth: undercut, fouling, tips within the base circle, the installed contact ratio, planets that do not fit."""

import math
from typing import Any

import pytest

import gearplay as gp
from drawn_pairs import standard
from gearplay.parts.mesh.train.geometry import installed_pair
from gearplay.parts.mesh.train.geometry import pair_of as drawn_pair


def pair(z_1: int, z_2: int, *, internal: bool = False, apart: float | None = None) -> gp.Case:
    """Return two gears of module 2 mm, ``apart`` [m] or at the nominal distance."""
    part = {"mass": 1.0, "inertia": 1e-3}
    second: dict[str, Any] = {"teeth": z_2, "internal": internal, "position": [0.0, 0.0], **part}
    first: dict[str, Any] = {"teeth": z_1, **part, "drive": {"kind": "speed", "speed": 1.0}}
    if apart is not None:
        first["position"] = [apart, 0.0]
    mesh = {"driver": "one", "driven": "two", "module": 2e-3, "backlash": 1e-4}
    mesh["stiffness"] = {"kind": "harmonic", "mean": 1e8}
    return gp.load_case(
        {"rotors": {"one": first, "two": second}, "meshes": [mesh], "run": {"duration": 0.01}}
    )


def said(case: gp.Case) -> str:
    return "\n".join(f.message for f in gp.check_case(case) if f.severity == "warning")


@pytest.mark.parametrize(("z", "warns"), [(8, True), (16, True), (17, False), (30, False)])
def test_undercut(z: int, warns: bool) -> None:
    assert ("undercut; from 17 teeth on" in said(pair(z, 40))) is warns


@pytest.mark.parametrize(
    ("pair_of", "warns"), [((29, 30), True), ((24, 30), True), ((20, 60), False), ((37, 91), False)]
)
def test_internal_pairs_that_foul(pair_of: tuple[int, int], warns: bool) -> None:
    assert ("foul each other" in said(pair(*pair_of, internal=True))) is warns


def test_fouling_is_that_of_tips_that_are_followed() -> None:
    """A corner of the pinion's tip is turned through the mesh: it enters a ring's tooth exactly where the formula says so."""
    alpha = math.radians(20.0)
    for z_2 in (34, 40, 60, 91):
        for z_1 in range(z_2 - 12, z_2 - 4):
            assert standard(z_1, z_2, True, 1.0).tips_foul is enters(z_1, z_2, alpha), (z_1, z_2)


def enters(z_1: int, z_2: int, alpha: float) -> bool:
    """Return whether a tip corner of the pinion gets behind the flank of the ring that it meshes with, by following it."""
    inv = lambda a: math.tan(a) - a  # noqa: E731
    r_1, r_2 = 0.5 * z_1, 0.5 * z_2
    tip_1, tip_2, base_1, base_2, apart = (
        r_1 + 1.0,
        r_2 - 1.0,
        r_1 * math.cos(alpha),
        r_2 * math.cos(alpha),
        r_2 - r_1,
    )
    corner = (
        math.pi / (2 * z_1) + inv(alpha) - inv(math.acos(base_1 / tip_1))
    )  # half angle of the tooth at its tip
    for k in range(1, 4000):
        turn = 1.2 * k / 4000  # of the pinion, the tooth at 0 on the line of centres
        angle = turn + corner
        x, y = apart + tip_1 * math.cos(angle), tip_1 * math.sin(angle)
        radius, direction = math.hypot(x, y), math.atan2(y, x)
        if radius < max(tip_2, base_2):  # the corner is inside the ring's tips: it has left the spaces
            return False
        # Leading flank of the space that the tooth began in, turned on with the ring: half the space at this radius.
        half = math.pi / (2 * z_2) + inv(alpha) - inv(math.acos(min(1.0, base_2 / radius)))
        if direction - turn * z_1 / z_2 > half + 1e-9:
            return True
    return False


def test_tips_within_the_base_circle() -> None:
    assert "lie inside their base circle" in said(pair(15, 30, internal=True))
    assert "lie inside their base circle" not in said(pair(20, 60, internal=True))


def test_the_contact_ratio_is_that_of_the_installed_distance() -> None:
    assert installed_pair(pair(20, 40), 0).contact_ratio == pytest.approx(
        drawn_pair(pair(20, 40), 0).contact_ratio, rel=1e-12
    )
    assert installed_pair(pair(20, 60, internal=True), 0).contact_ratio == pytest.approx(
        drawn_pair(pair(20, 60, internal=True), 0).contact_ratio, rel=1e-12
    )
    far = pair(20, 40, apart=0.0625)
    assert installed_pair(far, 0).contact_ratio < 0.8
    assert "at the installed distance (1.6" in said(far)


def test_planets_that_overlap_or_do_not_fit() -> None:
    part = {"mass": 1.0, "inertia": 1e-3}
    places = {"one": 0.0, "two": 80.0, "three": 42.0}
    rotors: dict[str, Any] = {
        "sun": {"teeth": 20, **part, "position": [0.0, 0.0], "drive": {"kind": "speed", "speed": 10.0}},
        "ring": {
            "teeth": 60,
            "internal": True,
            **part,
            "position": [0.0, 0.0],
            "drive": {"kind": "speed", "speed": 0.0},
        },
        "carrier": {**part, "position": [0.0, 0.0]},
    }
    mesh = {"module": 2e-3, "backlash": 1e-4, "stiffness": {"kind": "harmonic", "mean": 1e8}}
    meshes = []
    for name, angle in places.items():
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        rotors[name] = {"teeth": 20, **part, "position": [0.04 * c, 0.04 * s]}
        meshes += [{"driver": "sun", "driven": name, **mesh}, {"driver": name, "driven": "ring", **mesh}]
    sleeves = {name: {"radial_clearance": 1e-5, "stiffness": 1e9, "on": "carrier"} for name in places}
    found = gp.check_case(
        gp.load_case({"rotors": rotors, "sleeves": sleeves, "meshes": meshes, "run": {"duration": 0.01}})
    )
    words = {(f.path, f.message.split(":")[0]) for f in found if f.severity == "warning"}
    # 80 teeth of sun and ring: steps of 4.5 deg
    assert ("rotors.two.position", "its teeth cannot mesh with sun and ring as those of one do") in words
    assert ("rotors.three.position", "its teeth cannot mesh with sun and ring as those of one do") in words
    # where it should be: the nearest of steps of 4.5 deg from one, which lies at 0
    place = f"{40 * math.cos(math.radians(81)):.4f} mm, {40 * math.sin(math.radians(81)):.4f} mm"
    assert any(
        f"about the centre, to [{place}]" in f.message for f in found if f.path == "rotors.two.position"
    )
    assert ("rotors.three.position", "it overlaps one") in words
    assert ("rotors.three.position", "it overlaps two") in words
    assert ("rotors.two.position", "it overlaps one") not in words
