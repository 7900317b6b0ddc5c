"""Search of a calibration: the same trials after twenty kills."""

import threading
from typing import Any

import numpy as np
import pytest

from calibration_problems import KnownProblem, ListStore, small_plan
from gearplay.calibration import search
from gearplay.calibration.objective import Comparison, data_of, printed_measurements
from gearplay.calibration.search import Search, run_search
from gearplay.calibration.trials import POLISH, SEARCH, STARTUP, Observations, Trial, distinct

PLAN = small_plan()
PROBLEM = KnownProblem(PLAN, PLAN.models[0])
DATA = data_of(PLAN, printed_measurements(PLAN))
COMPARISONS = [Comparison(DATA, "absolute"), Comparison(DATA, "unnormalised")]


@pytest.fixture(scope="module")
def whole() -> ListStore:
    store = ListStore()
    run_search(PROBLEM, COMPARISONS, store)
    return store


@pytest.mark.slow
@pytest.mark.hostile
def test_a_search_killed_twenty_times_reaches_the_same_trials(whole: ListStore) -> None:
    store, kills = ListStore(), 0
    while True:
        store.patience = 1 + kills % 4
        try:
            run_search(PROBLEM, COMPARISONS, store)
        except KeyboardInterrupt:
            kills += 1
            continue
        break
    assert kills >= 20
    assert store.trials == whole.trials


@pytest.mark.slow
@pytest.mark.parametrize("turn", [1, 3])
def test_search__a_resumed_one_requests_the_same_points(turn: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the last bit: points that differ in the seventh digit are rounded to different ones now and then."""
    monkeypatch.setattr(search, "TURN", turn)  # 1: each is TPE's
    never, trials = Search(PROBLEM, COMPARISONS, []), []
    for number in range(40):
        point = never.propose()
        assert Search(PROBLEM, COMPARISONS, trials).propose() == point
        trials.append(PROBLEM.run(number, point, phase=never.phase(number)))
        never.add(trials[-1])


class Cornered(KnownProblem):
    """What would fit best lies beyond a corner of the ranges."""

    def observe(self, unit: Any, **more: Any) -> Observations:
        return super().observe((0.5 + 0.4 * unit[0], 0.1 + 0.4 * unit[1]), **more)


def test_no_point_is_tried_twice() -> None:
    """Where the best point is a corner, which the emulator says again and again."""
    store = ListStore()
    run_search(Cornered(PLAN, PLAN.models[0]), COMPARISONS, store)
    assert sum(trial.unit == (0.0, 1.0) for trial in store.trials if trial.phase != POLISH) == 1
    assert distinct(store.trials) == store.trials
    repeated = [*store.trials[:3], store.trials[1], Trial(4, store.trials[1].unit, {}, phase=POLISH)]
    assert distinct(repeated) == [*store.trials[:3], repeated[4]]


def test_phases_follow_the_plan(whole: ListStore) -> None:
    phases = [trial.phase for trial in whole.trials]
    effort = PLAN.effort
    assert phases == (
        [STARTUP] * effort.startup
        + [SEARCH] * (effort.evaluations - effort.startup - effort.polish)
        + [POLISH] * effort.polish
    )


@pytest.mark.slow
def test_the_search_closes_in_on_the_best_point(whole: ListStore) -> None:
    good = [trial for trial in whole.trials if trial.good]
    comparison = COMPARISONS[0]
    values = comparison.objective(*comparison.logs_of(good))
    early = min(v for trial, v in zip(good, values, strict=True) if trial.phase == STARTUP)
    assert values.min() < early - 5.0
    grid = [(u, v) for u in np.linspace(0, 0.95, 60) for v in np.linspace(0, 1, 60)]
    best = min(
        comparison.objective(*comparison.logs_of([PROBLEM.run(0, point, members=64)]))[0] for point in grid
    )
    assert values.min() < best + 12.0  # noise of 4 members against 64


def test_failed_trials_stay_in_the_list_with_their_reason() -> None:
    trial = PROBLEM.run(3, (0.99, 0.5))
    assert not trial.good
    assert trial.reason == "the shaft is stuck"
    store = ListStore()
    store.trials = [PROBLEM.run(n, (0.99, 0.5)) for n in range(20)]
    assert len(run_search(PROBLEM, COMPARISONS, store)) == PLAN.effort.evaluations


def test_a_stop_is_heeded_between_trials() -> None:
    stop, store = threading.Event(), ListStore()
    stop.set()
    with pytest.raises(KeyboardInterrupt):
        run_search(PROBLEM, COMPARISONS, store, stop=stop)
    assert store.trials == []
