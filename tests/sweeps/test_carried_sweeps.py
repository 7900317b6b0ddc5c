"""Sweeps that carry their state: the same as runs chained by hand, windows of a run-up as one run."""

from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.solver.simulate import run_one
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.sweep import sweep
from gearplay.vocabulary.errors import Fault, InputError

RPM = np.pi / 30.0
PATH = "rotors.pinion.drive.speed"
PLAN: dict[str, Any] = {
    "case": "han2021",
    "set": {
        "run.duration": 0.02,
        "run.transient": 0.02,
        "run.sampling": 1e3,
        "rotors.ring.initial": {"vx": 0.05},
    },
    "axes": [{"name": "speed", "path": PATH, "values": ["60 rpm", "90 rpm", "120 rpm"]}],
    "carry": {"axis": "speed", "ramp": 0.01},
    "reduce": [
        {"kind": "history", "name": "path", "signal": "x", "at": "ring"},
        {"kind": "statistic", "name": "speed_mean", "signal": "omega", "at": "pinion", "statistic": "mean"},
    ],
}


def plan_with(**changes: Any) -> SweepPlan:
    return load_sweep({**PLAN, **changes})


def test_steps_are_runs_chained_by_hand() -> None:
    found = sweep(plan_with(), reduce=None).ds
    assert found.path.dims == ("speed", "direction", "path_time")
    base = gp.replace(gp.load_case("han2021"), PLAN["set"])
    for direction, way in (("up", (60.0, 90.0, 120.0)), ("down", (120.0, 90.0, 60.0))):
        origin, before = None, 0.0
        for rpm in way:
            drive = {PATH: rpm * RPM}
            if before:
                drive |= {
                    "rotors.pinion.drive.start_speed": before * RPM,
                    "rotors.pinion.drive.ramp": 0.01,
                }
            run = run_one(gp.replace(base, drive), origin=origin)
            origin, before = run.end, rpm
            kept = found.path.sel(direction=direction).sel(speed=rpm * RPM, method="nearest")
            assert np.array_equal(kept.values, run.signal("x", "ring"))
    assert not np.array_equal(found.path.sel(direction="up"), found.path.sel(direction="down"))


def test_windows_of_a_run_up_are_one_run() -> None:
    """Three windows of 10 ms against one ramp of 30 ms; their mean speeds are the axis's."""
    base = {**PLAN["set"], "run.duration": 0.01, "run.transient": 0.0, "run.tolerance": 1e-11}
    carry = {"axis": "speed", "mode": "run-up", "directions": ["up"]}
    found = sweep(plan_with(set=base, carry=carry)).ds
    drive = {"kind": "speed", "speed": 135.0 * RPM, "start_speed": 45.0 * RPM, "ramp": 0.03}
    whole = gp.replace(gp.load_case("han2021"), {**base, "run.duration": 0.03, "rotors.pinion.drive": drive})
    run = run_one(whole)
    windows = found.path.sel(direction="up").values.ravel()
    assert np.allclose(windows, run.signal("x", "ring"), atol=1e-9)
    means = found.speed_mean.sel(direction="up").values / RPM
    assert np.allclose(means, [60.0, 90.0, 120.0], atol=2.0)  # samples begin at each window's start


def test_orders_of_a_run_up_count_from_the_window_s_mean_speed() -> None:
    made = Sweep(plan_with(carry={"axis": "speed", "mode": "run-up", "directions": ["up", "down"]}))
    chain = made.template.carried
    assert chain is not None
    for direction in ("up", "down"):
        for speed in chain.values:
            end = chain.changes(speed, direction)[PATH]
            assert chain.slowness(speed, direction) * end == pytest.approx(speed)


def test_continued_sequence__a_failure_is_stated_in_every_later_case() -> None:
    """A case that cannot mesh at 90 rpm leaves 60 rpm good and 120 rpm without a start."""
    made = Sweep(plan_with(carry={"axis": "speed", "ramp": 0.01, "directions": ["up"]}))
    case_at = made.template.case_at

    def failing(index: int) -> Any:
        case, member = case_at(index)
        return (gp.replace(case, {"run.max_steps": 1}), member) if index == 1 else (case, member)

    made.template.case_at = failing  # type: ignore[method-assign]
    outcomes = made.evaluate(0)
    assert [o.status for o in outcomes] == [0, 20, 20]
    assert "limit on steps" in outcomes[1].reason
    assert outcomes[2].reason.startswith("the case before it did not finish")
    assert len({o.address for o in outcomes}) == 3


def test_addresses_tell_ways_apart() -> None:
    both = Sweep(plan_with())
    everything = {both.template.address_of(i) for i in range(6)}
    assert len(everything) == 6
    longer = Sweep(plan_with(axes=[{**PLAN["axes"][0], "values": ["30 rpm", "60 rpm", "90 rpm", "120 rpm"]}]))
    assert everything.isdisjoint(
        {longer.template.address_of(i) for i in (2, 4, 6)}
    )  # up, after another start


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"carry": {"axis": "sped"}}, "carry.axis = .*must be the name of an axis"),
        ({"carry": {"axis": "speed", "ramp": 0.5}}, r"carry.ramp = .*must fit into the transient"),
        ({"carry": {"axis": "speed", "directions": ["up", "up"]}}, "must not name a direction twice"),
        (
            {"axes": [{"name": "speed", "path": PATH, "values": [2.0, 1.0]}]},
            "must have at least two values, rising",
        ),
        (
            {"axes": [{"name": "speed", "path": "sleeves.ring.radial_clearance", "values": [1e-5, 2e-5]}]},
            "must set the speed of one drive",
        ),
    ],
)
def test_chains_that_cannot_be(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(gp.InputError, match=words):
        Sweep(plan_with(**changes))


@pytest.mark.parametrize("refused", [True, False])
def test_a_lead_that_fails_is_rows_with_its_reason(refused: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """What runs before the first case may be refused, or not finish: the sweep goes on, and says so."""
    carry = {"axis": "speed", "mode": "run-up", "directions": ["up"]}
    made = Sweep(plan_with(carry=carry))
    begun: list[float] = []

    def run(case: Any, *rest: Any, **more: Any) -> Any:
        begun.append(case.run.duration)
        if refused:
            raise InputError(Fault("run.duration", 0.0, "must be something else", "Change it"))
        done = run_one(case, *rest, **more)
        monkeypatch.setattr(type(done), "success", property(lambda _: False))
        monkeypatch.setattr(type(done), "message", property(lambda _: "stuck"))
        return done

    monkeypatch.setattr("gearplay.sweeps.running.evaluate.run_one", run)
    outcomes = made.evaluate(0)
    assert len(begun) == 1
    assert len(outcomes) == 3
    words = "what runs before the first case did not finish: " + ("run.duration = 0" if refused else "stuck")
    assert all(outcome.reason.startswith(words) for outcome in outcomes)
