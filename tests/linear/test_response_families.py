"""Frequency responses over a field or over the parameter of a function: the pair of the literature in closed form."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.torsional_pair import BASE_RADIUS, MASS, NATURAL_FREQUENCY

RATIOS = [0.02, 0.05, 0.3]
ASKED: dict[str, Any] = {
    "force": "wheel.torque",
    "at": ["wheel.theta", "pinion-wheel.force"],
    "frequencies": np.array([0.0, 0.5, 0.99, 1.0, 2.0]) * NATURAL_FREQUENCY / (2.0 * math.pi),
}


def pair(zeta: float) -> gp.Case:
    return gp.torsional_pair(0.7, damping_ratio=zeta)


def test_function_of_the_damping_ratio__closed_form() -> None:
    """|theta| = T / (J w0^2 |1 - r^2 + 2 i zeta r|), the force of the teeth w0^2 J / r_b times that."""
    found = gp.frequency_response(pair, "zeta", RATIOS, **ASKED)
    assert found.parameter == "zeta"
    assert found.ds["amplitude"].dims == ("zeta", "at", "frequency")
    r, zeta = np.array([0.0, 0.5, 0.99, 1.0, 2.0]), np.array(RATIOS)[:, None]
    J = MASS * BASE_RADIUS**2
    theta = 1.0 / (J * NATURAL_FREQUENCY**2 * (1.0 - r**2 + 2j * zeta * r))
    force = NATURAL_FREQUENCY**2 * J / BASE_RADIUS * theta
    amplitude = found.ds["amplitude"].values
    np.testing.assert_allclose(amplitude[:, 0], np.abs(theta), rtol=1e-6)
    np.testing.assert_allclose(amplitude[:, 1], np.abs(force), rtol=1e-6)
    np.testing.assert_allclose(found.ds["phase"].values[:, 0], np.angle(theta), atol=1e-6)
    natural = found.ds["natural_frequency"].values * 2.0 * math.pi
    np.testing.assert_allclose(natural, np.full((3, 1), NATURAL_FREQUENCY), rtol=1e-9)
    assert "over 3 values of zeta, 0.02 to 0.3" in found.message


def test_field__is_the_same_as_the_function_and_as_each_case_alone() -> None:
    by_function = gp.frequency_response(pair, "zeta", RATIOS, **ASKED).ds
    by_field = gp.frequency_response(pair(0.05), "torsional_pair.damping_ratio", RATIOS, **ASKED).ds
    assert by_field["damping_ratio"].values.tolist() == RATIOS
    np.testing.assert_array_equal(by_field["amplitude"].values, by_function["amplitude"].values)
    alone = gp.frequency_response(pair(RATIOS[2]), **ASKED).ds
    np.testing.assert_array_equal(alone["amplitude"].values, by_function["amplitude"].values[2])
    speeds = gp.frequency_response(pair(0.05), "torsional_pair.frequency", [0.5, 0.7], **ASKED).ds
    assert speeds["amplitude"].dims[0] == "torsional_pair.frequency"


def test_units_and_answers(tmp_path: Path) -> None:
    """Values with units, saved and read, drawn."""
    found = gp.frequency_response(
        "two-stage-reducer", "meshes.0.backlash", ["50 um", 1e-4], force="output.torque",
        at="output.theta", frequencies=[100.0, 600.0, 700.0],
    )  # fmt: skip
    assert found.ds["backlash"].values == pytest.approx([5e-5, 1e-4])
    assert found.ds["backlash"].attrs["units"] == "m"
    found.save(tmp_path / "response.nc")
    again = gp.read_result(tmp_path / "response.nc")
    assert (again.message, again.parameter, again.resonances) == (found.message, "backlash", found.resonances)


@pytest.mark.parametrize(
    ("case", "more", "rule"),
    [
        (pair, (), "path: is required where the case is a function"),
        (pair, ("zeta",), "must be given together"),
        (pair, ("zeta", []), "must be a list of finite numbers"),
        (pair, ("zeta", ["5 %"]), r"values\.0 = .*plain numbers for the parameter of a function"),
        (lambda zeta: {"zeta": zeta}, ("zeta", [0.1]), r"case = .dict.: must return a Case"),
        (pair(0.1), ("torsional_pair.zeta", [0.1]), "must be a field of the case"),
    ],
)
def test_what_cannot_be__one_sentence(case: Any, more: tuple[Any, ...], rule: str) -> None:
    with pytest.raises(gp.InputError, match=rule):
        gp.frequency_response(case, *more, **ASKED)


def test_picture__a_line_for_each_value_and_output() -> None:
    found = gp.frequency_response(pair, "zeta", RATIOS, **ASKED)
    axes = [ax for ax in found.plot().axes if ax.lines]
    assert len(axes) == 2
    for k, ax in enumerate(axes):
        drawn = np.array([line.get_ydata() for line in ax.lines])
        np.testing.assert_allclose(drawn, found.ds["amplitude"].values[:, k])
