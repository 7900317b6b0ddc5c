"""Diagrams and maps on the page."""

from pathlib import Path

import pytest

from visiting import BACKLASH, CLEARANCE, SPEED, Open, brief, cells, field, fill, open_run, shown, small_map


@pytest.mark.slow
def test_a_bifurcation_diagram(visit: Open) -> None:
    made = visit(plots=False).ready()
    made.page.click("#tab-bifurcation")
    made.release()
    for name, value in (("count", "6"), ("settle", "5"), ("keep", "4")):
        made.page.fill(f"#bifurcation-form [name={name}]", value)
    made.page.click("#bifurcation-form button")
    made.until("document.getElementById('bifurcation').data?.length === 2")
    assert made.page.evaluate("document.getElementById('bifurcation').data[0].x.length") == 24


@pytest.mark.slow
def test_a_map(visit: Open) -> None:
    made = visit(plots=False).ready()
    brief(made)
    made.page.click("#tab-map")
    made.release()
    assert made.page.input_value("#map-form [name=members]") == "8"
    cells(made, 7, 3)
    made.page.click("#map-form button")
    made.until("document.getElementById('map').data?.[0].z.length === 3")
    assert made.page.evaluate("document.getElementById('map').data[0].z[0].length") == 7
    ticks = made.page.evaluate("document.getElementById('map').layout.yaxis.ticktext")
    assert ticks == ["20", "210", "400"]  # few values: each is named, and its cells stand apart
    assert made.page.evaluate("document.getElementById('map').layout.xaxis.tickvals") is None
    gaps = made.page.evaluate("(({ xgap, ygap }) => [xgap, ygap])(document.getElementById('map').data[0])")
    assert gaps == [0, 3]


@pytest.mark.deep
def test_a_map_of_contacts_is_saved(visit: Open) -> None:
    made = visit().ready()
    brief(made)
    made.page.click("#tab-map")
    made.page.select_option("#map-form [name=measure]", label="rms impact speed, pinion-ring:drive")
    small_map(made)
    title = made.page.evaluate("document.getElementById('map').data[0].colorbar.title.text")
    assert title == "rms impact speed of pinion-ring:drive [mm/s]"
    with made.page.expect_download() as waited:
        made.page.select_option("#save", "csv")
    lines = Path(waited.value.path()).read_text(encoding="utf-8").splitlines()
    start = f"{CLEARANCE} [m],{SPEED} [rad/s],rms impact speed of pinion-ring:drive [m/s]"
    assert lines[0].startswith(start + ",spread [m/s],impacts [1],")
    assert len(lines) == 1 + 6


@pytest.mark.deep
def test_map__is_marked_when_its_case_has_changed(visit: Open) -> None:
    made = visit().ready()
    open_run(made)
    fill(made, "run.duration", "10")
    made.page.click("#tab-map")
    made.page.fill("#map-form [name=columns]", "20")
    made.page.fill("#map-form [name=rows]", "12")
    made.page.click("#map-form button")
    made.until("Boolean(window.gearplay.state.job)")
    made.after(lambda: made.page.select_option("#case", "pinion-idler-ring"))
    made.until(
        "document.getElementById('message').textContent.includes('of another case: see Results')", 60.0
    )
    assert made.page.evaluate("!document.getElementById('map').data")


@pytest.mark.deep
def test_diagram__marks_a_changed_case(visit: Open) -> None:
    made = visit().ready()
    brief(made)
    small_map(made)
    assert "coupled model, 2 members of 0.05 s after 0 s" in made.page.text_content("#map-words")
    assert made.page.locator("#map-stale").is_hidden()
    fill(made, BACKLASH, "140")
    assert made.page.locator("#map-stale").is_visible()
    fill(made, BACKLASH, "100")
    assert made.page.locator("#map-stale").is_hidden()


@pytest.mark.deep
def test_a_click_on_a_map_runs_its_point(visit: Open) -> None:
    made = visit().ready()
    brief(made)
    small_map(made)
    box = made.page.locator("#map .nsewdrag").bounding_box()
    made.after(lambda: made.page.mouse.click(box["x"] + 0.9 * box["width"], box["y"] + 0.1 * box["height"]))
    assert made.page.locator("#panel-run").is_visible()
    assert field(made, SPEED).input_value() == "400"
    assert field(made, CLEARANCE).input_value() == "400"
    assert "pinion drive: speed 400 rpm" in made.page.text_content("#changes")


@pytest.mark.deep
def test_diagrams_drawn_unseen_have_their_size(visit: Open) -> None:
    made = visit().ready()
    brief(made)
    made.page.click("#tab-map")
    cells(made, 3, 2)
    made.page.click("#map-form button")
    made.page.click("#tab-run")
    made.until("document.getElementById('map').data", 60.0)
    made.page.click("#tab-map")
    made.page.wait_for_timeout(300)
    widths = (
        "['#map', '#map .main-svg'].map((each) => document.querySelector(each).getBoundingClientRect().width)"
    )
    card, plot = made.page.evaluate(widths)
    assert plot == pytest.approx(card, abs=2.0)


@pytest.mark.deep
def test_bad_bounds__are_reported_in_display_units(visit: Open) -> None:
    made = visit().ready()
    made.page.click("#tab-bifurcation")
    made.page.fill("#bifurcation-form [name=axis-low]", "400")
    made.page.fill("#bifurcation-form [name=axis-high]", "36")
    made.page.click("#bifurcation-form button")
    assert made.page.text_content("#message") == (
        "pinion drive: speed: from, 400 rpm, must be below to, 36 rpm. Correct one."
    )


@pytest.mark.deep
def test_invalid_map__is_reported(visit: Open) -> None:
    made = visit().ready()
    made.page.click("#tab-map")
    made.page.fill("#map-form [name=columns]", "1")
    made.page.click("#map-form button")
    made.until(
        "document.getElementById('message').textContent.includes('columns = 1: must be a whole number')"
    )


@pytest.mark.deep
def test_a_long_job_is_cancelled(visit: Open) -> None:
    made = visit().ready()
    made.page.click("#tab-bifurcation")
    made.page.fill("#bifurcation-form [name=count]", "900")
    made.page.click("#bifurcation-form button")
    made.page.click("#cancel")
    made.until("document.getElementById('message').textContent.includes('Cancelled')")
    assert made.page.locator("#progress").is_hidden()


@pytest.mark.deep
def test_cells_with_few_impacts_are_hatched(visit: Open) -> None:
    made = visit().ready()
    small_map(made)
    assert made.page.evaluate("document.getElementById('map').data[1].name") == "hatched: uncertain"
    assert "hatched: fewer than 30 impacts" in str(made.page.text_content("#map-words"))
    assert shown(made, "diagrams.map.impacts.every((each) => each < 30)")
