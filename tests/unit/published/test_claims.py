"""The claims: patterns, shares with their intervals, and the perfect model's floor, by brute force."""

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binomtest

from gearplay.files.parts import FolderStore
from gearplay.published.article import LINES, conditions
from gearplay.published.claims.floor import best_of, condition_errors, floor_of, pair_errors, runs_needed
from gearplay.published.claims.points import MODELS, ClaimSettings, PointResult, point_from, run_points
from gearplay.published.claims.repetition import repeated, tolerance_words
from gearplay.published.claims.shares import (
    OVERALL,
    PATTERNS,
    Share,
    coupling_ratios,
    dropped,
    is_favoured,
    pattern_shares,
    share_of,
    shown_by_the_test,
    wedging,
)
from gearplay.published.claims.summary import (
    favoured_words,
    rare_words,
    shipped_claims,
    summarise,
)


@pytest.mark.parametrize(("count", "of"), [(0, 128), (3, 10), (77, 128), (128, 128)])
def test_wilsons_interval(count: int, of: int) -> None:
    expected = binomtest(count, of).proportion_ci(0.95, method="wilson")
    assert Share(count, of).interval == pytest.approx((expected.low, expected.high), abs=1e-7)


def test_the_measured_amplitudes_show_both_peaks() -> None:
    assert shown_by_the_test() == {
        "peak_120": True,
        "growth": False,
        "peak_200_100": True,
        "peak_200_200": False,
    }


def made(model: str, point: int, level: np.ndarray, members: int = 4) -> PointResult:
    """Return a point whose three lines all have these levels [decades], shape [condition]; one member differs from the others."""
    ensemble = np.repeat(10.0 ** level[:, None], len(LINES), axis=1)
    single = np.repeat(ensemble[None], members, axis=0)
    single[0] = 1.0  # shows no pattern
    return PointResult(model, point, ensemble, single, (0.0, 0.0, 0.0, 0.1, 0.0, 0.0))


RISING = np.array([0.0, 1.0, 2.0, 0.5, 0.0, 0.0])  # grows with speed, largest at 200/100
PEAKED = np.array([0.0, 1.0, 0.5, 0.0, 0.5, 1.0])  # largest at 120 rpm, and at 200/200


def test_shares_count_points_and_single_runs() -> None:
    results = [made("coupled", k, RISING if k < 3 else PEAKED) for k in range(4)]
    rows = pattern_shares(results)
    assert {r["measure"] for r in rows} == {OVERALL, *LINES}
    for pattern, count, points in (
        ("growth", 3, [0, 1, 2]),
        ("peak_200_100", 3, [0, 1, 2]),
        ("peak_120", 1, [3]),
        ("peak_200_200", 1, [3]),
    ):
        row = share_of(rows, pattern, "coupled")
        assert (row["count"], row["of"], row["points"]) == (count, 4, points)
        assert row["single_runs"] == pytest.approx(count / 4 * 3 / 4)  # one member of four shows nothing


def test_coupled_over_uncoupled_at_the_same_point() -> None:
    results = [made("coupled", k, RISING + 0.1 * (k + 1)) for k in range(3)]
    results += [made("uncoupled", k, RISING) for k in range(3)]
    rows = coupling_ratios(results)
    assert [r["condition"] for r in rows] == [*(c.label for c in conditions()), "all six"]
    assert rows[0]["median"] == pytest.approx(10.0**0.2)
    assert rows[-1]["above"]["share"] == 1.0


def test_a_model_is_favoured_only_above_all_its_controls() -> None:
    results = [made("coupled_as_published", k, RISING) for k in range(40)]
    results += [made("uncoupled_as_published", k, PEAKED) for k in range(40)]
    results += [made("coupled", k, RISING if k % 2 else PEAKED) for k in range(40)]
    rows = pattern_shares(results)
    assert is_favoured(rows, "peak_200_100", "coupled_as_published", ("uncoupled_as_published", "coupled"))
    assert not is_favoured(rows, "peak_200_100", "coupled", ("coupled_as_published",))
    document = {"shares": rows}
    assert "make that peak." in favoured_words(document)
    assert "cannot be told" in favoured_words({"shares": pattern_shares([*results[:2], *results[40:]])})
    assert "seen at points" in rare_words(document)


def test_shares_at_a_finer_tolerance_are_those_of_the_same_points() -> None:
    """The first 20 of 40 points all rise: 19 of 20 agree with that, 5 of 20 do not: 15 lost, none gained."""
    results = [made("coupled", k, RISING if k < 20 else PEAKED) for k in range(40)]
    for rising, agree in ((20, True), (19, True), (5, False)):
        finer = [made("coupled", k, RISING if k < rising else PEAKED) for k in range(20)]
        rows = repeated(results, finer)
        assert {row["model"] for row in rows} == {"coupled"}
        growth = next(row for row in rows if row["pattern"] == "growth")
        assert (growth["first"], growth["finer"], growth["of"]) == (20, rising, 20)
        assert (growth["lost"], growth["gained"]) == (20 - rising, 0)
        assert growth["p"] == pytest.approx(min(1.0, 2.0 * 0.5 ** (20 - rising)))
        assert growth["single_runs"] == pytest.approx([0.75, 0.75 * rising / 20])
        assert growth["agree"] == agree
        words = tolerance_words({"repeated": rows, "settings": {"finer_tolerance": 1e-9}})
        assert words.startswith("The first 20 points again at a tolerance of 1e-09: ")
        assert ("grows with the speed, coupled: 20 and 5 of 20" in words) != agree
        assert ("none of the 4 shares differs significantly" in words) == agree


