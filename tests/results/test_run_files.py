"""A file of a run keeps its motion: every signal read back is that of the result, bit for bit; samples are for other programs."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import gearplay as gp
from gearplay.cli.main import run as command
from gearplay.files import netcdf_streams
from gearplay.results import run_files
from gearplay.solver import checkpoints, stored_motion
from gearplay.solver.checkpoints import states
from gearplay.solver.kept_samples import KeptSamples
from gearplay.solver.status import Status

SHORT = {"run.duration": 0.05, "run.transient": 0.01}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "sleeve": ("han2021", {**SHORT, "run.duration": 0.6}),
    "planets": ("planetary-reducer", SHORT),
    "two stages": ("two-stage-reducer", SHORT),
    "implicit steps": ("lin-parker-1999", {"run.duration": 0.02, "run.transient": 0.0}),
    "joined rotors": ("torsional-train", SHORT),
    "housing": ("space-launch", SHORT),
    "equal steps": ("han2021", {**SHORT, "run.fixed_step": 1e-6, "run.duration": 3e-3}),
    "contacts by stage": (
        "pinion-idler-ring",
        {
            "run.fixed_step": 1e-6,
            "run.fixed_step_contacts": "stage",
            "run.duration": 3e-3,
            "run.transient": 0.0,
        },
    ),
    "ensemble": ("han2021", {**SHORT, "run.ensemble": 3}),
    "ensemble that stops": ("pinion-idler-ring", {**SHORT, "run.ensemble": 3, "run.max_steps": 1200}),
    "stopped": ("pinion-idler-ring", {"run.duration": 0.05, "run.transient": 0.0, "run.max_steps": 700}),
    "stopped in the transient": (
        "han2021",
        {"run.transient": 5.0, "run.duration": 0.1, "run.max_steps": 300},
    ),
}


def result_of(name: str) -> gp.Result:
    case, changes = CASES[name]
    return gp.simulate(gp.replace(gp.load_case(case), changes))


@pytest.fixture
def many_checkpoints(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkpoints, "FEWEST_SAMPLES", 50)
    monkeypatch.setattr(checkpoints, "SHORTEST", 20)


@pytest.mark.parametrize("name", CASES)
def test_run_file__is_read_back_bit_for_bit(name: str, many_checkpoints: None, tmp_path: Path) -> None:
    result = result_of(name)
    result.save(tmp_path / "run.nc")
    again = gp.read_result(tmp_path / "run.nc")
    assert again.case == result.case
    assert again.ds.identical(result.ds)
    assert (again.message, again.statuses, repr(again)) == (result.message, result.statuses, repr(result))
    for read, run in zip(again.runs, result.runs, strict=True):
        assert (read.counters, read.wedged, read.left_mesh) == (run.counters, run.wedged, run.left_mesh)
        assert (read.member, read.reached, read.wall_time) == (run.member, run.reached, run.wall_time)
        np.testing.assert_array_equal(read.log, run.log)
        np.testing.assert_array_equal(read.final_state, run.final_state)
        for name, values in run.end._asdict().items():
            np.testing.assert_array_equal(getattr(read.end, name), values)
    span = result.case.run
    window = (0.4 * (span.transient + span.duration), 0.6 * (span.transient + span.duration))
    if result.success:
        signal = f"{list(result.case.rotors)[-1]}.omega"
        for member in range(result.members):
            own = again.signal(signal, member=member, sampling=3e5, window=window)
            assert np.array_equal(own, result.signal(signal, member=member, sampling=3e5, window=window))
            assert own.size > 100


def test_a_member_has_the_record_of_its_own_housing(tmp_path: Path) -> None:
    base = {"acceleration": {"kind": "spectral-density", "density": [[10.0, 0.5], [500.0, 0.5]]}}
    case = gp.replace(gp.load_case("han2021"), {**SHORT, "base": base, "run.ensemble": 2})
    result = gp.simulate(case)
    result.save(tmp_path / "run.nc")
    again = gp.read_result(tmp_path / "run.nc")
    assert again.ds.identical(result.ds)
    assert not np.array_equal(result.signal("ring.ax"), result.signal("ring.ax", member=1))
    np.testing.assert_array_equal(
        again.runs[1].mean_acceleration("ring"), result.runs[1].mean_acceleration("ring")
    )


@pytest.mark.parametrize("name", CASES)
def test_checkpoint__index_lists_follow_from_its_states(name: str, many_checkpoints: None) -> None:
    """Those that the integration itself has filled, against those made of the stored states."""
    samples = result_of(name).runs[0].samples
    assert isinstance(samples, KeptSamples)
    motion = samples.motion
    counts, integers, floats = stored_motion.tables_of([motion])
    made = stored_motion.motion_of(
        motion.case, motion.packed, motion.ends, motion.reached, integers, floats, "x"
    )
    assert counts == [len(made.marks)]
    assert len(made.marks) > 1
    names = list(states(stored_motion._course(motion).run))
    stride = -(-len(motion.marks) // counts[0])
    for own, mark in zip(made.marks, motion.marks[::stride], strict=True):
        arrays, found = (dict(zip(names, each.arrays, strict=True)) for each in (mark, own))
        for key in stored_motion.LISTS:
            length = arrays[key][0]
            assert found[key][: length + 1].tolist() == arrays[key][: length + 1].tolist(), key
        for key in stored_motion._stored(arrays, "f"):
            if key != "clock":
                assert found[key].tobytes() == arrays[key].tobytes()


def test_run_file__takes_less_than_10_kb_per_simulated_second(tmp_path: Path) -> None:
    result = gp.simulate("han2021", duration=50.0)
    result.save(tmp_path / "run.nc")
    assert (tmp_path / "run.nc").stat().st_size < 10e3 * 50.0


def test_plain_samples_are_those_of_the_record(tmp_path: Path) -> None:
    """Any reader of netCDF finds all signals, thinned: each is a sample of the record."""
    result = gp.simulate("two-stage-reducer", duration=0.3, transient=0.1)
    result.save(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as plain:
        stride = round(float(plain.time[1] - plain.time[0]) * result.sampling)
        assert stride > 1
        assert plain.attrs["Conventions"].startswith("CF")
        assert set(plain.data_vars) >= set(result.ds.data_vars)
        for name in result.ds.data_vars:
            assert plain[name].attrs["units" if name != "contact_state" else "long_name"]
            if "time" in plain[name].dims and plain[name].dtype.kind == "f":
                record = result.ds[name].values[::stride][: plain.sizes["time"]]
                scale = np.nanmax(np.abs(record), initial=1e-30)
                assert np.nanmedian(np.abs(plain[name].values - record)) < 1e-9 * scale


def test_requested_samples_are_stored(tmp_path: Path) -> None:
    result = gp.simulate("han2021", duration=0.05, transient=0.0)
    result.save(tmp_path / "some.nc", signals=["ring.ax", "backlash"], sampling=2e4)
    with xr.open_dataset(tmp_path / "some.nc", engine="h5netcdf") as plain:
        assert {name for name in plain.data_vars if "time" in plain[name].dims} == {"ax", "backlash"}
        expected = result.signal("ring.ax", sampling=2e4)
        np.testing.assert_array_equal(plain["ax"].sel(rotor="ring").values, expected)
        assert np.isnan(plain["ax"].sel(rotor="pinion").values).all()
    assert gp.read_result(tmp_path / "some.nc").ds.identical(result.ds)
    result.save(tmp_path / "none.nc", signals=[])
    assert gp.read_result(tmp_path / "none.nc").ds.identical(result.ds)
    kept = gp.simulate("han2021", duration=0.05, transient=0.0, signals=["ring.ax"])
    kept.save(tmp_path / "kept.nc")
    assert gp.read_result(tmp_path / "kept.nc").ds.identical(kept.ds)
    with xr.open_dataset(tmp_path / "kept.nc", engine="h5netcdf") as plain:
        assert plain.sizes["time"] == 5000
    for wrong, words in (
        ({"signals": ["ring.zx"]}, "signals = .*must be a signal of this case"),
        ({"sampling": -1.0}, r"sampling = -1.*must be positive"),
        ({"full": True, "signals": ["ax"]}, "full = .*must be left out"),
    ):
        with pytest.raises(gp.InputError, match=words):
            result.save(tmp_path / "wrong.nc", **wrong)
    assert not (tmp_path / "wrong.nc").exists()


@pytest.mark.parametrize(
    "name", ["sleeve", "planets", "ensemble", "ensemble that stops", "stopped", "housing"]
)
def test_full_run_file__equals_the_dataset(
    name: str, many_checkpoints: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Written block by block, in a file on the disk, compressed."""
    monkeypatch.setattr(netcdf_streams, "CHUNK", 257)
    monkeypatch.setattr(run_files, "CHUNK", 257)
    monkeypatch.setattr(netcdf_streams, "IN_MEMORY", 0.0)
    result = result_of(name)
    result.save(tmp_path / "full.nc", full=True)
    assert gp.read_result(tmp_path / "full.nc").ds.identical(result.ds)
    with xr.open_dataset(tmp_path / "full.nc", engine="h5netcdf") as full:
        for key, variable in {**result.ds.data_vars, **result.ds.coords}.items():
            assert full[key].dims == variable.dims
            np.testing.assert_array_equal(full[key].values, variable.values)
            assert full[key].attrs.get("units") == variable.attrs.get("units")


