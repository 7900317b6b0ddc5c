"""Statics across clearances and backlash: field rows, and random planetary sets against simulations that have settled."""

import json
import math

import numpy as np
import pytest

import gearplay as gp
from building import Document, Measured, merged
from depth import sized

FLOATING_SUN: Document = {
    "planetary": {
        "p": {
            "module": "3 mm",
            "backlash": "200 um",
            "sun_planet": {"kind": "harmonic", "mean": "2e8 N/m"},
            "planet_ring": {"kind": "harmonic", "mean": "3e8 N/m"},
            "damping": {"ratio": 0.1},
            "pin_errors": [{"planet": 1, "tangential": "20 um"}],
            "sun": {
                "teeth": 24, "mass": "1 kg", "inertia": "1e-3 kg m^2", "floating": True,
                "drive": {"kind": "speed", "speed": "10 rad/s"},
            },
            "planets": {"count": 3, "teeth": 30, "mass": "0.5 kg", "inertia": "5e-4 kg m^2"},
            "ring": {"teeth": 84, "mass": "5 kg", "inertia": "0.1 kg m^2", "fixed": True},
            "carrier": {"mass": "5 kg", "inertia": "0.05 kg m^2", "load": {"torque": "30 N m"}},
            "support": {"stiffness": ["1e9 N/m", "1e9 N/m"]},
        }
    },
    "run": {"duration": "0.1 s"},
}  # fmt: skip


def test_a_floating_sun_is_carried_across_its_gaps() -> None:
    """Field row 62: a settled simulation gives 0.3336, 0.3331, 0.3333."""
    for load, error in (("30 N m", "20 um"), ("300 N m", "60 um")):
        changes = {"carrier": {"load": {"torque": load}}, "pin_errors": [{"planet": 1, "tangential": error}]}
        found = gp.load_sharing(merged(FLOATING_SUN, {"planetary": {"p": changes}})).ds["share"].values
        np.testing.assert_allclose(found, 1.0 / 3.0, atol=2e-3)
    light = gp.load_sharing(FLOATING_SUN).ds["share"].values
    np.testing.assert_allclose(light, [0.3336, 0.3331, 0.3333], atol=1e-4)


@pytest.mark.parametrize("planet", [1, 2, 3])
@pytest.mark.parametrize("error", ["50 um", "-20 um"])
def test_the_bundled_reducer_shares_alike_with_an_error_on_any_planet(planet: int, error: str) -> None:
    off = {"planetary.stage.pin_errors": [{"planet": planet, "tangential": error}]}
    found = gp.load_sharing(gp.replace(gp.load_case("planetary-reducer"), off)).ds["share"].values
    np.testing.assert_allclose(found, 1.0 / 3.0, atol=1e-3)
    first = {"planetary.stage.pin_errors": [{"planet": 1, "tangential": error}]}
    same = gp.load_sharing(gp.replace(gp.load_case("planetary-reducer"), first)).ds["share"].values
    np.testing.assert_allclose(np.roll(same, planet - 1), found, atol=1e-6)  # turned by a planet


def test_a_light_load_on_a_large_inertia_has_modes_at_every_speed() -> None:
    """Field row n1: two stages in series, pins with clearance, floating suns, 0.5 N m of friction on 12 kg m^2."""
    pin = {
        "radial_clearance": "8 um", "shaft_radius": "2 mm", "material": {"modulus": "200 GPa", "poisson": 0.3},
        "restitution": 0.7,
    }  # fmt: skip

    def stage(module: str, sun: int, planet: int, drive: Document) -> Document:
        return {
            "module": module,
            "backlash": "20 um",
            "stiffness": {"kind": "harmonic", "mean": "1e8 N/m"},
            "damping": {"ratio": 0.05},
            "sun": {"teeth": sun, "mass": "5 g", "inertia": "2e-5 kg m^2", "floating": True, **drive},
            "planets": {"count": 3, "teeth": planet, "mass": "6 g", "inertia": "2e-7 kg m^2"},
            "ring": {
                "teeth": sun + 2 * planet, "fixed": True, "mass": "60 g", "inertia": "3e-5 kg m^2"
            },
            "carrier": {"mass": "40 g", "inertia": "4e-6 kg m^2"},
            "pin": pin,
        }  # fmt: skip

    case = {
        "rotors": {"array": {"mass": "40 kg", "inertia": "12 kg m^2", "load": {"friction": "0.5 N m"}}},
        "planetary": {
            "s1": stage("0.5 mm", 18, 27, {"drive": {"kind": "speed", "speed": "30 rpm"}}),
            "s2": stage("0.8 mm", 21, 24, {}),
        },
        "couplings": [
            {"between": ["s1.carrier", "s2.sun"], "torsional_stiffness": "800 N m/rad"},
            {"between": ["s2.carrier", "array"], "torsional_stiffness": "3000 N m/rad"},
        ],
        "run": {"duration": "1 s"},
    }
    at_rest = gp.modes(case).ds
    assert at_rest["closed"].values.sum() == 18  # six pins, the drive flanks of twelve meshes
    turning = gp.modes(case, speed="30 rpm").ds
    np.testing.assert_allclose(turning["frequency"].values[0], at_rest["frequency"].values[0], rtol=1e-2)
    assert gp.campbell(case, ["5 rpm", "15 rpm", "30 rpm"]).ds.sizes["mode"] == at_rest.sizes["mode"]


