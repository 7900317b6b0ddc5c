"""Signal analysis of simulated, measured or given arrays: spectra, lines, orders, envelopes, averages.

Put samples into a `Channel` with their rate and unit; every function takes one and returns numbers with their settings.

>>> import gearplay as gp, numpy as np
>>> t = np.arange(4000) / 1000.0
>>> channel = gp.Channel("acc", 3.0 * np.sin(2.0 * np.pi * 50.0 * t), 1000.0, "m/s^2")
>>> row = gp.signals.line_table(channel, [50.0]).rows[0]
>>> round(row.frequency, 6), round(row.amplitude, 6)
(50.0, 3.0)
"""

from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

HOMES: Final = MappingProxyType(
    {
        "Channel": "gearplay.files.record",
        "Record": "gearplay.files.record",
        "Spectrum": "gearplay.results.spectra",
        "amplitude_spectrum": "gearplay.results.spectra",
        "ensemble_spectrum": "gearplay.results.spectra",
        "angle_from_angle": "gearplay.signals.angle",
        "angle_from_speed": "gearplay.signals.angle",
        "angle_from_tacho": "gearplay.signals.angle",
        "averaged_spectrum": "gearplay.signals.averaging",
        "mean_square": "gearplay.signals.averaging",
        "power_density": "gearplay.signals.averaging",
        "envelope": "gearplay.signals.envelopes",
        "envelope_spectrum": "gearplay.signals.envelopes",
        "most_impulsive_band": "gearplay.signals.envelopes",
        "draw_record": "gearplay.signals.figures",
        "band_level": "gearplay.signals.levels",
        "line_table": "gearplay.signals.line_tables",
        "find_hump": "gearplay.signals.lines",
        "find_line": "gearplay.signals.lines",
        "order_map": "gearplay.signals.orders",
        "order_spectrum": "gearplay.signals.orders",
        "track_orders": "gearplay.signals.orders",
        "spectrogram": "gearplay.signals.spectrograms",
        "signal_statistics": "gearplay.signals.statistics",
        "synchronous_average": "gearplay.signals.synchronous",
    }
)
"""Module of each public name; loaded when it is first used."""

if TYPE_CHECKING:
    from gearplay.files.record import Channel, Record
    from gearplay.results.spectra import Spectrum, amplitude_spectrum, ensemble_spectrum
    from gearplay.signals.angle import angle_from_angle, angle_from_speed, angle_from_tacho
    from gearplay.signals.averaging import averaged_spectrum, mean_square, power_density
    from gearplay.signals.envelopes import envelope, envelope_spectrum, most_impulsive_band
    from gearplay.signals.figures import draw_record
    from gearplay.signals.levels import band_level
    from gearplay.signals.line_tables import line_table
    from gearplay.signals.lines import find_hump, find_line
    from gearplay.signals.orders import order_map, order_spectrum, track_orders
    from gearplay.signals.spectrograms import spectrogram
    from gearplay.signals.statistics import signal_statistics
    from gearplay.signals.synchronous import synchronous_average

__all__ = [
    "Channel",
    "Record",
    "Spectrum",
    "amplitude_spectrum",
    "angle_from_angle",
    "angle_from_speed",
    "angle_from_tacho",
    "averaged_spectrum",
    "band_level",
    "draw_record",
    "ensemble_spectrum",
    "envelope",
    "envelope_spectrum",
    "find_hump",
    "find_line",
    "line_table",
    "mean_square",
    "most_impulsive_band",
    "order_map",
    "order_spectrum",
    "power_density",
    "signal_statistics",
    "spectrogram",
    "synchronous_average",
    "track_orders",
]


def __getattr__(name: str) -> Any:
    if name not in HOMES:
        raise AttributeError(f"module 'gearplay.signals' has no attribute {name!r}")
    return getattr(import_module(HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
