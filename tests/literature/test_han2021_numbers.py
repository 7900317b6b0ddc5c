"""Numbers of Han, Liang, Zhang, Zhao, Entropy 2021, 23, 834, and of the standards used where it is silent."""

import math

import numpy as np
import pytest

from building import case_of, dynamic_backlash, mesh_at, pair_document
from drawn_pairs import standard
from gearplay.model.pack import pack
from gearplay.model.reading import load_case, replace
from gearplay.parts.mesh.geometry import B_T
from gearplay.parts.mesh.mesh_stiffness import iso6336_mesh_stiffness, pack_stiffness
from gearplay.parts.mesh.train.geometry import jam_ratio, pitch_radius, working_distance
from gearplay.parts.sleeve.contact_laws import hertz_stiffness

STEEL = (206e9, 0.3)
ALPHA = math.radians(20.0)


def test_hertz_stiffness_of_a_steel_journal() -> None:
    """Equation (9): R_j = 10 mm, 100 um, steel: 1.52e11 N/m^1.5, falling as the clearance's root."""
    K = hertz_stiffness(0.01, 100e-6, STEEL, STEEL)
    assert pytest.approx(1.52e11, rel=5e-3) == K
    # by hand: s = (1 - 0.09) / (pi 206e9) on both sides, R_b = 10.1 mm
    by_hand = 4.0 / (3.0 * math.pi * 2.0 * 0.91 / (math.pi * 206e9)) * math.sqrt(0.0101 * 0.01 / 1e-4)
    assert pytest.approx(by_hand, rel=1e-12) == K
    assert hertz_stiffness(0.01, 200e-6, STEEL, STEEL) / K == pytest.approx(math.sqrt(0.5), rel=6e-3)
    # two materials: compliances add
    soft = hertz_stiffness(0.01, 100e-6, STEEL, (103e9, 0.3))
    assert K / soft == pytest.approx(1.5, rel=1e-12)


def iso(
    internal: bool, ratio: float, width: float = 0.006, modulus: float = 206e9, alpha: float = 20.0
) -> float:
    pair = standard(20, 60, internal, 4e-3, alpha)
    return iso6336_mesh_stiffness(pair.first, pair.second, ratio, width, modulus)


def test_iso_stiffness_of_six_millimetres_of_steel() -> None:
    """ISO 6336-1 method B: 6 mm of steel at the rig's contact ratio between 1.3e8 and 1.5e8 N/m."""
    k_m = iso(True, 1.95)
    assert 1.3e8 < k_m < 1.5e8
    # by hand: q' = 0.04723 + 0.15551 / 20, c' = 0.8 0.975 / q', c_gamma = c' (0.75 1.95 + 0.25) N/(mm um)
    by_hand = 0.78 / (0.04723 + 0.15551 / 20.0) * (0.75 * 1.95 + 0.25) * 1e9 * 0.006
    assert k_m == pytest.approx(by_hand, rel=1e-12)
    # an external wheel is softer than a ring, and stiffness goes with facewidth and modulus
    assert iso(False, 1.95) < k_m
    assert iso(True, 1.95, 0.012, 103e9) == pytest.approx(k_m, rel=1e-12)
    # C_B goes with the rack's pressure angle: 1 - 0.02 (20 deg - alpha)
    for degrees, factor in ((14.5, 0.89), (20.0, 1.0), (25.0, 1.1)):
        turned = iso(True, 1.95, alpha=degrees)
        assert turned / k_m == pytest.approx(factor, rel=1e-12)


def test_the_stiffness_of_a_case_is_of_its_own_rack() -> None:
    case = load_case("han2021")
    given = {"meshes.0.stiffness": {"kind": "iso6336", "facewidth": "6 mm"}}
    for degrees in (14.5, 20.0, 25.0):
        turned = replace(case, {**given, "meshes.0.pressure_angle": math.radians(degrees)})
        ratio = standard(20, 60, True, 4e-3, degrees).contact_ratio
        expected = iso(True, ratio, alpha=degrees)
        assert pack_stiffness(turned, 0).mean == pytest.approx(expected, rel=1e-12)


def test_the_wave_of_a_case_is_a_share_of_its_mean() -> None:
    """K runs from 0.8 to 1.2 of its mean once a mesh period where amplitude_ratio is 0.2."""
    given = {"kind": "iso6336", "facewidth": "6 mm", "amplitude_ratio": 0.2, "phase": 0.5}
    wave = pack_stiffness(replace(load_case("han2021"), {"meshes.0.stiffness": given}), 0)
    assert wave.rows.tolist() == [[1.0, pytest.approx(0.2 * wave.mean, rel=1e-12), 0.5]]
    assert wave.highest == pytest.approx(1.2 * wave.mean, rel=1e-12)


