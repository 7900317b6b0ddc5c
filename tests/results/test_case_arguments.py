"""One language for all functions: what they take as a case, what changes may say, what a read result can do, messages."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.calibration.spans import spans_of
from gearplay.calibration.trials import Problem
from gearplay.cli.main import run
from gearplay.model.reading import to_toml

PART = {"mass": 1.0, "inertia": 1e-3}
DISC: dict[str, Any] = {
    "rotors": {"disc": {**PART, "initial": {"x": 1e-4, "vx": 0.1}}},
    "supports": {"disc": {"stiffness": [1e6, 1e6], "damping": [20.0, 20.0]}},
    "run": {"duration": 0.1, "sampling": 1e4},
}
TURNED: dict[str, Any] = {
    "rotors": {"d": {**PART, "drive": {"kind": "torque", "torque": 1.0}}},
    "run": {"duration": 0.1, "sampling": 1e4},
}
MEAN_SPEED = [{"kind": "statistic", "name": "w", "signal": "omega", "at": "d", "statistic": "mean"}]


@pytest.mark.parametrize(
    "function",
    [
        gp.load_case,
        gp.check_case,
        lambda case: gp.replace(case, {"run.seed": 3}),
        lambda case: gp.simulate(case, duration=1e-3),
        gp.modes,
    ],
    ids=["load_case", "check_case", "replace", "simulate", "modes"],
)
def test_case__any_form_is_taken(function: Callable[[Any], Any], tmp_path: Path) -> None:
    file = tmp_path / "disc.toml"
    file.write_text(to_toml(gp.load_case(DISC)))
    for form in (DISC, gp.load_case(DISC), file, str(file)):
        function(form)


def _records(folder: Path) -> None:
    """Write two torques, 10 t and 20 t N m, as time and value."""
    for name, rate in (("a", 10.0), ("b", 20.0)):
        rows = [f"{k * 0.01},{rate * k * 0.01}" for k in range(11)]
        (folder / f"{name}.csv").write_text("\n".join(["t,T", *rows]) + "\n")


def _case(folder: Path, given: str = "a.csv") -> Path:
    file = folder / "case.toml"
    file.write_text(
        "[rotors.d]\nmass = 1.0\ninertia = 1e-3\n"
        'drive = { kind = "torque", torque = 1.0 }\n'
        f'load = {{ table = {{ file = "{given}" }} }}\n'
        "[run]\nduration = 0.1\nsampling = 1e4\n"
    )
    return file


def test_changes__may_name_the_file_of_a_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Paths in a file count from it, those in changes from the current directory; the old file need not be there."""
    (tmp_path / "cases").mkdir()
    _records(tmp_path / "cases")
    _records(tmp_path)
    monkeypatch.chdir(tmp_path)
    case = gp.load_case(_case(tmp_path / "cases"))
    assert case.rotors["d"].load.table.values[1] == pytest.approx(0.1)
    missing = _case(tmp_path / "cases", "nowhere.csv")
    changed = [
        gp.load_case(missing, ["rotors.d.load.table.file=b.csv"]),
        gp.replace(case, {"rotors.d.load.table.file": "b.csv"}),
        gp.replace(case, {"rotors.d.load.table": {"file": "b.csv"}}),
        gp.replace(case, {"rotors.d.load": {"torque": 0.0, "table": {"file": "b.csv"}}}),
    ]
    assert [each.rotors["d"].load.table.values[1] for each in changed] == pytest.approx([0.2] * 4)
    assert run(["check", str(missing), "--set", "rotors.d.load.table.file=b.csv"]) == 0


