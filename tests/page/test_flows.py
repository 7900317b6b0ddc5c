"""What a user does on the page, in the system's Chromium."""

import json
import math
import resource
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from serving import Server, Visit

Open = Callable[..., Visit]
SPEED, CLEARANCE = "rotors.pinion.drive.speed", "sleeves.ring.radial_clearance"
BACKLASH = "meshes.0.backlash"


def field(visit: Visit, path: str) -> Any:
    return visit.page.locator(f'input[data-path="{path}"]')


def slider(visit: Visit, path: str) -> Any:
    return visit.page.locator(f'input[data-slider="{path}"]')


def fill(visit: Visit, path: str, value: str) -> None:
    def act() -> None:
        field(visit, path).fill(value)
        field(visit, path).press("Tab")

    visit.after(act)


def open_run(visit: Visit) -> None:
    """Open the fields of the run."""
    visit.page.locator("details[data-group=Run]").evaluate("(each) => { each.open = true; }")


def shown(visit: Visit, expression: str) -> Any:
    return visit.page.evaluate(f"window.gearplay.state.{expression}")


def test_opens_with_the_article_s_case(visit: Open) -> None:
    page = visit().ready().page
    assert page.text_content("#title") == "Han 2021, 120 rpm, 100/100 um"
    assert page.text_content("#link-state") == "connected"
    assert page.locator("#stage figure").count() == 2
    for name in ("orbit", "spectrum", "backlash", "forces"):
        assert page.locator(f"#{name} .main-svg").count() > 0


NAMES = ("orbit", "spectrum", "backlash", "forces")
AXES = """([of, inside]) => Object.fromEntries(["orbit", "spectrum", "backlash", "forces"].map((name) => {
  const place = document.getElementById(name);
  const { left, top } = place.getBoundingClientRect();
  const texts = [...place.querySelectorAll(`${inside} text`)].map((each) => {
    const box = each.getBoundingClientRect();
    return [each.textContent.replaceAll("\u200b", ""), box.left - left, box.top - top];
  }).sort();
  const ranges = ["xaxis", "yaxis", "yaxis2"].map((axis) => place[of][axis]?.range ?? null);
  return [name, { texts, ranges }];
}))"""


def first_view(visit: Open, case: str) -> tuple[Visit, Any]:
    """Open a case while plotly.js is held back; return the page and what the answer to its request waits for."""
    made, held = visit(), []
    made.page.route("**/plotly.js", lambda route: held.append(route))
    made.until("Boolean(window.gearplay && window.gearplay.first)", 60.0)
    if case != "han2021":
        made.page.select_option("#case", case)
        made.until(f"window.gearplay.state.name === '{case}' && window.gearplay.latencies.length > 1", 60.0)
    made.until("document.querySelectorAll('.sketch').length === 4 && !window.gearplay.state.running")

    def release() -> None:
        made.page.hover("#orbit")  # who points at a plot wants to zoom
        while not held:
            made.page.wait_for_timeout(20)
        held[0].continue_()

    return made, release


@pytest.mark.parametrize(
    "case",
    [
        "han2021",
        pytest.param("planetary-reducer", marks=pytest.mark.deep),
        pytest.param("two-stage-reducer", marks=pytest.mark.deep),
    ],
)
def test_first_plots_need_no_plotly_and_stay_as_they_are_when_it_comes(visit: Open, case: str) -> None:
    made, release = first_view(visit, case)
    made.page.click("#play")
    assert made.page.evaluate("window.Plotly === undefined")
    sketched = made.page.evaluate(AXES, ["sketched", ".sketch"])
    colors = "[...document.querySelectorAll('#spectrum .sketch g path')].map((each) => each.getAttribute('stroke'))"
    assert set(made.page.evaluate(colors)) == {"#0b5fa5", "#b4540f"}
    assert "frequency [Hz]" in [each[0] for each in sketched["spectrum"]["texts"]]
    release()
    made.ready()
    assert made.page.locator(".sketch").count() == 0
    drawn = made.page.evaluate(AXES, ["_fullLayout", ".main-svg"])
    for name in NAMES:
        for one, other in zip(sketched[name]["ranges"], drawn[name]["ranges"], strict=True):
            assert one == (other and pytest.approx(other, rel=2e-3, abs=1e-9))
        assert [each[0] for each in sketched[name]["texts"]] == [each[0] for each in drawn[name]["texts"]]
        for one, other in zip(sketched[name]["texts"], drawn[name]["texts"], strict=True):
            assert one[1:] == pytest.approx(other[1:], abs=3.0), one[0]