def random_set(seed: int) -> tuple[gp.Case, float]:
    """Return a random planetary set and its load [N m]: 3 to 6 planets, pins and teeth off, 0.1 to 100 N m per mm of module."""
    rng = np.random.default_rng([42, seed])
    while True:
        count, sun, planet = int(rng.integers(3, 7)), int(rng.integers(15, 40)), int(rng.integers(15, 50))
        apart = (sun + planet) * math.sin(math.pi / count) > planet + 2.5
        if 2 * (sun + planet) % count == 0 and apart:
            break
    module = float(rng.uniform(0.5e-3, 8e-3))
    torque = float(10.0 ** rng.uniform(-1.0, 2.0) * module * 1e3)
    k = float(10.0 ** rng.uniform(7.7, 9.0))
    stage: Document = {
        "module": module,
        "backlash": float(rng.random() * min(0.08 * module, 200e-6)),
        "sun_planet": {"kind": "harmonic", "mean": k},
        "planet_ring": {"kind": "harmonic", "mean": float(k * rng.uniform(0.8, 1.5))},
        "damping": {"ratio": 0.1},
        "sun": {
            "teeth": sun, "mass": 0.5, "inertia": 1e-3, "floating": bool(rng.random() < 0.6),
            "drive": {"kind": "speed", "speed": 10.0},
        },
        "planets": {"count": count, "teeth": planet, "mass": 0.5, "inertia": 1e-3},
        "ring": {"teeth": sun + 2 * planet, "mass": 2.0, "inertia": 1e-2, "fixed": True},
        "carrier": {"mass": 2.0, "inertia": 1e-2, "load": {"torque": torque}},
    }  # fmt: skip
    if rng.random() < 0.6:
        clearance = 0.0 if rng.random() < 0.5 else float(rng.uniform(2e-6, 30e-6))
        stiffness = float(10.0 ** rng.uniform(9.7, 10.7))
        stage["pin"] = {
            "radial_clearance": clearance, "law": "hunt-crossley", "stiffness": stiffness, "restitution": 0.3
        }  # fmt: skip
    else:
        stage["support"] = {
            "stiffness": [float(10.0 ** rng.uniform(7.5, 9.3))] * 2,
            "damping": [500.0, 500.0],
        }
    size = float(rng.choice([5e-6, 20e-6, 60e-6]))
    stage["pin_errors"] = [
        {
            "planet": k + 1,
            "tangential": float(rng.normal() * size),
            "radial": float(0.3 * rng.normal() * size),
        }
        for k in range(count)
        if rng.random() < 0.7
    ]
    case = gp.load_case({"planetary": {"s": stage}, "run": {"duration": 0.1}})
    if rng.random() < 0.5:  # thickness of the teeth, mesh by mesh
        meshes = [
            mesh.model_copy(update={"backlash": max(0.0, mesh.backlash + 1e-5 * float(rng.normal()))})
            for mesh in case.meshes
        ]
        case = case.model_copy(update={"meshes": tuple(meshes)})
    return case, torque


def settled(case: gp.Case, softest: float) -> np.ndarray | None:
    """Return the forces of all meshes [N] near and at the end of a run without speed, with dampers that let it settle.

    None where it takes too many steps, as where contacts bounce on.

    Light, alike bodies, their centres damped critically for the geometric stiffness ``softest`` [N/m], as the slowest motion has.
    """
    mass = 0.1
    duration = 25.0 * math.sqrt(mass / softest)
    document = case.model_dump()
    del document["planetary"]  # its members stand as plain rotors, so that they can be changed one by one
    document = json.loads(json.dumps(document).replace('"s.', '"s_'))
    for name, rotor in document["rotors"].items():
        rotor |= {"mass": mass, "inertia": 2e-4, "radial_damping": 2.0 * math.sqrt(mass * softest)}
        if name == "s_sun":
            rotor["drive"]["speed"] = 1e-6
        if name == "s_carrier":
            rotor["inertia"] = 0.5 * case.planetary["s"].distance ** 2
    labels = [mesh.label.replace("s.", "s_") for mesh in case.meshes]
    result = gp.simulate(
        gp.Case.model_validate(document),
        duration=duration,
        transient=0.0,
        sampling=20.0 / duration,
        policy=gp.Policy(tolerance=1e-8, max_steps=40_000),
        signals=["drive_force", "back_force"],
    )
    if result.ds.attrs["status"] != "DONE":
        return None
    forces = [result.signal("drive_force", label) - result.signal("back_force", label) for label in labels]
    return np.array(forces)[:, [-6, -1]]


@pytest.mark.slow
def test_random_planetary_sets_are_where_a_simulation_settles(measured: Measured) -> None:
    """All are found; force of every mesh of the sun, to a millionth of the load of a planet, of those whose run settles."""
    worst, judged, wanted = 0.0, 0, sized(60, 3, torture=150)
    for seed in range(sized(500)):
        case, torque = random_set(seed)
        table = case.planetary["s"]
        found = gp.load_sharing(case).ds["sun_force"].values
        load = float(found.sum()) / found.size
        base = 0.5 * table.module * table.sun.teeth * math.cos(table.pressure_angle)
        input_torque = torque * table.sun.teeth / (table.sun.teeth + table.ring.teeth)
        assert found.sum() * base == pytest.approx(input_torque, rel=2e-2), seed  # as its pressure angle is
        if judged == wanted:
            continue
        sun = [j for j, mesh in enumerate(case.meshes) if "s.sun" in mesh.rotors]
        both = settled(case, load / table.distance)
        if both is None or np.max(np.abs(both[sun, 1] - both[sun, 0])) > 1e-7 * load:
            continue  # what swings on is no judge
        forces = both[sun, 1] * np.sign(both[sun, 1].sum())
        worst, judged = max(worst, float(np.max(np.abs(forces - found))) / load), judged + 1
    assert judged == wanted
    assert worst < 1e-6
    measured("largest difference of a mesh force, per the load of a planet", worst, "relative")
