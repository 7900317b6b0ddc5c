"""`check` on deviations of teeth: quality without effect, quality against the backlash, length of tip relief."""

import math
from typing import Any

import gearplay as gp
from gearplay.parts.mesh.train.geometry import pair_of
from gearplay.toothing.quality import tolerances
from planetary_sets import planetary_document
from tooth_pairs import MODULE, TEETH, with_pairs


def found(case: gp.Case, severity: str, words: str) -> list[Any]:
    return [each for each in gp.check_case(case) if each.severity == severity and words in each.message]


def test_quality__that_eats_the_backlash() -> None:
    """Sum of F_p cos(alpha) of both gears against the backlash, from either side of it."""
    allowed = [
        tolerances(diameter=MODULE * z, module=MODULE, quality=q).cumulative_pitch
        for z, q in ((20, 8), (60, 9))
    ]
    eaten = sum(allowed) * math.cos(math.radians(20.0))
    words = "cumulative pitch deviations that ISO 1328-1 allows"
    enough = with_pairs({"quality": 8}, {"quality": 9}, backlash=eaten * 1.0001)
    assert not found(enough, "warning", words)
    (said,) = found(with_pairs({"quality": 8}, {"quality": 9}, backlash=eaten * 0.9999), "warning", words)
    assert said.path == "meshes.0.backlash"
    assert f"add up to {1e6 * eaten:.4g} um" in said.message
    one = with_pairs({"quality": 8}, {}, backlash=eaten * 0.9999)
    assert not found(one, "warning", words), "gears without a class have none"


def test_quality__without_effect_or_of_helical_gears_is_noted() -> None:
    plain = with_pairs({}, {"quality": 7}, contact="mesh")
    assert not found(plain, "note", "has no effect")
    (said,) = found(gp.replace(plain, {"backlash_model": "uncoupled"}), "note", "has no effect")
    assert (said.path, "quality = 7 of two" in said.message) == ("rotors.two.quality", True)
    helix = {"helix_angle": 0.2}
    (said,) = found(
        with_pairs(helix, {"quality": 7, **helix}), "note", "pitch and profile slope count: the form"
    )
    assert said.path == "rotors.two.quality"
    narrow = {"contact": "mesh", "stiffness": {"kind": "harmonic", "mean": 1e8}}
    unknown = with_pairs({**helix, "facewidth": None}, {"quality": 7, **helix}, **narrow)
    (said,) = found(unknown, "note", "the pitch counts alone: profile deviations need the facewidths")


def test_tip_relief__leaves_a_base_pitch_of_the_path() -> None:
    """Both lengths together may be the path less a base pitch: (contact ratio - 1) base pitches."""
    drawn = pair_of(with_pairs({}, {}), 0)
    most = (drawn.contact_ratio - 1.0) * drawn.first.base_pitch
    words = "base pitches without"
    for share, warns in ((0.999, False), (1.001, True)):
        relief = {"amount": 1e-5, "length": 0.5 * share * most}
        assert (
            bool(found(with_pairs({"tip_relief": relief}, {"tip_relief": relief}), "warning", words)) is warns
        )
    beyond = with_pairs({"tip_relief": {"amount": 1e-5, "length": 0.03}}, {})
    (said,) = found(beyond, "warning", words)
    assert said.path == "rotors.one.tip_relief.length"
    assert "leaves 0 base pitches" in said.message


def test_tip_relief_of_helical_gears__may_be_longer_by_the_shift_over_the_facewidth() -> None:
    """Unrelieved lengths of all lines of contact together: the path less relief and b tan(beta_b) make a base pitch."""
    helix = {"helix_angle": 0.15}
    drawn = pair_of(with_pairs(helix, helix), 0)
    most = drawn.path.length - drawn.first.base_pitch + drawn.overlap
    for share, warns in ((0.999, False), (1.001, True)):
        relief = {"tip_relief": {"amount": 1e-5, "length": 0.5 * share * most}}
        case = with_pairs({**relief, **helix}, {**relief, **helix})
        assert bool(found(case, "warning", "base pitches without, at an overlap ratio of")) is warns


def test_findings_of_planets__are_one_of_all_alike() -> None:
    """Four planets, eight meshes: one line of the light load, one of each kind of mesh with little backlash."""
    fields = {name: {"facewidth": 0.05, "quality": 9} for name in ("sun", "planets", "ring")}
    case = gp.load_case(
        planetary_document(contact="pairs", stiffness=None, sun_planet=TEETH, planet_ring=TEETH, **fields)
    )
    assert len(found(case, "note", "of the stiffness above 100 N/mm")) == 1
    said = found(case, "warning", "cumulative pitch deviations")
    assert [each.message.count("stage.planet") for each in said] == [4, 4]
