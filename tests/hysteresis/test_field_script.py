"""The script for measured files of an RV reducer, on files of the same form with known numbers."""

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

SCRIPT = Path(__file__).parents[1] / "field" / "rv_reducer.py"
WIDTHS = {0.0: 0.0045, 300.0: 0.0309, 800.0: 0.0667, 1600.0: 0.1217}


@pytest.fixture(scope="module")
def script() -> Any:
    spec = importlib.util.spec_from_file_location("rv_reducer", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def write(folder: Path, widths: dict[float, float]) -> Path:
    """Write files as measured: a ripple over the output's turn, and a last row without numbers."""
    rng = np.random.default_rng(1)
    place = np.arange(0.0, 360.0, 0.05)
    ripple = 0.003 * np.sin(np.radians(40.0 * place))
    for torque, width in widths.items():
        rows = ["Input Position,Output Poisition,Transmission Error Forward,Transmission Error Backward"]
        for at, each, noise in zip(place, ripple, 1e-4 * rng.standard_normal((place.size, 2)), strict=True):
            rows.append(
                f"{81 * at:.3f},{at:.3f},{each - width / 2 + noise[0]:.6f},{each + width / 2 + noise[1]:.6f}"
            )
        rows += ["nan,nan,nan,nan", ",,,"]
        (folder / f"1100.0rpm{torque}Nm25.0deg.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    return folder


def test_field_script__finds_what_the_files_hold(script: Any, tmp_path: Path, capsys: Any) -> None:
    assert script.main([str(write(tmp_path, WIDTHS))]) == 0
    said = capsys.readouterr().out
    assert "1600 N m: 0.12" in said
    assert "7.3" in said  # arcmin at 1600 N m
    slopes = {"0 to 300": 379, "300 to 800": 466, "800 to 1600": 485}
    for torques, stiffness in slopes.items():
        (line,) = [each for each in said.splitlines() if f"{torques} N m:" in each]
        assert float(line.split()[-3]) == pytest.approx(stiffness, rel=0.03)
    (lost,) = [each for each in said.splitlines() if "arcmin of lost motion" in each]
    assert float(lost.split()[0]) == pytest.approx(60.0 * (0.0045 + 16.0 / 268.0 * 0.0264), rel=0.1)


def test_field_script__says_where_the_files_are_others(script: Any, tmp_path: Path, capsys: Any) -> None:
    assert script.main([str(write(tmp_path, WIDTHS | {800.0: 0.08}))]) == 1
    assert capsys.readouterr().out.count("OFF") == 1


def test_field_script__needs_files_and_columns(script: Any, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="must have files of three torques"):
        script.main([str(tmp_path)])
    for torque in (0.0, 300.0, 800.0):
        (tmp_path / f"1100.0rpm{torque}Nm25.0deg.csv").write_text("a,b,c\n1,2,3\n", encoding="utf-8")
    with pytest.raises(SystemExit, match="Name them by --columns"):
        script.main([str(tmp_path)])
