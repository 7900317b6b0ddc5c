"""Every slider of the page in every bundled case moves what it says; faults are shown; measurements keep their units."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from depth import FULL
from gearplay.model.bundled import bundled
from visiting import BACKLASH, WITHOUT_AVERAGES, Open, field, fill

CASES = (
    ["han2021", *sorted({*bundled("gearplay.model", "cases")} - {"han2021"})]
    if FULL
    else ["han2021", "kahraman-singh-1990"]
)

FEWEST = {"kahraman-singh-1990": 10}
"""Sliders that a case has at least, of a torsional pair its numbers and those of the run; of all others 40."""

BATCH = 8
"""Sliders that are moved together; one by one where their values do not go together."""

MOVE = """async ([first, count]) => {
  const { state, latencies } = window.gearplay;
  const message = document.getElementById("message");
  const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });
  const at = (place, path) => path.split(".").reduce((inner, part) => inner?.[part], place);
  const calm = async () => { while (state.running || state.again) await pause(5); };
  const every = [...document.querySelectorAll("#controls input[type=range]")];
  const dead = [];
  const moves = every.slice(first, first + count).map((slider) => {
    const field = slider.parentElement.querySelector("input[type=number]");
    return { path: slider.dataset.slider, slider, field, before: field.value, place: Number(slider.value) };
  });
  await calm();
  const begun = latencies.length;
  for (const { path, slider, field, before, place } of moves) {
    for (const step of [7, -7, 90, -90, 450, -450]) {
      if (place + step < 0 || place + step > 1000) continue;
      slider.value = place + step;
      slider.dispatchEvent(new Event("input"));
      if (field.value !== before) break;
    }
    if (field.value === before) dead.push(`${path}: its value stays ${before}`);
  }
  const until = performance.now() + 60_000;
  while (latencies.length === begun && message.hidden && performance.now() < until) await pause(5);
  await calm();
  const told = message.hidden ? "" : message.textContent;
  if (!told) {
    for (const { path, field } of moves) {
      const { control } = state.panel.rows.get(path);
      const [factor, offset] = control.kind === "number" ? [control.factor, control.offset] : [1, 0];
      const [shown, ran] = [(Number(field.value) - offset) / factor, at(state.result.case, path)];
      if (!(Math.abs(ran - shown) <= 1e-3 * Math.abs(shown) + 1e-12)) dead.push(`${path}: ${ran} was run, not ${shown}`);
    }
  }
  document.getElementById("reset").click();
  await calm();
  return { moved: moves.length, count: every.length, paths: moves.map(({ path }) => path), dead, told };
}"""


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_every_slider_moves_its_field(visit: Open, case: str) -> None:
    """Each is moved once: a run of the new value follows, or one sentence that says why there is none."""
    made = visit(plots=False).ready()
    if case != "han2021":
        made.after(lambda: made.page.select_option("#case", case))
    made.page.evaluate("document.getElementById('compare').checked = false")
    if not FULL:  # what is not in view is not drawn, which is quicker
        made.page.click("#tab-map")
    made.page.evaluate(
        """() => {
          const { state } = window.gearplay;
          Object.assign(state.base.run, { duration: 0.02, transient: 0.0 });
        }"""
    )
    made.page.evaluate(WITHOUT_AVERAGES)

    def move(first: int, number: int) -> dict[str, Any]:
        found: dict[str, Any] = made.page.evaluate(MOVE, [first, number])
        assert found["dead"] == []
        return found

    done, count = 0, 1
    while done < count:
        found = move(done, BATCH)
        count = found["count"]
        alone = range(done, done + found["moved"]) if found["told"] else ()
        told = {at: move(at, 1)["told"] for at in alone}
        assert all(words == "" or words.endswith(".") for words in told.values()), told
        assert not any("fault" in words for words in told.values()), told
        done += found["moved"]
    assert count > FEWEST.get(case, 40)


@pytest.mark.slow
def test_page_fault__is_displayed_and_stops_nothing(visit: Open) -> None:
    """What a control does throws once: a message is shown, the next move runs."""
    made = visit(plots=False).ready()
    made.page.evaluate(
        """() => {
          const { state } = window.gearplay;
          const submit = state.wire.submit.bind(state.wire);
          state.wire.submit = (...words) => { state.wire.submit = submit; throw new TypeError("nothing of the kind"); };
        }"""
    )
    field(made, BACKLASH).fill("150")
    field(made, BACKLASH).press("Tab")
    made.until("!document.getElementById('message').hidden")
    assert "nothing of the kind" in (made.page.text_content("#message") or "")
    assert "fault of the program" in (made.page.text_content("#message") or "")
    assert made.complaints
    made.complaints.clear()
    fill(made, BACKLASH, "160")
    assert made.page.evaluate("window.gearplay.state.result.case.meshes[0].backlash") == pytest.approx(160e-6)
    assert made.page.is_hidden("#message")
    assert made.page.evaluate("window.gearplay.state.running === null")


MEASURED = "window.gearplay.state.overlay?.measured"


def write_mat(place: Path, time: np.ndarray, values: np.ndarray) -> None:
    from scipy.io import savemat

    savemat(place, {"acc": 9.80665 * values, "time": time})


def write_wav(place: Path, time: np.ndarray, values: np.ndarray) -> None:
    from scipy.io import wavfile

    wavfile.write(place, 2048, (0.25 * values).astype(np.float32))


@pytest.mark.slow
def test_measurements_keep_their_units(visit: Open, tmp_path: Path) -> None:
    """2 g at 100 Hz are 19.6133 m/s^2; so it is in m/s^2, of MAT and WAV files, and of a table of amplitudes."""
    time = np.arange(8192) / 2048.0
    values = 2.0 * np.sin(2.0 * np.pi * 100.0 * time)
    rows = "".join(f"{t:.9f},{v:.9f}\n" for t, v in zip(time, values, strict=True))
    files = {
        name: tmp_path / name
        for name in ("g.csv", "si.csv", "lines.csv", "a.mat", "a.wav", "none.csv", "volts.csv")
    }
    files["g.csv"].write_text(f"time [s],acc [g]\n{rows}")
    files["none.csv"].write_text(f"time [s],acc\n{rows}")
    files["volts.csv"].write_text(f"time [s],acc [V]\n{rows}")
    files["lines.csv"].write_text(
        "frequency [Hz],acc [g]\n" + "".join(f"{k},{2.0 * (k == 100):g}\n" for k in range(1, 400))
    )
    files["si.csv"].write_text(
        "time [s],acc [m/s^2]\n"
        + "".join(f"{t:.9f},{9.80665 * v:.9f}\n" for t, v in zip(time, values, strict=True))
    )
    write_mat(files["a.mat"], time, values)
    write_wav(files["a.wav"], time, values)
    made = visit(plots=False).ready()
    for name, unit, factor in (
        ("g.csv", "", 1.0), ("si.csv", "", 1.0), ("lines.csv", "", 1.0), ("none.csv", "g", 1.0), ("a.mat", "m/s^2", 1.0),
        ("a.wav", "g", 0.25),
    ):  # fmt: skip
        made.page.select_option("#measured-unit", unit)
        made.page.set_input_files("#measured", files[name])
        made.until(f"{MEASURED}?.name.startsWith('{name}')")
        f, a = made.page.evaluate(
            f"(() => {{ const {{ f, a }} = {MEASURED}; const k = a.indexOf(Math.max(...a)); return [f[k], a[k]]; }})()"
        )
        assert f == pytest.approx(100.0, abs=0.3), name
        assert a == pytest.approx(factor * 2.0 * 9.80665, rel=1e-3), name
    made.page.select_option("#measured-unit", "")
    for name, words in (
        ("none.csv", "says no unit"),
        ("volts.csv", "must hold an acceleration; found acc [V]"),
    ):
        made.page.set_input_files("#measured", files[name])
        made.until(f"document.getElementById('message').textContent.includes({words!r})")
    made.complaints.clear()  # the browser notes the answers 400


@pytest.mark.slow
@pytest.mark.parametrize(
    "case", ["planetary-reducer", pytest.param("two-stage-reducer", marks=pytest.mark.deep)]
)
def test_names_of_orders_do_not_lie_over_each_other(visit: Open, case: str) -> None:
    made = visit(plots=False).ready()
    made.after(lambda: made.page.select_option("#case", case))
    made.release()
    made.until("document.querySelectorAll('#spectrum .annotation-text').length > 2")
    boxes = made.page.evaluate(
        """[...document.querySelectorAll("#spectrum .annotation-text")].map((each) => {
          const { left, right, top, bottom } = each.getBoundingClientRect();
          return [each.textContent, left, right, top, bottom];
        })"""
    )
    inside = made.page.evaluate(
        "document.querySelector('#spectrum .plot, #spectrum .nsewdrag').getBoundingClientRect().bottom"
    )
    for at, (name, left, right, top, bottom) in enumerate(boxes):
        assert bottom <= inside + 2.0, name
        for other, left_2, right_2, top_2, bottom_2 in boxes[at + 1 :]:
            wide, high = min(right, right_2) - max(left, left_2), min(bottom, bottom_2) - max(top, top_2)
            assert wide <= 2.0 or high <= 4.0, (name, other)