def test_sweep__over_the_file_of_a_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """J w' = 1 - r t from rest at rolling: the mean of w over T is (T / 2 - r T^2 / 6) / J more than at the start."""
    _records(tmp_path)
    monkeypatch.chdir(tmp_path)
    case = gp.load_case(_case(tmp_path))
    found = gp.sweep(case, {"rotors.d.load.table.file": ["a.csv", "b.csv"]}, reduce=MEAN_SPEED)
    assert found.ds["status"].values.tolist() == [0, 0]
    assert list(found.ds["file"].values) == ["a.csv", "b.csv"]
    for name, mean in zip(("a.csv", "b.csv"), found.ds["w"].values, strict=True):
        one = gp.simulate(gp.replace(case, {"rotors.d.load.table.file": name}))
        assert mean == pytest.approx(one.signal("omega").mean(), rel=1e-9)
    assert found.ds["w"].values[0] != found.ds["w"].values[1]


@pytest.mark.parametrize(
    ("path", "values", "unit"),
    [
        ("run.start", ["given", "drawn"], "1"),
        ("rotors.d.unbalance.amount", ["1 g mm", "2 g mm"], "kg m"),
        ("rotors.d.load.drag", [0.0, 1e-3], "N m s/rad"),
        ("rotors.d.material.expansion", [0.0, 1e-5], "1/K"),
    ],
)
def test_sweep__over_fields_that_the_case_does_not_write_out(path: str, values: list[Any], unit: str) -> None:
    found = gp.sweep(TURNED, {path: values}, reduce=MEAN_SPEED)
    name = path.rpartition(".")[2]
    assert found.ds["status"].values.tolist() == [0] * len(values)
    assert found.ds[name].attrs["units"] == unit


def _set(**changes: Any) -> dict[str, Any]:
    table = {
        "module": "4 mm",
        "backlash": "80 um",
        "stiffness": {"kind": "harmonic", "mean": 3e8},
        "sun": {"teeth": 20, **PART},
        "planets": {"count": 4, "teeth": 20, **PART},
        "ring": {"teeth": 60, "fixed": True, **PART},
        "carrier": PART,
        "pin": {"radial_clearance": "10 um", "stiffness": "1e10 N/m^1.5"},
    }
    return {
        "rotors": {"motor": {**PART, "drive": {"kind": "speed", "speed": 10.0}}, "fan": PART},
        "supports": {"fan": {"on": "stage.carrier", "stiffness": [1e6, 1e6]}},
        "planetary": {"stage": {**table, **changes}},
        "couplings": [{"between": ["motor", "stage.sun"], "torsional_stiffness": 1e3}],
        "run": {"duration": 0.1},
    }


@pytest.mark.parametrize(
    ("changes", "path"),
    [
        ({"module": "-4 mm"}, "planetary.stage.module"),
        ({"ring": {"teeth": 61, "fixed": True, **PART}}, "planetary.stage.ring.teeth"),
        ({"sun": {"teeth": 20, "masss": 1.0, **PART}}, "planetary.stage.sun.masss"),
        ({"planets": {"count": 0, "teeth": 20, **PART}}, "planetary.stage.planets.count"),
    ],
)
def test_fault__in_a_planetary_set_is_the_only_one(changes: dict[str, Any], path: str) -> None:
    gp.load_case(_set())
    with pytest.raises(gp.InputError) as caught:
        gp.load_case(_set(**changes))
    assert [fault.path for fault in caught.value.faults] == [path]


def test_fault__of_a_planetary_set_hides_no_other() -> None:
    document = _set(module="-4 mm")
    document["couplings"][0]["between"] = ["motro", "stage.sun"]
    with pytest.raises(gp.InputError) as caught:
        gp.load_case(document)
    assert [fault.path for fault in caught.value.faults] == [
        "planetary.stage.module",
        "couplings.0.between.0",
    ]


@pytest.mark.parametrize(
    ("given", "cure"),
    [
        (-60, r'Write "-60 degC" if these are degrees Celsius'),
        (-300.0, "Correct it; absolute zero is -273.15 degC"),
        ("-300 degC", "Correct it; absolute zero is -273.15 degC"),
    ],
)
def test_fault__negative_temperature(given: Any, cure: str) -> None:
    with pytest.raises(gp.InputError, match=cure):
        gp.load_case({**DISC, "environment": {"temperature": given}})
    cold = gp.load_case({**DISC, "environment": {"temperature": "-60 degC"}})
    assert cold.environment.temperature == pytest.approx(213.15)