def test_contact_ratio_of_the_pair() -> None:
    """Full-depth 20/60 of 20 deg: 1.95 internal; the same teeth external 1.67, from the ends of contact."""
    assert standard(20, 60, True, 4e-3).contact_ratio == pytest.approx(1.95, abs=0.03)
    # external by hand: sum of both tip lengths less the centre distance's, over the base pitch
    tips = sum(math.sqrt((r + 4.0) ** 2 - (r * math.cos(ALPHA)) ** 2) for r in (40.0, 120.0))
    by_hand = (tips - 160.0 * math.sin(ALPHA)) / (4.0 * math.pi * math.cos(ALPHA))
    assert standard(20, 60, False, 4e-3).contact_ratio == pytest.approx(by_hand, rel=1e-12)


def test_contact_ratio_of_the_ring_from_where_tips_cross_the_line_of_action() -> None:
    """Internal by construction: where both tip circles cut the common tangent of the base circles, from the tangent point on.

    The ring's tip circle cuts it 0.15 mm within the pinion's base tangent point, where the pinion has no involute.
    """
    u = np.array(
        [math.sin(ALPHA), math.cos(ALPHA)]
    )  # along the tangent, from the ring's side of the pinion's centre

    def along(r_tip: float, centre: float) -> float:
        """Return where the tip circle cuts the tangent through the pitch point, as far along as possible."""
        pitch = np.array([120.0 - centre, 0.0])
        half = pitch @ u
        return -half + math.sqrt(half**2 - pitch @ pitch + r_tip**2)

    tangent_point = -40.0 * math.sin(ALPHA)
    assert along(116.0, 0.0) == pytest.approx(tangent_point - 0.15, abs=1e-3)
    path = along(44.0, 80.0) - max(along(116.0, 0.0), tangent_point)
    assert standard(20, 60, True, 4e-3).contact_ratio == pytest.approx(
        path / (4.0 * math.pi * math.cos(ALPHA)), rel=1e-9
    )


def test_printed_backlash_has_the_external_sign() -> None:
    """(6) as printed makes a ring's backlash grow when the centres part; in truth it shrinks."""
    document = pair_document("internal")
    for moved, true in ((-100e-6, 168.080e-6), (50e-6, 65.717e-6)):
        got = {}
        for formulation in ("as_published", "geometric"):
            packed = pack(case_of({**document, "formulation": formulation}))
            y = np.zeros(packed.state_size)
            y[0] = moved  # the pinion moves away from the ring's centre
            got[formulation] = float(mesh_at(packed, 0, y)[B_T])
        assert got["geometric"] == pytest.approx(true, abs=1e-9)
        # mirrored about b0: right for an external pair of the same centre distance
        assert got["as_published"] == pytest.approx(200e-6 - true, abs=1e-9)
        assert got["as_published"] == pytest.approx(
            dynamic_backlash(0.08 + moved, 0.08, ALPHA, 100e-6, -1.0), abs=1e-15
        )


def test_printed_inertias_do_not_fit_the_gears() -> None:
    """Radii of gyration 0.284 and 0.277 m against pitch radii of 0.04 and 0.12 m."""
    case = load_case("han2021")
    gyration = [math.sqrt(case.rotors[n].inertia / case.rotors[n].mass) for n in ("pinion", "ring")]
    assert gyration == [pytest.approx(0.284, abs=5e-4), pytest.approx(0.277, abs=5e-4)]
    assert [pitch_radius(case, case.meshes[0], n) for n in ("pinion", "ring")] == [
        pytest.approx(0.04),
        pytest.approx(0.12),
    ]
    assert working_distance(case, 0) == pytest.approx(0.08)
    disc = load_case("han2021-geometric-inertia").rotors["pinion"]
    assert disc.inertia == pytest.approx(0.5 * 0.235 * 0.04**2, rel=5e-3)


@pytest.mark.parametrize(
    ("clearance", "backlash", "ratio"),
    [(100e-6, 100e-6, 0.684), (200e-6, 100e-6, 1.368), (200e-6, 200e-6, 0.684)],
)
def test_only_one_of_the_conditions_can_wedge(clearance: float, backlash: float, ratio: float) -> None:
    """Jam ratio 2 sin(alpha0) c / b0 of the rig: only 200 um of clearance in 100 um of backlash exceeds 1."""
    document = pair_document("internal", mesh={"backlash": backlash})
    del document["sleeves"]["pinion"]
    document["sleeves"]["ring"]["radial_clearance"] = clearance
    assert jam_ratio(case_of(document), 0) == pytest.approx(ratio, abs=5e-4)
