"""The answers of a tolerance study on small, often degenerate samples; the plan's part and the search's designs."""

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from gearplay.model.reading import load_case
from gearplay.sweeps.cases.draws import draw, sample_size, unit_points
from gearplay.sweeps.plans.design import Design, Random
from gearplay.sweeps.plans.kept import scalar_names
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.plans.tolerance import Tolerance, tolerance_problems
from gearplay.sweeps.tolerances.allowable import (
    ALL,
    FOUND,
    NONE,
    UNKNOWN,
    largest_scale,
    scaled,
    search_cases,
    search_plan,
    size_words,
    step_of,
)
from gearplay.sweeps.tolerances.statistics import cuts_of, distribution, exceedance, proportion, statistics_of
from gearplay.sweeps.variance import (
    as_table,
    emulated_indices,
    independent_rows,
    indices_of,
    member_variance,
    sobol_indices,
)
from gearplay.vocabulary.errors import InputError

NAMES = ("a", "b", "c")


def design_of(kind: str = "monte-carlo", count: int = 64, **changes: Any) -> Design:
    """Return a design of three factors, each uniform from 0 to 1."""
    parameters = tuple({"name": n, "path": n, "mode": "scale", "low": 0, "high": 1} for n in NAMES)
    return Design.model_validate(
        {"kind": kind, "count": count, "seed": 5, "parameters": parameters, **changes}
    )


def plan_of(**changes: Any) -> SweepPlan:
    drawn = [
        {"name": "clearance", "path": "sleeves.ring.radial_clearance", "low": "50 um", "high": "0.15 mm"},
        {"name": "backlash", "path": "meshes.0.backlash", "distribution": "normal", "mean": "100um",
         "deviation": 1e-5, "low": "20 um"},
        {"name": "drag", "path": "rotors.ring.load.drag", "mode": "scale", "distribution": "log-normal",
         "mean": 1.0, "deviation": 0.2},
    ]  # fmt: skip
    document = {
        "case": "han2021",
        "design": {"kind": "saltelli", "count": 16, "seed": 7, "parameters": drawn},
        "reduce": [
            {"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"},
            {"kind": "line", "name": "mesh", "signal": "ax", "at": "ring", "order": 1},
            {"kind": "spectrum", "name": "bands", "signal": "ax", "at": "ring", "band": [1.0, 9.0]},
        ],
    }
    return load_sweep({**document, **changes})


def test_an_exceedance_is_counted_and_its_interval_is_the_binomial_one() -> None:
    found = exceedance(np.arange(20.0), 16.5)
    assert (found.probability, found.samples, found.cases, found.failed) == (0.15, 20, 20, 0)
    assert (found.low, found.high) == pytest.approx((0.03207, 0.37893), abs=1e-5)  # exact interval of 3 in 20
    assert found.bounds == (found.low, found.high)


def test_a_value_on_the_limit_keeps_to_it() -> None:
    assert exceedance(np.full(10, 2.0), 2.0).probability == 0.0
    assert step_of(1.0, np.full(10, 2.0), 2.0).meets == 1.0


def test_failed_cases_are_left_out_and_bound_what_they_could_change() -> None:
    values = np.array([1.0] * 12 + [3.0] * 4 + [np.nan, np.inf, -np.inf, np.nan])
    found = exceedance(values, 2.0)
    assert (found.probability, found.cases, found.failed) == (0.25, 16, 4)
    assert found.bounds[0] == exceedance(np.where(np.isfinite(values), values, 0.0), 2.0).low < found.low
    assert found.bounds[1] == exceedance(np.where(np.isfinite(values), values, 9.0), 2.0).high > found.high


