"""Does it jam in the cold: lines of jamming in a map over temperature, of a train with many meshes."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.case import Case
from gearplay.sweeps.plans.reading import make_plan
from gearplay.sweeps.report import jam
from gearplay.sweeps.report.drawable import View
from gearplay.sweeps.report.jam import excess_at, jam_lines
from gearplay.sweeps.report.maps import jam_lines_of
from gearplay.sweeps.running.evaluate import Sweep
from sweep_products import made

HOUSING, STEEL = {"expansion": 12.5e-6}, {"expansion": 11.5e-6}
KELVIN = 273.15


def cold_train() -> Case:
    """Return a planetary reducer whose housing and carrier shrink more than its gears."""
    changes: dict[str, Any] = {"environment": {"temperature": "20 degC", "housing": HOUSING}}
    case = gp.load_case("planetary-reducer")
    for name in case.planetary:
        for member in ("sun", "planets", "ring"):
            changes[f"planetary.{name}.{member}.material"] = STEEL
        changes[f"planetary.{name}.carrier.material"] = HOUSING
        changes[f"planetary.{name}.pin.shaft_radius"] = "10 mm"
    return gp.replace(case, changes)


@pytest.fixture(scope="module")
def sweep() -> Sweep:
    case = cold_train()
    name = next(iter(case.planetary))
    axes = [
        {"name": "temperature", "path": "environment.temperature", "low": "-60 degC", "high": "60 degC", "count": 3},
        {"name": "backlash", "path": f"planetary.{name}.backlash", "low": "1 um", "high": "200 um", "count": 3},
    ]  # fmt: skip
    kept = {"kind": "jam", "name": "jam", "mesh": case.meshes[0].label}
    return Sweep(make_plan(case, axes, [kept]))


@pytest.mark.slow
def test_lines__are_where_the_excess_vanishes(sweep: Sweep) -> None:
    across, up = ("temperature", KELVIN - 60.0, KELVIN + 60.0), ("backlash", 1e-6, 2e-4)
    lines = jam_lines(sweep, across, up, {})
    assert lines
    for line in lines:
        j = [mesh.label for mesh in sweep.template.base.meshes].index(line.mesh)
        left = [
            excess_at(sweep, j, {"temperature": float(x), "backlash": float(y)})
            for x, y in zip(line.across, line.up, strict=True)
        ]
        assert np.abs(left).max() < 1e-10  # m, of backlashes of 1e-4 m
        assert line.sides[1] == -1  # less backlash jams


@pytest.mark.slow
def test_lines__of_all_meshes_ask_for_each_case_once(sweep: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Mapping[str, Any]] = []
    replace: Callable[..., Case] = jam.replace

    def counted(case: Case, changes: Mapping[str, Any]) -> Case:
        asked.append(dict(changes))
        return replace(case, changes)

    monkeypatch.setattr(jam, "replace", counted)
    jam._excesses.cache_clear()
    across, up = ("temperature", KELVIN - 60.0, KELVIN + 60.0), ("backlash", 1e-6, 2e-4)
    lines = jam_lines(sweep, across, up, {})
    first = len(asked)
    assert len(sweep.template.base.meshes) > 3
    assert first < 2 * jam.THERMAL_POINTS * jam.NODES + 4 * len(lines) + 1
    jam_lines(sweep, across, up, {})
    assert len(asked) == first


def test_lines__over_the_clearance_of_a_sets_pins() -> None:
    """2 sin(alpha) c = b of every mesh of the set, c the clearance of its pins: a field of a planetary table."""
    case = gp.load_case("planetary-reducer")
    (name,) = case.planetary
    axes = [
        {
            "name": "x",
            "path": f"planetary.{name}.pin.radial_clearance",
            "low": 2e-5,
            "high": 4e-4,
            "count": 3,
        },
        {"name": "y", "path": f"planetary.{name}.backlash", "low": 2e-5, "high": 2e-4, "count": 3},
    ]
    sweep = Sweep(make_plan(case, axes, [{"kind": "jam", "name": "jam", "mesh": case.meshes[0].label}]))
    lines = jam_lines(sweep, ("x", 2e-5, 4e-4), ("y", 2e-5, 2e-4), {})
    assert [line.mesh for line in lines] == [mesh.label for mesh in case.meshes]
    for line in lines:
        assert line.sides == (1, -1)
        np.testing.assert_allclose(line.up, 2.0 * math.sin(math.radians(20.0)) * line.across, rtol=1e-8)
    kept = {"kind": "output", "name": "e", "statistic": "transmission_error"}
    plan = {"case": "planetary-reducer", "axes": axes, "reduce": [kept]}
    view = View(*made(plan, lambda kept, values, member: values["x"] + values["y"]))
    (shown,) = jam_lines_of(view, "x", "y", {})
    assert shown.mesh == f"{lines[0].mesh} and {len(lines) - 1} more"
