"""Orders of rolling bearings against printed values and kinematics; envelope lines."""

import math

import numpy as np
import pytest

import gearplay as gp
from gearplay.signals import bearing_orders, envelope_lines

INCH = 0.0254
# FTF, BPFO, BPFI, BSF per turn; the first two are printed in Randall and Antoni 2011 and in the description of the Case Western
# Reserve University records to four digits, all computed independently to nine.
PRINTED = {
    (8, 0.3125, 1.319): (0.381539045, 3.052312358, 4.947687642, 1.991939045),
    (9, 0.3126, 1.537): (0.398308393, 3.584775537, 5.415224463, 2.356721701),
    (8, 0.2656, 1.122): (0.381639929, 3.053119430, 4.946880570, 1.993838724),
    (8, 0.235, 1.245): (0.405622490, 3.244979920, 4.755020080, 2.554558660),
}


@pytest.mark.parametrize("geometry", PRINTED)
def test_orders__printed(geometry: tuple[int, float, float]) -> None:
    elements, diameter, pitch = geometry
    found = bearing_orders(elements, diameter * INCH, pitch * INCH)
    assert (found.ftf, found.bpfo, found.bpfi, found.bsf) == pytest.approx(PRINTED[geometry], abs=1e-9)


def test_orders__rolling_without_slip() -> None:
    """The element's centre moves at the mean of the ring's speeds at the contacts; its spin follows from the outer one."""
    d, dm, angle, elements = 7.9e-3, 33.5e-3, 0.4, 11
    found = bearing_orders(elements, d, dm, contact_angle=angle)
    inner, outer = 0.5 * (dm - d * math.cos(angle)), 0.5 * (dm + d * math.cos(angle))
    cage = 0.5 * inner / (0.5 * dm)  # inner ring turns once, the outer stands
    assert found.ftf == pytest.approx(cage, rel=1e-12)
    assert found.bpfo + found.bpfi == pytest.approx(elements, rel=1e-12)
    assert found.bsf == pytest.approx(cage * outer / (0.5 * d), rel=1e-12)


def test_frequency__6205_at_1797_rpm() -> None:
    found = bearing_orders(9, 0.3126 * INCH, 1.537 * INCH).frequencies(1797 / 60)
    assert round(found["BPFI"], 1) == 162.2
    assert list(found) == ["FTF", "BPFO", "BPFI", "BSF"]


def test_envelope_lines__depth_of_a_modulated_carrier() -> None:
    t = np.arange(20_000) / 10_000.0
    x = (1.0 + 0.5 * np.cos(2 * np.pi * 81.0 * t)) * np.cos(2 * np.pi * 3000.0 * t)
    found = envelope_lines(
        gp.Channel("acc", x, 10_000.0), {"BPFO": 80.5, "BPFI": 120.0}, 2500.0, 3500.0, harmonics=2
    )
    assert [line.name for line in found] == ["BPFO", "2 BPFO", "BPFI", "2 BPFI"]
    assert (found[0].frequency, found[0].amplitude) == pytest.approx((81.0, 0.5), rel=1e-9)
    assert found[0].prominence > 1e3
    assert max(found[1].amplitude, found[2].amplitude) < 1e-6


def test_envelope_lines__beyond_the_band_are_left_out() -> None:
    x = np.random.default_rng(0).standard_normal(4000)
    assert len(envelope_lines(gp.Channel("acc", x, 1000.0), {"BPFO": 40.0}, 200.0, 300.0)) == 1


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: bearing_orders(1, 1e-3, 1e-2), "whole number from 2"),
        (lambda: bearing_orders(8, -1e-3, 1e-2), "greater than 0 m"),
        (lambda: bearing_orders(8, math.nan, 1e-2), "greater than 0 m"),
        (lambda: bearing_orders(8, 33.5e-3, 7.9e-3), "must hold 8 elements"),
        (lambda: bearing_orders(30, 7.9e-3, 33.5e-3), "must hold 30 elements"),
        (lambda: bearing_orders(8, 7.9e-3, 33.5e-3, contact_angle=2.0), "from 0 to 1.57"),
        (lambda: envelope_lines(gp.Channel("a", np.ones(100), 100.0), {"x": -1.0}, 10.0, 40.0), "greater than 0 Hz"),
        (lambda: envelope_lines(gp.Channel("a", np.ones(100), 100.0), {"x": 1.0}, 10.0, 40.0, search=0.0), "must be a number"),
        (lambda: envelope_lines(gp.Channel("a", np.ones(100), 100.0), {"x": 1.0}, 10.0, 90.0), "half the sampling rate"),
    ],
)  # fmt: skip
def test_refusals(call: object, words: str) -> None:
    with pytest.raises(gp.InputError, match=words) as caught:
        call()  # type: ignore[operator]
    assert len(caught.value.faults) == 1
