"""The report of a calibration: what the document, the table and the page hold, and what user text cannot do to them."""

import csv
import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.calibration.figures import colors_of, density_of, pairs_of, predicted_figure
from gearplay.calibration.model_comparison import Prediction, Standing
from gearplay.calibration.objective import data_of, printed_measurements
from gearplay.calibration.out_of_sample import Drift, LeftOut
from gearplay.calibration.plan import Model, Plan
from gearplay.calibration.posterior import Interval
from gearplay.calibration.procedure import Fit, Row
from gearplay.calibration.reading import load_plan
from gearplay.calibration.report import write_calibration
from gearplay.calibration.result import Calibration
from gearplay.calibration.spans import datum_unit
from gearplay.calibration.trials import Problem
from gearplay.work.pieces import with_digest

SCRIPT = "<script>alert(1)</script> of $ 5"
LINE = {"kind": "line", "name": "mesh", "order": 1}
RMS = {"kind": "statistic", "name": "level", "statistic": "rms"}


def small_plan(*, frequencies: bool = True, **changes: Any) -> Plan:
    """Return a plan of two models, two readings, two conditions and two parameters; one target with a frequency or without."""
    seen = {"mesh": {"amplitude": 2.0, "frequency": 40.0}} if frequencies else {"level": {"value": 2.0}}
    document: dict[str, Any] = {
        "title": SCRIPT,
        "case": "han2021",
        "sensor": {"rotor": "ring"},
        "models": [
            {"name": "coupled <b>", "set": {"backlash_model": "coupled"}},
            {"name": "_un$coupled", "set": {"backlash_model": "uncoupled"}},
        ],
        "readings": ["absolute", "displacement"],
        "parameters": [
            {"name": "drag", "path": "rotors.ring.load.drag", "low": 1e-4, "high": "1e-2 N m s/rad"},
            {"name": "factor", "path": "meshes.0.backlash", "low": 0.5, "high": 2.0, "mode": "scale"},
        ],
        "targets": [LINE if frequencies else RMS],
        "conditions": [{"name": "slow & steady", "measured": seen}, {"name": "fast, $ 60", "measured": seen}],
    }
    return load_plan({**document, **changes})


def fit_of(plan: Plan, model: Model, reading: str, *, evidence: float, seed: int) -> Fit:
    """Return a fit with made-up numbers; the first parameter is identified, the others are not."""
    generator = np.random.default_rng(seed)
    problem = Problem(plan, model)
    number = len(plan.parameters)
    sample = generator.uniform(0.2, 0.8, (60, number))
    sample[:, 0] = generator.normal(0.5, 0.005, 60)
    low, median, high = (problem.values(q) for q in np.quantile(sample, [0.05, 0.5, 0.95], axis=0))
    data = data_of(plan, printed_measurements(plan))
    off = [float(r) for r in generator.normal(0.0, 0.05, len(data))]
    frequency = 2.5 if any(d.key == "frequency" for d in data) else math.nan
    predicted = tuple(
        Prediction(
            condition.name,
            evidence,
            10.0 * (at + 1),
            frequency,
            tuple(0.1 for d in data if d.condition == condition.name),
            tuple(d.label for d in data if d.condition == condition.name),
        )
        for at, condition in enumerate(plan.conditions)
    )
    return Fit(
        model=model.name,
        reading=reading,
        trials=50,
        failed=2,
        best=problem.values([0.5] * number),
        unit=(0.5,) * number,
        factor=1.0,
        amplitude_error=7.5,
        frequency_error=frequency,
        found_errors=(4.25, frequency),
        rows=tuple(
            Row(d.condition, d.target, d.key, d.value, d.value * 10.0**r, r, 0.01)
            for d, r in zip(data, off, strict=True)
        ),
        intervals=tuple(Interval(p.name, low[p.name], median[p.name], high[p.name]) for p in plan.parameters),
        correlation=tuple(tuple(float(i == j) for j in range(number)) for i in range(number)),
        sample=tuple(tuple(float(u) for u in row) for row in sample),
        scatter=(0.01, 0.02, 0.04),
        emulator_degree=2,
        emulator_error=(0.015,) * len(data),
        predicted=predicted,
        left_out=tuple(LeftOut(x.condition, {}, (0.02,) * len(x.labels), x.labels) for x in predicted),
        standing=Standing(
            model.name, -2.0 * evidence, evidence, 0.1, {x.condition: x.log_density for x in predicted}
        ),
        history=(30.0, 20.0, 10.0),
        drift=(),
    )


