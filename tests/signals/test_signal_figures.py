"""Pictures of signals: labels with units, settings printed, shocks and lines kept, user text shown as it is."""

from pathlib import Path

import numpy as np
import pytest

from gearplay.files.record import Channel
from gearplay.pictures.style import MOST_POINTS, new_axes
from gearplay.signals.averaging import power_density
from gearplay.signals.figures import (
    draw_record,
    plot_averaged_spectrum,
    plot_channel,
    plot_spectrogram,
)
from gearplay.signals.spectrograms import spectrogram
from gearplay.vocabulary.errors import InputError

T = np.arange(20_000) / 5000.0
C = Channel(
    "cost $5$ \\frac{",
    np.cos(2 * np.pi * 60.3 * T) + 0.1 * np.random.default_rng(0).standard_normal(T.size),
    5000.0,
    "m/s^2",
)


def test_labels_carry_units_and_captions_the_settings() -> None:
    ax = plot_averaged_spectrum(new_axes(), power_density(C, segment=1000))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency [Hz]", "power spectral density [(m/s²)²/Hz]")
    caption = " ".join(ax.texts[0].get_text().split())
    assert "window hann, mean of 39 segments of 1000, overlap 50 %, line spacing 5 Hz" in caption
    assert ax.get_title(loc="left") == r"cost \$5\$ \frac{"


def test_a_shock_survives_thinning() -> None:
    values = np.zeros(1_000_000)
    values[777_777] = 9.0
    line = plot_channel(new_axes(), Channel("a", values, 1e5)).lines[0]
    assert np.max(line.get_ydata()) == 9.0
    assert len(line.get_xdata()) <= MOST_POINTS


@pytest.mark.slow
def test_signals_at_rest_are_drawn(tmp_path: Path) -> None:
    assert (
        len(draw_record(Channel("still", np.zeros(4000), 1000.0), tmp_path, speed=60.0, expected=(50.0,)))
        == 8
    )


def test_spectrogram__has_a_colour_bar_with_unit() -> None:
    ax = plot_spectrogram(new_axes(), spectrogram(C))
    assert ax.figure.axes[1].get_ylabel() == "amplitude [m/s²]"


@pytest.mark.slow
def test_a_folder_that_cannot_be_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="folder"):
        draw_record(C, tmp_path / "file")
