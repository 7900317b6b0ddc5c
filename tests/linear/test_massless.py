"""Rotors without mass: condensed statically in linear analysis, refused by a simulation over time."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document
from gearplay.linear.condense import condense
from gearplay.linear.system import linear_system
from gearplay.parts.mesh.mesh_stiffness import pack_stiffness
from gearplay.parts.mesh.packing import damping_maximum
from gearplay.parts.mesh.tooth_loads import tooth_loads

DISC = {"mass": 1.0, "inertia": 2e-3}
NODE = {"mass": 0.0, "inertia": 0.0}


def train(inertia: float = 0.0, **run: Any) -> Document:
    """Return field row 34: rotor and generator behind stiff gears of little or no inertia."""
    return {
        "rotors": {
            "rotor": {"mass": 10.0, "inertia": 10.0, "drive": {"kind": "torque", "torque": 30.0}},
            "wheel": {"teeth": 90, "mass": 0.0, "inertia": inertia},
            "pinion": {"teeth": 30, "mass": 0.0, "inertia": inertia},
            "gen": {"mass": 2.0, "inertia": 2.0, "load": {"torque": 10.0}},
        },
        "couplings": [
            {"between": ["rotor", "wheel"], "torsional_stiffness": 1.2e6, "torsional_damping": 300.0},
            {"between": ["pinion", "gen"], "torsional_stiffness": 8e5},
        ],
        "meshes": [
            {
                "driver": "wheel", "driven": "pinion", "module": 1e-2, "backlash": 1e-5,
                "stiffness": {"kind": "harmonic", "mean": 1e13}, "damping": {"ratio": 0.1},
            }
        ],
        "run": {"duration": 1e-3, **run},
    }  # fmt: skip


def chain(*discs: Document, k: float, **more: Any) -> Document:
    """Return discs in a row on shafts of stiffness k."""
    names = [f"d{i}" for i in range(len(discs))]
    return {
        "rotors": dict(zip(names, discs, strict=True)),
        "couplings": [{"between": pair, "torsional_stiffness": k} for pair in itertools.pairwise(names)],
        "run": {"duration": 1e-3},
        **more,
    }


def test_massless_gears__springs_in_series() -> None:
    """sqrt(k (1/10 + 1/18)) / 2 pi, 1/k = 1/k_1 + 1/k_teeth + 1/(9 k_2): two modes of four rotors, the limit of light gears."""
    found = gp.modes(train()).ds
    tooth = 1e13 * (0.45 * math.cos(math.radians(20.0))) ** 2
    k = 1.0 / (1.0 / 1.2e6 + 1.0 / tooth + 1.0 / (9.0 * 8e5))
    expected = math.sqrt(k * (1.0 / 10.0 + 1.0 / 18.0)) / (2.0 * math.pi)
    np.testing.assert_allclose(found["frequency"].values, [0.0, expected], rtol=1e-12)
    light = gp.modes(train(1e-9)).ds
    assert light["frequency"].values[1] == pytest.approx(expected, rel=1e-9)
    assert light["damping_ratio"].values[1] == pytest.approx(float(found["damping_ratio"][1]), rel=1e-6)
    shape = found["shape"].values[1]
    twists = (shape[0] - shape[1], shape[2] - shape[3])
    assert 9.0 * 8e5 * twists[1] / 3.0 == pytest.approx(-1.2e6 * twists[0], rel=1e-9)  # torques at the wheel
    strain = dict(zip(found["element"].values, found["strain_energy_share"].values[1], strict=True))
    assert strain["coupling rotor-wheel"] == pytest.approx(k / 1.2e6, rel=1e-7)
    np.testing.assert_allclose(found["kinetic_energy_share"].values[1, 1:3], 0.0)


def test_campbell_and_response__of_massless_gears() -> None:
    """The response of the condensed system, written down: two inertias, one spring."""
    document = train()
    del document["couplings"][0]["torsional_damping"]
    del document["meshes"][0]["damping"]
    frequencies = np.array([10.0, 60.0, 200.0])
    found = gp.frequency_response(document, force="rotor.torque", at="gen.theta", frequencies=frequencies).ds
    diagram = gp.campbell(document, [1.0, 2.0]).ds
    natural = float(diagram["frequency"].values[0, 1])
    w = 2.0 * math.pi * frequencies
    k = (2.0 * math.pi * natural) ** 2 / (1.0 / 10.0 + 1.0 / 18.0)
    stiffness, mass = np.array([[k, k / 3.0], [k / 3.0, k / 9.0]]), np.diag([10.0, 2.0])
    expected = [abs(np.linalg.inv(stiffness - each**2 * mass)[1, 0]) for each in w]
    np.testing.assert_allclose(found["amplitude"].values[0], expected, rtol=1e-8)


def test_damper_on_a_massless_node__maxwell_element() -> None:
    """J x'' + k_2 x + k (x - y) = 0, c y' = k (x - y): ratio of the complex root of its cubic, whatever c."""
    J, k, k_2 = 2e-3, 900.0, 1500.0
    for c in (1e-3, 0.05, 0.3, 5.0, 1e3):
        supports = {
            "d0": {"torsional_stiffness": k_2},
            "d1": {"torsional_damping": c, "torsional_stiffness": 0.0},
        }
        found = gp.modes(chain(DISC, NODE, k=k, supports=supports)).ds
        roots = np.roots([c * J, k * J, (k + k_2) * c, k * k_2])
        (root,) = roots[roots.imag > 0.0]
        assert found["frequency"].values == pytest.approx([math.sqrt(k_2 / J) / (2.0 * math.pi)], rel=1e-12)
        assert found["damping_ratio"].values == pytest.approx([-root.real / abs(root)], rel=1e-8)