def fits_of(plan: Plan) -> list[Fit]:
    """Return a fit of every model in every reading; the first model is ahead."""
    return [
        fit_of(plan, model, reading, evidence=20.0 - 10.0 * at, seed=at)
        for at, model in enumerate(plan.models)
        for reading in plan.readings
    ]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Plan, list[Fit], Path, dict[str, Any]]:
    plan = small_plan()
    fits, folder = fits_of(plan), tmp_path_factory.mktemp("report")
    return plan, fits, folder, write_calibration(plan, fits, folder)


@pytest.mark.slow
def test_the_document_is_the_file_and_holds_every_fit(written: Any) -> None:
    plan, fits, folder, document = written
    assert json.loads((folder / "calibration.json").read_text()) == with_digest(document)
    assert list(document) == ["title", "statement", "answer", "duels", "fits", "plan", "versions"]
    assert document["title"] == SCRIPT
    assert document["plan"]["effort"]["seed"] == plan.effort.seed
    assert {"gearplay", "numpy", "python", "optuna"} <= set(document["versions"])
    kept = {field.name for field in dataclasses.fields(Fit)} - {"sample", "history"}
    for held, fit in zip(document["fits"], fits, strict=True):
        assert kept <= set(held)
        assert not {"sample", "history"} & set(held)
        assert held["best"] == fit.best
        assert held["predicted_amplitude_error"] == pytest.approx(15.0)
        assert held["left_out_amplitude_error"] == pytest.approx(100.0 * (10.0**0.02 - 1.0))
        assert held["standing"]["predictive"] == fit.standing.predictive


def test_the_document_states_the_winner_with_its_evidence(written: Any) -> None:
    _, _, folder, document = written
    assert document["statement"]["overall"] == "coupled <b>"
    assert [r["winner"] for r in document["statement"]["readings"]] == ["coupled <b>"] * 2
    assert [d["reading"] for d in document["duels"]] == ["absolute", "displacement"]
    assert document["duels"][0]["log_odds"] == pytest.approx(10.0)
    assert document["duels"][0]["words"] in document["statement"]["words"]
    page = (folder / "report.html").read_text()
    assert page.index("coupled &lt;b&gt; explains the data better") < page.index('id="models"')


def test_parameters_have_units_bounds_and_a_verdict(written: Any) -> None:
    drag, factor = written[3]["fits"][0]["parameters"]
    assert (drag["unit"], drag["searched"], drag["identified"]) == ("N m s/rad", [1e-4, 1e-2], True)
    assert (factor["unit"], factor["searched"], factor["identified"]) == ("1", [0.5, 2.0], False)
    page = (written[2] / "report.html").read_text()
    assert page.count('<td class="one">drag</td><td class="one holds">identified</td>') == 4
    assert page.count('<td class="one">factor</td><td class="one cannot">not identified</td>') == 4


def test_the_page_begins_with_the_answer_and_one_picture(written: Any) -> None:
    _, fits, folder, document = written
    told, first, errors = document["answer"]
    assert first == document["statement"]["words"][0]
    assert "coupled <b> 8 % and 5 %" in errors  # 0.02 decades are 4.7 %
    assert told.startswith("90 % intervals of the model coupled <b>: drag ")
    interval = next(each for each in fits[0].intervals if each.name == "drag")
    assert (
        f"drag {interval.low:.3g} to {interval.high:.3g} N m s/rad (the case's 0.000293 lies below)" in told
    )
    assert "; not identified: factor " in told
    page = (folder / "report.html").read_text()
    places = [
        page.index(text)
        for text in ("90 % intervals of the model", "data:image/png", 'id="models"', 'id="parameters"')
    ]
    assert places == sorted(places)