@pytest.mark.deep
def test_the_quieter_curve_lies_on_top(visit: Open) -> None:
    made = visit().ready()
    curves = made.page.evaluate(
        "document.getElementById('spectrum').data.map(({ name, y }) => [name, y.reduce((sum, a) => sum + a, 0)])"
    )
    assert curves[0][1] > curves[1][1]
    legend = made.page.locator("#spectrum .legendtext").all_text_contents()
    assert legend == ["coupled", "uncoupled"]


@pytest.mark.deep
def test_gears_of_a_planetary_set_and_of_two_stages_have_their_views(visit: Open) -> None:
    made = visit().ready()
    made.after(lambda: made.page.select_option("#case", "planetary-reducer"))
    assert made.page.locator("#carrier-row").is_visible()
    choices = made.page.locator("#mesh-of option").all_text_contents()
    assert len(choices) == 6
    made.page.select_option("#sleeve-of", "stage.planet1")
    made.until("document.getElementById('orbit').layout.annotations?.[0].text.includes('no orbit to draw')")
    made.page.select_option("#carrier", "turning")
    made.after(lambda: made.page.select_option("#case", "two-stage-reducer"))
    assert made.page.locator("#carrier-row").is_hidden()
    made.page.select_option("#mesh-of", label=made.page.locator("#mesh-of option").nth(1).text_content())
    made.until("document.getElementById('forces').data.some((each) => each.y.some((force) => force > 0))")
    drawn = "[...document.querySelector('#stage canvas').getContext('2d').getImageData(0, 0, 300, 300).data]"
    assert len(set(made.page.evaluate(drawn))) > 20


def test_a_field_changes_the_run(visit: Open) -> None:
    made = visit().ready()
    before = shown(made, "result.sha256")
    fill(made, BACKLASH, "150")
    assert shown(made, "result.sha256") != before
    assert shown(made, "result.case.meshes[0].backlash") == pytest.approx(150e-6)


def test_a_slider_moves_by_keys(visit: Open) -> None:
    made = visit().ready()
    slider(made, CLEARANCE).focus()
    made.after(lambda: made.page.keyboard.press("ArrowRight"))
    assert shown(made, "result.case.sleeves.ring.radial_clearance") == pytest.approx(100.4e-6, rel=1e-3)
    assert field(made, CLEARANCE).input_value() == "100.4"


@pytest.mark.deep
def test_the_orbit_has_its_clearance_circle(visit: Open) -> None:
    made = visit().ready()
    fill(made, CLEARANCE, "50")
    top = made.page.evaluate("Math.max(...document.getElementById('orbit').data[0].x)")
    assert top == pytest.approx(50.0, rel=1e-6)


@pytest.mark.deep
def test_models_side_by_side_or_alone(visit: Open) -> None:
    made = visit().ready()
    made.after(lambda: made.page.uncheck("#compare"))
    assert made.page.locator("#stage figure").count() == 1
    assert made.page.evaluate("Object.keys(window.gearplay.state.result.models)") == ["coupled"]
    made.after(lambda: made.page.check("#compare"))
    assert made.page.locator("#stage figure").count() == 2


@pytest.mark.deep
def test_another_bundled_case(visit: Open) -> None:
    made = visit().ready()
    made.after(lambda: made.page.select_option("#case", "pinion-idler-ring"))
    assert made.page.text_content("#title") == "Pinion, idler and ring, 20/20/60"
    assert "idler" in made.page.text_content("#statistics")
    assert made.page.locator('input[data-path="sleeves.idler.radial_clearance"]').count() == 1


def test_reset_brings_the_case_back(visit: Open) -> None:
    made = visit().ready()
    before = shown(made, "result.sha256")
    fill(made, BACKLASH, "150")
    made.after(lambda: made.page.click("#reset"))
    assert shown(made, "result.sha256") == before
    assert field(made, BACKLASH).input_value() == "100"


