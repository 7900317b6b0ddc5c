"""The averages beside the page's one run."""

from typing import Any

import numpy as np
import pytest

from gearplay.model.reading import load_case, replace
from gearplay.solver.simulate import run_batch
from gearplay.web.frames import unpack_frame
from gearplay.web.tasks import TASKS
from page_jobs import STOP, quiet, ranges_of


def averaged(case: Any) -> Any:
    """Return the models of an average of 16 members of 5 s."""
    words = {"case": case.resolved(), "members": 16, "duration": 5.0, "transient": 1.0}
    return unpack_frame(TASKS["average"](words, quiet, STOP))["models"]


def test_averages_are_of_drawn_members_with_their_interval_and_the_lines_of_the_run() -> None:
    case = load_case("han2021", ["run.duration=50ms", "run.transient=0s", "run.sampling=20kHz"])
    job = {"case": case.resolved()}
    words = job | {"models": ["coupled", "uncoupled"], "members": 6, "duration": 1.0, "transient": 0.2}
    found = unpack_frame(TASKS["average"](words, quiet, STOP))
    run = unpack_frame(TASKS["run"](job | {"models": ["coupled"]}, quiet, STOP))["models"]["coupled"]
    assert (found["members"], found["duration"], found["transient"], found["records"]) == (6, 1.0, 0.2, 6)
    case = replace(case, {"run.start": "drawn", "run.transient": 0.2})
    members = run_batch([(case, range(6))], duration=1.0, sampling=20.0)[0]
    rates = np.array(
        [
            dict(zip(each.statistics.labels, each.statistics.impacts_per_second, strict=True))["ring"]
            for each in members
        ]
    )
    ring = next(each for each in found["models"]["coupled"]["statistics"] if each["contact"] == "ring")
    assert ring["impacts_per_second"] == pytest.approx(rates.mean(), rel=1e-12)
    assert ring["half"]["impacts_per_second"] == pytest.approx(
        2.5706 * rates.std(ddof=1) / np.sqrt(6), rel=1e-4
    )
    ours, theirs = found["models"]["uncoupled"]["spectra"][0], run["spectra"][0]
    np.testing.assert_array_equal(ours["f"][:20], theirs["f"][:20])
    assert ours["s"] is not None
    assert theirs["s"] is None


@pytest.mark.deep
def test_the_contacts_that_the_page_shows_agree_with_other_ensembles() -> None:
    """20 random cells of its ranges, impacts and speeds of shaft and drive flank: within both 95 % intervals, but for chance."""
    rng = np.random.default_rng(23)
    case = load_case("han2021", ["run.sampling=20kHz", "run.duration=0.5s"])
    spans = ranges_of(case)
    off = []
    for _ in range(20):
        cell = replace(case, {path: rng.uniform(*span) for path, span in spans.items()})
        ours, theirs = (
            {
                each["contact"]: each
                for each in averaged(replace(cell, {"run.seed": seed}))["coupled"]["statistics"]
            }
            for seed in (0, 1)
        )
        off += [
            abs(ours[contact][name] - theirs[contact][name])
            / (ours[contact]["half"][name] + theirs[contact]["half"][name])
            for contact in ("ring", "pinion-ring:drive")
            for name in ("impacts_per_second", "rms_impact_speed")
        ]
    assert np.mean(np.array(off) > 1.0) <= 0.05
    assert np.median(off) > 0.05, "intervals so wide say nothing"
