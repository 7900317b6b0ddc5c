"""The trials of the bundled plan that are kept: its points give them, and a search goes on from them as if it had run here."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearplay.calibration.objective import Comparison, data_of, printed_measurements
from gearplay.calibration.reading import load_plan
from gearplay.calibration.search import Search
from gearplay.calibration.store import StudyStore, digest_of
from gearplay.calibration.trials import DECIMALS, Problem, Trial
from gearplay.published.calibrated import calibration, fit_of
from programs import load_script

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def script() -> Any:
    return load_script(ROOT / "docs" / "keep_trials.py")


@pytest.fixture(scope="module")
def kept(script: Any) -> dict[str, list[Trial]]:
    digest, trials = script.kept()
    assert digest == digest_of(load_plan("han2021"))
    return trials  # type: ignore[no-any-return]


@pytest.mark.parametrize("model", calibration()["fits"])
def test_the_errors_of_the_search_are_those_of_the_kept_trials(
    model: str, kept: dict[str, list[Trial]]
) -> None:
    """The provenance's number of trials, and the errors that the search saw at its best one, follow from what is kept."""
    plan, fit, trials = load_plan("han2021"), fit_of(model), kept[model]
    comparison = Comparison(data_of(plan, printed_measurements(plan)), "unnormalised")
    good = [trial for trial in trials if trial.good]
    assert len(trials) == fit["trials"] == len(good) + fit["failed"]
    assert all(trial.number == at for at, trial in enumerate(trials))
    logs, errors = comparison.logs_of(good)
    best = int(np.argmin(comparison.objective(logs, errors)))
    amplitude, frequency = comparison.mean_errors(logs, errors)
    assert [amplitude[best], frequency[best]] == pytest.approx(fit["in_sample"], rel=1e-9)


def test_a_kept_trial_is_what_its_point_gives(kept: dict[str, list[Trial]]) -> None:
    """Three members of a chaotic motion, on another processor perhaps: alike, but not to the last digit."""
    plan = load_plan("han2021")
    problem = Problem(plan, plan.models[0])
    comparison = Comparison(data_of(plan, printed_measurements(plan)), "unnormalised")
    trial = kept["coupled"][2]
    again = problem.run(2, trial.unit)
    logs, _ = comparison.logs_of([trial, again])
    assert np.median(np.abs(logs[1] - logs[0])) < 0.1  # decades; found 0.03
    others, _ = comparison.logs_of(kept["coupled"][:64])
    assert np.median(np.abs(others - logs[1])) > 0.15  # other points; found 0.24


def test_the_points_follow_from_seed_and_trials_before(kept: dict[str, list[Trial]]) -> None:
    """Sobol points of the start, and what TPE and the emulator say next, are those that were simulated."""
    plan = load_plan("han2021")
    problem = Problem(plan, plan.models[0])
    comparison = Comparison(data_of(plan, printed_measurements(plan)), "unnormalised")
    trials = kept[problem.model.name]
    for number in (
        0,
        5,
        plan.effort.startup - 1,
        plan.effort.startup,
        plan.effort.startup + 1,
        plan.effort.startup + 5,
    ):
        asked = Search(problem, [comparison], trials[:number]).ask()
        assert np.round(asked, DECIMALS) == pytest.approx(trials[number].unit, abs=2e-6)


def test_laid_trials_are_the_kept_ones(script: Any, kept: dict[str, list[Trial]], tmp_path: Path) -> None:
    """Kept, laid into a folder and kept again: nothing is lost, a failed trial neither; a folder with trials is not touched."""
    plan, folder = load_plan("han2021"), tmp_path / "one"
    folder.mkdir()
    store = StudyStore(folder, plan, "coupled", digest_of(plan))
    made = [kept["coupled"][0], Trial(1, (0.5,) * 13, {}, "too few members", "search")]
    for trial in made:
        store.add(trial)
    script.keep(folder, plan, tmp_path / "kept.json.xz")
    script.lay(tmp_path / "two", plan, tmp_path / "kept.json.xz")
    assert StudyStore(tmp_path / "two", plan, "coupled", digest_of(plan)).read() == made
    with pytest.raises(SystemExit, match="holds trials of coupled already"):
        script.lay(tmp_path / "two", plan, tmp_path / "kept.json.xz")
