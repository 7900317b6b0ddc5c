"""Parts of the page's server: frames, controls, the store, the guard's decisions, addresses, tasks."""

import asyncio
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.stats import t

from gearplay.model.bundled import bundled_text
from gearplay.model.reading import bundled_names, load_case, replace
from gearplay.model.toml_files import parse_toml
from gearplay.parts.mesh.train.rolling import mesh_frequency
from gearplay.pictures.extremes import extremes
from gearplay.results.spectra import amplitude_spectrum, ensemble_spectrum
from gearplay.signals.lines import find_line
from gearplay.solver.simulate import run_batch
from gearplay.vocabulary.errors import InputError
from gearplay.web.access import Guard
from gearplay.web.app import make_app
from gearplay.web.controls import GROUPS, controls
from gearplay.web.downloads import file_of
from gearplay.web.frames import pack_frame, read_head, unpack_frame
from gearplay.web.jobs import limited_case
from gearplay.web.maps import measures
from gearplay.web.pool import Pool
from gearplay.web.serve import address_of
from gearplay.web.store import Store
from gearplay.web.tasks import TASKS
from gearplay.web.toml_edits import edited
from page_jobs import CLEARANCE, SPEED, STOP, quiet, ranges_of
from serving import together

BACKLASH = "meshes.0.backlash"
SMALL_MAP = {
    "columns": 3,
    "rows": 2,
    "first": {"path": BACKLASH, "low": 5e-5, "high": 1.5e-4},
    "second": {"path": CLEARANCE, "low": 5e-5, "high": 1e-4},
    "measure": "rms",
    "of": "ring",
}


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
    frame = pack_frame(document)
    length = int.from_bytes(frame[:4], "little")
    assert length % 4 == 0
    assert json.loads(frame[4 : 4 + length])["a"] == [1, None, "x"]
    found = unpack_frame(frame)
    assert found["a"] == [1, None, "x"]
    np.testing.assert_array_equal(found["b"]["c"], np.arange(6.0).reshape(2, 3))
    assert found["d"].shape == (0, 2)
    assert found["e"] is None
    with pytest.raises(ValueError, match="frame"):
        unpack_frame(b"abc")


@pytest.mark.slow
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
                same = controls(replace(case, {each["path"]: (value - each["offset"]) / each["factor"]}))
                now = next(c["value"] for c in same if c["path"] == each["path"])
                assert now == pytest.approx(value, rel=1e-12)
        assert each["label"]
        assert each["group"] in GROUPS.values()


def test_controls__velocities_of_a_held_centre_are_left_out() -> None:
    """The pinion's centre is held, and every value but 0 refused; the ring's moves in its sleeve."""
    paths = {each["path"] for each in controls(load_case("han2021"))}
    assert {"rotors.ring.initial.vx", "rotors.ring.initial.vy"} <= paths
    assert not {"rotors.pinion.initial.vx", "rotors.pinion.initial.vy"} & paths


@pytest.mark.parametrize("name", ["pinion-idler-ring", "cooley-parker-2012"])
def test_controls__numbers_of_teeth_begin_at_the_least(name: str) -> None:
    """Fields that may be absent, too: 6 teeth is the least that the schema takes."""
    teeth = [each for each in controls(load_case(name)) if each["path"].endswith(".teeth")]
    assert teeth
    assert {(each["least"], each["low"], each["most"]) for each in teeth} == {(6, 6, 10_000)}


def test_store__keeps_the_newest(tmp_path: Path) -> None:
    store = Store(tmp_path, most=3)
    keys = [Store.key_of({"n": n}) for n in range(5)]
    for n, key in enumerate(keys):
        store.save(key, pack_frame({"kind": "run", "title": str(n)}))
    assert len(list(tmp_path.glob("*.frame"))) == 3
    assert store.load(keys[4]) is not None
    Store(tmp_path, most=2).save(keys[0], pack_frame({"kind": "run", "title": "again"}))
    assert [each["key"] for each in Store(tmp_path).listed()] == [keys[0], keys[4]]
    assert store.load("../../etc/passwd") is None
    assert store.load(32 * "0") is None
    (tmp_path / f"{32 * 'a'}.frame").write_bytes(b"broken")
    assert {each["kind"] for each in store.listed()} == {"run"}


