"""The fields of a case on the page: changed, bounded, found, refused."""

import pytest

from visiting import BACKLASH, CLEARANCE, SPEED, Open, field, fill, open_run, shown, slider


@pytest.mark.slow
def test_a_slider_moves_by_keys(visit: Open) -> None:
    made = visit(plots=False).ready()
    slider(made, CLEARANCE).focus()
    made.after(lambda: made.page.keyboard.press("ArrowRight"))
    assert shown(made, "result.case.sleeves.ring.radial_clearance") == pytest.approx(100.4e-6, rel=1e-3)
    assert field(made, CLEARANCE).input_value() == "100.4"


@pytest.mark.slow
def test_reset_brings_the_case_back(visit: Open) -> None:
    made = visit(plots=False).ready()
    before = shown(made, "result.sha256")
    fill(made, BACKLASH, "150")
    assert shown(made, "result.sha256") != before
    assert shown(made, "result.case.meshes[0].backlash") == pytest.approx(150e-6)
    made.after(lambda: made.page.click("#reset"))
    assert shown(made, "result.sha256") == before
    assert field(made, BACKLASH).input_value() == "100"


@pytest.mark.deep
def test_one_field_is_reset(visit: Open) -> None:
    made = visit(plots=False).ready()
    fill(made, BACKLASH, "150")
    fill(made, CLEARANCE, "70")
    button = made.page.get_by_role("button", name="Reset pinion-ring backlash")
    made.after(button.click)
    assert field(made, BACKLASH).input_value() == "100"
    assert field(made, CLEARANCE).input_value() == "70"
    assert button.is_hidden()
    assert shown(made, "result.case.meshes[0].backlash") == pytest.approx(100e-6)


@pytest.mark.deep
def test_field_bounds__are_next_to_the_field(visit: Open) -> None:
    made = visit(plots=False).ready()
    label = made.page.locator(".control", has=field(made, "sleeves.ring.restitution")).locator("label")
    assert "to 1" in label.get_attribute("title")
    assert "sleeves.ring.restitution" in label.get_attribute("title")


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (BACKLASH, "-5", "must be at least 0 um"),
        ("sleeves.ring.restitution", "1.5", "must be at most 1"),
        (SPEED, "", "must be a number"),
    ],
)
def test_a_value_out_of_bounds_is_refused_in_words(visit: Open, path: str, value: str, said: str) -> None:
    made = visit(plots=False).ready()
    runs = made.runs()
    field(made, path).fill(value)
    field(made, path).press("Tab")
    assert said in made.page.text_content("#message")
    assert path in made.page.text_content("#message")
    assert field(made, path).get_attribute("aria-invalid") == "true"
    assert made.runs() == runs


CUT = """() => {
  for (const each of document.querySelectorAll("#controls details")) each.open = true;
  const fields = [...document.querySelectorAll("#controls input[type=number]")];
  return fields.filter((each) => each.scrollWidth > each.clientWidth).map((each) => `${each.dataset.path} ${each.value}`);
}"""


@pytest.mark.slow
@pytest.mark.parametrize("case", ["two-stage-reducer", "planetary-reducer"])
def test_fields__show_their_whole_number_and_some_are_open(visit: Open, case: str) -> None:
    made = visit().ready()
    made.after(lambda: made.page.select_option("#case", case))
    assert made.page.locator("#controls > details[open] .control").count() > 0
    assert made.page.evaluate(CUT) == []


@pytest.mark.deep
def test_find_narrows_the_fields(visit: Open) -> None:
    made = visit(plots=False).ready()
    made.page.fill("#find", "backlash")
    assert field(made, BACKLASH).is_visible()
    assert not field(made, SPEED).is_visible()
    made.page.fill("#find", "")
    assert field(made, SPEED).is_visible()


@pytest.mark.deep
def test_a_law_is_chosen_from_a_list(visit: Open) -> None:
    made = visit(plots=False).ready()
    choice = made.page.locator(".control select", has_text="hunt-crossley").first
    made.after(lambda: choice.select_option("hunt-crossley"))
    assert shown(made, "result.case.sleeves.ring.law") == "hunt-crossley"


@pytest.mark.slow
def test_refused_case__greys_the_earlier_results(visit: Open) -> None:
    made = visit(plots=False).ready()
    assert made.page.locator("#stale").is_hidden()
    field(made, "meshes.0.stiffness.amplitude").fill("500")
    field(made, "meshes.0.stiffness.amplitude").press("Tab")
    made.until("document.getElementById('message').textContent.includes('must be less than the mean')")
    assert made.page.locator("#stale").is_visible()
    assert made.page.locator("#panel-run.outdated").count() == 1
    fill(made, "meshes.0.stiffness.amplitude", "5")
    assert made.page.locator("#stale").is_hidden()
    assert made.page.locator("#panel-run.outdated").count() == 0


@pytest.mark.deep
def test_case_warnings__are_displayed(visit: Open) -> None:
    made = visit(plots=False).ready()
    assert made.page.locator("#notes").is_hidden()
    open_run(made)
    fill(made, "run.transient", "0")
    assert "recording starts at t = 0" in made.page.text_content("#notes")
