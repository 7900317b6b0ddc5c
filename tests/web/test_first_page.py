"""The page at its address: the first case and its motion come with it, its modules as one script."""

import base64
import json
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from gearplay.web.bundle import EXPORT, script_of, static_text
from gearplay.web.first_page import FirstPage
from gearplay.web.frames import unpack_frame
from gearplay.web.tasks import run
from page_jobs import STOP, quiet
from serving import Server, Visit, together

Open = Callable[..., Visit]
STATIC = Path(__file__).parents[2] / "src/gearplay/web/static"
START = re.compile(r'<script id="start" type="application/json">(.*)</script>')
DRAWN = """() => {
  const canvas = document.querySelector('#stage canvas');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  return data.some((value) => value > 0);
}"""
ORBIT = "window.gearplay.state.result.models.coupled.orbits[0].x.join()"
SET = """([path, value]) => {
  const field = document.querySelector(`[data-path="${path}"]`);
  field.value = value;
  field.dispatchEvent(new Event("change"));
}"""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Serve without results of other tests, of which the oldest go."""
    made = Server(tmp_path_factory.mktemp("first"))
    yield made
    made.stop()


def start_of(server: Server, seconds: float = 60.0) -> dict[str, Any]:
    """Return the data of the page once they have a result."""
    end = time.monotonic() + seconds
    while True:
        found = START.search(httpx.get(server.url, timeout=20).text)
        assert found is not None
        start: dict[str, Any] = json.loads(found[1])
        if start["result"] is not None:
            return start
        assert time.monotonic() < end, "no first motion"
        time.sleep(0.2)


def test_script__has_every_export_of_every_module_and_no_import() -> None:
    text = script_of("main")
    assert re.search(r"^(import|export) ", text, re.MULTILINE) is None
    imported = {file.stem for file in STATIC.glob("*.js")} - {"main", "player"}
    assert set(re.findall(r"^modules\.(\w+) = ", text, re.MULTILINE)) == imported
    for name in imported:
        source = static_text(f"{name}.js")
        assert len(EXPORT.findall(source)) == source.count("\nexport ") + source.startswith("export ")
        assert text.index(f"modules.{name} = ") < text.index(f" = modules.{name};"), "made before it is used"


def test_first_motion__is_that_of_a_run_of_the_first_case(server: Server) -> None:
    start = start_of(server)
    described = httpx.get(f"{server.url}/api/cases/{start['name']}", timeout=20).json()
    assert start["described"] == described
    assert start["name"] in start["cases"]
    found = unpack_frame(base64.b64decode(start["result"]["frame"]))
    case = described["case"]
    own = unpack_frame(run({"case": case, "models": [case["backlash_model"]]}, quiet, STOP))
    assert found["sha256"] == own["sha256"]
    (model,) = own["models"]
    for one, other in zip(found["models"][model]["orbits"], own["models"][model]["orbits"], strict=True):
        np.testing.assert_array_equal(one["x"], other["x"])
    assert httpx.get(f"{server.url}/api/results/{start['result']['key']}", timeout=20).status_code == 200


def test_first_visit__draws_before_it_has_a_connection(chromium: Any, server: Server) -> None:
    start_of(server)
    made = Visit(chromium, "about:blank", chromium.new_context())
    try:
        held: list[Any] = []
        made.page.route_web_socket("**/wire", lambda socket: held.append(socket))  # never connected
        made.page.goto(server.url)
        made.until("Boolean(window.gearplay && window.gearplay.first)")
        assert made.page.evaluate(DRAWN)
        asked = [url.removeprefix(server.url) for url in made.asked if url.startswith("http")]
        assert set(asked) <= {
            "/",
            "/page.js",
            "/static/style.css",
            "/static/icon.svg",
            "/plotly.js",
            "/api/results",
        }
    finally:
        made.context.close()
    assert made.complaints == []


def test_first_visit__requests_no_run_until_a_control_moves(visit: Open, server: Server) -> None:
    start_of(server)
    sent: list[str] = []
    made = visit("/?")
    made.page.on("websocket", lambda socket: socket.on("framesent", lambda text: sent.append(str(text))))
    made.page.reload()
    made.ready()
    assert not [text for text in sent if '"kind":"run"' in text], "what came with the page is shown"
    first = made.page.evaluate(ORBIT)
    for value, same in (("80", False), ("100", True)):
        made.after(lambda: made.page.evaluate(SET, ["meshes.0.backlash", value]))  # noqa: B023
        assert (made.page.evaluate(ORBIT) == first) is same


def test_page__is_without_a_result_until_there_is_one() -> None:
    html = together(FirstPage().html)
    found = START.search(html)
    assert found is not None
    assert json.loads(found[1])["result"] is None
    assert "</script>" not in found[1]
