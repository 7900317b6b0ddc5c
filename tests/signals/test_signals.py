"""Signal analysis against closed forms: tones in noise, run-ups, averages over turns."""

import numpy as np
import pytest

from depth import FULL, sized
from gearplay.files.record import Channel
from gearplay.signals.line_tables import line_table
from gearplay.signals.orders import order_spectrum, track_orders
from gearplay.signals.synchronous import synchronous_average

FS, N = 2000.0, 4000
T = np.arange(N) / FS
DF = FS / N
TONES = ((100.0 + 0.37 * DF, 1.0, 0.3), (100.0 + 4.71 * DF, 0.5, 1.2), (250.0 + 0.5 * DF, 2.0, -2.0))
CLEAN = sum(a * np.cos(2 * np.pi * f * T + p) for f, a, p in TONES)
EXPECTED = tuple(f for f, _, _ in TONES)


@pytest.mark.parametrize("window", ["hann", "boxcar", "blackman"])
def test_tones_between_lines_are_exact_without_noise(window: str) -> None:
    for row, (f, a, p) in zip(
        line_table(Channel("a", CLEAN, FS), EXPECTED, window=window).rows, TONES, strict=True
    ):
        assert row.frequency == pytest.approx(f, abs=1e-4 * DF)
        assert row.amplitude == pytest.approx(a, rel=1e-4)
        assert row.phase == pytest.approx(p, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("window", ["hann", "boxcar"])
def test_tones_between_lines_in_noise_keep_a_thousandth_and_a_hundredth_of_a_line(window: str) -> None:
    for seed in range(20):
        values = CLEAN + 0.005 * np.random.default_rng(seed).standard_normal(N)
        rows = line_table(Channel("a", values, FS), EXPECTED, window=window).rows
        for row, (f, a, _) in zip(rows, TONES, strict=True):
            assert row.frequency == pytest.approx(f, abs=0.01 * DF)
            assert row.amplitude == pytest.approx(a, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("window", ["hann", "boxcar"])
def test_stated_intervals__have_their_coverage(window: str) -> None:
    """95 % intervals of 300 draws; the coverage of 300 scatters by 1.3 %, of 30 by 4 %."""
    draws = sized(300)
    generator = np.random.default_rng(3)
    inside = np.zeros((3, 3))
    for _ in range(draws):
        values = CLEAN + 0.1 * generator.standard_normal(N)
        rows = line_table(Channel("a", values, FS), EXPECTED, window=window).rows
        for i, (row, (f, a, p)) in enumerate(zip(rows, TONES, strict=True)):
            turned = (row.phase - p + np.pi) % (2 * np.pi) - np.pi
            inside[i] += [
                abs(row.frequency - f) < 1.96 * row.frequency_uncertainty,
                abs(row.amplitude - a) < 1.96 * row.amplitude_uncertainty,
                abs(turned) < 1.96 * row.phase_uncertainty,
            ]
    low, high = (0.90, 0.99) if FULL else (0.80, 1.0)
    assert np.all((inside / draws >= low) & (inside / draws <= high)), inside / draws


def test_uncertainty_follows_the_local_noise_not_the_global() -> None:
    """Noise ten times stronger above 500 Hz: the line below must not be charged with it."""
    white = np.random.default_rng(1).standard_normal(N)
    transform = np.fft.rfft(white)
    transform[np.fft.rfftfreq(N, 1.0 / FS) > 500.0] *= 10.0
    coloured = np.fft.irfft(transform, N)
    rows = [line_table(Channel("a", CLEAN + 0.1 * x, FS), EXPECTED).rows[2] for x in (white, coloured)]
    assert rows[1].amplitude_uncertainty == pytest.approx(rows[0].amplitude_uncertainty, rel=0.1)
    # A Hann window weighs by w^2, so the variance is mean(w^4) / mean(w^2)^2 = 35/18 times the bound S / T.
    expected = np.sqrt(35.0 / 18.0 * 2.0 * 0.1**2 / FS / (N / FS))
    assert rows[1].amplitude_uncertainty == pytest.approx(expected, rel=0.2)


@pytest.mark.slow
def test_a_boxcar_attains_the_bounds_of_cramer_and_rao() -> None:
    density, length = 2.0 * 0.1**2 / FS, N / FS
    rows = [
        line_table(
            Channel("a", CLEAN + 0.1 * np.random.default_rng(k).standard_normal(N), FS),
            EXPECTED,
            window="boxcar",
        ).rows[2]
        for k in range(40)
    ]
    frequency = np.sqrt(np.mean([r.frequency_uncertainty**2 for r in rows]))
    amplitude = np.sqrt(np.mean([r.amplitude_uncertainty**2 for r in rows]))
    assert frequency == pytest.approx(np.sqrt(3.0 * density / (np.pi**2 * 2.0**2 * length**3)), rel=0.05)
    assert amplitude == pytest.approx(np.sqrt(density / length), rel=0.05)


@pytest.mark.slow
def test_a_long_record_shows_thirty_lines() -> None:
    n, fs = 2_000_000, 1e5
    t = np.arange(n) / fs
    values = np.random.default_rng(0).standard_normal(n)
    frequencies = 25.003 * np.arange(1, 31)
    for k, f in enumerate(frequencies, start=1):
        values += np.cos(2 * np.pi * f * t) / k
    table = line_table(Channel("a", values, fs), tuple(frequencies))
    assert len(table.found) == 30
    for row, f in zip(table.rows, frequencies, strict=True):
        assert abs(row.frequency - f) < 5.0 * row.frequency_uncertainty


TIME = np.arange(60_000) / 10_000.0
TURNS = 10.0 * TIME + 2.5 * TIME**2  # 10 to 40 turns a second in 6 s
SPEED = Channel("n", 60.0 * (10.0 + 5.0 * TIME), 10_000.0, "rpm")


def test_a_known_order_of_a_run_up_keeps_its_place_and_amplitude() -> None:
    """Order 3 of amplitude 1.5 and order 17.4 that grows with speed; a fixed 777 Hz and noise beside them."""
    growing = 0.02 * (10.0 + 5.0 * TIME)
    values = (
        1.5 * np.cos(2 * np.pi * 3.0 * TURNS + 0.7)
        + growing * np.cos(2 * np.pi * 17.4 * TURNS)
        + 0.3 * np.cos(2 * np.pi * 777.0 * TIME)
        + 0.05 * np.random.default_rng(0).standard_normal(TIME.size)
    )
    c = Channel("a", values, 10_000.0, "m/s^2")
    s = order_spectrum(c, SPEED, highest=60.0)
    at = int(np.argmax(s.amplitude))
    assert s.order[at] == pytest.approx(3.0, abs=0.005)
    assert s.amplitude[at] == pytest.approx(1.5, rel=0.01)
    tracks = track_orders(c, SPEED, (3.0, 17.4), revolutions=10.0, highest=60.0)
    assert np.max(np.abs(tracks.amplitude[0] / 1.5 - 1.0)) < 0.02
    assert np.max(np.abs(tracks.phase[0] - 0.7)) < 0.02
    expected = 0.02 * tracks.speed / (2 * np.pi)
    assert np.max(np.abs(tracks.amplitude[1] - expected)) < 0.03


def test_the_tacho_gives_the_same_orders_as_the_speed() -> None:
    from gearplay.signals.angle import angle_from_tacho

    c = Channel("a", 1.5 * np.cos(2 * np.pi * 3.0 * TURNS), 10_000.0)
    tacho = Channel("tacho", ((8.0 * TURNS) % 1.0 < 0.5).astype(float), 10_000.0, "V")
    s = order_spectrum(c, angle_from_tacho(tacho, 8), highest=20.0)
    at = int(np.argmax(s.amplitude))
    assert s.order[at] == pytest.approx(3.0, abs=0.01)
    assert s.amplitude[at] == pytest.approx(1.5, rel=0.01)


@pytest.mark.parametrize("turns", [16, 100])
def test_a_synchronous_average_takes_noise_down_by_the_root_of_the_turns(turns: int) -> None:
    n = 250 * turns + 1
    t = np.arange(n) / 2500.0
    generator = np.random.default_rng(5)
    left, errors = [], []
    for _ in range(20):
        c = Channel("a", np.cos(2 * np.pi * 30.0 * t) + generator.standard_normal(n), 2500.0)
        tsa = synchronous_average(c, 2 * np.pi * 10.0, highest=100.0, samples_per_revolution=250)
        assert tsa.periods == turns
        left.append(np.mean((tsa.average - np.cos(3.0 * tsa.angle)) ** 2))
        errors.append(np.mean(tsa.error**2))
    # The low-pass at order 100 of 125 keeps the share of white noise between them.
    per_turn = np.mean(left) * turns
    assert 0.75 < per_turn < 1.0
    assert np.mean(errors) * turns == pytest.approx(per_turn, rel=0.1)
    assert tsa.residual_share == pytest.approx((1 - 1 / turns) * per_turn / (0.5 + per_turn), rel=0.15)
