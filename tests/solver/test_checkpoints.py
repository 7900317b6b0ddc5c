"""A kept motion gives what sampling on the way gives, bit for bit; at any rate, in any window, in little memory."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.solver import checkpoints
from gearplay.solver.kept_samples import KeptSamples
from gearplay.solver.simulate import run_members
from gearplay.solver.status import Status
from gearplay.vocabulary.errors import InputError, ResourceError

CASES: dict[str, dict[str, Any]] = {
    "han2021": {"run.duration": 0.3, "run.transient": 0.05},
    "external-pair": {"run.duration": 0.02, "run.transient": 0.1},  # a ramp ends with the transient
    "pinion-idler-ring": {"run.duration": 0.05, "run.transient": 0.0},
}


def case_of(name: str) -> gp.Case:
    return gp.replace(gp.load_case(name), CASES[name])


def kept_of(result: gp.Result) -> KeptSamples:
    samples = result.runs[0].samples
    assert isinstance(samples, KeptSamples)
    return samples


@pytest.fixture
def many_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let even short records be put together from many pieces."""
    monkeypatch.setattr(checkpoints, "FEWEST_SAMPLES", 50)
    monkeypatch.setattr(checkpoints, "SHORTEST", 40)


@pytest.mark.parametrize("name", sorted(CASES))
@pytest.mark.parametrize("fixed_step", [None, 1e-6])
def test_samples_are_those_of_the_run(name: str, fixed_step: float | None, many_pieces: None) -> None:
    case = gp.replace(case_of(name), {"run.fixed_step": fixed_step, "run.ensemble": 2})
    if fixed_step is not None:
        case = gp.replace(case, {"run.duration": 2e-3, "run.transient": 1e-3})
    recalled, written = gp.simulate(case).runs, run_members(case, range(2))
    for again, first in zip(recalled, written, strict=True):
        assert np.array_equal(again.values, first.values)
        assert np.array_equal(again.log, first.log)
        assert again.counters == first.counters


def test_a_record_is_put_together_from_pieces(many_pieces: None) -> None:
    kept = kept_of(gp.simulate(case_of("pinion-idler-ring")))
    pieces = kept.motion._pieces(kept.start, 1.0 / kept.sampling, kept.count)
    assert len(pieces) > 5
    assert [last for _, _, last in pieces[:-1]] == [first for _, first, _ in pieces[1:]]


@pytest.mark.parametrize("name", sorted(CASES))
def test_another_rate_and_another_window_meet_the_record(name: str, many_pieces: None) -> None:
    result = gp.simulate(case_of(name))
    run, signal = result.case.run, {"han2021": "ring.vx"}.get(name, f"{list(result.case.rotors)[-1]}.vy")
    record = result.signal(signal)
    finer = result.signal(signal, sampling=4.0 * run.sampling)
    assert len(finer) == 4 * len(record)
    assert np.array_equal(finer[::4], record)
    later = run.transient + 0.5 * run.duration
    part = result.signal(signal, window=(later, later + 0.25 * run.duration))
    at = round(0.5 * run.duration * run.sampling)
    assert np.allclose(part, record[at : at + len(part)], rtol=0.0, atol=1e-9 * np.ptp(record) + 1e-300)
    assert len(part) == round(0.25 * run.duration * run.sampling)


def test_the_transient_is_within_reach() -> None:
    case = case_of("han2021")
    whole = gp.simulate(gp.replace(case, {"run.duration": 0.35, "run.transient": 0.0}))
    early = gp.simulate(case).signal("ring.x", window=(0.0, 0.04))
    assert np.array_equal(early, whole.signal("ring.x")[:4000])


def test_a_window_across_the_end_of_the_transient_meets_the_record() -> None:
    """No step passed that time, so none may when the motion is followed again."""
    result = gp.simulate(gp.replace(case_of("external-pair"), {"run.tolerance": 1e-4}))
    part = result.signal("output.vy", window=(0.095, 0.11))
    record = result.signal("output.vy")
    assert np.allclose(part[250:], record[: len(part) - 250], rtol=0.0, atol=1e-12 * np.ptp(record))


@pytest.mark.parametrize("window", [(0.2, 0.2), (0.3, 0.1), (-0.1, 0.1), (0.1, 0.5)])
def test_a_window_outside_the_run_is_refused(window: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"window = .* within 0 and 0\.35"):
        gp.simulate(case_of("han2021")).signal("ring.x", window=window)


def test_a_run_that_stopped_early_has_the_samples_that_it_reached() -> None:
    case = gp.replace(case_of("pinion-idler-ring"), {"run.max_steps": 700})
    again, first = gp.simulate(case).runs[0], run_members(case, [0])[0]
    assert again.status == first.status == Status.TOO_MANY_STEPS
    assert 100 < len(first.values) < 5000
    assert np.array_equal(again.values, first.values)
    assert np.array_equal(again.time, first.time)


def test_signal__a_request_of_too_many_samples_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gearplay.solver.limits.MAX_BYTES", 1e6)  # 125 000 samples
    result = gp.simulate(case_of("han2021"), sampling=1e6)
    assert result.success
    for ask in (lambda: result.signal("ring.ax"), lambda: result.ds):
        with pytest.raises(ResourceError, match="Lower the sampling"):
            ask()
    assert len(result.signal("ring.ax", sampling=1e5)) == 30_000


@pytest.mark.slow
def test_a_result_from_a_file_computes_its_motion_again(tmp_path: Path) -> None:
    case = gp.replace(case_of("han2021"), {"run.duration": 0.01})
    result = gp.simulate(case)
    result.save(tmp_path / "run.nc")
    back = gp.read_result(tmp_path / "run.nc")
    assert np.array_equal(back.signal("ring.ax"), result.signal("ring.ax"))
    asked = {"window": (0.002, 0.006), "sampling": 1e6}
    assert np.array_equal(back.signal("ring.ax", **asked), result.signal("ring.ax", **asked))
    assert [run.success for run in back.runs] == [True]


@pytest.mark.slow
@pytest.mark.parametrize(("tolerance", "limit"), [(1e-6, 5e-3), (1e-9, 2e-4)])
def test_peaks_of_contacts_are_those_of_the_motion(tolerance: float, limit: float) -> None:
    """Forces and depths of some impacts, against the same motion looked at every 20 ns."""
    changes = {"run.duration": 0.05, "run.transient": 0.0, "run.tolerance": tolerance}
    result = gp.simulate(
        gp.replace(gp.load_case("han2021"), {**changes, "rotors.ring.initial": {"vx": 0.02}})
    )
    fine: dict[str, Any] = {"sampling": 5e7, "window": (0.0, 0.05)}
    x, y = (result.signal(f"ring.sleeve_force_{axis}", **fine) for axis in "xy")
    seen = {
        "ring": (np.hypot(x, y), result.signal("ring.sleeve_penetration", **fine)),
        "pinion-ring:drive": tuple(
            result.signal(f"pinion-ring.drive_{what}", **fine) for what in ("force", "penetration")
        ),
        "pinion-ring:back": tuple(
            result.signal(f"pinion-ring.back_{what}", **fine) for what in ("force", "penetration")
        ),
    }
    table = result.contacts
    for at, label in enumerate(table.labels):
        force, depth = seen[label]
        assert table.values["peak_force"][at] == pytest.approx(np.max(force), rel=limit)
        assert table.values["max_penetration"][at] == pytest.approx(np.max(depth), rel=limit)
        assert np.max(force) > 1.0