@pytest.mark.deep
def test_one_field_is_reset(visit: Open) -> None:
    made = visit().ready()
    fill(made, BACKLASH, "150")
    fill(made, CLEARANCE, "70")
    button = made.page.get_by_role("button", name="Reset pinion-ring backlash")
    made.after(button.click)
    assert field(made, BACKLASH).input_value() == "100"
    assert field(made, CLEARANCE).input_value() == "70"
    assert button.is_hidden()
    assert shown(made, "result.case.meshes[0].backlash") == pytest.approx(100e-6)


@pytest.mark.deep
def test_bounds_are_told_beside_the_field(visit: Open) -> None:
    made = visit().ready()
    label = made.page.locator(".control", has=field(made, "sleeves.ring.restitution")).locator("label")
    assert "to 1" in label.get_attribute("title")
    assert "sleeves.ring.restitution" in label.get_attribute("title")


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
    made = visit().ready()
    runs = made.runs()
    field(made, path).fill(value)
    field(made, path).press("Tab")
    assert said in made.page.text_content("#message")
    assert path in made.page.text_content("#message")
    assert field(made, path).get_attribute("aria-invalid") == "true"
    assert made.runs() == runs


@pytest.mark.deep
def test_what_only_the_server_can_refuse_is_told(visit: Open) -> None:
    made = visit().ready()
    field(made, "meshes.0.stiffness.amplitude").fill("500")
    field(made, "meshes.0.stiffness.amplitude").press("Tab")
    made.until("document.getElementById('message').textContent.includes('must be less than the mean')")


@pytest.mark.deep
def test_find_narrows_the_fields(visit: Open) -> None:
    made = visit().ready()
    made.page.fill("#find", "backlash")
    assert field(made, BACKLASH).is_visible()
    assert not field(made, SPEED).is_visible()
    made.page.fill("#find", "")
    assert field(made, SPEED).is_visible()


@pytest.mark.deep
def test_a_law_is_chosen_from_a_list(visit: Open) -> None:
    made = visit().ready()
    choice = made.page.locator(".control select", has_text="hunt-crossley").first
    made.after(lambda: choice.select_option("hunt-crossley"))
    assert shown(made, "result.case.sleeves.ring.law") == "hunt-crossley"


def test_play_pause_and_scrub(visit: Open) -> None:
    made = visit().ready()
    made.page.click("#play")
    assert made.page.text_content("#play") == "Play"
    first = made.page.text_content("#clock")
    made.page.locator("#scrub").focus()
    made.page.keyboard.press("End")
    assert made.page.text_content("#clock") != first
    assert made.page.text_content("#clock") == "0.9999 s"


@pytest.mark.deep
def test_clearances_are_magnified_by_a_factor_that_is_shown(visit: Open) -> None:
    made = visit().ready()
    first = made.page.text_content("#factor")
    made.page.locator("#magnify").focus()
    made.page.keyboard.press("ArrowRight")
    assert made.page.text_content("#factor") != first
    assert first == "10.0 times as large"


@pytest.mark.deep
def test_the_picture_moves(visit: Open) -> None:
    made = visit().ready()
    made.page.select_option("#slow", "1")
    first = made.page.evaluate("document.querySelector('#stage canvas').toDataURL()")
    made.until(f"document.querySelector('#stage canvas').toDataURL() !== {json.dumps(first)}")