@pytest.mark.slow
def test_read_result__computes_what_the_result_could(tmp_path: Path) -> None:
    result = gp.simulate(DISC)
    result.save(tmp_path / "run.nc")
    back = gp.read_result(tmp_path / "run.nc")
    for asked in ({"sampling": 1e6, "window": (0.01, 0.02)}, {"window": (0.0, 0.05)}, {"sampling": 3e3}):
        assert np.array_equal(back.signal("disc.x", **asked), result.signal("disc.x", **asked))


def _plan(**changes: Any) -> dict[str, Any]:
    return {
        "case": DISC,
        "parameters": [
            {"name": "k", "path": "supports.disc.stiffness.0", "low": 5e5, "high": 2e6},
            {"name": "c", "path": "supports.disc.damping.0", "low": 5.0, "high": 50.0},
        ],
        "sensor": {"rotor": "disc"},
        "simulation": {"members": 2, "duration": 0.5, "transient": 0.0},
        "effort": {"evaluations": 24, "startup": 16, "polish": 4, "polish_members": 2, "check_members": 2},
        "targets": [{"kind": "line", "name": "a", "near": 159.0, "search": 0.3}],
        "conditions": [
            {"name": each, "measured": {"a": {"amplitude": 10.0, "frequency": 160.0}}}
            for each in ("one", "two")
        ],
        **changes,
    }


def test_calibrate__models_free_different_parameters() -> None:
    """What a model does not free stays as the case has it."""
    models = [{"name": "both"}, {"name": "spring", "parameters": ["k"]}]
    plan = gp.load_plan(_plan(models=models))
    both, spring = (Problem(plan, model) for model in plan.models)
    assert [p.name for p in spring.parameters] == ["k"]
    assert (list(both.values((0.5, 0.5))), list(spring.values((0.5,)))) == (["k", "c"], ["k"])
    assert spring.cases_at({"k": 7e5})[0].supports["disc"].damping[0] == 20.0
    assert both.cases_at({"k": 7e5, "c": 30.0})[0].supports["disc"].damping[0] == 30.0
    assert spans_of(plan, []) == {}
    for wrong, words in (
        (
            [{"name": "x", "parameters": ["kk"]}],
            "must be the name of a parameter of the plan. Did you mean 'k'",
        ),
        ([{"name": "x", "parameters": ["k"]}], "must be freed by a model"),
    ):
        with pytest.raises(gp.InputError, match=words):
            gp.load_plan(_plan(models=wrong))


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_calibrate__a_case_without_mesh_in_a_folder_that_is_not_there(tmp_path: Path) -> None:
    """The answer begins with the interval against the case's own value."""
    pytest.importorskip("optuna")
    plan = _plan(models=[{"name": "spring", "parameters": ["k"]}, {"name": "both"}])
    found = gp.calibrate({**plan, "case": gp.load_case(DISC)}, folder=tmp_path / "new" / "out")
    assert (tmp_path / "new" / "out" / "report.html").exists()
    fits = {fit["model"]: fit for fit in found.document["fits"]}
    assert [len(fits[name]["parameters"]) for name in ("spring", "both")] == [1, 2]
    assert [row["case"] for row in fits["both"]["parameters"]] == [1e6, 20.0]
    assert found.message.startswith(("90 % intervals of the model ", "The data identify none of the "))


def test_calibrate__orders_need_a_mesh() -> None:
    with pytest.raises(
        gp.InputError, match=r"targets\.0\.order = 1: counts mesh frequencies, but the case has no mesh"
    ):
        Problem(
            gp.load_plan(_plan(targets=[{"kind": "line", "name": "a", "order": 1}])),
            gp.load_plan(_plan()).models[0],
        )
