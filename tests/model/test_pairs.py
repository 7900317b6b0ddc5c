"""Contact ratio and characteristic frequencies of pairs of gears, as `gearplay check` prints them."""

import json
import math
from pathlib import Path
from typing import Any

import pytest

import gearplay as gp
from drawn_pairs import drawn, standard
from gearplay.cli.main import run
from gearplay.model.reading import to_toml
from gearplay.parts.mesh.check_pairs import pair_table

ALPHA = math.radians(20.0)
PRINTED_REDUCER: dict[str, Any] = {
    "planetary": {
        "p": {
            "module": "1 mm",
            "backlash": "150 um",
            "stiffness": {"kind": "square", "single": "1e7 N/m", "double": "1.7e7 N/m"},
            "damping": {"ratio": 0.1},
            "sun": {
                "teeth": 12,
                "mass": 0.01,
                "inertia": 2e-7,
                "drive": {"kind": "speed", "speed": "300 rpm"},
            },
            "planets": {"count": 3, "teeth": 18, "mass": 0.01, "inertia": 5e-7},
            "support": {"stiffness": [1e8, 1e8]},
            "ring": {"teeth": 48, "mass": 0.1, "inertia": 8e-5, "fixed": True},
            "carrier": {"mass": 0.05, "inertia": 6e-6, "load": {"torque": "1 N m"}},
        }
    },
    "run": {"duration": "10 ms", "transient": 0.0, "sampling": "20 kHz"},
}


def hunting_pair(speed: str = "1750 rpm") -> dict[str, Any]:
    return {
        "rotors": {
            "p": {"teeth": 24, "mass": 1.0, "inertia": 4e-4, "drive": {"kind": "speed", "speed": speed}},
            "w": {"teeth": 38, "mass": 2.0, "inertia": 2e-3, "load": {"torque": 40.0}},
        },
        "meshes": [
            {
                "driver": "p",
                "driven": "w",
                "module": "2 mm",
                "backlash": "80 um",
                "stiffness": {"kind": "harmonic", "mean": 2e8},
                "damping": {"ratio": 0.08},
            }
        ],
        "run": {"duration": "2 s", "sampling": "20 kHz"},
    }


def test_contact_ratio__planets_in_a_small_ring() -> None:
    """18 in 48: the path begins at the planet's base tangent point, sqrt(r_a^2 - r_b^2) / p_b long; the case runs."""
    path = math.sqrt(10.0**2 - (9.0 * math.cos(ALPHA)) ** 2)
    assert standard(18, 48, True, 1e-3).contact_ratio == pytest.approx(
        path / (math.pi * math.cos(ALPHA)), rel=1e-12
    )
    case = gp.load_case(PRINTED_REDUCER)
    by_name = {row["mesh"]: row for row in pair_table(case)}
    assert by_name["p.planet1-p.ring"]["contact_ratio"] == pytest.approx(1.808, abs=5e-4)
    assert gp.simulate(case).success
    words = [
        f.message
        for f in gp.check_case(case)
        if "p.planet3-p.ring" in f.message and "interference" in f.message
    ]
    assert len(words) == 1
    assert "contact ratio 1.808 (uncut 2.016: the tip of p.ring stands 0.616 mm inside" in words[0]


@pytest.mark.parametrize(
    ("internal", "apart", "ratio"),
    [
        (False, -0.2e-3, 1.720533),
        (False, 0.0, 1.670776),
        (False, 0.1e-3, 1.646074),
        (False, 0.4e-3, 1.572651),
        (True, -0.2e-3, 1.899665),
        (True, 0.0, 1.936972),
        (True, 0.1e-3, 1.936972),
        (True, 0.4e-3, 1.936972),
    ],
)
def test_contact_ratio__other_centre_distances(internal: bool, apart: float, ratio: float) -> None:
    """20/60, m 4: the ring's path is cut at the pinion's tangent point from the nominal distance on."""
    nominal = 0.08 if internal else 0.16
    assert standard(20, 60, internal, 4e-3, distance=nominal + apart).contact_ratio == pytest.approx(
        ratio, abs=1e-6
    )


@pytest.mark.parametrize("internal", [False, True])
@pytest.mark.parametrize("z_1", [8, 12, 17, 18, 24, 40])
def test_contact_path__radii_of_the_tips_that_meet_it(internal: bool, z_1: int) -> None:
    """A point of the line of action at rho from T1 lies at sqrt(r_b1^2 + rho^2) of gear 1; the partner's tip passes there."""
    z_2 = 3 * z_1
    path = standard(z_1, z_2, internal, 1e-3).path
    start, end, line = path.tip_of_second, path.tip_of_first, path.tangent_of_second
    b_1, b_2 = 0.5e-3 * z_1 * math.cos(ALPHA), 0.5e-3 * z_2 * math.cos(ALPHA)
    t_2 = 0.5e-3 * (z_2 - z_1 if internal else z_1 + z_2) * math.sin(ALPHA)
    at_2 = start + t_2 if internal else t_2 - start  # from T2
    assert math.hypot(b_1, end) == pytest.approx(0.5e-3 * z_1 + 1e-3, rel=1e-12)
    tip_2 = 0.5e-3 * z_2 + (-1e-3 if internal else 1e-3)
    if tip_2 > b_2:
        assert math.hypot(b_2, at_2) == pytest.approx(tip_2, rel=1e-12)
    assert line == (math.inf if internal else pytest.approx(t_2, rel=1e-12))