def test_nothing_but_failures_bounds_nothing() -> None:
    found = exceedance(np.full((8, 2), np.nan), 1.0)
    assert math.isnan(found.probability)
    assert (found.low, found.high, found.cases, found.failed) == (0.0, 1.0, 0, 16)
    assert found.bounds == (exceedance(np.zeros((8, 2)), 1.0).low, exceedance(np.full((8, 2), 2.0), 1.0).high)
    nothing = distribution(np.full(3, np.nan))
    assert (nothing.samples, nothing.failed) == (0, 3)
    assert all(math.isnan(q.value) and math.isinf(q.low) and math.isinf(q.high) for q in nothing.quantiles)


def test_one_point_says_nearly_nothing() -> None:
    found, told = exceedance(np.array([1.0]), 2.0), distribution(np.array([1.0]))
    assert (found.probability, found.low, found.high) == (0.0, 0.0, 0.975)
    assert told.mean == told.least == told.most == 1.0
    assert math.isnan(told.deviation)
    assert math.isnan(told.mean_error)
    assert math.isinf(told.quantiles[2].low)


def test_effective_members__copies_count_once_and_independent_ones_each() -> None:
    generator = np.random.default_rng(2)
    single = generator.normal(size=(60, 1))
    alone, copied = exceedance(single, 1.0), exceedance(np.repeat(single, 6, axis=1), 1.0)
    assert (copied.low, copied.high) == pytest.approx((alone.low, alone.high))
    scattered = exceedance(generator.normal(size=(60, 6)), 1.0)
    assert scattered.effective > 200.0
    assert scattered.high - scattered.low < 0.6 * (alone.high - alone.low)
    assert scattered.effective < 360.0  # what is not known of the scatter is paid for


def test_points_weigh_the_same_however_many_members_finished() -> None:
    values = np.array([[3.0, np.nan, np.nan], [1.0, 1.0, 1.0]])
    assert exceedance(values, 2.0).probability == 0.5
    told = distribution(values)
    assert (told.mean, told.quantiles[1].value) == (2.0, 1.0)


def test_the_scatter_among_members_is_theirs_within_a_point() -> None:
    generator = np.random.default_rng(3)
    table = 5.0 * generator.normal(size=(500, 1)) + 0.5 * generator.normal(size=(500, 4))
    assert member_variance(table) == pytest.approx(0.25, rel=0.06)
    table[::7, 1] = np.nan
    assert member_variance(table) == pytest.approx(0.25, rel=0.06)
    assert math.isnan(member_variance(table[:, :1]))
    assert math.isnan(distribution(table[:, :1]).noise)


def test_quantiles_are_order_statistics() -> None:
    told = distribution(np.arange(1.0, 100.0), levels=[0.05, 0.5, 0.999])
    assert [q.value for q in told.quantiles] == [5.0, 50.0, 99.0]
    assert (told.quantiles[1].low, told.quantiles[1].high) == (40.0, 60.0)
    assert (told.quantiles[0].low, told.quantiles[0].high) == (1.0, 11.0)  # P(B >= 10) is still 2.7 %
    assert told.quantiles[2].high == math.inf


def test_a_constant_measure_is_described_without_indices() -> None:
    for kind in ("saltelli", "latin-hypercube"):
        design = design_of(kind, 32)
        values = np.full(sample_size(design), 2.5)
        found = statistics_of(design, unit_points(design), values, 2.0)
        assert found.exceedance.probability == 1.0
        assert found.distribution.deviation == 0.0
        assert found.indices.reason == "the measure does not vary"
        assert found.indices.first == ()


def test_values_of_a_wrong_shape_are_a_programming_error() -> None:
    with pytest.raises(ValueError, match="a row for each"):
        indices_of(design_of(), np.zeros(63))
    with pytest.raises(ValueError, match="shape"):
        as_table(np.zeros((2, 2, 2)))


def test_only_the_ends_of_a_saltelli_block_are_draws_of_their_own() -> None:
    design = design_of("saltelli", 4)
    rows = independent_rows(design)
    assert rows.tolist() == [0, 4, 5, 9, 10, 14, 15, 19]
    unit = unit_points(design)
    assert np.unique(unit[rows]).size == unit[rows].size == np.unique(unit).size
    assert independent_rows(design_of("sobol", 4)).tolist() == [0, 1, 2, 3]


