"""`gearplay load-sharing`: factors of a case with a pin error and of a stored motion, as the function returns them."""

import json
from pathlib import Path

import numpy as np
import pytest

import gearplay as gp
from gearplay.cli.main import run

ERROR = 'planetary.stage.pin_errors=[{planet=1, tangential="30 um"}]'
FIXED_SUN = "planetary.stage.sun.floating=false"


def test_load_sharing__of_a_case(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The picture and the file are written; factors add up to the number of planets, the advanced planet carries most."""
    words = ["load-sharing", "planetary-reducer", "--set", ERROR, "--set", FIXED_SUN, "--out", str(tmp_path)]
    assert run([*words, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    factors = document["load_sharing_factor"]
    assert sum(factors.values()) == pytest.approx(3.0, abs=1e-9)
    expected = gp.load_sharing(gp.load_case("planetary-reducer", [ERROR, FIXED_SUN])).ds
    np.testing.assert_allclose(list(factors.values()), expected["load_sharing_factor"].values, rtol=1e-9)
    assert max(factors, key=lambda planet: abs(factors[planet] - 1.0)) == "stage.planet1"
    assert gp.read_result(document["out"]).ds.attrs["set"] == "stage"
    assert Path(document["picture"]).stat().st_size > 10_000
    assert run(words) == 2  # they are there
    assert "overwrite" in capsys.readouterr().err
    assert run([*words, "--overwrite"]) == 0
    assert "stage.planet1" in capsys.readouterr().out


def test_load_sharing__of_a_stored_motion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gp.simulate("planetary-reducer", duration=0.01).save(tmp_path / "run.nc")
    assert run(["load-sharing", str(tmp_path / "run.nc"), "--out", str(tmp_path / "s"), "--json"]) == 0
    factors = json.loads(capsys.readouterr().out)["load_sharing_factor"]
    assert sum(factors.values()) == pytest.approx(3.0, abs=0.05)
    assert run(["load-sharing", str(tmp_path / "run.nc"), "--set", ERROR, "--out", str(tmp_path / "t")]) == 2
    assert "--set" in capsys.readouterr().err
    assert run(["load-sharing", str(tmp_path / "s" / "load-sharing.nc"), "--out", str(tmp_path / "t")]) == 2
    assert "must be a result of gearplay run" in capsys.readouterr().err
