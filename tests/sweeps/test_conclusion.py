"""What the pages of a sweep say: one number in one place, jamming by name, temperatures in degrees Celsius."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearplay.sweeps.report.conclusion import conclusion_of
from gearplay.sweeps.report.drawable import View
from gearplay.sweeps.report.figures import pictures_of
from gearplay.sweeps.report.page import write_sweep_report
from gearplay.sweeps.tolerances.page import write_tolerance
from sweep_products import BACKLASH, DESIGN, PLAY, RMS, SPEED, made, plan_of

TEMPERATURE = {
    "name": "temperature", "path": "environment.temperature", "low": "-60 degC", "high": "60 degC", "count": 5,
}  # fmt: skip
TWO = {"name": "backlash", "path": "meshes.0.backlash", "values": ["5 um", "20 um"]}
JAM = {"kind": "jam", "name": "jam", "mesh": "pinion-ring"}
STEEL = {"environment.temperature": "20 degC", "environment.housing.expansion": "12e-6 1/K"}


def jam_at(where: Any) -> Any:
    def value(kept: Any, values: Any, member: int) -> Any:
        return np.full(kept.size, 0.25 if where(values) else 0.0)

    return value


def cold_plan(**more: Any) -> dict[str, Any]:
    plan = plan_of(TEMPERATURE, TWO, reduce=[JAM], **more)
    plan["set"] = {**plan["set"], **STEEL}
    return plan


@pytest.mark.parametrize(
    ("where", "sentence"),
    [
        (lambda v: v["temperature"] < 220.0 and v["backlash"] < 1e-5,
         "Mesh pinion-ring jams at temperature -60 °C with backlash 5 µm, up to 25 % of the time; not with backlash 20 µm."),
        (lambda v: v["temperature"] < 250.0,
         "Mesh pinion-ring jams at temperature from -60 °C to -30 °C with backlash 5 µm, "
         "at temperature from -60 °C to -30 °C with backlash 20 µm, up to 25 % of the time."),
        (lambda v: v["backlash"] < 1e-5,
         "Mesh pinion-ring jams at every temperature with backlash 5 µm, up to 25 % of the time; not with backlash 20 µm."),
        (lambda v: False, "Mesh pinion-ring jams in none of the 10 cases."),
        (lambda v: True, "Mesh pinion-ring jams in all of the 10 cases, up to 25 % of the time."),
    ],
)  # fmt: skip
def test_jamming_is_said_where_it_is(where: Any, sentence: str) -> None:
    """One of ten cases jams: that is said, and not that half of them lie above 0."""
    said = [
        each.replace("\N{NO-BREAK SPACE}", " ")
        for each in conclusion_of(View(*made(cold_plan(), jam_at(where))))
    ]
    assert said[0] == sentence
    assert not any("half" in each for each in said)


def test_most_cases_at_one_end_are_said() -> None:
    sweep, dataset = made(plan_of(SPEED, reduce=[RMS]), lambda k, v, m: 3.0 if v["speed"] > 30.0 else 1.0)
    (words, *_) = conclusion_of(View(sweep, dataset))
    assert words.endswith("lies between 1 and 3 m/s²; it is 1 m/s² in 4 of the 5 cases.")
    sweep, dataset = made(plan_of(SPEED, reduce=[RMS]), lambda k, v, m: v["speed"])
    values = dataset["rms"].values
    (words, *_) = conclusion_of(View(sweep, dataset))
    assert words.endswith(f"the median of the 5 cases is {np.median(values):.3g} m/s².")
    sweep, dataset = made(plan_of(SPEED, reduce=[RMS], members=4), lambda k, v, m: v["speed"] + m)
    (words, *_) = conclusion_of(View(sweep, dataset))
    assert f"the median of the 20 runs is {np.sort(dataset['rms'].values.ravel())[9]:.3g} m/s²." in words


def test_range_and_median__of_a_saltelli_design_are_of_its_independent_points() -> None:
    """As on the page of tolerances: the points between repeat values of those."""
    design = {"kind": "saltelli", "count": 8, "parameters": DESIGN["parameters"]}
    sweep, dataset = made(plan_of(design=design, reduce=[RMS]), lambda k, v, m: sum(v.values()))
    (words, *_) = conclusion_of(View(sweep, dataset))
    block = len(DESIGN["parameters"]) + 2
    values = dataset["rms"].values.reshape(-1, block)
    own = np.sort(values[:, [0, -1]].ravel())
    assert own[-1] < values.max()  # the points between reach farther
    assert (
        f"lies between {own[0]:.3g} and {own[-1]:.3g} m/s²; the median of the 16 cases is {own[7]:.3g} m/s²."
        in words
    )


SHARES = re.compile(
    r"Shares of its variance, first order \(alone\) and total \(with others\)(?:, with 95 % intervals)?: ([^<]*?\.)(?:\s|<|$)"
)


@pytest.mark.slow
def test_both_pages_of_a_sweep_have_the_same_shares(tmp_path: Path) -> None:
    """The shares are those of a known function: y = 4 a + 2 b + 2 a b of uniform a, b, apart from the polynomial's error."""
    parameters = [
        {"name": "a", "path": "meshes.0.backlash", "distribution": "uniform", "low": 1e-5, "high": 2e-5},
        {"name": "b", "path": "sleeves.ring.radial_clearance", "distribution": "uniform", "low": 1e-5, "high": 2e-5},
    ]  # fmt: skip
    tolerance = {"measure": "rms", "limit": "1 m/s^2", "probability": 0.9}
    plan = plan_of(
        design={"kind": "latin-hypercube", "count": 200, "parameters": parameters},
        tolerance=tolerance,
        reduce=[RMS],
    )

    def value(kept: Any, values: Any, member: int) -> float:
        a, b = (2e5 * values[name] - 3.0 for name in ("a", "b"))
        return 10.0 + 4.0 * a + 2.0 * b + 2.0 * a * b

    sweep, dataset = made(plan, value)
    write_sweep_report(sweep, dataset, tmp_path)
    write_tolerance(sweep.plan, sweep.plan.tolerance, dataset, tmp_path)
    said = [SHARES.findall((tmp_path / name).read_text()) for name in ("report.html", "tolerance.html")]
    assert said[0]
    assert set(said[0]) == set(said[1])
    numbers = [float(each) for each in re.findall(r"[\d.]+(?= ±)", said[0][0])]
    whole = 16.0 / 3.0 + 4.0 / 3.0 + 4.0 / 9.0
    right = [
        1600.0 / 3.0 / whole,
        (1600.0 / 3.0 + 400.0 / 9.0) / whole,
        400.0 / 3.0 / whole,
        (400.0 / 3.0 + 400.0 / 9.0) / whole,
    ]
    assert np.allclose(numbers, right, atol=1.0)