def test_where_no_point_is_left_nothing_is_compared() -> None:
    assert repeated([made("coupled", 0, RISING)], []) == []
    assert "No point could be compared" in tolerance_words(
        {"repeated": [], "settings": {"finer_tolerance": 1e-9}}
    )


def test_half_of_the_points_are_tried_again() -> None:
    settings = ClaimSettings(points=128)
    assert (settings.finer().points, settings.finer().tolerance) == (64, 1e-9)
    assert dataclasses.replace(settings.finer(), points=128, tolerance=1e-7) == settings


def test_points_that_fail_are_named_and_counted_nowhere() -> None:
    bad = PointResult(
        "coupled", 7, np.empty((0, 0)), np.empty((0, 0, 0)), (), "60 rpm: 5 of 8 members failed: stuck"
    )
    results = [made("coupled", 0, RISING), bad]
    assert dropped(results) == [{"model": "coupled", "point": 7, "reason": bad.reason}]
    assert share_of(pattern_shares(results), "growth", "coupled")["of"] == 1
    assert wedging(results)[3]["count"] == 1
    for each in results:
        again = point_from(each.to_part())
        assert (again.model, again.point, again.reason) == (each.model, each.point, each.reason)
        assert np.allclose(again.ensemble, each.ensemble, rtol=1e-5)


def test_the_best_of_n_by_trying_all_choices() -> None:
    row = np.array([[5.0, 1.0, 4.0, 2.0, 9.0]])
    for n in range(1, 6):
        brute = np.mean([min(chosen) for chosen in itertools.combinations(row[0], n)])
        assert best_of(row, n) == pytest.approx(brute)


def test_runs_that_differ_by_a_factor_alone_are_equal() -> None:
    base = np.exp(np.random.default_rng(0).normal(size=(6, 3)))
    runs = np.array([base, 3.0 * base, 0.2 * base])
    errors = pair_errors(runs)
    assert np.isnan(np.diag(errors)).all()
    assert np.nanmax(errors) == pytest.approx(0.0, abs=1e-9)
    assert condition_errors(runs)[0, 0, 1] == pytest.approx(200.0)  # no factor is free for one condition


def test_the_floor_falls_with_the_runs_to_pick_from() -> None:
    runs = np.exp(0.2 * np.random.default_rng(1).normal(size=(24, 6, 3)))
    floor = floor_of(runs, 4.0, 7.3)
    assert floor["pairs"] == 24 * 23
    assert floor["best_of"] == sorted(floor["best_of"], reverse=True)
    assert all(
        free <= best + 25.0 for free, best in zip(floor["free_per_condition"], floor["best_of"], strict=True)
    )
    assert runs_needed({**floor, "limit": 0.0}, "best_of") is None
    assert runs_needed({**floor, "limit": 1e9}, "best_of") == 1


@pytest.mark.slow
def test_the_same_seed_gives_the_same_document_and_kept_points_are_not_run_again(tmp_path: Path) -> None:
    settings = ClaimSettings(points=1, members=2, duration=1.0, transient=0.2)
    store = FolderStore(tmp_path)
    first = run_points(settings, store=store)
    assert [r.model for r in first] == list(MODELS)
    assert len(list(tmp_path.glob("*.json"))) == len(MODELS)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.json")}
    again = run_points(settings, store=store)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.json")} == kept
    assert summarise(first, [], [], settings) == summarise(again, [], [], settings)
    afresh = run_points(settings)
    for a, b in zip(first, afresh, strict=True):
        assert a.to_part() == b.to_part()


def test_the_document_that_came_with_the_package() -> None:
    document = shipped_claims()
    assert document["settings"]["points"] >= 128
    assert document["settings"]["members"] >= 8
    assert set(PATTERNS) == {r["pattern"] for r in document["shares"]}
    assert {r["model"] for r in document["shares"]} == set(MODELS)
    for model in MODELS:
        lost = sum(each["model"] == model for each in document["dropped"])
        assert share_of(document["shares"], "peak_120", model)["of"] + lost == document["settings"]["points"]
    assert all(floor["runs"] >= 32 for floor in document["floors"])
    assert len(document["repeated"]) == len(PATTERNS) * len(MODELS)
    for row in document["repeated"]:
        assert row["of"] >= 60
        (low, high), (bottom, top) = (Share(row[each], row["of"]).interval for each in ("first", "finer"))
        assert max(low, bottom) <= min(high, top), row
        assert row["p"] == pytest.approx(binomtest(row["lost"], row["lost"] + row["gained"]).pvalue)
        assert row["p"] * len(document["repeated"]) > 0.05, row
        assert abs(row["single_runs"][0] - row["single_runs"][1]) < 0.06, row
