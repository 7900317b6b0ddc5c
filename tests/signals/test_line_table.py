"""Line tables: what counts as a line, what is refused, and that nothing is invented."""

import math

import numpy as np
import pytest

from depth import sized
from gearplay.files.record import Channel
from gearplay.signals.line_tables import line_table

FS, N = 2000.0, 8000
T = np.arange(N) / FS
DF = FS / N


def noise(seed: int, level: float = 1.0) -> np.ndarray:
    return level * np.random.default_rng(seed).standard_normal(N)


def test_noise_has_no_lines() -> None:
    found = sum(len(line_table(Channel("a", noise(k), FS), (100.0, 400.0, 850.0)).found) for k in range(60))
    assert found <= 2, "a thousandth of 180 rows was stated, a little more is the noise level's own scatter"


def test_line_table__a_row_without_a_line_is_marked() -> None:
    row = line_table(Channel("a", noise(1), FS, "V"), (100.0,)).rows[0]
    assert not row.found
    assert math.isnan(row.amplitude)
    assert row.remark.startswith("no line above 0.")
    assert row.remark.endswith(" V")
    assert row.noise == pytest.approx(2.0 / FS, rel=0.4)


def test_the_stated_limit_parts_what_is_found() -> None:
    limit = line_table(Channel("a", noise(1), FS), (100.0,)).rows[0].limit
    for factor, found in ((0.3, False), (2.0, True)):
        c = Channel("a", noise(1) + factor * limit * np.cos(2 * np.pi * 100.0 * T), FS)
        assert line_table(c, (100.0,)).rows[0].found is found


@pytest.mark.slow
def test_a_hump_is_no_line() -> None:
    frequency = np.fft.rfftfreq(N, 1.0 / FS)
    shape = np.exp(-0.5 * ((frequency - 100.0) / (12.0 * DF)) ** 2) + 1e-3
    rows = []
    for seed in range(sized(8, 2)):
        c = Channel("a", np.fft.irfft(np.fft.rfft(noise(seed)) * shape), FS)
        rows += line_table(c, (100.0,), search=0.01).rows
    assert sum(row.found for row in rows) <= 1
    assert any("no single sharp line" in row.remark for row in rows)


def test_a_clean_record_shows_no_side_lobes_as_lines() -> None:
    c = Channel("a", np.cos(2 * np.pi * 100.07 * T) + 1e-4 * np.cos(2 * np.pi * 300.03 * T), FS)
    table = line_table(c, (50.0, 100.0, 104.0, 300.0, 700.0))
    assert [row.found for row in table.rows] == [False, True, False, True, False]
    assert table.rows[3].amplitude == pytest.approx(1e-4, rel=1e-6)


def test_neighbouring_side_bands_do_not_bias_a_line() -> None:
    mesh, side = 200.0 + 0.3 * DF, 3.3 * DF
    c = Channel(
        "a", (1.0 + 0.8 * np.cos(2 * np.pi * side * T)) * np.cos(2 * np.pi * mesh * T) + noise(3, 1e-3), FS
    )
    row = line_table(c, (200.0,), search=0.02).rows[0]
    assert row.frequency == pytest.approx(mesh, abs=0.01 * DF)
    assert row.amplitude == pytest.approx(1.0, rel=1e-3)


@pytest.mark.slow
def test_line_table__rows_are_in_the_requested_order_without_wandering_tones() -> None:
    c = Channel(
        "a", np.cos(2 * np.pi * (300.0 * T + 2.0 * T**2)) + np.cos(2 * np.pi * 90.0 * T) + noise(2, 0.05), FS
    )
    rows = line_table(c, (308.0, 90.0)).rows
    assert [row.expected for row in rows] == [308.0, 90.0]
    assert rows[1].found


def test_a_constant_record_has_no_lines() -> None:
    row = line_table(Channel("a", np.full(N, 3.3), FS), (100.0,)).rows[0]
    assert not row.found
    assert row.prominence == 0.0


@pytest.mark.parametrize("scale", [1e-9, 1e9, 1e120])
def test_scale_changes_nothing(scale: float) -> None:
    values = np.cos(2 * np.pi * 100.03 * T) + noise(1, 0.1)
    one, other = (line_table(Channel("a", s * values, FS), (100.0,)).rows[0] for s in (1.0, scale))
    assert other.frequency == pytest.approx(one.frequency, rel=1e-12)
    assert other.amplitude_uncertainty == pytest.approx(scale * one.amplitude_uncertainty, rel=1e-6)


def test_rounding_has_no_lines() -> None:
    c = Channel("a", np.round(np.cos(2 * np.pi * 100.0 * T), 15), FS)
    assert [row.found for row in line_table(c, (100.0, 300.0, 500.0, 700.0)).rows] == [
        True,
        False,
        False,
        False,
    ]
