"""`gearplay portrait` and `gp.portrait`: orbits and phase portraits of a settled motion."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import gearplay as gp
from gearplay.cli.main import run

BRIEF = ["--settle", "20", "--keep", "30", "--show", "4"]


@pytest.mark.slow
def test_a_portrait_is_written_with_its_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["portrait", "han2021", *BRIEF, "--out", str(tmp_path)]
    assert run([*words, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["sections"] == 30
    assert document["period"] == pytest.approx(0.025)
    assert (tmp_path / "portrait.png").read_bytes().startswith(b"\x89PNG")
    with xr.open_dataset(tmp_path / "portrait.nc", engine="h5netcdf") as found:
        assert found.sizes["path_time"] == 4 * 200 + 1
        assert found["path.ring.vx"].attrs["units"] == "m/s"
        assert "path.pinion.x" not in found  # rigidly centred
        assert found.sizes["onset_time"] == document["onsets"] > 0
    assert run(words) == 2
    assert "must not exist yet" in capsys.readouterr().err
    assert run([*words, "--overwrite", "--rotor", "ring"]) == 0
    assert "30 sections, one per 0.025 s" in capsys.readouterr().out


def test_path_section_and_onsets_are_of_one_motion() -> None:
    found = gp.portrait("han2021", settle=20, keep=8, show=8, period="mesh", member=0).ds
    every = {f"ring.{name}" for name in ("x", "y", "theta", "vx", "vy", "omega")}
    assert {str(name)[5:] for name in found.data_vars if str(name).startswith("path.")} == every
    for signal in every:
        np.testing.assert_allclose(
            found[f"path.{signal}"].values[: 8 * 200 : 200],
            found[f"section.{signal}"].values,
            rtol=0.0,
            atol=1e-9,
        )
    times = found.onset_time.values
    assert np.all(np.diff(times) >= 0.0)
    assert np.all((times >= 0.5) & (times <= 0.7))
    sleeve = found.contact.values == "ring"
    distance = np.hypot(found["onset.ring.x"].values, found["onset.ring.y"].values)
    assert distance[sleeve] == pytest.approx(np.full(sleeve.sum(), 100e-6), rel=1e-6)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["portrait", "han2021", "--rotor", "rong"], 'rotor = "rong": must be a rotor of the case. Choose from: pinion, ring'),
        (["portrait", "han2021", "--keep", "0"], "keep = 0: must be a whole number, 1 or more"),
        (["portrait", "pinion-idler-ring"], "drive.ramp to 0 s"),
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*words, "--out", str(tmp_path)]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_portrait__a_rotor_that_cannot_move_is_refused() -> None:
    fixed = {
        "rotors": {
            name: {"teeth": 20, "mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": speed}}
            for name, speed in (("a", 10.0),)
        },
        "run": {"duration": 1.0},
    }
    with pytest.raises(gp.InputError, match=r"rotors = .*must leave a rotor free"):
        gp.portrait(fixed, period=0.1)