def test_shares_of_a_grid_are_exact() -> None:
    """Of y = a + b + a b over a grid of centred axes the variance splits into those of a, b and a b."""
    sweep, dataset = made(
        plan_of(SPEED, PLAY, reduce=[RMS]),
        lambda k, v, m: (
            7.0
            + _centred(v["speed"], SPEED)
            + _centred(v["play"], PLAY) * (1.0 + _centred(v["speed"], SPEED))
        ),
    )
    a, b = (np.linspace(-1.0, 1.0, n) for n in (5, 4))
    parts = [np.var(a), np.var(b), np.var(a) * np.var(b)]
    whole = sum(parts)
    words = SHARES.findall(conclusion_of(View(sweep, dataset))[1])[0]
    right = f"play {100 * parts[1] / whole:.3g} and {100 * (parts[1] + parts[2]) / whole:.3g} %, "
    right += f"speed {100 * parts[0] / whole:.3g} and {100 * (parts[0] + parts[2]) / whole:.3g} %."
    assert words == right


def _centred(value: float, axis: Any) -> float:
    factor = np.pi / 30.0 if axis is SPEED else 1e-6
    low, high = (factor * float(axis[end].split()[0]) for end in ("low", "high"))
    return float(2.0 * (value - low) / (high - low) - 1.0)


@pytest.mark.slow
def test_temperatures_are_degrees_celsius_in_pictures_and_pages(tmp_path: Path) -> None:
    """Axes in °C from -60 to 60, in the map too, whose jam line still lies where backlash equals the play."""
    plan = cold_plan()
    plan["axes"][1] = {**BACKLASH, "low": "5 um", "high": "400 um"}
    plan["reduce"] = [RMS]
    sweep, dataset = made(plan, lambda k, v, m: 5.0 + 0.01 * (v["temperature"] - 273.15))
    view = View(sweep, dataset)
    axis = view.axes["temperature"]
    assert axis.label == "temperature [°C]"
    assert np.allclose(axis.values, [-60.0, -30.0, 0.0, 30.0, 60.0])
    assert np.allclose(axis.raw(axis.values), dataset["temperature"].values)
    assert pictures_of(sweep, dataset)
    write_sweep_report(sweep, dataset, tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "213.1" not in page.split("<pre")[0]
    assert "-60" in page
    assert "°C" in page


def test_drawn_parameters_are_counted_once() -> None:
    """A design alone has the shares of its parameters, one over axes those of the axes and of all drawn together."""
    sweep, dataset = made(plan_of(design=DESIGN, reduce=[RMS]), lambda k, v, m: v["speed"])
    assert (
        "total (with others), with 95 % intervals: speed 100 ± 0 and"
        in conclusion_of(View(sweep, dataset))[1]
    )
    fewer = {**DESIGN, "parameters": DESIGN["parameters"][1:]}
    sweep, dataset = made(plan_of(SPEED, design=fewer, reduce=[RMS]), lambda k, v, m: v["speed"])
    assert (
        "speed 100 and 100 %, the drawn parameters together 0 and 0 %"
        in conclusion_of(View(sweep, dataset))[1]
    )