def test_store__reads_a_result_once_for_all_lists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store, read = Store(tmp_path), []
    monkeypatch.setattr(
        "gearplay.web.store.read_head", lambda source: read.append(source.name) or read_head(source)
    )
    for n in range(3):
        store.save(Store.key_of({"n": n}), pack_frame({"kind": "run", "title": str(n)}))
        assert [each["title"] for each in store.listed()] == [str(k) for k in reversed(range(n + 1))]
    assert len(read) == 3
    store.save(Store.key_of({"n": 0}), pack_frame({"kind": "run", "title": "again"}))
    assert [each["title"] for each in store.listed()] == ["again", "2", "1"]
    assert len(read) == 4


def test_store__removes_leftovers_of_a_killed_server_only(tmp_path: Path) -> None:
    key = 32 * "a"
    others = [
        f".{key}.frame.0123456789ab.part.txt",
        f".{key}x.frame.01.part",
        ".mine.part",
        f"{key}.frame.01.part",
    ]
    for name in (*others, f".{key}.frame.0123456789ab.part"):
        (tmp_path / name).touch()
    Store(tmp_path)
    assert sorted(os.listdir(tmp_path)) == sorted(others)


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


def test_a_proxy_may_speak_https_for_a_name_that_was_given() -> None:
    address = address_of("192.168.1.5", 8, "a-token-of-enough-letters", ("Rig.local",))
    guard = Guard(None, address.names, None, address.proxied)  # type: ignore[arg-type]
    assert guard.refusal(scope(host="rig.local", origin="https://rig.local")) is None
    assert guard.refusal(scope(host="RIG.local:8", origin="http://rig.local:8")) is None
    assert guard.refusal(scope(host="rig.local", origin="https://rig.local.evil.test")) is not None
    assert guard.refusal(scope(host="192.168.1.5:8", origin="https://192.168.1.5:8")) is not None
    assert guard.refusal(scope(host="rig.local:9", origin="http://rig.local:9")) is not None


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
    outside = address_of("192.168.1.5", 8, "a-token-of-enough-letters", ("Rig.local",))
    assert outside.names == {"192.168.1.5:8", "rig.local:8", "rig.local"}
    assert address_of("127.0.0.1", 80, None).names >= {"127.0.0.1", "localhost", "localhost:80"}
    assert outside.url == "http://192.168.1.5:8/?token=a-token-of-enough-letters"


def test_run_view__equals_the_solver() -> None:
    """Curves, frames and statistics are those of the same run by `simulate`."""
    import gearplay as gp

    found = unpack_frame(TASKS["run"](job(models=["coupled"]), quiet, STOP))
    case = limited_case(job())
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
    assert {each["line"]: each["frequency"] for each in found["test"]} == {
        "radial": 2.856,
        "mesh_1x": 39.991,
        "mesh_2x": 80.172,
    }
    assert found["lines"]["f_m"] == pytest.approx(40.0)