@pytest.mark.slow
def test_numbers_are_si_in_the_document_and_as_engineers_read_them_on_the_page(tmp_path: Path) -> None:
    play = {"name": "play", "path": "sleeves.ring.radial_clearance", "low": "40 um", "high": "250 um"}
    turn = {
        "name": "turn",
        "path": "meshes.0.stiffness.phase",
        "low": "0 deg",
        "high": "360 deg",
        "scale": "linear",
    }
    plan = small_plan(parameters=[play, turn], readings=["absolute"])
    fits = fits_of(plan)
    document = write_calibration(plan, fits, tmp_path)
    length, angle = document["fits"][0]["parameters"]
    assert length["unit"] == "m"
    assert length["searched"] == pytest.approx([4e-5, 2.5e-4])
    assert length["best"] == fits[0].best["play"] == pytest.approx(1e-4)
    assert (length["shown_unit"], angle["shown_unit"]) == ("µm", "deg")
    page = (tmp_path / "report.html").read_text()
    assert '<td class="one">µm</td><td class="n">100</td>' in page
    assert "40 to 250, log" in page
    assert "0 to 360, linear" in page
    found = Calibration(document)
    assert dict(found.rows())["play, coupled <b>, absolute"].startswith("100 µm (")
    assert float(found.ds["best"][0]) == pytest.approx(1e-4)
    assert str(found.ds["unit"].values[0]) == "m"


def test_the_table_of_residuals_parses_back_to_the_numbers(written: Any) -> None:
    _, fits, folder, _ = written
    with open(folder / "residuals.csv", encoding="utf-8", newline="") as file:
        found = list(csv.DictReader(file))
    expected = [(fit, row) for fit in fits for row in fit.rows]
    assert len(found) == len(expected) == 16
    for line, (fit, row) in zip(found, expected, strict=True):
        assert (line["model"], line["reading"]) == (fit.model, fit.reading)
        assert (line["condition"], line["target"], line["key"]) == (row.condition, row.target, row.key)
        assert float(line["measured"]) == row.measured
        assert float(line["simulated"]) == row.simulated
        assert float(line["residual_decades"]) == row.residual
        assert float(line["error_pct"]) == row.error
        assert float(line["ensemble_error_decades"]) == row.ensemble_error
        assert float(line["predicted_residual_decades"]) == 0.1
        unit = {"absolute": "m/s²", "displacement": "µm"}[fit.reading]
        assert line["unit"] == (unit if row.key == "amplitude" else "Hz")


def test_user_text_cannot_leave_its_place(written: Any) -> None:
    _, _, folder, _ = written
    page = (folder / "report.html").read_text()
    assert "<script" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page
    assert "<b>coupled" not in page
    assert "coupled <b>" not in page
    assert "slow &amp; steady" in page


def test_the_page_is_self_contained_and_shows_every_figure(written: Any) -> None:
    _, _, folder, _ = written
    page = (folder / "report.html").read_text()
    names = sorted(path.name for path in (folder / "figures").iterdir())
    assert len(names) == 1 + 2 * 5
    assert all((folder / "figures" / name).read_bytes().startswith(b"\x89PNG") for name in names)
    assert page.count('src="data:image/png;base64,') == len(names)
    assert "http" not in page
    assert not list(folder.rglob("*.part"))


