"""The calibrated cases hold what the calibration found, and what the study reports comes from members that it has not seen."""

from itertools import combinations

import numpy as np
import pytest

from gearplay.calibration.model_comparison import Duel
from gearplay.calibration.out_of_sample import CHECK_SEED, CHOOSE_SEED
from gearplay.calibration.reading import load_plan
from gearplay.calibration.store import digest_of
from gearplay.calibration.trials import Problem
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from gearplay.model.plan_values import value_at
from gearplay.model.reading import load_case, replace
from gearplay.published.article import LINES, conditions
from gearplay.published.calibrated import calibration, duel_of, fit_of, left_out_error
from gearplay.published.claims.points import ClaimSettings
from gearplay.published.settings import PARAMETERS, SWITCHED, Settings, base_case

CASES = {"coupled": "han2021-calibrated", "uncoupled": "han2021-calibrated-uncoupled"}


@pytest.mark.parametrize("model", CASES)
def test_the_cases_hold_the_best_values(model: str) -> None:
    plan = load_plan(calibration()["plan"])
    document = load_case(CASES[model]).resolved()
    best = {p["name"]: p["best"] for p in fit_of(model)["parameters"]}
    for parameter in plan.parameters:
        assert float(value_at(document, parameter.path)) == pytest.approx(best[parameter.name], rel=1e-3)
    problem = Problem(plan, next(m for m in plan.models if m.name == model))
    simulated = problem.cases_at(best)[1]  # 120 rpm, 100/100 um
    for name in ("rotors", "sleeves", "meshes"):
        for path in ("0.stiffness", "0.damping") if name == "meshes" else ("ring",):
            ours, theirs = (value_at(each, f"{name}.{path}") for each in (document, simulated.resolved()))
            assert set(ours) == set(theirs)
    ours, theirs = (value_at(each, "base.acceleration") for each in (document, simulated.resolved()))
    floor = best["floor"]
    assert np.array(theirs.pop("density"))[:, 1] == pytest.approx([floor, floor])
    assert np.array(ours.pop("density"))[:, 1] == pytest.approx([floor, floor], rel=1e-3)
    assert ours == theirs


def test_study_and_claims_record_as_their_calibration_did() -> None:
    simulation = load_plan("han2021").simulation
    for settings in (Settings(), ClaimSettings()):
        assert settings.transient == simulation.transient
        assert settings.duration == simulation.duration
        assert settings.sampling == simulation.sampling


def test_the_provenance_is_that_of_the_bundled_plan() -> None:
    plan = load_plan("han2021")
    held = calibration()
    assert held["digest"] == digest_of(plan)[:16]
    assert held["seed"] == plan.effort.seed
    assert all(fit["trials"] == plan.effort.evaluations for fit in held["fits"].values())
    assert {condition.label for condition in conditions()} == set(fit_of("coupled")["left_out"])
    for line in LINES:
        assert left_out_error("coupled", conditions()[0], line, "amplitude_as_printed") >= 0.0


def test_the_verdict_is_that_of_the_duels() -> None:
    """Every pair of models once; who wins follows from the numbers, and the verdict from who wins."""
    held = calibration()
    models = list(held["fits"])
    assert [(d["first"], d["second"]) for d in held["duels"]] == list(combinations(models, 2))
    for each in held["duels"]:
        numbers = {name: value for name, value in each.items() if name != "winner"}
        assert Duel(**numbers).winner == each["winner"]
    best = [
        m for m in models if all(d["winner"] == m for d in held["duels"] if m in (d["first"], d["second"]))
    ]
    assert held["winner"] == (best[0] if best else None)
    assert (best[0] if best else "no model beats every other") in held["statement"]
    assert duel_of("coupled", "uncoupled") == held["duels"][0]


def test_the_studys_members_are_not_those_of_any_search() -> None:
    settings = Settings()
    searched = calibration()["seed"]
    seeds_seen = {searched, searched + CHOOSE_SEED, searched + CHECK_SEED}
    assert settings.seed not in seeds_seen
    case = base_case(settings.variants[0], settings)
    own = initial_state(case, pack(case), member=1)
    for seed in seeds_seen:
        other = replace(case, {"run.seed": seed})
        assert not np.allclose(own, initial_state(other, pack(other), member=1), rtol=1e-6, atol=0.0)


def test_what_the_choice_of_the_model_changes_is_seen_with_equal_parameters() -> None:
    coupled, uncoupled, switched = PARAMETERS["calibrated"]
    assert (switched.name, switched.model, switched.case) == (SWITCHED, "uncoupled", coupled.case)
    assert uncoupled.case != coupled.case


@pytest.mark.parametrize("model", list(calibration()["fits"]))
def test_left_out_errors_follow_from_their_conditions_and_are_not_the_searchs(model: str) -> None:
    """The mean error of conditions left out is that of its 18 residuals; none is an error of the search or of fresh members."""
    fit = fit_of(model)
    for at, quantity in enumerate(("amplitude", "frequency")):
        residuals = [
            value
            for condition in fit["left_out"].values()
            for name, value in condition.items()
            if name.endswith(quantity)
        ]
        assert len(residuals) == 18
        assert len(set(residuals)) > 12
        errors = [100.0 * abs(10.0**value - 1.0) for value in residuals]
        assert sum(errors) / len(errors) == pytest.approx(fit["held_out"][at], rel=1e-6)
        assert fit["held_out"][at] != pytest.approx(fit["in_sample"][at], rel=1e-6)
        assert fit["held_out"][at] != pytest.approx(fit["fresh"][at], rel=1e-6)
