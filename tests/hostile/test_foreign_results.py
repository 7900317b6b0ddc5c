"""Results of other programs or other cases: one sentence each, and nothing of them is written anew."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import gearplay as gp

Change = Callable[[xr.Dataset], xr.Dataset]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    place = tmp_path_factory.mktemp("sound") / "run.nc"
    gp.simulate("han2021", duration=0.02, transient=0.0).save(place)
    dataset = gp.read_result(place).ds.load()  # once, since a copy of lazy variables computes them again
    dataset.attrs["gearplay_kind"] = "run"
    return dataset


def other_times(change: Callable[[np.ndarray], np.ndarray]) -> Change:
    return lambda dataset: dataset.assign_coords(time=change(dataset["time"].values.copy()))


def late(times: np.ndarray) -> np.ndarray:
    times[5:] += 0.01
    return times


def with_nan(dataset: xr.Dataset) -> xr.Dataset:
    dataset["x"].values[10] = np.nan
    return dataset


def other_case(dataset: xr.Dataset) -> xr.Dataset:
    case = json.loads(dataset.attrs["case"])
    case["rotors"]["ring"]["mass"] = 5.0
    return dataset.assign_attrs(case=json.dumps(case))


CHANGES: dict[str, tuple[Change, str]] = {
    "gap": (other_times(late), r"time = .*: must be evenly spaced, and is 0\.0\d+ s off"),
    "not-a-time": (other_times(lambda t: np.where(t > 0.01, np.nan, t)), "time = .*must be finite"),
    "reversed": (
        lambda ds: ds.isel(time=slice(None, None, -1)),
        "must rise from sample to sample, and does not at sample 2",
    ),
    "nan": (with_nan, r"x = .*1 samples are not \(the first at sample 11\)"),
    "status": (lambda ds: ds.assign_attrs(status="FINE"), 'status = "FINE": must be one of DONE'),
    "case": (other_case, "case_sha256 = .*: must be the digest of the case in the file"),
    "names": (lambda ds: ds.assign_coords(rotor=["pinion", "<script>"]), "must be a rotor of the case"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CHANGES)
def test_a_run_that_contradicts_itself_is_one_sentence(name: str, sound: xr.Dataset, tmp_path: Path) -> None:
    change, words = CHANGES[name]
    place = tmp_path / "foreign.nc"
    change(sound.copy(deep=True)).to_netcdf(place, engine="h5netcdf")
    with pytest.raises(gp.GearplayError, match=words):
        gp.read_result(place)
    assert [each.name for each in tmp_path.iterdir()] == ["foreign.nc"]


@pytest.mark.slow
def test_the_run_itself_is_read_without_its_seal(sound: xr.Dataset, tmp_path: Path) -> None:
    sound.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    found = gp.read_result(tmp_path / "run.nc")
    assert found.success
    np.testing.assert_array_equal(found.ds["x"].values, sound["x"].values)


@pytest.mark.slow
def test_a_member_that_was_cut_short_may_end_in_nan(sound: xr.Dataset, tmp_path: Path) -> None:
    short = sound.copy(deep=True).assign_attrs(status="INTERRUPTED")
    for name, variable in short.data_vars.items():
        if "time" in variable.dims and variable.dtype.kind == "f":
            short[name].values[-5:] = np.nan
    short.to_netcdf(tmp_path / "short.nc", engine="h5netcdf")
    assert not gp.read_result(tmp_path / "short.nc").success
