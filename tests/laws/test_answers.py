"""Answer files: states and counts of the bundled cases after a few milliseconds, as once computed and looked at.

``python tests/laws/test_answers.py`` writes them anew; do so only for a change that is meant to change them.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.reading import bundled_names
from gearplay.solver.simulate import run_members

FOLDER = Path(__file__).parent / "answers"
SPAN = 5e-3  # s
POLICY = {"run.duration": SPAN, "run.transient": 0.0, "run.sampling": 1e3, "run.tolerance": 1e-11}
LIVELY = {
    "han2021": {"rotors.ring.initial.vx": 0.3},
    "han2021-calibrated": {"rotors.ring.initial.vx": 0.3},
    "han2021-calibrated-uncoupled": {"rotors.ring.initial.vx": 0.3},
    "han2021-geometric-inertia": {"rotors.ring.initial.vx": 0.3},
}


def answer(name: str) -> dict[str, Any]:
    """Return the final state and the work of a bundled case over ``SPAN``."""
    case = gp.replace(gp.load_case(name), {**POLICY, **LIVELY.get(name, {})})
    run = run_members(case, [0])[0]
    assert run.success, run.message
    c = run.counters
    counts = {"steps": c.steps, "rejected_steps": c.rejected_steps, "events": c.events, "calls": c.calls}
    return {"states": [float(v) for v in run.final_state], "counts": counts}


@pytest.mark.parametrize("name", bundled_names())
def test_bundled_cases_give_the_recorded_answers(name: str) -> None:
    """Positions within 1e-12 m, angles and speeds alike in natural sizes; equal events; steps within 2 %."""
    expected = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    found = answer(name)
    n = len(found["states"]) // 6
    scale = np.array([1.0, 1.0, 10.0] * n + [1e4, 1e4, 1e5] * n + [1e4] * (len(found["states"]) - 6 * n))
    difference = np.abs(np.array(found["states"]) - expected["states"])
    assert np.all(difference < 1e-12 * scale)
    assert found["counts"]["events"] == expected["counts"]["events"]
    for key in ("steps", "calls"):
        assert found["counts"][key] == pytest.approx(expected["counts"][key], rel=0.02)


def test_a_recorded_answer_is_that_of_a_finer_run() -> None:
    """Flanks that just touch at the start: a step once ended later than its state, 5e-11 m beside the motion."""
    case = gp.replace(gp.load_case("pinion-idler-ring"), {**POLICY, "run.tolerance": 1e-13})
    run = run_members(case, [0])[0]
    expected = json.loads((FOLDER / "pinion-idler-ring.json").read_text(encoding="utf-8"))["states"]
    places = 3 * len(case.rotors)
    assert np.max(np.abs(run.final_state - expected)[:places]) < 1e-11


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for bundled in bundled_names():
        text = json.dumps(answer(bundled), indent=1)
        (FOLDER / f"{bundled}.json").write_text(text + "\n", encoding="utf-8")