@pytest.mark.deep
def test_what_is_shown_moves_with_the_mechanism(visit: Open) -> None:
    """The line in the histories and the dot in the orbit stand where the clock says."""
    made = visit().ready()
    made.page.click("#play")
    made.page.evaluate("document.getElementById('backlash').scrollIntoView()")
    made.page.locator("#scrub").evaluate(
        "(each) => { each.value = 0.5; each.dispatchEvent(new Event('input')); }"
    )
    found = made.page.evaluate(
        """() => {
          const [plot, mark] = [document.getElementById("backlash"), document.querySelector("#backlash .time-line")];
          const { xaxis } = plot._fullLayout;
          const x = mark.getBoundingClientRect().left - plot.getBoundingClientRect().left - xaxis._offset;
          return [xaxis.p2l(x), Number(document.getElementById("clock").textContent.split(" ")[0])];
        }"""
    )
    assert found[0] == pytest.approx(found[1], abs=0.003)
    dot = made.page.evaluate(
        """() => {
          const plot = document.getElementById("orbit");
          const mark = document.querySelector("#orbit .shaft-dot.coupled").getBoundingClientRect();
          const { xaxis, yaxis } = plot._fullLayout;
          const { frames } = window.gearplay.state.result.models.coupled;
          const { left, top } = plot.getBoundingClientRect();
          const [n, i] = [frames.t.length, Math.floor(0.5 * frames.t.length)];
          return [xaxis.p2l(mark.left + mark.width / 2 - left - xaxis._offset), 1e6 * frames.rotors[3 * n + i],
            yaxis.p2l(mark.top + mark.height / 2 - top - yaxis._offset), 1e6 * frames.rotors[4 * n + i]];
        }"""
    )
    assert (dot[0], dot[2]) == (pytest.approx(dot[1], abs=1.0), pytest.approx(dot[3], abs=1.0))


@pytest.mark.deep
def test_which_sleeve_and_mesh_are_looked_at(visit: Open) -> None:
    made = visit().ready()
    assert made.page.locator("#look-sleeve").is_hidden()
    made.after(lambda: made.page.select_option("#case", "pinion-idler-ring"))
    made.page.select_option("#sleeve-of", "idler")
    made.page.select_option("#mesh-of", "idler-ring")
    top = "Math.max(...document.getElementById('orbit').data[0].x)"
    made.until(f"Math.abs({top} - 20) < 1e-6")
    made.until("document.getElementById('forces').layout.uirevision === 'idleridler-ring'")
    texts = made.page.evaluate("document.getElementById('forces').layout.yaxis2.ticktext")
    assert texts == 2 * ["sleeve", "drive", "back"]


@pytest.mark.deep
def test_the_spectrum_of_another_signal_and_scale(visit: Open) -> None:
    made = visit().ready()
    made.page.select_option("#spectrum-of", "ring.ay")
    made.page.select_option("#spectrum-scale", "linear")
    made.until("document.getElementById('spectrum').layout.yaxis.type === 'linear'")


@pytest.mark.deep
def test_lines_of_mesh_and_test_are_marked(visit: Open) -> None:
    made = visit().ready()
    texts = made.page.evaluate("document.getElementById('spectrum').layout.annotations.map((a) => a.text)")
    assert texts == ["f_m", "2 f_m", "test f_r", "test f_m", "test 2 f_m"]
    fill(made, BACKLASH, "123")
    texts = made.page.evaluate("document.getElementById('spectrum').layout.annotations.map((a) => a.text)")
    assert texts == ["f_m", "2 f_m"]


@pytest.mark.deep
def test_contacts_are_counted(visit: Open) -> None:
    made = visit().ready()
    head = made.page.locator("#statistics th").all_text_contents()
    assert head[2:4] == ["share of time", "impacts"]
    assert head[4:] == ["impacts [1/s]", "rms impact speed [mm/s]", "largest force [N]"]
    assert made.page.locator("#statistics tr").count() == 7


@pytest.mark.deep
def test_light_and_dark(visit: Open) -> None:
    made = visit("/", color_scheme="dark").ready()
    assert made.page.evaluate("document.documentElement.dataset.theme") == "dark"
    made.page.click("#theme")
    assert made.page.evaluate("document.documentElement.dataset.theme") == "light"
    made.until("document.getElementById('orbit').layout.font.color === '#1d2126'")


def test_a_file_is_opened(visit: Open, tmp_path: Path) -> None:
    from gearplay.model.reading import load_case, to_toml

    file = tmp_path / "mine.toml"
    file.write_text(to_toml(load_case("han2021", ["title=Mine", "meshes.0.backlash=70um"])), encoding="utf-8")
    made = visit().ready()
    made.after(lambda: made.page.set_input_files("#upload", file))
    assert made.page.text_content("#title") == "Mine"
    assert field(made, BACKLASH).input_value() == "70"


