from typing import Any

import pytest

from calibration_problems import MEASURED, small_plan
from gearplay.calibration.plan import to_value
from gearplay.calibration.reading import load_plan
from gearplay.calibration.trials import Problem
from gearplay.model.bundled import bundled
from gearplay.vocabulary.errors import InputError


@pytest.mark.parametrize("name", bundled("gearplay.calibration", "plans"))
def test_bundled_plans_fit_their_cases(name: str) -> None:
    plan = load_plan(name)
    for model in plan.models:
        problem = Problem(plan, model)
        assert len(problem.cases_at(problem.values([0.5] * len(plan.parameters)))) == len(plan.conditions)


def test_bounds_are_read_in_si() -> None:
    plan = small_plan()
    assert Problem(plan, plan.models[0]).bounds == [(1e-4, 1e-2), (1e-8, pytest.approx(1e-6))]


def test_a_scaled_parameter_multiplies_what_each_condition_has() -> None:
    plan = small_plan(
        parameters=[
            {
                "name": "clearance",
                "path": "sleeves.ring.radial_clearance",
                "low": 0.5,
                "high": 2.0,
                "mode": "scale",
            }
        ],
        conditions=[
            {"name": "a", "set": {"sleeves.ring.radial_clearance": "100 um"}, "measured": MEASURED},
            {"name": "b", "set": {"sleeves.ring.radial_clearance": "200 um"}, "measured": MEASURED},
        ],
    )
    problem = Problem(plan, plan.models[0])
    found = [case.sleeves["ring"].radial_clearance for case in problem.cases_at({"clearance": 1.5})]
    assert found == pytest.approx([150e-6, 300e-6])


def test_models_free_parameters_of_their_own() -> None:
    """A worn bush or worn teeth: each model moves its own clearance, the other stays as on the drawing."""
    bush = {"name": "bush", "path": "sleeves.ring.radial_clearance", "low": "100 um", "high": "400 um"}
    teeth = {"name": "teeth", "path": "meshes.0.backlash", "low": "100 um", "high": "400 um"}
    models = [{"name": "worn bush", "parameters": ["bush"]}, {"name": "worn teeth", "parameters": ["teeth"]}]
    plan = small_plan(parameters=[bush, teeth], models=models)
    found = {}
    for model in plan.models:
        problem = Problem(plan, model)
        assert len(problem.bounds) == 1
        (case, *_) = problem.cases_at(problem.values([0.5]))
        found[model.name] = (case.sleeves["ring"].radial_clearance, case.meshes[0].backlash)
    assert found == {
        "worn bush": pytest.approx((200e-6, 100e-6)),
        "worn teeth": pytest.approx((100e-6, 200e-6)),
    }


def test_scales() -> None:
    assert to_value(0.25, 1e-4, 1e4, "log") == pytest.approx(1e-2)
    assert to_value(1.0, 2.0, 4.0, "linear") == 4.0


DRAG = {"name": "drag", "path": "rotors.ring.load.drag", "low": 1e-4, "high": 1e-2}
HUMP = {"kind": "hump", "name": "radial", "band": [2.0, 12.0]}
FAULTS: list[tuple[dict[str, Any], str]] = [
    ({"parameters": [DRAG, DRAG]}, 'parameters.1.name = "drag": must not be given twice'),
    ({"parameters": [{**DRAG, "high": 1e-5}]}, "parameters.0.high = 1e-05: must be above low"),
    ({"parameters": [{**DRAG, "low": 0.0}]}, "parameters.0.low = 0.0: must be above 0 on a log scale"),
    ({"parameters": [{**DRAG, "low": "1 kg"}]}, "parameters.0.low: rotors.ring.load.drag"),
    ({"parameters": [{**DRAG, "path": "rotors.ring.load.drgg"}]}, "Did you mean 'drag'"),
    ({"parameters": [{**DRAG, "path": "title"}]}, "parameters.0.low: title"),
    ({"parameters": [{**DRAG, "mode": "scale", "low": "1 N"}]}, "must be a plain number, as a factor"),
    ({"sensor": {"rotor": "rng"}}, 'sensor.rotor = "rng": must be a rotor of the case. Rotors: pinion, ring.'),
    ({"sensor": {"rotor": "ring", "accelerometer": {"angle": 1.0}}}, "sensor.accelerometer.angle = 1.0: must not be given"),
    ({"targets": [{"kind": "line", "name": "mesh"}]}, "targets.0.order: must be given, or near"),
    ({"targets": [{**HUMP, "kind": "bump"}]}, 'targets.0.kind = "bump": must be one of line, hump, level, statistic'),
    ({"targets": [{**HUMP, "bnd": 1}]}, "targets.0.bnd: unknown field"),
    ({"targets": [{"kind": "statistic", "name": "s", "statistic": "peak_force"}]}, "targets.0.contact"),
    ({"conditions": [{"name": "a"}]}, "conditions.0.measured"),
    ({"conditions": [{"name": "a", "measured": {"radal": {"amplitude": 1.0}}}]}, "must be the name of a target"),
    ({"conditions": [{"name": "a", "measured": {"radial": {"value": 1.0}}}]}, "does not belong to a hump"),
    ({"conditions": [{"name": "a", "set": {"x": 1}, "measured": MEASURED}]}, "conditions.0.set: x: unknown field"),
    ({"effort": {"evaluations": 10, "startup": 9, "polish": 9}}, "effort.evaluations = 10: must be at least startup"),
    ({"case": "han2022"}, "Did you mean 'han2021'"),
    ({"redings": ["absolute"]}, "redings: unknown field. Did you mean 'readings'?"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "words"), FAULTS, ids=[words[:40] for _, words in FAULTS])
def test_faults_are_named(changes: dict[str, Any], words: str) -> None:
    def build() -> None:
        plan = small_plan(**changes)
        Problem(plan, plan.models[0])

    with pytest.raises(InputError) as caught:
        build()
    assert words in str(caught.value)


def test_a_plan_that_is_not_there_is_named() -> None:
    with pytest.raises(InputError, match="Did you mean 'han2021'"):
        load_plan("han2012")


def test_missing_lists_are_named_as_a_file_writes_them() -> None:
    with pytest.raises(
        InputError, match=r"conditions: is required\. Add a table \[\[conditions\]\] with name\."
    ):
        load_plan({"case": "han2021", "sensor": {"rotor": "ring"}})
