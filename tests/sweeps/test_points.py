"""Points of a sweep: grids in SI, their order, and what is refused before anything runs."""

from itertools import product
from typing import Any

import numpy as np
import pytest

from gearplay.model.reading import load_case
from gearplay.sweeps.cases.draws import sample_size
from gearplay.sweeps.cases.points import Points, order_of, points_of
from gearplay.sweeps.cases.template import Template
from gearplay.sweeps.plans.reading import load_sweep, make_plan
from gearplay.vocabulary.errors import InputError, ResourceError

BASE = load_case("han2021")
RPM = np.pi / 30.0
SPEED: dict[str, Any] = {"name": "speed", "path": "rotors.pinion.drive.speed"}
GAP: dict[str, Any] = {"name": "gap", "path": "meshes.0.backlash"}
MODEL: dict[str, Any] = {"name": "model", "path": "backlash_model", "values": ["coupled", "uncoupled"]}
REDUCE = [{"kind": "jam", "name": "jam", "mesh": "pinion-ring"}]


def document(*axes: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"case": "han2021", "axes": list(axes), "reduce": REDUCE, **more}


def points(*axes: dict[str, Any], **more: Any) -> Points:
    return points_of(load_sweep(document(*axes, **more)), BASE)


def test_a_grid_is_even_in_si_with_its_ends() -> None:
    (values,) = points({**SPEED, "low": "20 rpm", "high": "300 rpm", "count": 15}).values
    assert len(values) == 15
    assert values == pytest.approx([RPM * v for v in range(20, 301, 20)], rel=1e-14)
    assert all(type(v) is float for v in values)


def test_a_logarithmic_grid_has_even_ratios() -> None:
    (values,) = points({**GAP, "low": "10 um", "high": 1e-3, "count": 5, "scale": "log"}).values
    assert np.diff(np.log10(values)) == pytest.approx([0.5] * 4)
    assert (values[0], values[-1]) == pytest.approx((1e-5, 1e-3), rel=1e-14)


def test_a_grid_may_fall() -> None:
    assert points({**GAP, "low": 3e-4, "high": 1e-4, "count": 3}).values[0] == pytest.approx(
        [3e-4, 2e-4, 1e-4]
    )


def test_lists_keep_their_order_and_become_si() -> None:
    (values,) = points({**GAP, "values": ["300 um", 1e-5, "0.2 mm", 0]}).values
    assert values == pytest.approx((3e-4, 1e-5, 2e-4, 0.0))
    assert all(type(v) is float for v in values)


@pytest.mark.parametrize(
    ("path", "values"),
    [
        ("backlash_model", ["uncoupled", "coupled"]),
        ("rotors.pinion.teeth", [18, 20]),
        ("rotors.pinion.floating", [True, False]),
        ("title", ["a", "é \u4e2d"]),
    ],
)
def test_any_field_may_be_listed(path: str, values: list[Any]) -> None:
    (found,) = points({"name": "any", "path": path, "values": values}).values
    assert list(found) == values
    assert [type(v) for v in found] == [type(v) for v in values]


def test_factors_multiply_what_the_case_has() -> None:
    axis = {**GAP, "mode": "scale", "values": [0.5, 2], "also": ["sleeves.ring.radial_clearance"]}
    template = Template(load_sweep(document(axis, set={"sleeves.ring.radial_clearance": "300 um"})))
    assert template.points.values == ((0.5, 2.0),)
    for index, factor in enumerate((0.5, 2.0)):
        case, _ = template.case_at(index)
        assert case.meshes[0].backlash == factor * 1e-4
        assert case.sleeves["ring"].radial_clearance == factor * 3e-4
    ranged = points({**GAP, "mode": "scale", "low": 0.5, "high": 1.5, "count": 3})
    assert ranged.values == ((0.5, 1.0, 1.5),)


def test_further_fields_get_the_same_value() -> None:
    axis = {**GAP, "values": ["50 um", "70 um"], "also": ["sleeves.ring.radial_clearance"]}
    template = Template(load_sweep(document(axis)))
    for index, value in enumerate((5e-5, 7e-5)):
        case, _ = template.case_at(index)
        assert (case.meshes[0].backlash, case.sleeves["ring"].radial_clearance) == pytest.approx(
            (value, value)
        )
    with pytest.raises(InputError, match=r"axes\.0\.values\.0: rotors\.ring\.mass"):
        points({**axis, "also": ["rotors.ring.mass"]})


def test_points_come_in_c_order() -> None:
    """Axes as listed, then the sample, then the member, the last one fastest."""
    parameter = {"name": "drag", "path": "rotors.ring.load.drag", "low": 1e-4, "high": 1e-3}
    found = points(
        {**GAP, "values": [1e-5, 2e-5, 3e-5]},
        MODEL,
        design={"count": 4, "parameters": [parameter]},
        members=2,
    )
    assert found.dims == ("gap", "model", "sample", "member")
    assert found.shape == (3, 2, 4, 2)
    drags = [float(v) for v in found.sample[:, 0]]
    expected = [  # every drawn point has members of its own, none of them the undisturbed one, 0
        ({"gap": gap, "model": model, "drag": drag}, 1 + 2 * at + member)
        for gap, model, (at, drag), member in product(
            (1e-5, 2e-5, 3e-5), MODEL["values"], enumerate(drags), (0, 1)
        )
    ]
    assert [found.at(i) for i in range(len(found))] == expected
    assert len(found) == 48
    assert [found.job(i) for i in range(found.jobs)] == [[2 * i, 2 * i + 1] for i in range(24)]
    assert all(1e-4 <= drag <= 1e-3 for drag in drags)


