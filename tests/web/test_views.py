"""What the page shows of a run, in the system's Chromium: mechanism, plots, cursors, marks."""

import json
import math
from pathlib import Path

import pytest

from serving import Visit
from visiting import BACKLASH, CLEARANCE, SPEED, WITHOUT_AVERAGES, Open, fill


@pytest.mark.slow
def test_opens_with_the_article_s_case(visit: Open) -> None:
    page = visit().ready().page
    assert page.text_content("#title") == "Han 2021, 120 rpm, 100/100 um"
    assert page.text_content("#link-state") == "connected"
    assert page.locator("#stage figure").count() == 1
    assert page.text_content("#output-title") == "Output shaft ring, driven by pinion, ratio 3 : 1"
    assert page.locator("#output div").count() == 10
    for name in ("orbit", "spectrum", "backlash", "forces"):
        assert page.locator(f"#{name} .main-svg").count() > 0


NAMES = ("orbit", "spectrum", "backlash", "forces")


AXES = """([of, inside]) => Object.fromEntries(["orbit", "spectrum", "backlash", "forces"].map((name) => {
  const place = document.getElementById(name);
  const { left, top } = place.getBoundingClientRect();
  const texts = [...place.querySelectorAll(`${inside} text`)].map((each) => {
    const box = each.getBoundingClientRect();
    return [each.textContent.replaceAll("\u200b", ""), box.left - left, box.top - top];
  }).concat(window.written?.[name] ?? []).sort();
  const ranges = ["xaxis", "yaxis", "yaxis2"].map((axis) => place[of][axis]?.range ?? null);
  return [name, { texts, ranges }];
}))"""

RECORD = """() => { // texts of sketches with their left and upper ends, by plot; an exponent belongs to the text before it
  window.written = {};
  const write = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
    write.call(this, text, x, y);
    if (this.canvas.className !== "sketch") return;
    const found = window.written[this.canvas.parentElement.id] ??= [];
    const { width, fontBoundingBoxAscent: up } = this.measureText(text);
    if (Math.abs(x - found.at(-1)?.end) < 0.01) { found.at(-1)[0] += text; return; }
    const { b, e, f } = this.getTransform(); // b: turned by a quarter
    const left = x - (this.textAlign === "center" ? width / 2 : 0);
    found.push(Object.assign(b ? [text, e - up, f - left - width] : [text, left, y - up], { end: left + width }));
  };
  document.getElementById("theme").click();
  window.written = {};
  document.getElementById("theme").click();
}"""
STROKES = """() => {
  const canvas = document.querySelector("#spectrum .sketch");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const count = (...color) => {
    let n = 0;
    for (let i = 0; i < data.length; i += 4) n += data[i + 3] > 200 && color.every((each, k) => Math.abs(data[i + k] - each) < 5);
    return n;
  };
  return { coupled: count(0x0b, 0x5f, 0xa5), uncoupled: count(0xb4, 0x54, 0x0f) };
}"""


def first_view(visit: Open, case: str) -> Visit:
    """Open a case while plotly.js is held back."""
    made = visit(plots=False).ready()
    if case != "han2021":
        made.page.select_option("#case", case)
        made.until(f"window.gearplay.state.name === '{case}' && window.gearplay.latencies.length > 1", 60.0)
    made.until("document.querySelectorAll('.sketch').length === 4 && !window.gearplay.state.running")
    return made


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        "han2021",
        pytest.param("planetary-reducer", marks=pytest.mark.deep),
        pytest.param("two-stage-reducer", marks=pytest.mark.deep),
    ],
)
def test_first_plots__need_no_plotly_and_do_not_change_with_it(visit: Open, case: str) -> None:
    made = first_view(visit, case)
    made.page.evaluate(WITHOUT_AVERAGES)
    assert made.page.evaluate("window.Plotly === undefined")
    made.page.evaluate(RECORD)
    made.until("Object.keys(window.written).length === 4")
    sketched = made.page.evaluate(AXES, ["sketched", ".sketch"])
    made.page.evaluate("delete window.written")
    colors = made.page.evaluate(STROKES)
    assert colors["coupled"] > 300
    assert colors["uncoupled"] == 0
    assert "frequency [Hz]" in [each[0] for each in sketched["spectrum"]["texts"]]
    made.page.hover("#orbit")  # who points at a plot wants to zoom
    made.release()
    made.ready()
    assert made.page.locator(".sketch").count() == 0
    drawn = made.page.evaluate(AXES, ["_fullLayout", ".main-svg"])
    for name in NAMES:
        for one, other in zip(sketched[name]["ranges"], drawn[name]["ranges"], strict=True):
            assert one == (other and pytest.approx(other, rel=2e-3, abs=1e-9))
        assert [each[0] for each in sketched[name]["texts"]] == [each[0] for each in drawn[name]["texts"]]
        for one, other in zip(sketched[name]["texts"], drawn[name]["texts"], strict=True):
            assert one[1:] == pytest.approx(other[1:], abs=3.0), one[0]


DRAG = """(path) => {
  const slider = document.querySelector(`[data-slider="${path}"]`);
  return new Promise((done) => {
    let place = 300;
    const timer = setInterval(() => {
      slider.value = place;
      slider.dispatchEvent(new Event("input"));
      if ((place += 20) > 600) { clearInterval(timer); done(); }
    }, 15);
  });
}"""
CIRCLE = "1e-6 * Math.max(...document.getElementById('orbit').data[0].x)"