def test_massless_centre__bearings_in_series() -> None:
    """A disc on a shaft k_2 to a bearing without mass on k_1: sqrt(k_1 k_2 / (k_1 + k_2) / m) / 2 pi in both directions."""
    document = {
        "rotors": {"disc": {**DISC, "floating": True}, "journal": dict(NODE)},
        "supports": {"journal": {"stiffness": [4e6, 9e6]}},
        "couplings": [{"between": ["disc", "journal"], "torsional_stiffness": 1e4, "lateral_stiffness": 2e6}],
        "gravity": [0.0, -9.81],
        "run": {"duration": 1e-3},
    }
    found = gp.modes(document).ds
    lateral = [math.sqrt(1.0 / (1.0 / k + 1.0 / 2e6)) / (2.0 * math.pi) for k in (4e6, 9e6)]
    np.testing.assert_allclose(found["frequency"].values, [0.0, *lateral], rtol=1e-9)
    at = dict(zip(found["coordinate"].values, found["static_displacement"].values, strict=True))
    assert at["journal.y"] == pytest.approx(-9.81 / 9e6, rel=1e-9)
    assert at["disc.y"] == pytest.approx(-9.81 / 9e6 - 9.81 / 2e6, rel=1e-9)


def stage(**extra: Any) -> Document:
    """Return a planetary set that turns, and a node on a damped shaft from its carrier to the disc of its load."""
    gear = {"mass": 0.5, "inertia": 1e-3}
    return {
        "planetary": {
            "s": {
                "module": 2e-3, "backlash": 2e-5, "stiffness": {"kind": "harmonic", "mean": 2e8}, "damping": {"ratio": 0.05},
                "sun": {
                    "teeth": 30, **gear, "support": {"stiffness": [5e7, 5e7]},
                    "drive": {"kind": "speed", "speed": 100.0},
                },
                "planets": {"count": 3, "teeth": 30, **gear},
                "ring": {"teeth": 90, "mass": 2.0, "inertia": 1e-2, "fixed": True},
                "carrier": {"mass": 2.0, "inertia": 1e-2, "support": {"stiffness": [5e7, 5e7]}},
                "support": {"stiffness": [9e7, 9e7]},
                "pin_errors": [{"planet": 1, "tangential": 1e-5}],
            }
        },
        "rotors": {"node": {"mass": 1.0, **extra}, "fan": {"mass": 3.0, "inertia": 0.05, "load": {"torque": 200.0}}},
        "couplings": [
            {"between": ["s.carrier", "node"], "torsional_stiffness": 4e4, "torsional_damping": 3.0},
            {"between": ["node", "fan"], "torsional_stiffness": 3e4},
        ],
        "run": {"duration": 1e-3},
    }  # fmt: skip


def test_turning_set__with_a_massless_node_is_the_limit_of_a_light_one() -> None:
    bare, light = stage(inertia=0.0), stage(inertia=1e-9)
    for speed in (None, 300.0, 2000.0):
        found, near = (gp.modes(document, speed=speed).ds for document in (bare, light))
        count, own = found.sizes["mode"], int(np.argmax(near["damping_ratio"].values))
        assert near["damping_ratio"].values[own] > 1.0 - 1e-9
        for name in ("frequency", "damping_ratio"):
            expected = np.delete(near[name].values, own)
            np.testing.assert_allclose(found[name].values, expected, rtol=1e-6, atol=1e-8)
    assert gp.campbell(bare, [0.0, 500.0, 1000.0]).ds["frequency"].shape == (3, count)
    shares = [gp.load_sharing(document).ds["share"].values for document in (bare, light)]
    np.testing.assert_allclose(shares[0], shares[1], rtol=1e-9)


def test_massless_planets__statics_do_not_depend_on_mass() -> None:
    heavy, bare = stage(inertia=1e-3), stage(inertia=0.0)
    bare["planetary"]["s"]["planets"] |= NODE
    bare["planetary"]["s"]["carrier"] |= NODE
    shares = [gp.load_sharing(document).ds["sun_force"].values for document in (heavy, bare)]
    np.testing.assert_allclose(shares[0], shares[1], rtol=1e-9)


