"""Parts of the page's server: frames, controls, the store, the guard's decisions, addresses, tasks."""

import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearplay.model.reading import bundled_names, load_case, replace
from gearplay.study.signals.extremes import extremes
from gearplay.vocabulary.errors import InputError
from gearplay.web.controls import controls
from gearplay.web.frames import pack_frame, unpack_frame
from gearplay.web.guard import Guard
from gearplay.web.serve import address_of
from gearplay.web.store import Store
from gearplay.web.tasks import TASKS, case_of

STOP = threading.Event()


def quiet(done: float, total: float) -> None:
    return


def job(**more: Any) -> dict[str, Any]:
    case = load_case("han2021", ["run.duration=50ms", "run.transient=0s", "run.sampling=20kHz"])
    return {"case": case.resolved(), **more}


def test_frames_keep_every_number_and_shape() -> None:
    document = {
        "a": [1, None, "x"],
        "b": {"c": np.arange(6.0).reshape(2, 3)},
        "d": np.zeros((0, 2)),
        "e": float("nan"),
    }
    found = unpack_frame(pack_frame(document))
    assert found["a"] == [1, None, "x"]
    np.testing.assert_array_equal(found["b"]["c"], np.arange(6.0).reshape(2, 3))
    assert found["d"].shape == (0, 2)
    assert found["e"] is None
    with pytest.raises(ValueError, match="frame"):
        unpack_frame(b"abc")


@pytest.mark.parametrize("name", bundled_names())
def test_every_number_of_a_case_has_a_control_that_holds_it(name: str) -> None:
    """A control's value lies on its slider and within its bounds, and setting it to itself changes nothing."""
    case = load_case(name)
    found = controls(case)
    assert len({each["path"] for each in found}) == len(found)
    for each in found:
        if each["kind"] in ("number", "integer") and each["path"] != "run.sampling":
            value = each["value"]
            low, high = each["low"], each["high"]
            assert low is None or low <= value * (1 + 1e-12)
            assert high is None or value <= high * (1 + 1e-12), each
            assert each["least"] is None or each["least"] <= value
            if each["kind"] == "number":
                same = controls(replace(case, {each["path"]: value / each["factor"]}))
                now = next(c["value"] for c in same if c["path"] == each["path"])
                assert now == pytest.approx(value, rel=1e-12)
        assert each["label"]
        assert each["group"] in ("Model", "Gears", "Drive and load", "Sleeves", "Mesh", "Run")


def test_the_store_keeps_the_newest(tmp_path: Path) -> None:
    store = Store(tmp_path, most=3)
    keys = [Store.key_of({"n": n}) for n in range(5)]
    for n, key in enumerate(keys):
        store.save(key, pack_frame({"kind": "run", "title": str(n)}))
    assert len(list(tmp_path.glob("*.frame"))) == 3
    assert store.load(keys[4]) is not None
    assert store.load("../../etc/passwd") is None
    assert store.load(32 * "0") is None
    (tmp_path / f"{32 * 'a'}.frame").write_bytes(b"broken")
    assert {each["kind"] for each in store.listed()} == {"run"}


def scope(**headers: str) -> dict[str, Any]:
    pairs = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
    return {"type": "http", "method": "GET", "path": "/", "headers": pairs, "query_string": b""}


def test_the_guard_s_reasons() -> None:
    guard = Guard(None, frozenset({"127.0.0.1:80"}))  # type: ignore[arg-type]
    assert guard.refusal(scope(host="127.0.0.1:80")) is None
    assert guard.refusal(scope(host="127.0.0.1:80", origin="http://127.0.0.1:80")) is None
    assert "Host" in str(guard.refusal(scope(host="127.0.0.1")))
    assert "Origin" in str(guard.refusal(scope(host="127.0.0.1:80", origin="http://x")))
    assert "required" in str(guard.refusal(scope(host="127.0.0.1:80") | {"method": "POST"}))
    assert "another site" in str(guard.refusal(scope(host="127.0.0.1:80", sec_fetch_site="cross-site")))
    tokened = Guard(None, frozenset({"127.0.0.1:80"}), "secret-secret-secret")  # type: ignore[arg-type]
    assert "token" in str(tokened.refusal(scope(host="127.0.0.1:80", cookie="gearplay-token=secret")))
    assert tokened.refusal(scope(host="127.0.0.1:80", cookie="gearplay-token=secret-secret-secret")) is None


