"""`save` and `--out` write the format that their ending names, or refuse in one sentence."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import gearplay as gp
from gearplay.cli.main import run


@pytest.fixture(scope="module")
def result() -> gp.Result:
    return gp.simulate("han2021", duration=0.01, transient=0.0)


def test_csv_has_a_column_for_each_signal(result: gp.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "run.csv")
    record = gp.read_measurement(tmp_path / "run.csv")
    assert record.channel("ring.ax").unit == "m/s^2"
    np.testing.assert_array_equal(record.channel("ring.ax").values, result.signal("ax", "ring"))
    assert record.channel("ring.ax").sampling == pytest.approx(result.sampling)
    assert "share_of_time" in (tmp_path / "run.csv").read_text().split("\n")[1]


def test_mat_has_every_variable(result: gp.Result, tmp_path: Path) -> None:
    result.save(tmp_path / "run.mat")
    found = loadmat(tmp_path / "run.mat", simplify_cells=True)
    assert {str(name) for name in result.ds.variables} <= set(found)
    np.testing.assert_array_equal(found["ax"], result.ds["ax"].values)
    assert found["units"]["ax"] == "m/s^2"
    assert found["dimensions"]["ax"] == "time rotor"
    assert list(found["rotor"]) == [str(name) for name in result.ds["rotor"].values]


@pytest.mark.parametrize("name", ["run.xlsx", "run.txt", "run.h5"])
def test_other_endings_are_refused_before_anything_is_computed(
    name: str, result: gp.Result, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(gp.GearplayError, match=r"must end in \.nc, \.csv or \.mat"):
        result.save(tmp_path / name)
    assert run(["run", "han2021", "--out", str(tmp_path / name)]) == 2
    assert "must end in .nc, .csv or .mat" in " ".join(capsys.readouterr().err.split())
    assert not list(tmp_path.iterdir())


def test_a_diagram_is_a_table_too(tmp_path: Path) -> None:
    modes = gp.modes("lin-parker-1999")
    for ending in ("csv", "mat"):
        modes.save(tmp_path / f"modes.{ending}")
        assert (tmp_path / f"modes.{ending}").stat().st_size > 100


def test_tables_of_chosen_signals_have_these_alone(result: gp.Result, tmp_path: Path) -> None:
    """Other elements of their signals were columns of NaN in MAT, and statistics of contacts seven vectors without a word."""
    chosen = ["ring.ax", "pinion.omega"]
    result.save(tmp_path / "two.mat", signals=chosen)
    found = loadmat(tmp_path / "two.mat", simplify_cells=True)
    about = {"units", "dimensions", "attributes", "names"}
    assert {name for name in found if not name.startswith("__")} == {
        "time",
        "ring_ax",
        "pinion_omega",
    } | about
    np.testing.assert_array_equal(found["ring_ax"], result.signal("ax", "ring"))
    np.testing.assert_array_equal(found["pinion_omega"], result.signal("omega", "pinion"))
    assert found["units"]["ring_ax"] == "m/s^2"
    assert found["names"]["ring_ax"] == "ring.ax"
    assert found["dimensions"]["ring_ax"] == "time"
    result.save(tmp_path / "two.csv", signals=chosen)
    rows, head, *_ = (tmp_path / "two.csv").read_text().split("\n")
    assert (rows, head) == ("# rows = 1000", "time [s],ring.ax [m/s^2],pinion.omega [rad/s]")
    result.save(tmp_path / "low.mat", sampling=2e4)  # all of them, at another rate
    assert "share_of_time" in loadmat(tmp_path / "low.mat")


def test_mat_of_a_diagram_has_names_of_matlab(tmp_path: Path) -> None:
    found = gp.section("han2021", ["ring.x"], settle=1, keep=3, period="mesh")
    found.save(tmp_path / "section.mat")
    held = loadmat(tmp_path / "section.mat", simplify_cells=True)
    np.testing.assert_array_equal(held["ring_x"], found.ds["ring.x"].values)
