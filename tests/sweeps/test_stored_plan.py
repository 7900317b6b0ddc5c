"""The plan that a sweep notes in its folder: it is read again by `resume` and by other shards, and has a digest."""

import json
from pathlib import Path

import pytest

from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running.folder import PROGRAM, plan_in
from gearplay.vocabulary.errors import InputError
from gearplay.work.claims import claim


def note(plan: SweepPlan, folder: Path) -> None:
    claim(folder, json.loads(plan.model_dump_json(exclude_none=True)), PROGRAM)


def test_stored_plan__is_read_back_unchanged(tmp_path: Path) -> None:
    plan = load_sweep("space-temperature")
    note(plan, tmp_path)
    note(plan, tmp_path)
    assert plan_in(tmp_path) == plan


def test_a_noted_plan_that_was_changed_is_refused(tmp_path: Path) -> None:
    """A digit of it, which leaves a plan that could be: another than the one whose rows lie beside."""
    note(load_sweep("space-temperature"), tmp_path)
    file = tmp_path / "plan.json"
    whole = file.read_text()
    digits = [at for at, letter in enumerate(whole[: whole.index('"sha256"')]) if letter in "12345"]
    assert len(digits) > 10
    for at in digits:
        file.write_text(whole[:at] + str(int(whole[at]) + 1) + whole[at + 1 :])
        with pytest.raises(InputError, match=r"plan\.json was changed after gearplay sweep wrote it"):
            plan_in(tmp_path)


def test_of_two_plans_that_are_noted_at_once_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Shards share the folder: another one notes its plan after this one has looked."""
    first, second = load_sweep("space-temperature"), load_sweep("han2021-map")
    exists = Path.exists

    def late(path: Path) -> bool:
        found = exists(path)
        if path.name == "plan.json" and not found:
            monkeypatch.setattr(Path, "exists", exists)
            note(first, tmp_path)
        return found

    for plan in (first, second):
        (tmp_path / "plan.json").unlink(missing_ok=True)
        monkeypatch.setattr(Path, "exists", late)
        if plan is first:
            note(plan, tmp_path)
        else:
            with pytest.raises(InputError, match="must hold the same plan"):
                note(plan, tmp_path)
        assert plan_in(tmp_path) == first