def test_sobol_indices_are_the_same_for_the_same_seed_and_lose_whole_blocks() -> None:
    design = design_of("saltelli", 64)
    values = unit_points(design) @ np.array([3.0, 2.0, 0.0])
    first, again = sobol_indices(design, values), sobol_indices(design, values)
    assert (first.first, first.total_error) == (again.first, again.total_error)
    assert first.first_error != sobol_indices(design, values, seed=1).first_error
    values[[7, 8, 100]] = np.nan
    assert sobol_indices(design, values).left_out == 10  # two blocks of five
    values[:300] = np.nan
    assert "complete blocks" in sobol_indices(design, values).reason


def test_total_indices__include_the_scatter_of_members_with_its_share() -> None:
    design = design_of("saltelli", 1024)
    generator, members = np.random.default_rng(0), 4
    signal = np.sqrt(12.0) * unit_points(design)[:, :1]  # variance 1
    found = sobol_indices(design, signal + 1.2 * generator.normal(size=(len(signal), members)))
    noise = 1.44 / members
    assert found.noise == pytest.approx(noise / (1.0 + noise), abs=0.03)
    assert found.total[2] == pytest.approx(found.noise, abs=0.04)  # a parameter without effect
    assert found.first[0] == pytest.approx(1.0 / (1.0 + noise), abs=0.06)


def test_correlated_or_too_few_points_have_no_polynomial_indices() -> None:
    correlations = [{"between": ("a", "b"), "value": 0.5}]
    assert "correlated" in emulated_indices(design_of(correlations=correlations), np.zeros(64)).reason
    assert "finished points" in emulated_indices(design_of(count=12), np.arange(12.0)).reason


def test_polynomial_emulator__states_the_unexplained_variance() -> None:
    design = design_of("latin-hypercube", 200)
    noise = np.random.default_rng(0).normal(size=200)
    found = emulated_indices(design, unit_points(design)[:, 0] * np.sqrt(12.0) + noise)
    assert found.source == "polynomial"
    assert found.unexplained == pytest.approx(0.5, abs=0.1)
    assert found.first[0] == pytest.approx(0.5, abs=0.1)
    assert found.ranking[0] == 0


def test_the_best_cut_is_that_of_the_harmful_end() -> None:
    drawn = np.random.default_rng(1).random((500, 2))
    cuts = cuts_of(["harmless", "harmful"], drawn, 1.0 - drawn[:, 1], 0.9)  # low values exceed
    assert (cuts[0].name, cuts[0].end) == ("harmful", "low")
    assert cuts[0].probability == 0.0
    assert cuts[0].bound == np.sort(drawn[:, 1])[100]
    assert cuts[1].probability > 0.05
    assert cuts_of(["a"], drawn[:, :1], drawn[:, 1], 2.0) == ()  # nothing exceeds
    assert cuts_of(["a"], drawn[:9, :1], drawn[:9, 1], 0.5) == ()  # too few points


def test_the_search_ends_at_the_range_and_owns_up_to_failures() -> None:
    sample = np.abs(np.random.default_rng(4).normal(size=200))
    everything = largest_scale(lambda f: f * sample, 99.0, check=lambda f: f * sample[::-1])
    assert (everything.verdict, everything.factor, everything.resolution) == (ALL, 4.0, 0.0)
    assert everything.confirmed is True
    nothing = largest_scale(lambda f: f * sample, 1e-3, check=lambda f: f * sample)
    assert (nothing.verdict, nothing.check, len(nothing.steps)) == (NONE, None, 5)
    assert math.isnan(nothing.factor)
    unknown = largest_scale(lambda f: np.full(10, np.nan), 1.0)
    assert (unknown.verdict, unknown.steps[0].failed) == (UNKNOWN, 10)
    half = np.where(np.arange(200) % 2 == 0, np.nan, 0.0)
    assert largest_scale(lambda f: half, 1.0).verdict == NONE  # what failed does not keep to the limit


