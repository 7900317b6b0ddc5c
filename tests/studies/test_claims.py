"""Claims: patterns, shares with their intervals, and the perfect model's floor, by brute force."""

import dataclasses
import itertools
import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.stats import binomtest

from gearplay.studies.han2021.article import LINES, conditions, stored
from gearplay.studies.han2021.claims import ClaimSettings, run_points, summarise
from gearplay.studies.han2021.shares import (
    MODELS,
    OVERALL,
    PATTERNS,
    PointResult,
    best_of,
    condition_errors,
    coupling_ratios,
    favoured_words,
    floor_of,
    pair_errors,
    pattern_shares,
    rare_words,
    repeated,
    runs_needed,
    share,
    share_of,
    shown_by_the_test,
    tolerance_words,
    wedging,
)
from gearplay.studies.han2021.simulation import Work


@pytest.mark.parametrize(("count", "of"), [(0, 128), (3, 10), (77, 128), (128, 128)])
def test_share__wilsons_interval(count: int, of: int) -> None:
    """Both ends are where the score test of the observed share has z = 1.96: (p - q)^2 n = z^2 q (1 - q)."""
    found = share(np.arange(of) < count)
    assert (found["count"], found["of"]) == (count, of)
    for end in (found["low"], found["high"]):
        assert (count / of - end) ** 2 * of == pytest.approx(1.959963985**2 * end * (1.0 - end), abs=1e-9)
    assert found["low"] <= count / of <= found["high"]


def test_shown_by_the_test__both_peaks() -> None:
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


def test_pattern_shares__points_and_single_runs() -> None:
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


def test_coupling_ratios__at_the_same_point() -> None:
    results = [made("coupled", k, RISING + 0.1 * (k + 1)) for k in range(3)]
    results += [made("uncoupled", k, RISING) for k in range(3)]
    rows = coupling_ratios(results)
    assert [r["condition"] for r in rows] == [*(c.label for c in conditions()), "all six"]
    assert rows[0]["median"] == pytest.approx(10.0**0.2)
    assert rows[-1]["above"]["share"] == 1.0


def test_favoured_words__interval_above_those_of_all_controls() -> None:
    results = [made("coupled_as_published", k, RISING) for k in range(40)]
    results += [made("uncoupled_as_published", k, PEAKED) for k in range(40)]
    results += [made("coupled", k, RISING if k % 2 else PEAKED) for k in range(40)]
    rows = pattern_shares(results)
    document = {"shares": rows}
    assert "make that peak." in favoured_words(document)
    assert "cannot be told" in favoured_words({"shares": pattern_shares([*results[:2], *results[40:]])})
    assert "seen at points" in rare_words(document)


def test_repeated__shares_of_the_same_points() -> None:
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


def test_repeated__no_common_point() -> None:
    assert repeated([made("coupled", 0, RISING)], []) == []
    assert "No point could be compared" in tolerance_words(
        {"repeated": [], "settings": {"finer_tolerance": 1e-9}}
    )


def test_finer__half_of_the_points() -> None:
    settings = ClaimSettings(points=128)
    assert (settings.finer().points, settings.finer().tolerance) == (64, 1e-9)
    assert dataclasses.replace(settings.finer(), points=128, tolerance=1e-7) == settings


def test_dropped_points__named_and_not_counted() -> None:
    bad = PointResult("coupled", 7, reason="60 rpm: 5 of 8 members failed: stuck")
    results = [made("coupled", 0, RISING), bad]
    document = summarise(results, [], [], ClaimSettings())
    assert document["dropped"] == [{"model": "coupled", "point": 7, "reason": bad.reason}]
    assert share_of(pattern_shares(results), "growth", "coupled")["of"] == 1
    assert wedging(results)[3]["count"] == 1
    for each in results:
        again = PointResult.from_part(json.loads(json.dumps(each.to_part())))
        assert (again.model, again.point, again.reason) == (each.model, each.point, each.reason)
        assert np.allclose(again.ensemble, each.ensemble, rtol=1e-5)


def test_best_of__all_choices() -> None:
    row = np.array([[5.0, 1.0, 4.0, 2.0, 9.0]])
    for n in range(1, 6):
        brute = np.mean([min(chosen) for chosen in itertools.combinations(row[0], n)])
        assert best_of(row, n) == pytest.approx(brute)


def test_pair_errors__a_common_factor_is_free() -> None:
    base = np.exp(np.random.default_rng(0).normal(size=(6, 3)))
    runs = np.array([base, 3.0 * base, 0.2 * base])
    errors = pair_errors(runs)
    assert np.isnan(np.diag(errors)).all()
    assert np.nanmax(errors) == pytest.approx(0.0, abs=1e-9)
    assert condition_errors(runs)[0, 0, 1] == pytest.approx(200.0)  # no factor is free for one condition


def test_floor_of__falls_with_the_number_of_runs() -> None:
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
def test_run_points__same_seed_same_document_and_kept_points_are_not_run_again() -> None:
    settings = ClaimSettings(points=1, members=2, duration=1.0, transient=0.2)
    store: dict[str, Any] = {}
    made: list[str] = []

    def keep(identity: Any, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        key = json.dumps(identity)
        if key not in store:
            made.append(key)
            store[key] = make()
        return store[key]

    first = run_points(settings, Work(keep=keep))
    assert [r.model for r in first] == list(MODELS)
    assert len(made) == len(MODELS)
    again = run_points(settings, Work(keep=keep))
    assert len(made) == len(MODELS)
    assert summarise(first, [], [], settings) == summarise(again, [], [], settings)
    for a, b in zip(first, run_points(settings, Work()), strict=True):
        assert a.to_part() == b.to_part()


def test_stored_claims__points_models_intervals() -> None:
    document = stored("claims")
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
        first, finer = (share(np.arange(row["of"]) < row[each]) for each in ("first", "finer"))
        assert max(first["low"], finer["low"]) <= min(first["high"], finer["high"]), row
        assert row["p"] == pytest.approx(binomtest(row["lost"], row["lost"] + row["gained"]).pvalue)
        assert row["p"] * len(document["repeated"]) > 0.05, row
        assert abs(row["single_runs"][0] - row["single_runs"][1]) < 0.06, row
