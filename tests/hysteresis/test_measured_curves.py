"""Measured hysteresis curves: play, stages and friction with intervals, from synthetic branches with noise."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gearplay as gp
from depth import sized
from hysteresis_curves import Truth, record

ARCMIN = 180.0 * 60.0 / np.pi
COLUMNS = ["Torque [N m]", "Output Poisition [arcmin]"]
GIVEN: dict[str, Any] = {"columns": COLUMNS, "torque": 100.0, "stages": [14.0, 48.0]}


def covered(ds: Any, truth: Truth) -> NDArray[np.bool_]:
    """Return whether play, K1, K2, K3 and friction lie in their intervals."""
    low, high = np.concatenate(
        [[ds["play_interval"].values], ds["stiffness_interval"].values, [ds["friction_interval"].values]]
    ).T
    values = np.array([truth.play, *truth.stages, truth.friction])
    return (low <= values) & (values <= high)


@pytest.mark.slow
def test_intervals_hold_the_truth_in_95_of_100(tmp_path: Path) -> None:
    """1 % noise of the rotation's amplitude: each number in 95 of 100 records or more, and narrow enough to be of use."""
    hits, widths, count = np.zeros(5), [], sized(100, 40)
    for seed in range(count):
        path = record(tmp_path / f"{seed}.csv", Truth(), noise=0.01, seed=seed)
        ds = gp.lost_motion(path, **GIVEN).ds
        hits += covered(ds, Truth())
        low, high = ds["stiffness_interval"].values.T
        widths.append((high - low) / np.array(Truth().stages))
    assert np.all(hits >= 0.95 * count), hits
    assert np.all(np.mean(widths, axis=0) < [0.1, 0.03, 0.03])


@pytest.mark.parametrize("friction", [0.0, 0.5, 8.0])
@pytest.mark.parametrize("noise", [1e-9, 1e-3])
def test_numbers_of_a_clean_record(friction: float, noise: float, tmp_path: Path) -> None:
    truth = Truth(friction=friction)
    found = gp.lost_motion(record(tmp_path / "r.csv", truth, noise=noise), **GIVEN)
    ds, rel = found.ds, 20.0 * noise + 1e-6
    assert float(ds["play"]) == pytest.approx(truth.play, rel=rel)
    np.testing.assert_allclose(ds["stiffness"].values, truth.stages, rtol=rel)
    assert float(ds["friction"]) == pytest.approx(friction, abs=100.0 * rel)
    exact = gp.lost_motion(truth.case(), at="arm", hold="motor", torque=100.0, stages=[14.0, 48.0]).ds
    for name in ("lost_motion", "backlash", "hysteresis_loss", "torsional_stiffness"):
        assert float(ds[name]) == pytest.approx(float(exact[name]), rel=rel, abs=10.0 * rel)
    assert ds.sizes["sample"] == 800
    assert "measured" not in found.message


def test_noise_of_the_torque_is_allowed_for(tmp_path: Path) -> None:
    hits = np.zeros(5)
    for seed in range(20):
        path = record(tmp_path / "r.csv", Truth(), noise=0.01, torque_noise=0.01, seed=seed)
        hits += covered(gp.lost_motion(path, **GIVEN).ds, Truth())
    assert np.all(hits >= 18), hits


def test_tails_without_numbers_and_units_of_the_head(tmp_path: Path) -> None:
    whole = record(tmp_path / "whole.csv", Truth(), noise=1e-3)
    tail = tmp_path / "tail.csv"
    tail.write_text(whole.read_text() + "9,nan,NaN\n9,,\n9,1.0,nan\n")
    first, second = (gp.lost_motion(path, **GIVEN) for path in (whole, tail))
    assert second.ds.attrs["rows_left_out"] == 3
    assert second.ds.drop_attrs().identical(first.ds.drop_attrs())
    for columns in (["Torque", "Output Poisition"], ["2", "3"]):
        assert (
            gp.lost_motion(tail, **{**GIVEN, "columns": columns})
            .ds.drop_attrs()
            .identical(first.ds.drop_attrs())
        )
    german = tmp_path / "german.csv"
    german.write_text(whole.read_text().replace(",", ";").replace(".", ","))
    assert gp.lost_motion(german, **GIVEN).ds.drop_attrs().identical(first.ds.drop_attrs())