def test_search__uses_all_steps_and_narrows_the_interval() -> None:
    sample = np.abs(np.random.default_rng(4).normal(size=400))
    widths = []
    for steps in (5, 8, 16):
        found = largest_scale(lambda f: f * sample, 2.0, steps=steps)
        assert (found.verdict, len(found.steps), found.single, found.confirmed) == (FOUND, steps, True, None)
        factors = [step.factor for step in found.steps]
        assert factors == sorted(set(factors))
        exact = 2.0 / np.sort(sample)[379]  # 380 of 400 keep to the limit up to here
        assert found.factor <= exact < found.factor + found.resolution
        assert found.span[0] <= found.factor <= found.span[1]
        widths.append(found.span[1] - found.span[0])
    assert widths[0] > widths[1] > widths[2]


def test_the_search_says_where_smaller_clearances_fail_too() -> None:
    sample = np.abs(np.random.default_rng(4).normal(size=200))
    found = largest_scale(lambda f: 5.0 * np.abs(f - 1.1875) * sample, 2.0, steps=12)
    assert (found.verdict, found.single) == (FOUND, False)
    assert 1.2 < found.factor < 1.5


def test_the_fresh_sample_can_contradict_the_search() -> None:
    sample = np.abs(np.random.default_rng(4).normal(size=400))
    found = largest_scale(lambda f: f * sample, 2.0, check=lambda f: 3.0 * f * sample)
    assert found.confirmed is False
    assert found.check is not None
    assert found.check.factor == found.advised == found.span[0] < found.factor


def test_advice_is_the_factor_whose_whole_interval_keeps_to_the_limit() -> None:
    sample = np.abs(np.random.default_rng(4).normal(size=400))
    found = largest_scale(lambda f: f * sample, 2.0)
    (advised,) = [step for step in found.steps if step.factor == found.advised]
    assert found.safe
    assert advised.low >= found.wanted
    assert all(step.low < found.wanted for step in found.steps if step.factor > found.advised)
    few = largest_scale(lambda f: f * sample[:20], 2.0)
    assert not few.safe
    assert few.advised == few.factor


def test_the_cases_of_the_search_are_foretold() -> None:
    plan = load_sweep("han2021-tolerances")
    assert (
        search_cases(plan) == (12 + 1) * 128 * 4
    )  # twelve factors and the fresh sample, of 128 points and 4 members
    assert search_cases(load_sweep("han2021-map")) == 0


def test_sizes__are_stated_in_the_units_of_the_plan() -> None:
    error = Random(name="e", path="p", distribution="triangular", low="0.1 um", high="2 um", peak="0.5 um")
    assert size_words(error, "high", 0.5) == "0.1 to 1 µm, peak 0.5 µm"
    mixed = Random(name="e", path="p", low="500 nm", high="2 um")
    assert size_words(mixed) == "500 nm to 2 µm"
    assert (
        size_words(Random(name="e", path="p", mode="scale", low=0.5, high=2.0), "size", 0.5)
        == "0.25 to 1 times the case's"
    )
    logs = Random(name="e", path="p", distribution="log-normal", mean="10 um", deviation=0.3)
    assert size_words(logs, "size", 2.0) == "median 20 µm, deviation of its logarithm 0.3"


def test_scaling__multiplies_the_draws_of_the_same_points() -> None:
    plan, base = plan_of(), load_case("han2021")
    tolerance = Tolerance(measure="rms", limit=1.0, scale=("clearance", "backlash", "drag"))
    one, two = (search_plan(plan, tolerance, factor) for factor in (1.0, 1.5))
    assert one.design is not None
    assert two.design is not None
    assert (one.design.kind, one.design.count, one.design.seed) == ("sobol", 32, 7)
    assert np.allclose(draw(two.design, base), 1.5 * draw(one.design, base), rtol=1e-9)
    assert two.design.parameters[0].high == "0.22499999999999998 mm"
    fresh = search_plan(plan, tolerance, 1.0, fresh=True)
    assert fresh.design is not None
    assert not np.any(draw(fresh.design, base) == draw(one.design, base))