@pytest.mark.parametrize(("members", "size"), [(1, 1), (4, 4), (16, 16), (34, 2), (37, 1), (60, 15)])
def test_jobs_are_members_of_one_case(members: int, size: int) -> None:
    found = points({**GAP, "values": [1e-5, 2e-5]}, members=members)
    jobs = [found.job(number) for number in range(found.jobs)]
    assert [i for job in jobs for i in job] == list(range(len(found)))
    for job in jobs:
        at = [found.at(i) for i in job]
        assert len(job) == size
        assert {values["gap"] for values, _ in at} == {at[0][0]["gap"]}
        assert [member for _, member in at] == list(range(at[0][1], at[0][1] + size))


def test_one_member_and_no_design_have_no_dimension() -> None:
    found = points({**GAP, "values": [1e-5]})
    assert (found.dims, found.shape) == (("gap",), (1,))
    assert found.at(0) == ({"gap": 1e-5}, 0)


def test_saltelli_has_points_for_every_parameter() -> None:
    parameters = [{**GAP, "low": 1e-5, "high": 2e-5}, {**SPEED, "low": "1 rpm", "high": "2 rpm"}]
    plan = load_sweep(document(design={"kind": "saltelli", "count": 8, "parameters": parameters}))
    assert plan.design is not None
    assert points_of(plan, BASE).shape == (sample_size(plan.design),) == (8 * (2 + 2),)


def test_carried_points_are_in_one_job_each() -> None:
    axis = {**SPEED, "low": "60 rpm", "high": "120 rpm", "count": 3}
    found = points(MODEL, axis, carry={"axis": "speed"}, members=2, set={"run.transient": 1.0})
    assert found.dims == ("model", "speed", "direction", "member")
    jobs = [found.job(number) for number in range(found.jobs)]
    assert sorted(i for job in jobs for i in job) == list(range(len(found)))
    for job in jobs:
        told = [found.at(i) for i in job]
        rest = {(values["model"], values["direction"], member) for values, member in told}
        assert len(rest) == 1
        speeds = [values["speed"] for values, _ in told]
        assert speeds == sorted(speeds, reverse=told[0][0]["direction"] == "down")


def test_the_order_of_work_is_fixed_and_complete() -> None:
    order = [int(i) for i in order_of(1000)]
    assert sorted(order) == list(range(1000))
    assert order != sorted(order)
    assert order == [int(i) for i in order_of(1000)]


def test_axes_by_path_are_named_after_it() -> None:
    plan = make_plan(
        "han2021",
        {"rotors.pinion.mass": [0.1], "rotors.ring.mass": [0.2, 0.3], "meshes.0.backlash": [0]},
        REDUCE,
    )
    assert [axis.name for axis in plan.axes] == ["mass", "ring_mass", "backlash"]
    assert points_of(plan, BASE).shape == (1, 2, 1)


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ([{**GAP, "values": ["1 um", "1 s"]}], r"axes\.0\.values\.1: meshes\.0\.backlash"),
        ([MODEL, {**GAP, "low": "1 um", "high": "1 rpm", "count": 3}], r"axes\.1\.high: meshes\.0\.backlash"),
        ([{**GAP, "low": 0.0, "high": 1e-4, "count": 3, "scale": "log"}], r"axes\.0\.low = 0\.0: must be above 0"),
        ([{**GAP, "low": 1e-4, "high": 0.0, "count": 3, "scale": "log"}], r"axes\.0\.low = .*must be above 0"),
        ([{**MODEL, "values": ["couplet"]}], r"axes\.0\.values\.0: backlash_model"),
        ([{"name": "a", "path": "gravity", "low": 0.0, "high": 1.0, "count": 2}], r"axes\.0\.low: gravity"),
        ([{**GAP, "path": "meshes.0", "values": [1.0]}], r"axes\.0\.values\.0: meshes\.0"),
        ([{**GAP, "path": "meshes.0.backlash.more", "values": [1.0]}], r"axes\.0\.values\.0: meshes\.0\.backlash"),
        ([{**GAP, "mode": "scale", "values": ["2"]}], r"axes\.0\.values\.0 = \"2\": must be a plain number"),
        ([{**GAP, "mode": "scale", "values": [True]}], r"axes\.0\.values\.0 = true: must be a plain number"),
    ],
)  # fmt: skip
def test_values_that_the_case_does_not_take(axes: list[dict[str, Any]], words: str) -> None:
    with pytest.raises(InputError, match=words):
        points(*axes)


def test_too_many_points_are_refused() -> None:
    with pytest.raises(ResourceError, match="are more than the limit of 1e\\+08"):
        points(
            {**SPEED, "low": "1 rpm", "high": "2 rpm", "count": 20_000},
            {**GAP, "low": 0.0, "high": 1e-4, "count": 5001},
        )