FALLING = "T,phi\n" + "".join(f"{t},{-t}\n" for t in [*range(-30, 30), *range(30, -30, -1)])


@pytest.mark.parametrize(
    ("text", "columns", "words"),
    [
        ("T,phi\n1,2\n", ["T [N m]", "phi [rad]"], "20 rows or more"),
        ("T,phi\n" + "1,2\n" * 40, ["T [N m]", "phi [rad]"], "must rise and fall"),
        ("T,phi\n" + "0,2\n" * 40, ["T [N m]", "phi [rad]"], "must not be 0 throughout"),
        ("T,phi\n" + "1,2\n" * 40, ["T", "fi"], 'columns = "fi": must be a column of the file'),
        ("T;phi\nNm;Grad\n" + "1;2\n" * 40, None, "must have a unit"),
        ("T,phi\nN m,furlong\n" + "1,2\n" * 40, ["1", "2"], "must have a unit"),
        (FALLING, ["T [N m]", "phi"], 'columns = "phi": must have a unit'),
        ("T,phi\n" + "1,2\n" * 40, ["T"], "must name two columns"),
        ("T,phi\n" + "1,2\n" * 40, ["T [kg]", "phi"], "T "),
        (FALLING, ["T [N m]", "phi [rad]"], "must turn further with more torque"),
        ("T,phi\n" + "".join(f"{t},{t}\n" for t in [*range(60), *range(60, -1, -1)]), ["T [N m]", "phi [rad]"], "with - torque"),
    ],
)  # fmt: skip
def test_refusals(text: str, columns: list[str] | None, words: str, tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_text(text)
    with pytest.raises(gp.InputError, match=words):
        gp.lost_motion(path, columns=columns)


def test_a_row_of_units_below_the_names(tmp_path: Path) -> None:
    """A table whose second row holds units reads as one with the units in brackets."""
    written = record(tmp_path / "r.csv", Truth(), noise=1e-3).read_text().splitlines()
    path = tmp_path / "units.csv"
    path.write_text("\n".join(["n;M;phi", "1;Nm;arcmin", *(line.replace(",", ";") for line in written[1:])]))
    expected = gp.lost_motion(tmp_path / "r.csv", **GIVEN).ds
    found = gp.lost_motion(path, **{**GIVEN, "columns": ["M", "phi"]}).ds
    assert float(found["play"]) == float(expected["play"])


@pytest.mark.parametrize(("friction", "warned"), [(0.0, False), (2.0, False), (5.0, True)])
def test_friction_beyond_the_torque_of_the_lost_motion(friction: float, warned: bool, tmp_path: Path) -> None:
    """Friction above 3 % of the rated torque: on both branches the flanks at 3 % are those of before, and the play is missing."""
    truth = Truth(friction=friction)
    simulated = gp.lost_motion(truth.case(), at="arm", hold="motor", torque=100.0, stages=[14.0, 48.0])
    measured = gp.lost_motion(record(tmp_path / "r.csv", truth, noise=1e-3), **GIVEN)
    for found in (simulated, measured):
        assert ("does not include the play" in found.message) == warned
        assert (float(found.ds["lost_motion"]) < 0.5 * truth.play) == warned


def test_a_missing_file_and_a_torque_out_of_reach(tmp_path: Path) -> None:
    with pytest.raises(gp.InputError, match="must be a file that can be read"):
        gp.lost_motion(tmp_path / "none.csv")
    (tmp_path / "empty.csv").write_text("")
    with pytest.raises(gp.MeasurementError, match="must hold rows of numbers"):
        gp.lost_motion(tmp_path / "empty.csv")
    path = record(tmp_path / "r.csv", Truth(), noise=1e-3)
    with pytest.raises(gp.InputError, match="must be reached by the record"):
        gp.lost_motion(path, columns=COLUMNS, torque=500.0)