@pytest.mark.slow
def test_plots__are_sketched_while_a_slider_moves_and_show_its_last_value(visit: Open) -> None:
    made = visit().ready()
    made.page.evaluate(WITHOUT_AVERAGES)
    made.page.evaluate(DRAG, CLEARANCE)
    made.until("document.querySelector('#orbit.covered > .sketch') !== null")
    assert (
        made.page.evaluate("getComputedStyle(document.querySelector('#orbit > .plot-container')).visibility")
        == "hidden"
    )
    made.until("!window.gearplay.state.running && window.gearplay.state.whole")
    wanted = made.page.evaluate(f"window.gearplay.state.changes.get('{CLEARANCE}')")
    assert wanted != made.page.evaluate("window.gearplay.state.base.sleeves.ring.radial_clearance")
    shown = made.page.evaluate("window.gearplay.state.result.models.coupled.orbits[0].clearance")
    assert (shown, made.page.evaluate(CIRCLE)) == (pytest.approx(wanted), pytest.approx(wanted))
    assert made.page.locator(".sketch, .covered").count() == 0


@pytest.mark.slow
def test_plots__keep_their_zoom_while_a_slider_moves(visit: Open) -> None:
    made = visit().ready()
    made.page.evaluate(WITHOUT_AVERAGES)
    made.page.locator("#orbit").scroll_into_view_if_needed()
    box = made.page.locator("#orbit .nsewdrag").bounding_box()
    assert box is not None
    made.page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.3 * box["height"])
    made.page.mouse.down()
    made.page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.6 * box["height"], steps=5)
    made.page.mouse.up()
    made.until("document.getElementById('orbit').edited !== undefined")
    ranges = (
        "['xaxis', 'yaxis'].map((each) => document.getElementById('orbit')._fullLayout[each].range.slice())"
    )
    zoomed = made.page.evaluate(ranges)
    made.page.evaluate(
        """() => {
          const plot = document.getElementById("orbit");
          const note = () => { if (plot.querySelector(".sketch")) plot.dataset.sketched = "1"; };
          new MutationObserver(note).observe(plot, { childList: true });
        }"""
    )
    fill(made, CLEARANCE, "50")
    assert made.page.evaluate(ranges) == zoomed
    assert made.page.get_attribute("#orbit", "data-sketched") != "1", "a sketch has no zoom"
    assert made.page.evaluate(CIRCLE) == pytest.approx(50e-6)


@pytest.mark.deep
def test_the_quieter_curve_lies_on_top(visit: Open) -> None:
    made = visit().ready()
    made.after(lambda: made.page.check("#compare"))
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
    made.until("document.getElementById('orbit').layout.uirevision === 'stage.planet1'")
    made.page.select_option("#carrier", "turning")
    made.after(lambda: made.page.select_option("#case", "two-stage-reducer"))
    assert made.page.locator("#carrier-row").is_hidden()
    made.page.select_option("#mesh-of", label=made.page.locator("#mesh-of option").nth(1).text_content())
    made.until("document.getElementById('forces').data.some((each) => each.y.some((force) => force > 0))")
    drawn = "[...document.querySelector('#stage canvas').getContext('2d').getImageData(0, 0, 300, 300).data]"
    assert len(set(made.page.evaluate(drawn))) > 20


@pytest.mark.deep
def test_the_orbit_has_its_clearance_circle(visit: Open) -> None:
    made = visit().ready()
    fill(made, CLEARANCE, "50")
    top = made.page.evaluate("Math.max(...document.getElementById('orbit').data[0].x)")
    assert top == pytest.approx(50.0, rel=1e-6)


@pytest.mark.deep
def test_models_side_by_side_or_alone(visit: Open) -> None:
    made = visit().ready()
    assert made.page.evaluate("Object.keys(window.gearplay.state.result.models)") == ["coupled"]
    made.after(lambda: made.page.check("#compare"))
    assert made.page.locator("#stage figure").count() == 2
    assert made.page.locator("#output dd.uncoupled-text").count() == 10
    made.after(lambda: made.page.uncheck("#compare"))
    assert made.page.locator("#stage figure").count() == 1


@pytest.mark.slow
def test_play_pause_and_scrub(visit: Open) -> None:
    made = visit("/", reduced_motion="no-preference").ready()
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
    made = visit("/", reduced_motion="no-preference").ready()
    made.page.select_option("#slow", "1")
    first = made.page.evaluate("document.querySelector('#stage canvas').toDataURL()")
    made.until(f"document.querySelector('#stage canvas').toDataURL() !== {json.dumps(first)}")


@pytest.mark.deep
def test_close_up__moves_with_the_mechanism(visit: Open) -> None:
    """The line in the histories and the dot in the orbit stand where the clock says."""
    made = visit().ready()
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
    assert texts == ["sleeve", "drive", "back"]


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
    assert sorted(texts) == ["2 f_m", "f_m", "test mesh_1x", "test mesh_2x", "test radial"]
    fill(made, BACKLASH, "123")
    texts = made.page.evaluate("document.getElementById('spectrum').layout.annotations.map((a) => a.text)")
    assert sorted(texts) == ["2 f_m", "f_m"]


@pytest.mark.deep
def test_contacts_are_counted(visit: Open) -> None:
    made = visit().ready()
    head = made.page.locator("#statistics th").all_text_contents()
    assert head[2:4] == ["share of time", "impacts"]
    assert head[4:] == ["impacts [1/s]", "rms impact speed [mm/s]", "largest force [N]"]
    assert made.page.locator("#statistics tr").count() == 4


@pytest.mark.deep
def test_light_and_dark(visit: Open) -> None:
    made = visit("/", color_scheme="dark").ready()
    assert made.page.evaluate("document.documentElement.dataset.theme") == "dark"
    made.page.click("#theme")
    assert made.page.evaluate("document.documentElement.dataset.theme") == "light"
    made.until("document.getElementById('orbit').layout.font.color === '#1d2126'")


@pytest.mark.deep
def test_the_mechanism_is_there_after_a_change_on_another_tab(visit: Open) -> None:
    made = visit().ready()
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
