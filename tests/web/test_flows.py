"""A visit to the page as a whole: keyboard, phone, newer moves before older ones, averages."""

import pytest

from serving import Visit
from visiting import CLEARANCE, WITHOUT_AVERAGES, Open, field, fill, open_run, shown, slider


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
def test_an_ensemble_has_its_spread(visit: Open) -> None:
    made = visit().ready()
    open_run(made)
    fill(made, "run.ensemble", "4")
    assert shown(made, "result.members") == 4
    assert made.page.evaluate("document.getElementById('spectrum').data.length") == 3
    assert "averages over 4 members" in made.page.text_content("#few")


@pytest.mark.slow
def test_averages_come_behind_one_run(visit: Open) -> None:
    """Of a rattling pair the contacts and the spectrum are means with their interval; a moved slider asks for new ones."""
    made = visit().ready()
    made.until("window.gearplay.state.result.average")
    words = made.page.text_content("#few")
    assert words.startswith(
        "Contacts are means over 16 members of 5 s after 1 s, from drawn starts; ± holds 95 %."
    )
    assert made.page.text_content("#statistics tr:nth-child(2) td:nth-child(5)").count(" ± ") == 1
    assert made.page.evaluate("document.getElementById('spectrum').data.length") == 3  # a curve with its band
    fill(made, "meshes.0.backlash", "140")
    made.until("window.gearplay.state.result.average")
    assert shown(made, "result.case.meshes[0].backlash") == pytest.approx(140e-6)
    kinds = made.page.evaluate(
        "fetch('/api/results').then((answer) => answer.json()).then((all) => all.map((each) => each.kind))"
    )
    assert "run" in kinds
    assert "average" not in kinds  # which are not kept as results


def test_the_main_flow_by_keyboard_alone(visit: Open) -> None:
    """From the address bar: to a field, a new value, the tabs, and back, without a pointer."""
    made = visit(plots=False).ready()
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
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    assert focused() == "tab-run"


@pytest.mark.deep
def test_reduced_motion_stands_still(visit: Open) -> None:
    made = visit("/", reduced_motion="reduce").ready()
    assert made.page.text_content("#play") == "Play"


@pytest.mark.slow
def test_motion__a_paused_page_requests_no_frames(visit: Open) -> None:
    made = visit().ready()
    made.page.evaluate(WITHOUT_AVERAGES)
    made.page.wait_for_timeout(300)
    made.page.evaluate(
        """() => {
          const request = window.requestAnimationFrame;
          window.frames_requested = 0;
          window.requestAnimationFrame = (act) => { window.frames_requested += 1; return request(act); };
        }"""
    )
    made.page.wait_for_timeout(300)
    assert made.page.evaluate("window.frames_requested") == 0
    made.page.click("#play")
    made.until(
        "window.frames_requested > 3 && window.gearplay.state.result && Number(document.getElementById('scrub').value) > 0"
    )
    made.page.click("#play")
    made.page.wait_for_timeout(300)
    stopped = made.page.evaluate("window.frames_requested")
    made.page.wait_for_timeout(300)
    assert made.page.evaluate("window.frames_requested") == stopped


@pytest.mark.deep
def test_the_last_of_many_moves_is_shown(visit: Open) -> None:
    made = visit().ready()
    slider(made, CLEARANCE).focus()
    for _ in range(30):
        made.page.keyboard.press("ArrowRight")
    made.until("!window.gearplay.state.running && !window.gearplay.state.again")
    value = float(field(made, CLEARANCE).input_value())
    assert shown(made, "result.case.sleeves.ring.radial_clearance") == pytest.approx(value * 1e-6)


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(visit: Open, scheme: str) -> None:
    from axe_playwright_python.sync_playwright import Axe

    made = visit("/", color_scheme=scheme).ready()
    for tab in ("run", "bifurcation", "map", "lost_motion"):
        made.page.click(f"#tab-{tab}")
        found = Axe().run(made.page, None if tab == "run" else f"#panel-{tab}")  # what is beside them stays
        serious = [
            (each["id"], [node["html"][:120] for node in each["nodes"][:3]])
            for each in found.response["violations"]
            if each["impact"] in ("serious", "critical")
        ]
        assert serious == []


LAPPED = """() => ["orbit", "spectrum", "backlash", "forces"].flatMap((name) => {
  const plot = document.getElementById(name);
  const { left, right } = plot.getBoundingClientRect();
  const placed = (each) => each.getBoundingClientRect();
  const boxes = (kinds) => [...plot.querySelectorAll(kinds)].map(placed).filter(({ width }) => width);
  const apart = (a, b) => a.left >= b.right || b.left >= a.right || a.top >= b.bottom || b.top >= a.bottom;
  const [titles, ticks] = [boxes(".ytitle, .y2title, .xtitle"), boxes(".ytick text, .y2tick text, .xtick text")];
  const found = titles.some((title) => !ticks.every((tick) => apart(title, tick))) ? [`${name}: a title over a tick`] : [];
  const cut = (box) => box.left < left - 1 || box.right > right + 1;
  if ([...titles, ...ticks, ...boxes(".legendtext")].some(cut)) found.push(`${name}: cut off`);
  if (boxes(".modebar-btn").length) found.push(`${name}: buttons over the legend`);
  return found;
})"""


@pytest.mark.slow
@pytest.mark.parametrize("width", [360, 390])
def test_phone__no_text_of_a_plot_lies_over_another(visit: Open, width: int) -> None:
    made = visit("/", viewport={"width": width, "height": 780}, has_touch=True, is_mobile=True).ready()
    assert made.page.evaluate(LAPPED) == []


@pytest.mark.slow
def test_phone_layout__parameters_are_below_the_view(visit: Open) -> None:
    made = visit("/", viewport={"width": 390, "height": 844}).ready()
    slider(made, CLEARANCE).focus()
    made.page.locator("#spectrum").evaluate("(each) => each.scrollIntoView({ block: 'start' })")
    boxes = [made.page.locator(each).bounding_box() for each in ("#spectrum", "aside")]
    assert -1 <= boxes[0]["y"] < boxes[1]["y"] - 200
    assert boxes[1]["y"] + boxes[1]["height"] == pytest.approx(844, abs=2)
    assert made.page.evaluate("document.documentElement.scrollWidth") <= 391
