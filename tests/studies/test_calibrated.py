"""Calibrated cases: values of the stored calibration, members that no search used."""

from itertools import combinations

import numpy as np
import pytest

from gearplay.calibration.model_comparison import PairComparison
from gearplay.calibration.out_of_sample import CHECK_SEED, CHOOSE_SEED
from gearplay.calibration.reading import load_plan
from gearplay.calibration.search import even_point
from gearplay.calibration.store import digest_of
from gearplay.calibration.trials import Problem
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from gearplay.model.plan_values import value_at
from gearplay.model.reading import load_case, replace
from gearplay.studies.han2021.article import (
    AMPLITUDE,
    FREQUENCY,
    LINES,
    conditions,
    fit_of,
    left_out_error,
    printed,
    stored,
)
from gearplay.studies.han2021.claims import ClaimSettings
from gearplay.studies.han2021.claims import Problem as ClaimProblem
from gearplay.studies.han2021.shares import MODELS
from gearplay.studies.han2021.simulation import PARAMETERS, SWITCHED, Settings, base_case

CASES = {"coupled": "han2021-calibrated", "uncoupled": "han2021-calibrated-uncoupled"}


@pytest.mark.parametrize("model", CASES)
def test_cases__best_values_of_the_calibration(model: str) -> None:
    plan = load_plan(stored("calibration")["plan"])
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


def test_settings__records_of_the_calibration() -> None:
    simulation = load_plan("han2021").simulation
    for settings in (Settings(), ClaimSettings()):
        assert settings.transient == simulation.transient
        assert settings.duration == simulation.duration
        assert settings.sampling == simulation.sampling


def test_plan__printed_test_values() -> None:
    for at, (condition, planned) in enumerate(
        zip(conditions(), load_plan("han2021").conditions, strict=True)
    ):
        assert planned.name == condition.label
        for k, line in enumerate(LINES):
            assert planned.measured[line].amplitude == printed("test", AMPLITUDE)[at, k]
            assert planned.measured[line].frequency == printed("test", FREQUENCY)[at, k]
        assert planned.set == {
            "rotors.pinion.drive.speed": f"{condition.speed_rpm:g} rpm",
            "sleeves.ring.radial_clearance": f"{condition.radial_clearance_um:g} um",
            "meshes.0.backlash": f"{condition.backlash_um:g} um",
        }


def test_calibration__provenance_of_the_bundled_plan() -> None:
    plan = load_plan("han2021")
    held = stored("calibration")
    assert held["digest"] == digest_of(plan)[:16]
    assert held["seed"] == plan.effort.seed
    assert all(fit["trials"] == plan.effort.evaluations for fit in held["fits"].values())
    assert {condition.label for condition in conditions()} == set(fit_of("coupled")["left_out"])
    for line in LINES:
        assert left_out_error("coupled", conditions()[0], line, AMPLITUDE) >= 0.0


def test_calibration__winner_follows_from_the_pairwise_comparisons() -> None:
    """Every pair of models once; the winner of each follows from its numbers, the overall one from the winners."""
    held = stored("calibration")
    models = list(held["fits"])
    assert [(d["first"], d["second"]) for d in held["duels"]] == list(combinations(models, 2))
    for each in held["duels"]:
        numbers = {name: value for name, value in each.items() if name != "winner"}
        assert PairComparison(**numbers).winner == each["winner"]
    best = [
        m for m in models if all(d["winner"] == m for d in held["duels"] if m in (d["first"], d["second"]))
    ]
    assert held["winner"] == (best[0] if best else None)
    assert (best[0] if best else "no model beats every other") in held["statement"]


def test_settings__seed_of_no_search() -> None:
    settings = Settings()
    searched = stored("calibration")["seed"]
    seeds_seen = {searched, searched + CHOOSE_SEED, searched + CHECK_SEED}
    assert settings.seed not in seeds_seen
    case = base_case(settings.variants[0], settings)
    own = initial_state(case, pack(case), member=1)
    for seed in seeds_seen:
        other = replace(case, {"run.seed": seed})
        assert not np.allclose(own, initial_state(other, pack(other), member=1), rtol=1e-6, atol=0.0)


def test_parameters__switched_variant_has_the_coupled_parameters() -> None:
    coupled, uncoupled, switched = PARAMETERS["calibrated"]
    assert (switched.name, switched.model, switched.case) == (SWITCHED, "uncoupled", coupled.case)
    assert uncoupled.case != coupled.case


@pytest.mark.parametrize("model", list(stored("calibration")["fits"]))
def test_left_out_errors__means_of_their_conditions(model: str) -> None:
    """The mean error of conditions left out is that of its 18 residuals, not that of the search or of fresh members."""
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


@pytest.mark.parametrize("name", MODELS)
def test_claim_problem__cases_of_the_calibration(name: str) -> None:
    """The cases of a Sobol point are those of the calibration's own problem, but for wider ranges of the tilt."""
    plan, settings = load_plan("han2021"), ClaimSettings()
    wider = [
        p.model_copy(update={"low": "-0.05 m/s^2", "high": "0.05 m/s^2"}) if p.name.startswith("tilt") else p
        for p in plan.parameters
    ]
    plan = plan.model_copy(update={"parameters": tuple(wider)})
    reference = Problem(plan, next(model for model in plan.models if model.name == name))
    ours = ClaimProblem(name)
    for point in (0, 5):
        unit = even_point(point, len(plan.parameters), settings.seed)
        theirs = reference.cases_at(reference.values(unit), seed=settings.seed + point)
        theirs = [replace(case, {"run.tolerance": settings.tolerance}) for case in theirs]
        assert ours.cases_at(point, settings) == theirs
