"""Kept trials of the bundled plan, the first of the coupled model and the best of each: search and provenance agree with them."""

import json
import lzma
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearplay.calibration.objective import Comparison, data_of, printed_measurements
from gearplay.calibration.observe import Observed
from gearplay.calibration.reading import load_plan
from gearplay.calibration.search import Search
from gearplay.calibration.store import digest_of
from gearplay.calibration.trials import DECIMALS, Problem, Trial
from gearplay.studies.han2021.article import fit_of, stored

PLAN = load_plan("han2021")
COMPARISON = Comparison(data_of(PLAN, printed_measurements(PLAN)), "unnormalised")
KEPT = json.loads(lzma.decompress(Path(__file__).with_name("han2021-trials.json.xz").read_bytes()))


def trial_of(number: int, row: dict[str, Any]) -> Trial:
    seen: dict[str, dict[str, dict[str, Observed]]] = {}
    for (c, t, k), value, error in zip(KEPT["places"], row["values"], row["errors"], strict=True):
        seen.setdefault(c, {}).setdefault(t, {})[k] = Observed(value, error)
    return Trial(number, tuple(row["unit"]), seen, "", row["phase"])


FIRST = [trial_of(number, row) for number, row in enumerate(KEPT["first"])]


def test_kept_trials__are_of_the_bundled_plan() -> None:
    assert KEPT["digest"] == digest_of(PLAN)


@pytest.mark.parametrize("model", stored("calibration")["fits"])
def test_provenance__has_the_count_and_the_errors_of_the_best_trial(model: str) -> None:
    best, fit = KEPT["best"][model], fit_of(model)
    assert (best["trials"], best["failed"]) == (fit["trials"], fit["failed"])
    logs, errors = COMPARISON.logs_of([trial_of(best["best"]["number"], best["best"])])
    amplitude, frequency = COMPARISON.mean_errors(logs, errors)
    assert [amplitude[0], frequency[0]] == pytest.approx(fit["in_sample"], rel=1e-9)


@pytest.mark.slow
def test_trials__agree_with_their_points_within_standard_errors() -> None:
    """Three members of a chaotic motion differ by their spread: 0.67 standard errors of the difference in the median."""
    kept, problem = FIRST[:8], Problem(PLAN, PLAN.models[0])
    logs, errors = COMPARISON.logs_of(kept)
    again, errors_again = COMPARISON.logs_of([problem.run(trial.number, trial.unit) for trial in kept])
    own = np.abs(again - logs) / np.hypot(errors, errors_again)
    assert 0.4 < np.median(own) < 1.1  # found 0.75
    others = np.abs(again - np.roll(logs, 1, axis=0)) / np.hypot(errors_again, np.roll(errors, 1, axis=0))
    assert np.median(others) > 1.3  # other points; found 1.6


@pytest.mark.slow
def test_search__points_follow_from_the_seed_and_the_trials_before() -> None:
    """Sobol points of the start, then those of TPE and of the emulator."""
    problem, startup = Problem(PLAN, PLAN.models[0]), PLAN.effort.startup
    for number in (0, 5, startup - 1, startup, startup + 1, startup + 5):
        asked = Search(problem, [COMPARISON], FIRST[:number]).propose()
        assert np.round(asked, DECIMALS) == pytest.approx(FIRST[number].unit, abs=2e-6)
