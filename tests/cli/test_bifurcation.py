"""`gearplay bifurcation` and the nonlinear functions of `gp` as a user meets them."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import gearplay as gp
from gearplay.cli.main import run
from gearplay.model.reading import to_toml

SPEED = "rotors.pinion.drive.speed"
SHORT = ["--low", "110rpm", "--high", "130rpm", "--count", "3", "--settle", "3", "--keep", "4"]


@pytest.mark.slow
def test_a_diagram_is_written_with_its_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bifurcation", "han2021", SPEED, *SHORT, "--signal", "ring.x", "--out", str(tmp_path)]
    assert run([*words, "--signal", "backlash", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["values"], document["failed"]) == (3, 0)
    assert (tmp_path / "bifurcation.png").read_bytes().startswith(b"\x89PNG")
    with xr.open_dataset(tmp_path / "bifurcation.nc", engine="h5netcdf") as found:
        assert dict(found.sizes) == {"direction": 2, "speed": 3, "section": 4}
        assert found["ring.x"].attrs["units"] == "m"
        assert found["pinion-ring.backlash"].attrs["units"] == "m"
        assert found.speed.values == pytest.approx(np.array([110.0, 120.0, 130.0]) * math.pi / 30.0)
        assert found.speed.attrs["units"] == "rad/s"
        assert bool(found["ring.x"].notnull().all())
    assert run(words) == 2
    assert "must not exist yet" in capsys.readouterr().err
    assert run([*words, "--overwrite", "--no-carry", "--period", "0.01"]) == 0
    assert "up and down; 6 cases: 6 finished, 0 failed" in capsys.readouterr().out


@pytest.mark.slow
def test_branches_are_drawn_with_the_sweeps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "pair.toml", tmp_path / "out"
    file.write_text(
        to_toml(gp.torsional_pair(0.6, mean_force=0.1, force=0.15, damping_ratio=0.1)), encoding="utf-8"
    )
    words = ["bifurcation", str(file), "meshes.0.transmission_error.0.amplitude", "--signal", "wheel.theta"]
    words += ["--count", "3", "--keep", "2", "--settle", "200", "--out", str(out), "--branches"]
    assert run([*words, "--low", "21um", "--high", "24um", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    one, two = document["branches"]
    assert (one["order"], two["order"]) == (1, 2)
    assert [s["kind"] for s in one["special"]] == ["period doubling"]
    with xr.open_dataset(out / "branches.nc", engine="h5netcdf") as table:
        assert table.sizes["orbit"] == one["orbits"] + two["orbits"]
        assert table.amplitude.attrs["units"] == "m"
    assert run([*words, "--low", "16um", "--high", "17um", "--order", "2", "--overwrite"]) == 4
    assert "no periodic orbit of order 2" in capsys.readouterr().out


@pytest.mark.slow
def test_bifurcation__a_failed_value_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "--low",
        "10um",
        "--high",
        "50mm",
        "--count",
        "2",
        "--settle",
        "1",
        "--keep",
        "1",
        "--out",
        str(tmp_path),
    ]
    assert run(["bifurcation", "han2021", "meshes.0.backlash", "--signal", "ring.x", *words]) == 2
    assert "--high: meshes.0.backlash" in capsys.readouterr().err
    words[3] = "2.9mm"
    teeth = ["bifurcation", "han2021", "sleeves.ring.radial_clearance", "--signal", "ring.x", *words]
    assert run([*teeth, "--overwrite"]) == 0
    told = capsys.readouterr().out
    assert "down at 1e-05 m: began anew, from the state of the value before:" in told
    assert run([*teeth, "--overwrite", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["not_carried"]) == 1


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ([SPEED.replace("speed", "sped"), *SHORT], "Did you mean 'speed'?"),
        ([SPEED, "--low", "60rpm", "--high", "60um"], "--high: rotors.pinion.drive.speed"),
        ([SPEED, "--low", "60rpm", "--high", "50rpm"], '--high = "50rpm": must be above --low'),
        ([SPEED, *SHORT, "--period", "tooth"], 'period = "tooth"'),
        ([SPEED, *SHORT, "--signal", "ring.ax"], "must follow from the state alone"),
        ([SPEED, *SHORT, "--signal", "ring.z"], "must be a signal of this case"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["bifurcation", "han2021", *words, "--signal", "ring.x", "--out", str(tmp_path / "out")]) == 2
    complaint = capsys.readouterr().err
    assert told in complaint
    assert complaint.count("\n") == 1
    assert not (tmp_path / "out").exists()
