"""Cases of a sweep's points, and the addresses of their results."""

import random
from typing import Any

import pytest

from gearplay.sweeps.cases import template as module
from gearplay.sweeps.cases.template import Template
from gearplay.sweeps.plans.reading import load_sweep

RMS: dict[str, Any] = {"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}
GAP: dict[str, Any] = {"name": "gap", "path": "meshes.0.backlash", "values": ["50 um", "100 um"]}
MODEL: dict[str, Any] = {"name": "model", "path": "backlash_model", "values": ["coupled", "uncoupled"]}

# Fields of all sorts, each as an axis: listed, ranged, scaled, of several fields, with and without a unit.
AXES: list[dict[str, Any]] = [
    {**GAP, "values": [0, "1e-4 m", 1e-7, "33.3 um"]},
    MODEL,
    {"path": "rotors.pinion.drive.speed", "low": "7 rpm", "high": "333 rpm", "count": 4},
    {
        "path": "sleeves.ring.radial_clearance",
        "low": "1 um",
        "high": 1e-3,
        "count": 5,
        "scale": "log",
        "also": ["sleeves.ring.shaft_radius"],
    },
    {
        "path": "rotors.ring.mass",
        "mode": "scale",
        "low": 0.5,
        "high": 1.7,
        "count": 3,
        "also": ["rotors.ring.inertia"],
    },
    {"path": "rotors.ring.load.drag", "mode": "scale", "values": [0.1, 3]},
    {"path": "rotors.pinion.teeth", "values": [18, 21]},
    {"path": "rotors.pinion.floating", "values": [True, False]},
    {"path": "rotors.ring.initial.vx", "values": [0.1, "-3 mm/s"]},
    {"path": "rotors.ring.initial.theta", "values": ["1 deg", 0.0]},  # none in the base case
    {"path": "run.max_steps", "values": [10**6, 2**60]},  # none in the base case
    {"path": "gravity.1", "values": [-9.81, 0]},
    {"path": "title", "values": ['a "quoted" \\ one', "\u4e2d\u00e9\U0001f600"]},
    {"path": "meshes.0.transmission_error.0.phase", "values": ["10 deg", 1]},
    {"path": "meshes.0.damping.maximum", "values": [0.1, 1e-300]},
]
DRAWN: list[dict[str, Any]] = [
    {"name": "stiffness", "path": "meshes.0.stiffness.mean", "low": 1e8, "high": 2e8},
    {"name": "runout", "path": "rotors.ring.runout.amplitude", "mode": "scale", "low": 0.5, "high": 2.0},
]


def template(*axes: dict[str, Any], **more: Any) -> Template:
    return Template(load_sweep({"case": "han2021", "axes": list(axes), "reduce": [RMS], **more}))


def random_template(seed: int) -> Template:
    chance = random.Random(seed)
    axes = [{"name": f"axis_{i}", **axis} for i, axis in enumerate(chance.sample(AXES, chance.randint(1, 4)))]
    more: dict[str, Any] = {"members": chance.randint(1, 2)}
    if chance.random() < 0.5:
        more["design"] = {"count": 3, "seed": seed, "parameters": DRAWN}
    if chance.random() < 0.5:
        more["set"] = {"run.duration": "0.3 s", "sleeves.ring.law": "flores"}
    return template(*axes, **more)


@pytest.mark.parametrize("seed", range(12))
def test_address__tells_points_apart_and_is_the_same_again(seed: int) -> None:
    made, again = random_template(seed), random_template(seed)
    addresses = [made.address_of(index) for index in range(len(made.points))]
    assert len(set(addresses)) == len(addresses)
    assert addresses == [again.address_of(index) for index in range(len(made.points))]
    assert {len(address) for address in addresses} == {32}


def test_address__depends_on_limits() -> None:
    """A limit changes no number of a finished run; one that it ended must run again under another."""
    free, short, long = (
        template(GAP, **({"set": {"run.max_steps": steps}} if steps else {})) for steps in (None, 10, 10**9)
    )
    assert len({each.address_of(0) for each in (free, short, long)}) == 3
    varied = template({"name": "limit", "path": "run.max_steps", "values": [10, 10**9]})
    assert varied.address_of(0) != varied.address_of(1)


def test_storage_key__differs_by_members_and_reductions(monkeypatch: pytest.MonkeyPatch) -> None:
    one = template(GAP).address_of(0)
    two = template(GAP, members=2)
    assert two.address_of(0) == one
    assert two.address_of(1) != one
    for other in ({**RMS, "statistic": "peak"}, {**RMS, "name": "level"}, {**RMS, "at": "pinion"}):
        assert template(GAP, reduce=[other]).address_of(0) != one
    assert template(GAP, reduce=[RMS, {**RMS, "name": "again"}]).address_of(0) != one
    monkeypatch.setattr(module, "VERSION", "99.0")
    assert template(GAP).address_of(0) != one


def test_address__depends_on_no_title_name_or_order_of_axes() -> None:
    one, wanted = template(GAP, MODEL, title="one"), {"gap": 1e-4, "model": "uncoupled"}
    (index,) = (i for i in range(4) if one.points.at(i)[0] == wanted)
    turned = template(MODEL, {**GAP, "name": "backlash"}, title="other")
    assert turned.address_of(3) == one.address_of(index)


def test_an_address_changes_with_the_case() -> None:
    one = template(GAP).address_of(0)
    assert template(GAP, set={"run.seed": 1}).address_of(0) != one
    assert template(GAP, set={"rotors.ring.mass": 0.81}).address_of(0) != one
    assert template({**GAP, "values": ["51 um"]}).address_of(0) != one


def test_points_that_the_case_refuses_have_addresses() -> None:
    """58 teeth do not fit into a ring of 56; each is fine with the base case."""
    teeth = [
        {"name": "pinion", "path": "rotors.pinion.teeth", "values": [20, 58, 21]},
        {"name": "ring", "path": "rotors.ring.teeth", "values": [60, 56, 62]},
    ]
    made = template(*teeth)
    assert len({made.address_of(index) for index in range(9)}) == 9


def test_the_case_of_a_point_has_its_values() -> None:
    made = template(
        GAP, {"name": "speed", "path": "rotors.pinion.drive.speed", "values": ["60 rpm"]}, members=2
    )
    case, member = made.case_at(3)
    assert (case.meshes[0].backlash, member) == (1e-4, 1)
    assert case.rotors["pinion"].drive is not None