@pytest.mark.slow
def test_export_writes_all_signals(tmp_path: Path) -> None:
    result = gp.simulate("external-pair", duration=0.02, transient=0.01)
    result.save(tmp_path / "run.nc")
    words = ["export", str(tmp_path / "run.nc"), "--out"]
    assert command([*words, str(tmp_path / "full.nc")]) == 0
    with xr.open_dataset(tmp_path / "full.nc", engine="h5netcdf") as full:
        np.testing.assert_array_equal(full["omega"].values, result.ds["omega"].values)
    assert command([*words, str(tmp_path / "full.nc")]) == 2
    assert command([*words, str(tmp_path / "full.txt")]) == 2
    assert (
        command([*words, str(tmp_path / "some.csv"), "--signal", "output.omega", "--sampling", "2kHz"]) == 0
    )
    record = gp.read_measurement(tmp_path / "some.csv")
    np.testing.assert_array_equal(
        record.channel("output.omega").values, result.signal("output.omega", sampling=2e3)
    )


LEAN = """
import sys
import gearplay as gp
def peak():
    return next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM"))
result = gp.simulate("han2021", duration=12.0, transient=0.0)
result.save("run.nc")
assert not {"xarray", "matplotlib", "h5netcdf"} & set(sys.modules), "too much is imported"
assert gp.read_result("run.nc").signal("ring.ax", window=(0.0, 0.1)).size == 10_000
assert not {"xarray", "matplotlib"} & set(sys.modules), "too much is imported"
before = peak()
result.save("full.nc", full=True)
print(before, peak())
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory is counted in kB on Linux")
def test_all_signals_are_written_in_little_memory(tmp_path: Path) -> None:
    """355 MB of numbers [kB]; saving the motion needs neither xarray nor matplotlib."""
    done = subprocess.run(
        [sys.executable, "-c", LEAN], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    before, peak = map(int, done.stdout.split())
    assert peak < 300e3
    assert peak - before < 60e3


class TestOtherKernels:
    """A file whose motion these kernels cannot replay: its samples are read, nothing else, and one sentence says so."""

    @pytest.fixture
    def read(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> gp.Result:
        gp.simulate("han2021", duration=0.2, transient=0.1).save(tmp_path / "run.nc")
        for module in (run_files, stored_motion):
            monkeypatch.setattr(module, "kernels_digest", lambda: "f" * 64)
        found: gp.Result = gp.read_result(tmp_path / "run.nc")
        return found

    def test_samples_are_readable(self, read: gp.Result) -> None:
        result = gp.simulate("han2021", duration=0.2, transient=0.1)
        stride = round(result.sampling / read.sampling)
        assert stride > 10
        assert read.success
        assert set(read.held()) == set(result.held())
        own, record = read.signal("ring.x"), result.signal("ring.x")[::stride]
        np.testing.assert_allclose(own[:20], record[:20], rtol=1e-9)
        assert read.ds["x"].sizes["time"] == own.size
        np.testing.assert_array_equal(read.runs[0].log, result.runs[0].log)
        for name, values in result.contacts.values.items():
            np.testing.assert_array_equal(read.contacts.values[name], values)
        assert f"37 signals at {read.sampling:g} Hz are stored" in read.message
        assert len(read.message.splitlines()) == 1

    def test_other_signals_and_rates_are_refused(self, read: gp.Result, tmp_path: Path) -> None:
        for ask in ({"sampling": 1e6}, {"window": (0.1, 0.2)}):
            with pytest.raises(gp.InputError, match=r"these kernels cannot replay.*gearplay export"):
                read.signal("ring.x", **ask)
        read.save(tmp_path / "part.nc", signals=["ring.ax"])
        part = gp.read_result(tmp_path / "part.nc")
        np.testing.assert_array_equal(part.signal("ring.ax"), read.signal("ring.ax"))

    def test_a_signal_that_was_not_stored_is_refused(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        result = gp.simulate("han2021", duration=0.02, transient=0.0)
        result.save(tmp_path / "run.nc", signals=["ring.ax"])
        monkeypatch.setattr(run_files, "kernels_digest", lambda: "f" * 64)
        read = gp.read_result(tmp_path / "run.nc")
        np.testing.assert_array_equal(read.signal("ring.ax"), result.signal("ring.ax"))
        words = r"signal = \"ring\.vx\": must be one of those stored: .*Simulate its case again, or run gearplay export"
        with pytest.raises(gp.InputError, match=words) as caught:
            read.signal("ring.vx")
        assert len(str(caught.value).splitlines()) == 1


def test_a_case_changed_afterwards_is_refused(tmp_path: Path) -> None:
    import h5py

    gp.simulate("han2021", duration=0.01, transient=0.0).save(tmp_path / "run.nc")
    with h5py.File(tmp_path / "run.nc", "r+") as file:
        file.attrs["case"] = file.attrs["case"].replace("0.8", "0.9")
    with pytest.raises(gp.InputError, match="must be a readable result file"):
        gp.read_result(tmp_path / "run.nc")


def test_an_interrupted_run_keeps_its_status(tmp_path: Path) -> None:
    import dataclasses

    result = gp.simulate("han2021", duration=0.05, transient=0.0)
    result = gp.Result(result.case, [dataclasses.replace(result.runs[0], status=Status.INTERRUPTED)])
    result.save(tmp_path / "run.nc", signals=[])
    again = gp.read_result(tmp_path / "run.nc")
    assert not again.success
    assert again.status == Status.INTERRUPTED