@pytest.mark.parametrize(
    ("host", "port", "token", "said"),
    [
        ("0.0.0.0", 80, None, "--token = .*is required"),
        ("192.168.1.5", 80, None, "is required"),
        ("192.168.1.5", 80, "short", "must be 16 or more letters"),
        ("192.168.1.5", 80, "has spaces and more", "must be 16 or more letters"),
        ("example.com", 80, None, "must be an IP address"),
        ("127.0.0.1", 70000, None, "--port = 70000"),
    ],
)
def test_addresses_that_are_refused(host: str, port: int, token: str | None, said: str) -> None:
    with pytest.raises(InputError, match=said):
        address_of(host, port, token)


def test_addresses_and_their_names() -> None:
    assert address_of("127.0.0.1", 8, None).names == {"127.0.0.1:8", "localhost:8", "[::1]:8"}
    outside = address_of("192.168.1.5", 8, "a-token-of-enough-letters", ("rig.local",))
    assert outside.names == {"192.168.1.5:8", "rig.local:8"}
    assert outside.url == "http://192.168.1.5:8/?token=a-token-of-enough-letters"


def test_a_run_shows_what_the_solver_says() -> None:
    """Curves, frames and statistics are those of the same run by `simulate`."""
    import gearplay as gp

    found = unpack_frame(TASKS["run"](job(models=["coupled"]), quiet, STOP))
    case = case_of(job())
    result = gp.simulate(case)
    view = found["models"]["coupled"]
    assert view["finished"]
    ring = list(case.rotors).index("ring")
    np.testing.assert_allclose(
        view["frames"]["rotors"][ring, 0, 0], result.ds.x.sel(rotor="ring").values[0], rtol=1e-6
    )
    backlash = next(each for each in view["histories"] if each["signal"] == "backlash")
    values = result.ds.backlash.values
    assert float(backlash["v"].max()) == pytest.approx(float(values.max()), rel=1e-6)
    assert float(backlash["v"].min()) == pytest.approx(float(values.min()), rel=1e-6)
    assert [each["line"] for each in found["test"]] == ["f_r", "f_m", "2 f_m"]
    assert found["lines"]["f_m"] == pytest.approx(40.0)


def test_strips_are_the_times_in_contact() -> None:
    words = job(models=["coupled"])
    words["case"]["run"] |= {"duration": 1.0}
    view = unpack_frame(TASKS["run"](words, quiet, STOP))["models"]["coupled"]
    for strip, each in zip(view["strip"], view["statistics"], strict=True):
        closed = float(np.sum(strip["spans"][:, 1] - strip["spans"][:, 0]))
        assert closed == pytest.approx(each["share_of_time"] * 1.0, abs=2e-6)


def test_no_shock_is_lost_in_thinning() -> None:
    time = np.linspace(0.0, 1.0, 100_001)
    values = np.zeros_like(time)
    values[[777, 99_999]] = 5.0, -3.0
    t, v = extremes(time, values, 700)
    assert t.size < 3000
    assert (v.max(), v.min()) == (5.0, -3.0)
    assert np.all(np.diff(t) > 0.0)


@pytest.mark.parametrize(
    ("kind", "words", "said"),
    [
        ("run", {"case": None}, "case"),
        ("bifurcation", {"count": 5, "keep": 5, "settle": 0, "signal": "ring.x"}, "axis"),
        ("bifurcation", {"count": 1000, "keep": 400, "settle": 0}, "must be at most 100000"),
        ("bifurcation", {"count": True, "keep": 400, "settle": 0}, "must be a whole number"),
        ("map", {"columns": 60, "rows": 60}, "must be at most 2500"),
        ("export", {"form": "exe"}, "must be nc, csv or toml"),
    ],
)
def test_tasks_refuse_in_words(kind: str, words: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        TASKS[kind](job(**words), quiet, STOP)


def test_limits_are_the_server_s() -> None:
    words = job()
    words["case"]["run"] |= {"max_steps": 2**40, "ensemble": 7}
    run = case_of(words).run
    assert (run.max_steps, run.ensemble, run.max_wall_time) == (20_000_000, 1, 120.0)