def test_scaling_the_upper_end_leaves_the_rest() -> None:
    plan = plan_of()
    assert plan.design is not None
    tolerance = Tolerance(measure="rms", limit=1.0, scale=("clearance",), scaling="high", count=40)
    found = scaled(plan.design, tolerance, 2.0)
    assert (found.parameters[0].low, found.parameters[0].high) == ("50 um", "0.3 mm")
    assert found.parameters[1:] == plan.design.parameters[1:]
    assert found.count == 40


def test_a_limit_has_the_unit_of_its_measure() -> None:
    assert Tolerance(measure="rms", limit="250 mm/s^2").limit_in("m/s^2") == 0.25
    assert Tolerance(measure="rms", limit=3).limit_in("m/s^2") == 3.0
    with pytest.raises(InputError, match=r"tolerance\.limit = \"3 um\""):
        Tolerance(measure="rms", limit="3 um").limit_in("m/s^2")


@pytest.mark.parametrize(
    "wrong",
    [
        {"limit": True}, {"limit": math.nan}, {"limit": ""}, {"limit": [1.0]}, {"probability": 1.0},
        {"confidence": 0.0}, {"factors": [2.0, 1.0]}, {"factors": [0.0, 1.0]}, {"factors": [1.0]},
        {"scale": ["a", "a"]}, {"steps": 4}, {"count": 3}, {"scaling": "low"}, {"more": 1},
    ],
)  # fmt: skip
def test_a_wrong_part_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        Tolerance.model_validate({"measure": "rms", "limit": 1.0, **wrong})


def test_a_part_survives_json() -> None:
    part = Tolerance.model_validate({"measure": "rms", "limit": "2 m/s^2", "scale": ["a"], "factors": [1, 2]})
    assert Tolerance.model_validate_json(part.model_dump_json()) == part
    assert Tolerance.model_validate(part.model_dump(mode="json", exclude_none=True)) == part
    assert Tolerance.model_json_schema()["properties"]["limit"]["anyOf"][0] == {"type": "number"}


def test_the_part_must_fit_its_plan() -> None:
    plan = plan_of()
    assert scalar_names(plan.reduce) == ["rms", "mesh_amplitude", "mesh_frequency"]
    good = Tolerance(measure="mesh_amplitude", limit=1.0, scale=("clearance",), scaling="high")
    assert tolerance_problems(good, plan.reduce, plan.design, axes=False) == []

    def places(plan: SweepPlan, **part: Any) -> list[tuple[str | int, ...]]:
        asked = Tolerance(**{"measure": "rms", "limit": 1.0, **part})
        return [p.at for p in tolerance_problems(asked, plan.reduce, plan.design, axes=bool(plan.axes))]

    assert places(plan, measure="mesh") == [("tolerance", "measure")]
    assert places(plan, measure="bands") == [("tolerance", "measure")]
    assert places(plan, scale=("clearance", "clearence")) == [("tolerance", "scale", 1)]
    assert places(plan, scale=("drag",), scaling="high") == [("tolerance", "scale", 0)]
    axes = [{"name": "speed", "path": "rotors.pinion.drive.speed", "values": [6.0, 12.0]}]
    assert places(plan_of(axes=axes)) == []
    assert places(plan_of(axes=axes), scale=("drag",)) == [("tolerance", "scale")]
    assert places(plan_of(design=None)) == [("tolerance",)]


def test_shares_of_few_points_with_many_members_stay_within_their_bounds() -> None:
    assert proportion(np.ones((2, 50))).high == 1.0
    even = proportion(np.tile([1.0, 0.0], (2, 5)))  # both shares are one half: no scatter to be seen
    assert even.value == 0.5
    assert 2.0 <= even.effective < 20.0