def test_tips__thickness_of_teeth_and_of_spaces() -> None:
    """A tooth and the space of a ring share an outline: thicknesses at one radius add up to the pitch there."""
    for z in (24, 60, 110):
        for alpha in (math.radians(14.5), ALPHA, math.radians(25.0)):
            base, radius = 0.5 * z * math.cos(alpha), 0.5 * z - 1.0
            if radius < base:
                continue
            at = math.acos(base / radius)
            inv = lambda a: math.tan(a) - a  # noqa: E731
            space = (
                2.0 * radius * (0.5 * math.pi / z + inv(alpha) - inv(at))
            )  # an external tooth at the ring's tip
            ring = drawn(1.0, z, alpha=math.degrees(alpha), internal=True)
            assert ring.tip_thickness + space == pytest.approx(2.0 * math.pi * radius / z, rel=1e-12)


@pytest.mark.parametrize(
    ("z_1", "z_2", "internal", "degrees", "pointed"),
    [
        (24, 38, False, 20.0, ()),
        (24, 90, True, 20.0, ()),
        (24, 38, False, 41.0, ("p", "w")),
        # an external gear of 90 teeth would be pointed, the ring is not
        (24, 90, True, 38.0, ("p",)),
        (24, 90, True, 41.0, ("p", "w")),
        (6, 60, False, 35.0, ("p",)),
    ],
)
def test_check__pointed_teeth(
    z_1: int, z_2: int, internal: bool, degrees: float, pointed: tuple[str, ...]
) -> None:
    document = hunting_pair()
    document["rotors"]["p"]["teeth"] = z_1
    document["rotors"]["w"] |= {"teeth": z_2, "internal": internal}
    document["meshes"][0]["pressure_angle"] = f"{degrees} deg"
    found = [f.path for f in gp.check_case(gp.load_case(document)) if "pointed" in f.message]
    assert found == [f"rotors.{name}.teeth" for name in pointed]


def test_check__frequencies_of_a_pair_with_hunting_teeth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """f_m = 24 x 1750 rpm; hunting tooth f_m gcd / (z1 z2); the common period is its inverse."""
    file = tmp_path / "pair.toml"
    file.write_text(to_toml(gp.load_case(hunting_pair())))
    assert run(["check", str(file), "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["pairs"]
    assert row["mesh"] == "p-w"
    assert row["mesh_frequency"] == pytest.approx(700.0, rel=1e-12)
    assert row["shafts"] == pytest.approx({"p": 29.166667, "w": 18.421053}, rel=1e-6)
    assert row["hunting_frequency"] == pytest.approx(700.0 * math.gcd(24, 38) / (24 * 38), rel=1e-12)
    assert row["common_period"] == pytest.approx(0.651429, abs=5e-7)
    assert row["sidebands"]["w"] == pytest.approx([700.0 - 18.421053, 700.0 + 18.421053], rel=1e-6)
    assert run(["check", str(file)]) == 0
    text = capsys.readouterr().out
    for words in ("700 Hz", "p 29.1667 Hz, w 18.4211 Hz", "hunting tooth 1.53509 Hz", "0.651429 s"):
        assert words in text


def test_check__frequencies_of_planets_are_those_relative_to_the_carrier() -> None:
    """Willis: sun 5 Hz, carrier 5 * 12 / 60 = 1 Hz, planets 12 * 4 / 18 Hz relative to it; f_m = 12 * 4 Hz at all meshes."""
    rows = {row["mesh"]: row for row in pair_table(gp.load_case(PRINTED_REDUCER))}
    assert [row["mesh_frequency"] for row in rows.values()] == pytest.approx([48.0] * 6)
    assert rows["p.sun-p.planet2"]["rotations"] == pytest.approx({"p.sun": 4.0, "p.planet2": 8.0 / 3.0})
    assert rows["p.planet2-p.ring"]["shafts"] == pytest.approx({"p.planet2": 5.0 / 3.0, "p.ring": 0.0})
    assert rows["p.planet2-p.ring"]["common_period"] == pytest.approx(math.lcm(18, 48) / 48.0)


def test_check__a_pair_that_no_speed_drives_has_no_frequency() -> None:
    document = hunting_pair()
    document["rotors"]["p"]["drive"] = {"kind": "torque", "torque": 25.0}
    (row,) = pair_table(gp.load_case(document))
    assert (row["mesh_frequency"], row["common_period"], row["mesh_periods"]) == (0.0, None, 456)
    words = [f.message for f in gp.check_case(gp.load_case(document)) if f.message.startswith("p-w")]
    assert "no frequency is known; the same two teeth meet every 456 mesh periods" in words[0]