def test_simulation__refuses_in_one_sentence() -> None:
    rule = r"rotors\.wheel\.inertia = 0\.0: must be greater than 0 kg m\^2 for a simulation over time\. Give it a pos"
    for act in (
        gp.simulate,
        gp.lyapunov,
        lambda case: gp.bifurcation(case, "meshes.0.backlash", [1e-5, 2e-5], ["wheel.theta"]),
    ):
        with pytest.raises(gp.InputError, match=rule):
            act(train())
    found = [each for each in gp.check_case(train()) if each.severity == "warning"]
    assert [each.path for each in found] == ["rotors.wheel.inertia", "rotors.pinion.inertia"]
    assert "a simulation over time refuses it" in found[0].message
    bare = stage(inertia=1.0)
    bare["planetary"]["s"]["planets"]["inertia"] = 0.0
    with pytest.raises(gp.InputError, match=r"^planetary\.s\.planets\.inertia = 0\.0: .*[^\n]*$"):
        gp.simulate(bare)
    with pytest.raises(gp.InputError, match=r"must be at least 1e-24 kg m\^2"):
        gp.load_case(train(1e-30))
    with pytest.raises(gp.InputError, match=r"must be 0 kg m\^2 or more"):
        gp.load_case(train(-1.0))


def test_what_does_not_move__needs_no_mass() -> None:
    """A held centre and a prescribed rotation have no equation of motion: 0 simulates as any other value."""
    results = []
    for mass, inertia in ((0.0, 0.0), (3.0, 0.7)):
        document = train(1e-3)
        for rotor in document["rotors"].values():
            rotor["mass"] = mass
        document["rotors"]["rotor"] |= {"inertia": inertia, "drive": {"kind": "speed", "speed": 10.0}}
        assert not [each for each in gp.check_case(document) if "over time" in each.message]
        results.append(gp.simulate(document))
    for signal, name in (("theta", "gen"), ("drive_force", "wheel-pinion")):
        np.testing.assert_array_equal(*(result.signal(signal, name) for result in results))


@pytest.mark.parametrize(
    ("document", "path"),
    [
        ({"rotors": {"a": NODE, "b": DISC}, "run": {"duration": 1e-3}}, "rotors.a.inertia"),
        (chain(NODE, NODE, k=1e3), r"rotors.d\d.inertia"),
        (
            chain(DISC, {**NODE, "floating": True}, k=1e3), "rotors.d1.mass",
        ),
        (
            {
                "rotors": {"a": {**DISC, "teeth": 20}, "b": {**NODE, "teeth": 30}},
                "meshes": [
                    {"driver": "a", "driven": "b", "module": 2e-3, "backlash": 1e-5,
                     "stiffness": {"kind": "harmonic", "mean": 1e8}}
                ],
                "run": {"duration": 1e-3},
            },
            "rotors.b.inertia",
        ),
        (chain(DISC, NODE, k=0.0, supports={"d1": {"torsional_damping": 1.0}}, couplings=[]), "rotors.d1.inertia"),
    ],
    ids=["alone", "together", "centre", "open mesh", "damper only"],
)  # fmt: skip
def test_nothing_elastic_holds_it__one_sentence(document: Document, path: str) -> None:
    with pytest.raises(gp.InputError, match=rf"^{path} = 0\.0: must be greater than 0 .* tie.*[^\n]*$"):
        gp.modes(document)


def test_condense__negative_stiffness_and_control() -> None:
    """Random springs of both signs, and a matrix that is not symmetric: K_mm - K_ms K_ss^-1 K_sm."""
    rng = np.random.default_rng(5)
    for n in range(3, 8):
        pull, push = rng.normal(size=(2 * n, n)), 0.7 * rng.normal(size=(n, n))
        light = np.arange(n) % 2 == 1
        matrix = pull.T @ pull - push.T @ push
        for stiffness, springs in ((matrix, (pull, push)), (matrix, None), (rng.normal(size=(n, n)), None)):
            found = condense(stiffness, springs, light)
            assert not isinstance(found, int)
            inner = np.linalg.inv(stiffness[np.ix_(light, light)])
            across = stiffness[np.ix_(light, ~light)]
            expected = stiffness[np.ix_(~light, ~light)] - stiffness[np.ix_(~light, light)] @ inner @ across
            np.testing.assert_allclose(found.stiffness, expected, atol=1e-9)
            np.testing.assert_allclose(found.recover[light], -inner @ across, atol=1e-9)


def test_rates_of_the_kernels__are_forces_on_massless_coordinates() -> None:
    """K does not depend on what has mass."""
    bare, heavy = (linear_system(gp.load_case(train(inertia))) for inertia in (0.0, 0.3))
    np.testing.assert_allclose(bare.stiffness, heavy.stiffness, rtol=1e-12)
    assert bare.mass.tolist() == [10.0, 0.0, 0.0, 2.0]


def test_teeth_of_massless_gears__no_damping_from_a_ratio_and_exact_loads() -> None:
    """2 zeta sqrt(k m_eq) with m_eq = 0; the force accelerates the inertias alone: (60 - 10 alpha) / r_b, alpha = 30 / 28."""
    document = train()
    document["rotors"]["rotor"]["drive"]["torque"] = 60.0
    case = gp.load_case(document)
    assert damping_maximum(case, 0, pack_stiffness(case, 0)) == 0.0
    base = 0.45 * math.cos(math.radians(20.0))
    assert tooth_loads(case) == pytest.approx([(60.0 - 10.0 * 30.0 / 28.0) / base], rel=1e-12)
