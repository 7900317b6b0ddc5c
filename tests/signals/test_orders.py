"""Shaft angles from every source, equal-angle records, and averages over turns."""

import numpy as np
import pytest

from gearplay.files.record import Channel
from gearplay.signals.angle import (
    angle_from_angle,
    angle_from_speed,
    angle_from_tacho,
    pulse_times,
    shaft_angle,
)
from gearplay.signals.orders import order_map, order_spectrum, track_orders
from gearplay.signals.resampling import resampled
from gearplay.signals.synchronous import synchronous_average

FS = 5000.0
T = np.arange(20_000) / FS
TURNS = 5.0 * T + 2.0 * T**2  # 5 to 21 turns a second
SPEED = Channel("n", 60.0 * (5.0 + 4.0 * T), FS, "rpm")


def test_every_source_gives_the_same_angle() -> None:
    truth = 2.0 * np.pi * TURNS
    np.testing.assert_allclose(angle_from_speed(SPEED).angle, truth, atol=1e-8)
    wrapped = Channel("phi", 360.0 * (TURNS % 1.0), FS, "deg")
    np.testing.assert_allclose(angle_from_angle(wrapped, wrapped=True).angle, truth, atol=1e-8)
    tacho = Channel("tacho", np.sin(2.0 * np.pi * 4.0 * TURNS - 1.0), FS, "V")
    shaft = angle_from_tacho(tacho, 4)
    at = np.linspace(shaft.time[0], shaft.time[-1], 500)
    offset = shaft.at(at)[0] - 2.0 * np.pi * (5.0 * at + 2.0 * at**2)
    assert np.ptp(offset) < 2e-3


def test_noise_on_a_slow_edge_makes_no_second_pulse() -> None:
    wave = np.sin(2.0 * np.pi * 2.0 * T - 1.0) + 0.05 * np.random.default_rng(0).standard_normal(T.size)
    assert pulse_times(Channel("tacho", wave, FS, "V"), hysteresis=0.3).size == 8
    assert pulse_times(Channel("tacho", wave, FS, "V"), hysteresis=0.0).size > 8


def test_resampling_is_exact_up_to_its_highest_order() -> None:
    c = Channel("a", np.cos(2.0 * np.pi * 30.0 * TURNS + 0.4), FS)
    r = resampled(c, SPEED, highest=40.0)
    turns = (r.first + np.arange(r.values.size)) / r.samples_per_revolution
    inner = slice(100, -100)
    assert np.max(np.abs(r.values - np.cos(2.0 * np.pi * 30.0 * turns + 0.4))[inner]) < 1e-3
    np.testing.assert_allclose(r.speed, 2.0 * np.pi * np.sqrt(25.0 + 8.0 * turns), rtol=1e-4)


def test_resampling__orders_above_the_highest_do_not_alias() -> None:
    c = Channel("a", np.cos(2.0 * np.pi * 2000.0 * T), FS)  # orders 95 to 400
    r = resampled(c, SPEED, highest=20.0)
    assert r.samples_per_revolution == 50
    assert np.max(np.abs(r.values[100:-100])) < 1e-3


def test_a_speed_in_the_wrong_unit_is_named() -> None:
    from gearplay.vocabulary.errors import InputError

    with pytest.raises(InputError, match=r'n\.unit = "m/s"'):
        shaft_angle(SPEED, Channel("n", np.ones(20), 10.0, "m/s"))


def test_order_map_puts_a_fixed_frequency_on_a_falling_order() -> None:
    c = Channel("a", 2.0 * np.cos(2.0 * np.pi * 60.0 * T), FS, "V")
    m = order_map(c, SPEED, highest=20.0, revolutions=2.0)
    ridge = m.order[np.argmax(m.amplitude, axis=0)]
    expected = 60.0 / (m.speed / (2.0 * np.pi))
    assert np.max(np.abs(ridge - expected)) < 1.0
    assert np.all(np.diff(m.speed) > 0.0)


def test_order_spectrum_states_its_settings() -> None:
    s = order_spectrum(
        Channel("a", np.cos(2 * np.pi * 3.0 * TURNS), FS), SPEED, highest=10.0, revolutions=10.0
    )
    assert s.resolution == pytest.approx(0.1)
    assert s.speed_low == pytest.approx(2.0 * np.pi * 5.0, rel=1e-6)
    assert "10 revolutions" in s.caption
    assert "300 to 1260 rpm" in s.caption


def test_synchronous_average_over_two_turns_keeps_half_orders() -> None:
    c = Channel("a", np.cos(2.0 * np.pi * 2.5 * TURNS), FS)
    one, two = (synchronous_average(c, SPEED, highest=10.0, period=p) for p in (1, 2))
    assert one.residual_share > 0.98
    assert two.residual_share < 1e-3
    assert two.angle[-1] > 2.0 * np.pi


def test_an_order_not_asked_for_does_not_leak_into_a_track() -> None:
    c = Channel("a", np.cos(2 * np.pi * 3.0 * TURNS) + np.cos(2 * np.pi * 5.3 * TURNS), FS)
    tracks = track_orders(c, SPEED, (3.0,), revolutions=8.0, highest=10.0)
    assert np.max(np.abs(tracks.amplitude[0, 1:-1] - 1.0)) < 2e-3
    assert np.allclose(tracks.residual_share, 0.5, atol=0.01)