@pytest.mark.many
@pytest.mark.parametrize(
    ("text", "said"), [("not = [a case", "upload"), ("[rotors.a]\nmass = -1\n", "rotors.a"), ("", "rotors")]
)
def test_a_bad_file_is_refused_and_the_case_stays(visit: Open, tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(text, encoding="utf-8")
    made = visit().ready()
    made.page.set_input_files("#upload", file)
    made.until(f"document.getElementById('message').textContent.includes({json.dumps(said)})")
    assert made.page.text_content("#title") == "Han 2021, 120 rpm, 100/100 um"
    made.complaints[:] = [
        each for each in made.complaints if "400" not in each
    ]  # the browser notes the refusal


@pytest.mark.deep
def test_a_link_carries_the_case(visit: Open) -> None:
    made = visit().ready()
    fill(made, BACKLASH, "140")
    made.page.click("#share")
    made.until("location.hash.startsWith('#case=')")
    link = made.page.evaluate("location.hash")
    other = visit("/" + link).ready()
    assert field(other, BACKLASH).input_value() == "140"
    assert other.page.evaluate("window.gearplay.state.base.meshes[0].backlash") == pytest.approx(140e-6)


@pytest.mark.many
@pytest.mark.parametrize(
    ("form", "start"), [("nc", b"\x89HDF"), ("csv", b"member,time [s],"), ("toml", b"# The rig of Han")]
)
def test_results_and_cases_are_saved(visit: Open, form: str, start: bytes) -> None:
    made = visit().ready()
    with made.page.expect_download() as waited:
        made.page.select_option("#save", form)
    path = Path(waited.value.path())
    assert path.read_bytes().startswith(start)
    of = "" if form == "toml" else "-coupled"
    assert waited.value.suggested_filename == f"han-2021-120-rpm-100-100-um{of}.{form}"


@pytest.mark.deep
@pytest.mark.many
@pytest.mark.parametrize(("form", "start"), [("png", b"\x89PNG"), ("svg", b"<svg")])
def test_pictures_are_saved(visit: Open, form: str, start: bytes) -> None:
    made = visit().ready()
    with made.page.expect_download() as waited:
        made.page.select_option("#save", form)
    assert Path(waited.value.path()).read_bytes().startswith(start)


def brief(made: Visit) -> None:
    for path, value in (("run.duration", "0.05"), ("run.transient", "0")):
        open_run(made)
        fill(made, path, value)


def test_a_bifurcation_diagram(visit: Open) -> None:
    made = visit().ready()
    made.page.click("#tab-bifurcation")
    for name, value in (("count", "6"), ("settle", "5"), ("keep", "4")):
        made.page.fill(f"#bifurcation-form [name={name}]", value)
    made.page.click("#bifurcation-form button")
    made.until("document.getElementById('bifurcation').data?.length === 2")
    assert made.page.evaluate("document.getElementById('bifurcation').data[0].x.length") == 24


def test_a_map(visit: Open) -> None:
    made = visit().ready()
    brief(made)
    made.page.click("#tab-map")
    assert made.page.input_value("#map-form [name=members]") == "8"
    cells(made, 4, 3)
    made.page.click("#map-form button")
    made.until("document.getElementById('map').data?.[0].z.length === 3")
    assert made.page.evaluate("document.getElementById('map').data[0].z[0].length") == 4


def cells(made: Visit, columns: int, rows: int) -> None:
    """Make the map that is asked for a short one."""
    values = {"columns": columns, "rows": rows, "members": 2, "duration": 0.05, "transient": 0}
    for name, value in values.items():
        made.page.fill(f"#map-form [name={name}]", str(value))


def small_map(made: Visit) -> None:
    made.page.click("#tab-map")
    cells(made, 3, 2)
    made.page.click("#map-form button")
    made.until("document.getElementById('map').data?.[0].z.length === 2")


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
def test_nothing_to_save_is_said(visit: Open) -> None:
    made = visit().ready()
    made.page.click("#tab-map")
    made.page.select_option("#save", "csv")
    made.until("document.getElementById('message').textContent.includes('nothing to save here yet')")


@pytest.mark.deep
def test_a_result_of_another_case_brings_its_case_back(visit: Open) -> None:
    made = visit().ready()
    brief(made)
    small_map(made)
    made.page.click("#tab-run")
    made.after(lambda: made.page.select_option("#case", "pinion-idler-ring"))
    made.after(lambda: recall(made, "map, Han 2021"))
    assert made.page.text_content("#title") == "Han 2021, 120 rpm, 100/100 um"
    assert made.page.locator("#panel-map").is_visible()
    assert field(made, "run.duration").input_value() == "0.05"
    assert made.page.evaluate("document.getElementById('map').data[0].z.length") == 2


def lengthen(made: Visit, seconds: str) -> None:
    """Start a run that takes long, and do not wait for it."""
    open_run(made)
    field(made, "run.duration").fill(seconds)
    field(made, "run.duration").press("Tab")
    made.until("Boolean(window.gearplay.state.running)")


@pytest.mark.deep
def test_a_long_run_gives_way_to_a_newer_one(visit: Open) -> None:
    made = visit().ready()
    lengthen(made, "90")
    made.page.wait_for_timeout(200)
    fill(made, "run.duration", "0.2")
    assert shown(made, "result.case.run.duration") == 0.2


@pytest.mark.deep
def test_a_run_of_another_case_is_not_shown(visit: Open) -> None:
    made = visit().ready()
    lengthen(made, "30")
    made.after(lambda: made.page.select_option("#case", "pinion-idler-ring"))
    assert shown(made, "result.title") == "Pinion, idler and ring, 20/20/60"
    made.page.wait_for_timeout(1500)
    assert shown(made, "result.title") == "Pinion, idler and ring, 20/20/60"


@pytest.mark.deep
def test_a_map_that_outlives_its_case_is_told_of(visit: Open) -> None:
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
def test_a_diagram_says_when_the_case_has_changed(visit: Open) -> None:
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
def test_the_mechanism_is_there_after_a_change_on_another_tab(visit: Open) -> None:
    made = visit().ready()
    made.page.click("#play")
    made.page.click("#tab-map")
    fill(made, BACKLASH, "140")
    made.page.click("#tab-run")
    made.until("document.querySelector('#stage canvas').width > 100")
    made.until("window.gearplay.state.whole")
    assert made.page.evaluate("document.getElementById('orbit').layout.uirevision") == "ring"


@pytest.mark.deep
def test_nothing_moves_at_no_speed(visit: Open) -> None:
    made = visit().ready()
    fill(made, SPEED, "0")
    assert made.page.evaluate("document.getElementById('spectrum').layout.shapes.length") < 5


@pytest.mark.deep
def test_a_damaged_link_is_told(visit: Open) -> None:
    made = visit("/#case=eyJydW4iOnsiZH").ready()
    made.until("document.getElementById('message').textContent.includes('The link is damaged')")


@pytest.mark.deep
def test_what_is_no_case_file_is_refused(visit: Open, tmp_path: Path) -> None:
    file = tmp_path / "run.nc"
    file.write_bytes(b"\x89HDF")
    made = visit().ready()
    made.page.set_input_files("#upload", file)
    made.until("document.getElementById('message').textContent.includes('run.nc: must be a case file')")


@pytest.mark.deep
def test_bad_ends_are_told_in_the_units_shown(visit: Open) -> None:
    made = visit().ready()
    made.page.click("#tab-bifurcation")
    made.page.fill("#bifurcation-form [name=axis-low]", "400")
    made.page.fill("#bifurcation-form [name=axis-high]", "36")
    made.page.click("#bifurcation-form button")
    assert made.page.text_content("#message") == (
        "pinion drive: speed: from, 400 rpm, must be below to, 36 rpm. Correct one."
    )


@pytest.mark.deep
def test_an_ensemble_has_its_spread(visit: Open) -> None:
    made = visit().ready()
    open_run(made)
    fill(made, "run.ensemble", "4")
    assert shown(made, "result.members") == 4
    assert made.page.evaluate("document.getElementById('spectrum').data.length") == 6
    assert "averages over 4 members" in made.page.text_content("#few")


def test_averages_come_behind_one_run(visit: Open) -> None:
    """Of a rattling pair the contacts and the spectrum are means with their interval; a moved slider asks for new ones."""
    made = visit().ready()
    made.until("window.gearplay.state.result.average")
    words = made.page.text_content("#few")
    assert words.startswith(
        "Contacts are means over 16 members of 5 s after 1 s, from drawn starts; ± holds 95 %."
    )
    assert made.page.text_content("#statistics tr:nth-child(2) td:nth-child(5)").count(" ± ") == 1
    assert (
        made.page.evaluate("document.getElementById('spectrum').data.length") == 6
    )  # two models, each with its band
    fill(made, "meshes.0.backlash", "140")
    made.until("window.gearplay.state.result.average")
    assert shown(made, "result.case.meshes[0].backlash") == pytest.approx(140e-6)
    kinds = made.page.evaluate(
        "fetch('/api/results').then((answer) => answer.json()).then((all) => all.map((each) => each.kind))"
    )
    assert "run" in kinds
    assert "average" not in kinds  # which are not kept as results


@pytest.mark.deep
def test_a_map_that_cannot_be_is_told(visit: Open) -> None:
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


def recall(made: Visit, start: str) -> None:
    """Choose the newest of the results that are kept whose words start so."""
    words = "[...document.getElementById('history').options]"
    made.until(f"{words}.some((each) => each.text.startsWith({json.dumps(start)}))")
    key = made.page.evaluate(f"{words}.find((each) => each.text.startsWith({json.dumps(start)})).value")
    made.page.select_option("#history", value=key)


@pytest.mark.deep
def test_earlier_results_are_recalled(visit: Open) -> None:
    made = visit().ready()
    fill(made, BACKLASH, "111")
    wanted = shown(made, "result.sha256")
    fill(made, BACKLASH, "112")
    recall(made, "run, Han 2021, 120 rpm, 100/100 um, pinion-ring backlash 111 µm")
    made.until(f"window.gearplay.state.result.sha256 === {json.dumps(wanted)}")
    assert field(made, BACKLASH).input_value() == "111"
    assert made.page.text_content("#changes") == "changed: pinion-ring backlash 111 µm"


def test_the_main_flow_by_keyboard_alone(visit: Open) -> None:
    """From the address bar: to a field, a new value, the tabs, and back, without a pointer."""
    made = visit().ready()
    page = made.page

    def focused() -> str:
        return str(page.evaluate("document.activeElement.dataset.path ?? document.activeElement.id"))

    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    for _ in range(80):
        if focused() == CLEARANCE:
            break
        page.keyboard.press("Tab")
    assert focused() == CLEARANCE
    page.keyboard.press("Control+A")
    page.keyboard.type("80")
    made.after(lambda: page.keyboard.press("Enter"))
    assert shown(made, "result.case.sleeves.ring.radial_clearance") == pytest.approx(80e-6)
    page.focus("#tab-run")
    page.keyboard.press("ArrowRight")
    assert focused() == "tab-bifurcation"
    assert page.locator("#panel-bifurcation").is_visible()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert focused() == "tab-run"


def test_fits_a_phone(visit: Open) -> None:
    made = visit("/", viewport={"width": 390, "height": 844}).ready()
    assert made.page.evaluate("document.documentElement.scrollWidth") <= 391


@pytest.mark.deep
def test_reduced_motion_stands_still(visit: Open) -> None:
    made = visit("/", reduced_motion="reduce").ready()
    assert made.page.text_content("#play") == "Play"


@pytest.mark.deep
def test_the_last_of_many_moves_is_shown(visit: Open) -> None:
    made = visit().ready()
    slider(made, CLEARANCE).focus()
    for _ in range(30):
        made.page.keyboard.press("ArrowRight")
    made.until("!window.gearplay.state.running && !window.gearplay.state.again")
    value = float(field(made, CLEARANCE).input_value())
    assert shown(made, "result.case.sleeves.ring.radial_clearance") == pytest.approx(value * 1e-6)


@pytest.mark.many
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(visit: Open, scheme: str) -> None:
    from axe_playwright_python.sync_playwright import Axe

    made = visit("/", color_scheme=scheme).ready()
    for tab in ("run", "bifurcation", "map"):
        made.page.click(f"#tab-{tab}")
        found = Axe().run(made.page)
        serious = [
            (each["id"], [node["html"][:120] for node in each["nodes"][:3]])
            for each in found.response["violations"]
            if each["impact"] in ("serious", "critical")
        ]
        assert serious == []


@pytest.mark.deep
def test_cells_with_few_impacts_are_hatched(visit: Open) -> None:
    made = visit().ready()
    small_map(made)
    words = made.page.evaluate("document.getElementById('map').data[1].name")
    assert words.startswith("hatched: fewer than 30 impacts")
    assert shown(made, "diagrams.map.impacts.every((each) => each < 30)")


def test_a_refused_case_greys_what_is_shown_of_the_one_before(visit: Open) -> None:
    made = visit().ready()
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
def test_warnings_about_the_case_are_told(visit: Open) -> None:
    made = visit().ready()
    assert made.page.text_content("#notes summary") == "2 warnings about this case"
    open_run(made)
    fill(made, "run.transient", "0")
    assert "recording starts at t = 0" in made.page.text_content("#notes")


@pytest.mark.deep
def test_the_next_impact(visit: Open) -> None:
    made = visit().ready()
    times = []
    for _ in range(2):
        made.page.click("#impact")
        times.append(made.page.evaluate("Number(document.getElementById('clock').textContent.split(' ')[0])"))
    onsets = "Object.values(window.gearplay.state.result.models).flatMap((v) => v.strip.flatMap((s) => [...s.spans]))"
    known = made.page.evaluate(onsets)
    assert times[0] < times[1]
    assert all(min(abs(time - each) for each in known) < 1e-3 for time in times)
    assert made.page.text_content("#play") == "Play"


@pytest.mark.deep
def test_an_earlier_run_and_a_measurement_lie_beside(visit: Open, tmp_path: Path) -> None:
    made = visit().ready()
    made.until("document.getElementById('overlay').options.length > 1")
    first = made.page.evaluate("document.getElementById('overlay').options[1].value")
    fill(made, BACKLASH, "150")
    names = "document.getElementById('spectrum').data.map((each) => each.name)"
    made.page.select_option("#overlay", value=first)
    made.until(f"{names}.includes('earlier, coupled')")
    file = tmp_path / "mine.csv"
    rows = [f"{k / 1000:.3f},{math.sin(0.1 * math.pi * k):.6f}" for k in range(1024)]
    file.write_text("time [s],a [m/s^2]\n" + "\n".join(rows), encoding="utf-8")
    made.page.set_input_files("#measured", file)
    made.until(f"{names}.includes('mine.csv')")
    f, a = made.page.evaluate(
        """() => {
          const { f, a } = window.gearplay.state.overlay.measured;
          const k = a.indexOf(Math.max(...a));
          return [f[k], a[k]];
        }"""
    )
    assert (f, a) == (pytest.approx(50.0, abs=0.6), pytest.approx(1.0, rel=0.1))


def test_a_case_file_is_saved_as_it_was_written(visit: Open) -> None:
    made = visit().ready()
    fill(made, BACKLASH, "150")
    with made.page.expect_download() as waited:
        made.page.select_option("#save", "toml")
    text = Path(waited.value.path()).read_text(encoding="utf-8")
    assert text.startswith("# The rig of Han")
    assert 'backlash = "150 um"                     # article: 100 or 200 um' in text


def test_parameters_stay_below_what_is_looked_at_on_a_phone(visit: Open) -> None:
    made = visit("/", viewport={"width": 390, "height": 844}).ready()
    slider(made, CLEARANCE).focus()
    made.page.locator("#spectrum").evaluate("(each) => each.scrollIntoView({ block: 'start' })")
    boxes = [made.page.locator(each).bounding_box() for each in ("#spectrum", "aside")]
    assert 0 <= boxes[0]["y"] < boxes[1]["y"] - 200
    assert boxes[1]["y"] + boxes[1]["height"] == pytest.approx(844, abs=2)
    assert made.page.evaluate("document.documentElement.scrollWidth") <= 391


def test_a_result_that_cannot_be_kept_is_said_until_the_next_run(server: Server, visit: Open) -> None:
    """At the limit of a file's size writes fail as on a full disk."""
    made = visit().ready()
    unlimited = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE)
    resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (1000, unlimited[1]))
    try:
        fill(made, SPEED, "131.5")
        made.until("document.getElementById('message').textContent.includes('not kept among the results')")
        assert not made.page.locator("#message").is_hidden()
    finally:
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, unlimited)
    fill(made, SPEED, "132.5")
    assert made.page.text_content("#message") == ""