def test_run_view__of_a_rolling_bearing_has_its_force_clearance_and_elements() -> None:
    """The bearing bears the weight, m g = 100 N, over its radial clearance, half of the diametral 20.5 um."""
    file = Path(__file__).parents[2] / "docs" / "how-to" / "shaft-in-6205.toml"
    found = unpack_frame(TASKS["run"]({"case": load_case(file).resolved()}, quiet, STOP))
    (view,) = found["models"].values()
    force = {each["signal"]: each["v"] for each in view["histories"]}["bearing_force"]
    assert np.mean(force) == pytest.approx(100.0, rel=0.02)
    assert [(each["name"], each["clearance"]) for each in view["orbits"]] == [
        ("shaft", pytest.approx(10.25e-6))
    ]
    assert [each["kind"] for each in found["mechanism"]["sleeves"]] == ["bearing"]
    assert {each["label"] for each in view["strip"]} >= {f"shaft:element{k}" for k in range(9)}


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
        ("map", {**SMALL_MAP, "second": SMALL_MAP["first"]}, "must be another field than first"),
        ("map", {**SMALL_MAP, "of": "lid"}, 'measure = "rms of lid": must be a measure of a rotor or contact'),
        ("map", {**SMALL_MAP, "first": {"path": "run.sampling", "low": 1e4, "high": 1e7}}, "must not be a field of run"),
        ("map", {**SMALL_MAP, "first": {"path": BACKLASH, "low": 0, "high": 10**400}}, "must be a number below high"),
        ("export", {"form": "exe"}, "must be nc, csv or toml"),
    ],
)  # fmt: skip
def test_tasks_refuse_in_words(kind: str, words: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        TASKS[kind](job(**words), quiet, STOP)


def test_limits_are_the_server_s() -> None:
    words = job()
    words["case"]["run"] |= {"max_steps": 2**40, "ensemble": 7}
    run = limited_case(words).run
    assert (run.max_steps, run.ensemble, run.max_wall_time) == (20_000_000, 7, 120.0)
    words["case"]["run"]["ensemble"] = 17
    with pytest.raises(InputError, match="must be at most 16 on the page"):
        limited_case(words)


def test_a_train_that_a_torque_turns_backwards() -> None:
    """Its senses are those of the torque, nothing has a nominal mesh frequency, and teeth roll on teeth in the drawing."""
    drive = {"kind": "torque", "torque": -0.5}
    words = job(models=["coupled"])
    words["case"]["rotors"]["pinion"]["drive"] = drive
    words["case"]["run"] |= {"duration": 0.2}
    found = unpack_frame(TASKS["run"](words, quiet, STOP))
    assert [gear["sense"] for gear in found["mechanism"]["gears"]] == [-1.0, -1.0]
    assert "f_m" not in found["lines"]
    frames = found["models"]["coupled"]["frames"]
    run = run_batch([(limited_case(words), [0])])[0][0]
    at = np.rint(
        (frames["t"] + found["models"]["coupled"]["start"] - run.first_sample) * run.sampling
    ).astype(int)
    for k, name in enumerate(("pinion", "ring")):
        drawn = frames["turns"][k] + frames["rotors"][k][2]
        off = np.mod(drawn - run.signal("theta", name)[at] + np.pi, 2.0 * np.pi) - np.pi
        assert np.max(np.abs(off)) < 1e-5
    pinion, ring = np.unwrap(frames["turns"].astype(float), axis=1)
    np.testing.assert_allclose((ring - ring[0]) * 3.0, pinion - pinion[0], atol=1e-4)
    assert np.max(np.abs(frames["rotors"][0][2])) < 1e-12


def test_arrows_are_the_largest_forces_since_the_frame_before() -> None:
    words = job(models=["coupled"])
    words["case"]["run"] |= {"duration": 0.4, "transient": 0.5}
    view = unpack_frame(TASKS["run"](words, quiet, STOP))["models"]["coupled"]
    run = run_batch([(limited_case(words), [0])])[0][0]
    drive = run.signal("drive_force", "pinion-ring")
    sleeve = np.hypot(run.signal("sleeve_force_x", "ring"), run.signal("sleeve_force_y", "ring"))
    at = np.unique(np.linspace(0, len(drive) - 1, 900).astype(int))
    hit = int(np.argmax(drive))
    frame = int(np.searchsorted(at, hit))  # the first frame that is not before it
    assert view["frames"]["meshes"][0, 0, frame] == pytest.approx(drive[hit], rel=1e-6)
    hit = int(np.argmax(sleeve))
    frame = int(np.searchsorted(at, hit))
    assert np.hypot(*view["frames"]["sleeves"][0, :, frame]) == pytest.approx(sleeve[hit], rel=1e-6)


def test_a_folder_that_cannot_be_and_frames_that_are_none(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("not a folder", encoding="utf-8")
    with pytest.raises(InputError, match="file"):
        Store(file / "inside")
    store = Store(tmp_path)
    head = b"[1]"
    store.save(32 * "b", len(head).to_bytes(4, "little") + head)
    assert store.listed() == []


def test_an_ensemble_is_averaged() -> None:
    words = job(models=["coupled"], note="backlash 100 um")
    words["case"]["run"] |= {"ensemble": 3, "duration": 0.2}
    found = unpack_frame(TASKS["run"](words, quiet, STOP))
    case = limited_case(words)
    runs = run_batch([(case, [0, 1, 2])])[0]
    assert (found["members"], found["note"]) == (3, "backlash 100 um")
    view = found["models"]["coupled"]
    spectrum = next(each for each in view["spectra"] if (each["label"], each["signal"]) == ("ring", "ax"))
    average = ensemble_spectrum([run.signal("ax", "ring") for run in runs], case.run.sampling)
    np.testing.assert_allclose(spectrum["a"][:400], average.amplitude[1:401], rtol=1e-6)
    assert average.spread is not None
    np.testing.assert_allclose(spectrum["s"][:400], average.spread[1:401], rtol=1e-5)
    contact = view["statistics"][1]
    counts = [round(run.statistics.impacts_per_second[1] * 0.2) for run in runs]
    assert contact["impacts"] == sum(counts)
    assert contact["peak_force"] == max(run.statistics.peak_force[1] for run in runs)
    speeds = [run.statistics.rms_impact_speed[1] for run in runs]
    mean_square = np.average(np.square(speeds), weights=counts)
    assert contact["rms_impact_speed"] == pytest.approx(np.sqrt(mean_square), rel=1e-9)


@pytest.mark.parametrize("measure", ["rms", "peak", "line", "share_of_time", "rms_impact_speed"])
def test_map__equals_single_runs(measure: str) -> None:
    of = "ring" if measure in ("rms", "peak", "line") else "pinion-ring:drive"
    words = job(**{**SMALL_MAP, "measure": measure, "of": of})
    words["case"]["run"]["duration"] = 0.2
    found = unpack_frame(TASKS["map"](words, quiet, STOP))
    assert found["values"].shape == (2, 3)
    case = replace(limited_case(words), {BACKLASH: 1e-4, CLEARANCE: 5e-5})
    run = run_batch([(case, [0])])[0][0]
    at = run.statistics.labels.index("pinion-ring:drive")
    ax = np.diff(run.signal("vx", "ring")) * run.sampling  # as sweeps keep it
    single = {
        "rms": np.sqrt(np.mean(ax**2)),
        "peak": np.max(np.abs(ax)),
        "line": find_line(amplitude_spectrum(ax, run.sampling), mesh_frequency(case)).amplitude,
        "share_of_time": run.statistics.share_of_time[at],
        "rms_impact_speed": run.statistics.rms_impact_speed[at],
    }[measure]
    assert found["values"][0, 1] == pytest.approx(single, rel=1e-6)
    assert found["values"][0, 1] > 0.0


@pytest.mark.slow
def test_every_measure_that_is_offered_is_kept() -> None:
    for each in measures(load_case("pinion-idler-ring")):
        case = load_case("pinion-idler-ring", ["run.duration=40ms", "run.transient=0s"])
        words = SMALL_MAP | {"columns": 2, "measure": each["measure"], "of": each["of"]}
        words |= {
            "case": case.resolved(),
            "second": {**SMALL_MAP["second"], "path": "sleeves.idler.radial_clearance"},
        }  # type: ignore[dict-item]
        found = unpack_frame(TASKS["map"](words, quiet, STOP))
        assert (found["reasons"], np.all(np.isfinite(found["values"]))) == ([], True), each


def test_map__failures_are_reported() -> None:
    words = job(**SMALL_MAP)
    words["case"]["run"]["max_steps"] = 5
    found = unpack_frame(TASKS["map"](words, quiet, STOP))
    assert np.all(np.isnan(found["values"]))
    assert "max_steps" in found["reasons"][0]
    with pytest.raises(InputError, match="must be less than the mean"):
        TASKS["map"](
            job(**SMALL_MAP | {"first": {"path": "meshes.0.stiffness.amplitude", "low": 1e7, "high": 1e9}}),
            quiet,
            STOP,
        )


def test_maps_and_diagrams_as_files(tmp_path: Path) -> None:
    frame = TASKS["map"](job(**SMALL_MAP), quiet, STOP)
    path = tmp_path / "map.nc"
    path.write_bytes(file_of(frame, "nc"))
    with xr.open_dataset(path, engine="h5netcdf") as saved:
        assert saved.value.dims == (CLEARANCE, BACKLASH)
        assert (saved.value.attrs["units"], saved[BACKLASH].attrs["units"]) == ("m/s^2", "m")
        np.testing.assert_array_equal(saved.value.values, unpack_frame(frame)["values"])
        assert json.loads(saved.attrs["case"])["run"]["duration"] == 0.05
        assert saved.attrs["case_sha256"] == load_case(json.loads(saved.attrs["case"])).sha256
    lines = file_of(frame, "csv").decode().splitlines()
    assert lines[0] == f"{CLEARANCE} [m],{BACKLASH} [m],rms acceleration of ring [m/s^2]"
    assert len(lines) == 1 + 6
    axis = SMALL_MAP["first"]
    diagram = TASKS["bifurcation"](job(axis=axis, signal="ring.x", count=3, keep=4, settle=2), quiet, STOP)
    lines = file_of(diagram, "csv").decode().splitlines()
    assert lines[0] == f"direction,{BACKLASH} [m],section,ring.x [m]"
    assert len(lines) == 1 + 2 * 3 * 4
    made = {
        "kind": "bifurcation",
        "title": "t",
        "case": load_case("han2021").resolved(),
        "failures": [[1, 0, "the shaft is locked"]],
        "signal": "ring.x",
        "path": BACKLASH,
        "unit": "m",
        "axis_unit": "m",
    }
    arrays = {"x": np.arange(2.0), "up": np.ones((2, 3)), "down": np.zeros((2, 3))}
    path.write_bytes(file_of(pack_frame(made | arrays), "nc"))
    with xr.open_dataset(path, engine="h5netcdf") as saved:
        assert saved["ring.x"].sel(direction="up").values.min() == 1.0
        assert saved["ring.x"].sel(direction="down").values.max() == 0.0
        assert saved.attrs["case_sha256"] == load_case("han2021").sha256
        assert saved["reason"].values.tolist() == [["", ""], ["the shaft is locked", ""]]
    with pytest.raises(InputError, match="must be a diagram, a map or a hysteresis curve"):
        file_of(pack_frame({"kind": "run", "title": None}), "csv")


def test_page__is_informed_that_no_worker_is_ready(tmp_path: Path) -> None:
    async def states() -> list[dict[str, Any]]:
        pool = Pool(size=0)
        given: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        sent: asyncio.Queue[Any] = asyncio.Queue()
        await given.put({"type": "websocket.connect"})
        scope = {"type": "websocket", "path": "/wire", "headers": [], "query_string": b"", "subprotocols": []}
        serving = asyncio.create_task(make_app(tmp_path, pool)(scope, given.get, sent.put))
        assert (await sent.get())["type"] == "websocket.accept"
        first = json.loads((await sent.get())["text"])
        pool.ready.set()
        second = json.loads((await sent.get())["text"])
        await given.put({"type": "websocket.disconnect", "code": 1000})
        await serving
        return [first, second]

    assert together(states) == [{"type": "state", "ready": False}, {"type": "state", "ready": True}]


def test_map_of_members__has_their_spread_and_marks_uncertain_cells() -> None:
    found = unpack_frame(TASKS["map"](job(**SMALL_MAP, members=3, duration=0.3, transient=0.0), quiet, STOP))
    case = replace(limited_case(job()), {BACKLASH: 1e-4, CLEARANCE: 5e-5, "run.duration": 0.3})
    runs = run_batch([(case, [1, 2, 3])])[0]
    values = [np.sqrt(np.mean((np.diff(run.signal("vx", "ring")) * run.sampling) ** 2)) for run in runs]
    assert found["values"][0, 1] == pytest.approx(np.sqrt(np.mean(np.square(values))), rel=1e-5)
    of_square = (
        t.ppf(0.975, 2) * np.std(np.square(values), ddof=1) / np.sqrt(3.0)
    )  # Student's interval of the mean square
    assert found["spread"][0, 1] == pytest.approx(
        0.5 * of_square / np.sqrt(np.mean(np.square(values))), rel=1e-4
    )
    counts = sum(np.sum(run.statistics.impacts_per_second) * 0.3 for run in runs)
    assert found["impacts"][0, 1] == pytest.approx(counts, abs=1e-3)
    few = found["impacts"] < 30.0
    assert np.all(found["doubtful"][few] == 1.0)
    assert found["case"]["run"]["duration"] == 0.05


def test_case_file__unchanged_text_is_kept() -> None:
    source = bundled_text("gearplay.model", "cases", "two-stage-reducer")
    changes = {
        "rotors.layshaft.gears.pinion.runout.phase": np.pi / 3.0,
        "meshes.1.damping.depth": 2e-6,
        "rotors.output.load.friction": 0.5,
    }
    text = edited(source, changes)
    new = [line for line in text.splitlines() if line not in source.splitlines()]
    assert set(new) == {
        'load = { torque = "50 N m", drag = "0.1 N m s/rad", friction = 0.5 }',
        'runout = { amplitude = "5 um", phase = "60 deg" }',
        "damping = { ratio = 0.05, depth = 2e-06 }",
    }
    wanted = replace(load_case("two-stage-reducer"), changes)
    found = load_case(parse_toml(text, "edited"))
    assert found.meshes == wanted.meshes
    assert found.rotors["output"].load == wanted.rotors["output"].load
    assert len(new) == 3


@pytest.mark.deep
def test_the_map_that_the_page_suggests_agrees_with_longer_ensembles() -> None:
    """Random cells of its ranges, 8 members of 5 s, against 16 others: within both 95 % intervals, or hatched."""
    rng = np.random.default_rng(22)
    case = load_case("han2021", ["run.sampling=20kHz", "run.transient=1s"])
    spans = ranges_of(case)
    apart, hatched = [], 0
    for _ in range(5):  # maps of 2 x 2 cells
        (a, b), (c, d) = (np.sort(rng.uniform(*spans[path], 2)).tolist() for path in (SPEED, CLEARANCE))
        words = {"columns": 2, "rows": 2, "measure": "rms", "of": "ring", "duration": 5.0, "transient": 1.0,
                 "first": {"path": SPEED, "low": a, "high": b}, "second": {"path": CLEARANCE, "low": c, "high": d}}  # fmt: skip
        ours, theirs = (
            unpack_frame(TASKS["map"]({**words, "case": each.resolved(), "members": members}, quiet, STOP))
            for each, members in ((case, 8), (replace(case, {"run.seed": 1}), 16))
        )
        doubt = ours["doubtful"] > 0.0
        hatched += int(np.count_nonzero(doubt))
        off = np.abs(ours["values"] - theirs["values"]) / (ours["spread"] + theirs["spread"])
        apart += off[~doubt].tolist()
    assert hatched < 10, "a map that is hatched everywhere says nothing"
    assert max(apart) < 1.0


def test_a_frame_that_was_changed_on_disk_is_not_shown(tmp_path: Path) -> None:
    """Every byte, cut and growth of a kept result: it counts as absent, and is computed again when it is asked for."""
    store, key = Store(tmp_path), 32 * "c"
    frame = pack_frame({"kind": "run", "title": "whole", "x": np.arange(20.0)})
    store.save(key, frame)
    file = tmp_path / f"{key}.frame"
    whole = file.read_bytes()
    assert store.load(key) == frame
    for at in range(len(whole)):
        file.write_bytes(whole[:at] + bytes([whole[at] ^ 4]) + whole[at + 1 :])
        assert store.load(key) is None
    for damaged in (whole[:-1], whole[:40], b"", whole + b"\0", frame):
        file.write_bytes(damaged)
        assert store.load(key) is None
        assert store.listed() == []
