"""Lost motion on the page: the task of a worker, its file, the panel."""

import json
import math
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import gearplay as gp
from gearplay.vocabulary.errors import InputError
from gearplay.web.downloads import file_of
from gearplay.web.frames import unpack_frame
from gearplay.web.tasks import TASKS
from visiting import BACKLASH, Open, fill, shown

WORDS = {"at": "output", "hold": "input", "torque": 50.0, "positions": 1}


def computed(**words: Any) -> bytes:
    job = {"case": gp.load_case("two-stage-reducer").resolved(), **WORDS, **words}
    return TASKS["lost_motion"](job, lambda *_: None, threading.Event())


def test_task__has_the_numbers_and_the_curve_of_the_function() -> None:
    found, own = unpack_frame(computed(positions=3)), gp.lost_motion(
        "two-stage-reducer", at="output", hold="input", torque=50.0, positions=3
    )  # fmt: skip
    for name in ("lost_motion", "backlash", "torsional_stiffness"):
        assert found[name] == float(own.ds[name])
    np.testing.assert_allclose(found["turn"]["lost_motion"], own.ds["lost_motion_by_position"], rtol=1e-6)
    torque, angle = found["branches"]["unloading"]
    assert (torque.min(), torque.max()) == (-50.0, 50.0)
    jump = np.flatnonzero(torque == 0.0)  # the play is crossed at no torque
    assert jump.size == 2
    play = math.radians(np.diff(angle[jump])[0] / 60.0)
    assert play == pytest.approx(float(own.ds["backlash"]), rel=1e-5)
    assert np.diff(found["ends"])[0] == pytest.approx(float(own.ds["lost_motion"]), rel=1e-5)
    assert dict(found["rows"])["lost motion"].startswith("7.077 arcmin")


def test_task__as_a_file(tmp_path: Path) -> None:
    frame = computed()
    (tmp_path / "curve.nc").write_bytes(file_of(frame, "nc"))
    with xr.open_dataset(tmp_path / "curve.nc", engine="h5netcdf") as saved:
        assert saved["torque"].values[[0, -1]].tolist() == [50.0, 50.0]
        assert saved["torque"].values.min() == -50.0
        assert saved.attrs["lost_motion"] == unpack_frame(frame)["lost_motion"]
        assert json.loads(saved.attrs["case"])["rotors"]
    lines = file_of(frame, "csv").decode().splitlines()
    assert lines[0] == "point,torque [N m],angle [arcmin]"
    assert len(lines) == 1 + sum(each.shape[1] for each in unpack_frame(frame)["branches"].values())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"at": "lid"}, "must be a rotor of the case"),
        ({"hold": "output"}, "must name a rotor other than the one"),
        ({"torque": -1.0}, "torque = -1.0: must be a number above 0"),
        ({"torque": "1e3"}, "must be a number above 0"),
        ({"positions": 1000}, "must be a whole number from 1 to 100"),
    ],
)
def test_task__refuses_in_words(words: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        computed(**words)


def test_task__stops() -> None:
    stop = threading.Event()
    stop.set()
    job = {"case": gp.load_case("two-stage-reducer").resolved(), **WORDS, "positions": 3}
    with pytest.raises(KeyboardInterrupt):
        TASKS["lost_motion"](job, lambda *_: None, stop)


@pytest.mark.slow
def test_panel(visit: Open) -> None:
    """On a screen, then as wide as a phone."""
    made = visit(plots=False).ready()
    made.after(lambda: made.page.select_option("#case", "two-stage-reducer"))
    made.page.click("#tab-lost_motion")
    made.release()
    form = "#lost_motion-form"
    assert made.page.input_value(f"{form} [name=at]") == "output"
    assert made.page.input_value(f"{form} [name=hold]") == "input"
    made.page.fill(f"{form} [name=positions]", "3")
    made.page.click(f"{form} button")
    made.until("document.getElementById('lost_motion-turn').data?.length === 2", 60.0)
    assert made.page.evaluate("document.getElementById('lost_motion').data.length") == 3
    tiles = made.page.text_content("#lost_motion-rows")
    for words in ("7.077 arcmin", "K1", "45.36 N m/arcmin", "mesh layshaft.pinion-output"):
        assert words in tiles
    for width in (1400, 390):
        made.page.set_viewport_size({"width": width, "height": 1000})
        made.until(f"document.documentElement.scrollWidth <= {width + 1}")
    assert made.page.locator("#lost_motion-stale").is_hidden()
    fill(made, BACKLASH, "140")
    assert made.page.locator("#lost_motion-stale").is_visible()
    assert shown(made, "diagrams.lost_motion.case.meshes[0].backlash") == pytest.approx(80e-6)
