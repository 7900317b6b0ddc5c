"""Keep trials of the bundled plan han2021, or lay them into a folder where it goes on from them.

    python docs/keep_trials.py keep FOLDER     FOLDER is what `gearplay calibrate han2021 --out FOLDER` wrote
    python docs/keep_trials.py lay FOLDER      then `gearplay calibrate han2021 --evaluations N --out FOLDER` goes on

A search of thousands of trials takes hours; whoever doubts it, or wants more of it, need not begin anew.
"""

import json
import lzma
import sys
from pathlib import Path
from typing import Any

from gearplay.calibration.observe import Observed
from gearplay.calibration.plan import Plan
from gearplay.calibration.reading import load_plan
from gearplay.calibration.store import StudyStore, digest_of
from gearplay.calibration.trials import Trial

FILE = Path(__file__).parent / "calibrated" / "han2021-trials.json.xz"
Place = tuple[str, str, str]  # condition, target, key


def places_of(trial: Trial) -> list[Place]:
    """Return where the numbers of a good trial belong, in their order."""
    return [(c, t, k) for c, targets in trial.seen.items() for t, keys in targets.items() for k in keys]


def row_of(trial: Trial, places: list[Place]) -> dict[str, Any]:
    """Return a trial as it is kept."""
    row: dict[str, Any] = {"phase": trial.phase, "unit": trial.unit}
    if not trial.good:
        return row | {"reason": trial.reason}
    assert places_of(trial) == places
    seen = [trial.seen[c][t][k] for c, t, k in places]
    return row | {"values": [o.value for o in seen], "errors": [o.error for o in seen]}


def trial_of(number: int, row: dict[str, Any], places: list[Place]) -> Trial:
    """Return a kept trial."""
    seen: dict[str, dict[str, dict[str, Observed]]] = {}
    if "reason" not in row:
        for (c, t, k), value, error in zip(places, row["values"], row["errors"], strict=True):
            seen.setdefault(c, {}).setdefault(t, {})[k] = Observed(value, error)
    return Trial(number, tuple(row["unit"]), seen, row.get("reason", ""), row["phase"])


def kept(path: Path = FILE) -> tuple[str, dict[str, list[Trial]]]:
    """Return the digest of the plan, and the trials of each model."""
    document = json.loads(lzma.decompress(path.read_bytes()))
    places = [(c, t, k) for c, t, k in document["places"]]
    trials = {
        model: [trial_of(number, row, places) for number, row in enumerate(rows)]
        for model, rows in document["models"].items()
    }
    return document["digest"], trials


def keep(folder: Path, plan: Plan, path: Path = FILE) -> None:
    """Write the trials of a folder, of all models that have any."""
    digest = digest_of(plan)
    trials = {m.name: StudyStore(folder, plan, m.name, digest).read() for m in plan.models}
    places = places_of(next(t for found in trials.values() for t in found if t.good))
    models = {name: [row_of(trial, places) for trial in found] for name, found in trials.items() if found}
    text = json.dumps({"digest": digest, "places": places, "models": models}, separators=(",", ":"))
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(lzma.compress(text.encode(), preset=9))
    print(
        ", ".join(f"{name} {len(rows)}" for name, rows in models.items()),
        f"{path.stat().st_size / 1e6:.1f} MB",
    )


def lay(folder: Path, plan: Plan, path: Path = FILE) -> None:
    """Put the kept trials into a folder that holds none of their models."""
    digest, trials = kept(path)
    if digest != digest_of(plan):
        raise SystemExit(f"{path} holds trials of another plan")
    folder.mkdir(parents=True, exist_ok=True)
    for model, found in trials.items():
        store = StudyStore(folder, plan, model, digest)
        if store.read():
            raise SystemExit(f"{folder} holds trials of {model} already")
        for trial in found:
            store.add(trial)


if __name__ == "__main__":
    {"keep": keep, "lay": lay}[sys.argv[1]](Path(sys.argv[2]), load_plan("han2021"))