def test_predicted_and_left_out_are_one_number_each_in_every_file(written: Any) -> None:
    """The fixture's conditions are 10 and 20 % off as predicted, 10^0.02 - 1 = 4.7 % off as left out."""
    _, _, folder, document = written
    assert (
        "under conditions left out of the fit (reading absolute): coupled <b> 8 % and 5 %"
        in document["answer"][2]
    )
    page = (folder / "report.html").read_text()
    assert '<td class="n">15.0</td><td class="n">2.5</td>\n<td class="n">4.7</td>' in page
    assert "predicted from the others:\ncoupled &lt;b&gt; 15.0 %" in page
    assert "held" not in json.dumps([{**fit, "plan": ""} for fit in document["fits"]])
    names = {path.name for path in (folder / "figures").iterdir()}
    assert {"predicted-absolute.png", "predicted-displacement.png"} <= names
    assert not [name for name in names if "left" in name]
    assert "sequential Monte Carlo" in page
    assert "nested" not in page


@pytest.mark.slow
def test_absent_numbers_are_dashes_on_the_page_and_null_in_the_document(tmp_path: Path) -> None:
    plan = small_plan(frequencies=False, readings=["absolute"])
    document = write_calibration(plan, fits_of(plan), tmp_path)
    assert document["fits"][0]["frequency_error"] is None
    assert document["fits"][0]["predicted_frequency_error"] is None
    assert document["fits"][0]["rows"][0]["unit"] == "m/s²"
    text = (tmp_path / "calibration.json").read_text()
    assert json.loads(text, parse_constant=pytest.fail) == with_digest(document)
    page = (tmp_path / "report.html").read_text()
    assert '<td class="n">7.5</td><td class="n">–</td>' in page
    assert "nan" not in page.split('id="figures"')[0].lower()


@pytest.mark.slow
def test_one_of_everything_can_be_told_nothing_about(tmp_path: Path) -> None:
    plan = small_plan(frequencies=False, readings=["absolute"])
    keep = {name: getattr(plan, name)[:1] for name in ("models", "conditions", "parameters")}
    tiny = plan.model_copy(update=keep)
    document = write_calibration(tiny, fits_of(tiny), tmp_path)
    assert document["statement"]["overall"] == "undecided"
    assert document["duels"] == []
    assert "pairs" not in " ".join(path.name for path in (tmp_path / "figures").iterdir())  # there is no pair
    page = (tmp_path / "report.html").read_text()
    assert "is the only model" in page
    assert "predicted from the others" not in page.split('id="models"')[0]
    assert document["answer"][-1] == "The plan has one condition: no other record tests the fit."


@pytest.mark.slow
def test_a_datum_that_vanishes_or_cannot_be_predicted_is_still_drawn(tmp_path: Path) -> None:
    plan = small_plan(readings=["unnormalised"])
    first, second = fits_of(plan)
    gone = dataclasses.replace(first.rows[0], simulated=0.0, residual=-300.0)
    unknown, known = first.predicted
    unknown = dataclasses.replace(unknown, residuals=(math.nan,) * 2, amplitude_error=math.nan)
    first = dataclasses.replace(first, rows=(gone, *first.rows[1:]), predicted=(unknown, known))
    document = write_calibration(plan, [first, second], tmp_path)
    assert document["fits"][0]["rows"][0]["error"] == 100.0
    assert document["fits"][0]["rows"][0]["predicted_residual"] is None
    assert document["fits"][0]["predicted_amplitude_error"] == 20.0  # of the other condition
    table = (tmp_path / "residuals.csv").read_text().splitlines()
    assert table[1].endswith(",")


@pytest.mark.slow
def test_a_prediction_that_does_not_exist_is_drawn_nowhere() -> None:
    plan = small_plan()
    fit = fits_of(plan)[0]
    absent, nothing = (
        dataclasses.replace(
            fit, predicted=tuple(dataclasses.replace(each, residuals=r, labels=n) for each in fit.predicted)
        )
        for r, n in (((math.nan,), (fit.predicted[0].labels[0],)), ((), ()))
    )
    colors = colors_of([fit])
    assert predicted_figure(plan, [absent], colors) == predicted_figure(plan, [nothing], colors)


