"""Every verb's answer: numbers, words, a picture, a file, and the same object back from that file."""

import io
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import gearplay as gp
from datasets.plans import FEW
from gearplay.results.provenance import KIND
from gearplay.sweeps.result import SweepResult
from life.pairs import wearing_pair
from machine_records import bearing_record

FORCE = "meshes.0.transmission_error.0.amplitude"
SHORT = {"run.duration": 0.1, "run.transient": 0.0}
RMS = {"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}


def pair() -> gp.Case:
    return gp.torsional_pair(0.7, force=0.05)


def some_calibration() -> Any:
    from gearplay.calibration.result import Calibration

    row = {
        "name": "clearance",
        "unit": "µm",
        "searched": [40.0, 250.0],
        "best": 8e-5,
        "low": 6e-5,
        "high": None,
    }
    fit = {
        "model": "coupled",
        "reading": "absolute",
        "parameters": [row, {**row, "name": "drag", "unit": "N m s/rad"}],
    }
    return Calibration({"title": "t", "answer": ["90 % intervals.", "Cannot be told."], "fits": [fit]})


MAKERS: dict[str, Callable[[], Any]] = {
    "run": lambda: gp.simulate("han2021", duration=0.05, transient=0.0, sampling=2e4),
    "ensemble": lambda: gp.simulate("han2021", duration=0.05, transient=0.0, sampling=2e4, ensemble=3),
    "sweep": lambda: gp.sweep("han2021", {"rotors.ring.initial.vx": [0.1, 0.2, 0.3]}, set=SHORT, reduce=[RMS]),
    "dataset": lambda: gp.make_dataset(FEW, tempfile.mkdtemp() + "/d"),
    "calibration": some_calibration,
    "bifurcation": lambda: gp.bifurcation(pair(), FORCE, [4e-6, 5e-6], ["wheel.theta"], settle=5, keep=3),
    "teeth": lambda: gp.teeth("han2021"),
    "wear": lambda: gp.wear(wearing_pair(), turns=1e6, blocks=1),
    "validation": lambda: gp.validate(),
    "portrait": lambda: gp.portrait("han2021", settle=2, keep=3, show=1),
    "section": lambda: gp.section("han2021", ["ring.x", "ring.vx"], keep=4, period="mesh"),
    "impacts": lambda: gp.impacts("han2021", ["ring.x"], "pinion-ring:drive", duration=0.5, transient=0.0),
    "exponents": lambda: gp.lyapunov(pair(), duration=0.2, transient=0.1),
    "motion": lambda: gp.motion(pair(), periods=120, settle=50, ensemble=4),
    "basins": lambda: gp.basins(pair(), ("wheel.theta", -1e-4, 1e-4, 2), ("wheel.omega", -0.1, 0.1, 3), settle=20),
    "orbit": lambda: gp.periodic_orbit(pair(), settle=300),
    "lost motion": lambda: gp.lost_motion("external-pair", at="output", hold="input", torque=5.0, positions=3, members=4),
    "describing function": lambda: gp.describing_function("external-pair", at="output", hold="input", torque=5.0),
    "reduction": lambda: gp.reduce("external-pair", at="output", hold="input", torque=5.0, members=4),
    "branch": lambda: gp.branch(pair(), FORCE, "4 um", "9 um", settle=300, orbits=4),
    "diagnosis": lambda: gp.diagnose(bearing_record(), bearings="9, 7.94mm, 39.04mm", speed="1797 rpm"),
    "branches": lambda: gp.branches(pair(), FORCE, "4.5 um", "5.5 um", doublings=0, orbits=6),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", MAKERS)
def test_an_answer_comes_back_from_its_file_and_draws_itself(kind: str, tmp_path: Path) -> None:
    """What it draws is not blank: some pixels inside are neither white nor grey."""
    answer = MAKERS[kind]()
    assert isinstance(answer.ds, xr.Dataset)
    assert isinstance(answer.message, str)
    assert answer.message
    for name, variable in answer.ds.data_vars.items():
        assert variable.attrs.get("long_name"), f"{name} says nothing"
    path = tmp_path / "answer.nc"
    answer.save(path)
    with pytest.raises(gp.InputError, match="must not exist yet"):
        answer.save(path)
    again = gp.read_result(path)
    assert type(again) is type(answer)
    assert again.ds.drop_attrs(deep=False).identical(answer.ds.drop_attrs(deep=False))
    assert {*again.ds.attrs, KIND} == {*answer.ds.attrs, KIND}
    assert again.message == answer.message
    assert again._repr_html_() == answer._repr_html_()
    assert "<" in again._repr_html_()
    assert repr(again) == repr(answer)
    drawn = answer.plot()
    if hasattr(drawn, "png"):
        png = drawn.png
    else:
        buffer = io.BytesIO()
        getattr(drawn, "figure", drawn).savefig(buffer, format="png")
        png = buffer.getvalue()
    from matplotlib.image import imread

    pixels = imread(io.BytesIO(png))[..., :3]
    blue = (np.ptp(pixels, axis=-1) > 0.15).sum()
    if kind in ("branch", "branches"):  # black lines
        assert drawn.get_lines()
        assert all(np.isfinite(line.get_ydata()).all() for line in drawn.get_lines())
    else:
        assert blue > 20
    for ax in getattr(getattr(drawn, "figure", drawn), "axes", []):
        if ax.get_visible() and kind != "calibration":
            assert ax.get_xlabel() or ax.get_ylabel()


def test_a_record_has_what_an_answer_has(tmp_path: Path) -> None:
    record = gp.measure("han2021", duration=0.05, transient=0.0)
    assert dict(record.ds.sizes) == {"time": record.channels[0].values.size}
    assert record.ds["sensor.voltage"].attrs["units"] == "V"
    assert record.plot().get_ylabel()
    for name in ("record.h5", "record.csv", "record.nc"):
        record.save(tmp_path / name)
        again = gp.read_result(tmp_path / name)
        np.testing.assert_allclose(
            again.channel("sensor.voltage").values, record.channel("sensor.voltage").values
        )
    assert "4 channels" in record.message


def test_what_is_no_answer_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.nc"
    xr.Dataset({"a": ("x", [1.0, 2.0])}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(gp.InputError, match="must be a file of a saved result"):
        gp.read_result(path)
    with pytest.raises(
        gp.InputError, match=r"must be a readable result file \(there is no such file\)\. Check"
    ):
        gp.read_result(tmp_path / "none.nc")
    case = tmp_path / "case.toml"
    case.write_text("[rotors]\n")
    with pytest.raises(gp.InputError, match="must be a result, and this is a TOML file"):
        gp.read_result(case)
    other = tmp_path / "text.nc"
    other.write_text("no result")
    with pytest.raises(gp.InputError, match=r"\(it is no HDF5 file\)"):
        gp.read_result(other)
    result = gp.simulate("han2021", **{"duration": 0.001, "transient": 0.0})
    whole = tmp_path / "whole.nc"
    result.save(whole)
    size = whole.stat().st_size
    whole.write_bytes(whole.read_bytes()[: size // 2])
    with pytest.raises(gp.InputError, match=rf"\(it is cut off: {size // 2} of \d+ bytes are there\)"):
        gp.read_result(whole)
    with pytest.raises(gp.InputError, match="must be that of a sweep"):
        SweepResult.from_dataset(result.ds.assign_attrs({KIND: "run"}))