def test_a_density_is_one_for_the_prior_and_integrates_to_one() -> None:
    at, density = density_of(np.random.default_rng(0).uniform(size=4000))
    assert np.abs(density - 1.0).max() < 0.2
    at, density = density_of(np.full(50, 0.3))
    assert np.trapezoid(density, at) == pytest.approx(1.0, abs=1e-3)
    assert at[density.argmax()] == pytest.approx(0.3)


def test_pair_plot__has_the_best_identified_parameters() -> None:
    plan = small_plan()
    fit = fits_of(plan)[0]
    spread = np.array([0.1, 0.01, 0.2, 0.02, 0.03, 0.3, 0.04, 0.05, 0.06, 0.07])
    sample = 0.5 + spread * np.random.default_rng(1).normal(size=(400, 10))
    many = dataclasses.replace(fit, sample=tuple(map(tuple, sample)))
    assert pairs_of(many) == [0, 1, 3, 4, 6, 7, 8, 9]


def test_the_written_document_is_read_again(written: Any) -> None:
    _, _, folder, document = written
    assert gp.read_result(folder / "calibration.json") == Calibration(document)


def test_a_written_document_that_was_changed_is_refused(written: Any, tmp_path: Path) -> None:
    """A digit of it anywhere, which leaves a document that could be; a row that is gone."""
    _, _, folder, document = written
    whole, file = (folder / "calibration.json").read_text(), tmp_path / "calibration.json"
    digits = [at for at, letter in enumerate(whole[: whole.index('"sha256"')]) if letter in "12345"]
    for at in digits[:: len(digits) // 20]:
        changed = whole[:at] + str(int(whole[at]) + 1) + whole[at + 1 :]
        if json.loads(changed) == json.loads(whole):  # the 17th digit of a number
            continue
        file.write_text(changed)
        with pytest.raises(gp.InputError, match="it was changed since") as caught:
            gp.read_result(file)
        assert len(caught.value.faults) == 1
    file.write_text(json.dumps({**json.loads(whole), "fits": document["fits"][1:]}))
    with pytest.raises(gp.InputError, match="it was changed since"):
        gp.read_result(file)


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "3", "[" * 100_000, "{}", '{"fits": 3}', '{"title": "", "statement": 3, "fits": []}',
     '{"title": "", "statement": {"words": [3]}, "fits": [{"model": "", "reading": "", "parameters": [{}]}]}'],
)  # fmt: skip
def test_what_is_no_document_is_refused(text: str, tmp_path: Path) -> None:
    file = tmp_path / "calibration.json"
    file.write_text(text)
    for path in (file, tmp_path / "none.json", tmp_path):
        with pytest.raises(
            gp.InputError, match=r"must be a calibration\.json that|must be a readable"
        ) as caught:
            gp.read_result(path)
        assert len(str(caught.value).splitlines()) == 1


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_fit__a_result_at_its_start_is_reported(written: Any, tmp_path: Path) -> None:
    plan, fits, _, document = written
    dying = Drift("slow", "radial", "amplitude", 20.0, -2.0, 0.01)
    changing = [dataclasses.replace(fits[0], drift=(dying,)), *fits[1:]]
    quiet, told = document["answer"], write_calibration(plan, changing, tmp_path / "dying")["answer"]
    assert len(quiet) == 3
    assert told[:3] == quiet
    assert "the amplitude of radial, slow, is 0.01 times as large after 20 s" in told[3]
    assert fits[0].model in told[3]
    assert "The start is not forgotten" in (tmp_path / "dying" / "report.html").read_text()


@pytest.mark.parametrize(("contact", "unit"), [("ring", "N"), ("a-b:drive", "N"), ("a-b:forward", "N m")])
def test_peaks_of_contacts__have_units_of_their_contact(contact: str, unit: str) -> None:
    """The largest load of a coupling is a torque, of a bush or flank a force."""
    target = {"kind": "statistic", "name": "level", "statistic": "peak_force", "contact": contact}
    plan = small_plan(frequencies=False, targets=[target])
    assert datum_unit(plan, "absolute", Row("slow & steady", "level", "value", 1.0, 1.0, 0.0, 0.0)) == unit
