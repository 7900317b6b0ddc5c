"""Every input that cannot be analysed is refused with one sentence that names it."""

from collections.abc import Callable

import numpy as np
import pytest

import gearplay as gp
from gearplay.files.record import Channel
from gearplay.signals.angle import angle_from_speed, angle_from_tacho
from gearplay.signals.averaging import averaged_spectrum, power_density
from gearplay.signals.bearing_lines import envelope_lines
from gearplay.signals.envelopes import envelope, envelope_spectrum, most_impulsive_band
from gearplay.signals.line_tables import line_table
from gearplay.signals.orders import order_map, order_spectrum, track_orders
from gearplay.signals.planetary_windows import planetary_average
from gearplay.signals.spectrograms import spectrogram
from gearplay.signals.statistics import signal_statistics
from gearplay.signals.synchronous import synchronous_average
from gearplay.vocabulary.errors import InputError

GOOD = Channel("acc", np.random.default_rng(0).standard_normal(2000), 1000.0, "m/s^2")
ANALYSES: dict[str, Callable[[Channel], object]] = {
    "statistics": signal_statistics,
    "density": power_density,
    "spectrum": averaged_spectrum,
    "spectrogram": spectrogram,
    "envelope": lambda c: envelope(c, 50.0, 100.0),
    "envelope spectrum": lambda c: envelope_spectrum(c, 50.0, 100.0),
    "band": most_impulsive_band,
    "orders": lambda c: order_spectrum(c, 60.0),
    "map": lambda c: order_map(c, 60.0),
    "tracks": lambda c: track_orders(c, 60.0, (1.0,)),
    "average": lambda c: synchronous_average(c, 60.0),
    "lines": lambda c: line_table(c, (100.0,)),
    "envelope lines": lambda c: envelope_lines(c, {"BPFO": 20.0}, 50.0, 200.0),
    "planetary average": lambda c: planetary_average(c, 60.0, 10, 5, 21, 2),
}
BAD = {
    "short": Channel("acc", np.zeros(4), 1000.0),
    "empty": Channel("acc", np.zeros(0), 1000.0),
    "nan": Channel("acc", np.where(np.arange(2000) == 7, np.nan, 1.0), 1000.0),
    "infinite": Channel("acc", np.where(np.arange(2000) == 7, np.inf, 1.0), 1000.0),
    "huge": Channel("acc", np.full(2000, 1e200), 1000.0),
    "table": Channel("acc", np.zeros((2000, 2)), 1000.0),
    "complex": Channel("acc", np.zeros(2000, dtype=complex), 1000.0),  # type: ignore[arg-type]
    "sampling": Channel("acc", np.zeros(2000), 0.0),
    "no sampling": Channel("acc", np.zeros(2000), float("nan")),
}


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("analysis", ANALYSES)
def test_analyses__bad_records_are_refused(analysis: str, bad: str) -> None:
    with pytest.raises(InputError, match=r"^acc\.(values|sampling) = .*: must .*\.") as caught:
        ANALYSES[analysis](BAD[bad])
    assert len(caught.value.faults) == 1


@pytest.mark.parametrize("value", [np.zeros(100), None, "acc.csv"], ids=type)
@pytest.mark.parametrize(
    "name", ["envelope", "line_table", "signal_statistics", "order_map", "angle_from_tacho"]
)
def test_functions_of_signals__a_value_that_is_no_channel_is_refused(name: str, value: object) -> None:
    function = getattr(gp.signals, name)
    needed = {
        "envelope": (50.0, 100.0),
        "line_table": ((100.0,),),
        "order_map": (60.0,),
        "angle_from_tacho": (1,),
    }
    with pytest.raises(InputError, match=r"must be of type Channel. Make one: gearplay.Channel"):
        function(value, *needed.get(name, ()))


def test_functions_of_signals__an_unknown_argument_or_another_class_is_refused() -> None:
    with pytest.raises(InputError, match=r"speeed: is no argument of .*Did you mean 'speed'"):
        gp.signals.order_map(GOOD, speeed=60.0)
    with pytest.raises(InputError, match=r"spectrum = .*must be of type Spectrum"):
        gp.signals.find_line(GOOD, 100.0)
    with pytest.raises(InputError, match=r"signals = none: must be a list of records"):
        gp.signals.ensemble_spectrum(None, 100.0)


@pytest.mark.parametrize("analysis", ANALYSES)
def test_analyses__a_constant_or_integer_record_is_accepted(analysis: str) -> None:
    ANALYSES[analysis](Channel("acc", np.zeros(2000), 1000.0))
    ANALYSES[analysis](Channel("acc", np.arange(2000) % 7, 1000.0))  # type: ignore[arg-type]


REFUSED: dict[str, tuple[str, Callable[[], object]]] = {
    "window": ("window", lambda: power_density(GOOD, window="haning")),
    "window with a parameter": ("window", lambda: power_density(GOOD, window="kaiser")),
    "window as a number": ("window", lambda: spectrogram(GOOD, window=3.0)),  # type: ignore[arg-type]
    "segment too long": ("segment", lambda: power_density(GOOD, segment=2001)),
    "segment of nothing": ("segment", lambda: power_density(GOOD, segment=0)),
    "segment broken": ("segment", lambda: averaged_spectrum(GOOD, segment=25.5)),  # type: ignore[arg-type]
    "overlap": ("overlap", lambda: power_density(GOOD, overlap=1.0)),
    "averaging": ("averaging", lambda: power_density(GOOD, averaging="max")),
    "correction": ("correction", lambda: averaged_spectrum(GOOD, correction="none")),
    "detrend": ("detrend", lambda: averaged_spectrum(GOOD, detrend="cubic")),
    "kind": ("kind", lambda: spectrogram(GOOD, kind="dB")),
    "band above Nyquist": ("band", lambda: envelope(GOOD, 100.0, 501.0)),
    "band empty": ("band", lambda: envelope(GOOD, 100.0, 100.0)),
    "band backwards": ("band", lambda: envelope(GOOD, 200.0, 100.0)),
    "band below zero": ("band", lambda: envelope(GOOD, -5.0, 100.0)),
    "band between lines": ("band", lambda: envelope(GOOD, 100.0, 100.3)),
    "band nan": ("band", lambda: envelope(GOOD, float("nan"), 100.0)),
    "Butterworth from zero": ("band", lambda: envelope(GOOD, 0.0, 100.0, filter="butterworth")),
    "filter": ("filter", lambda: envelope(GOOD, 50.0, 100.0, filter="cheby")),
    "speed zero": ("speed", lambda: order_spectrum(GOOD, 0.0)),
    "speed negative": ("speed", lambda: synchronous_average(GOOD, -3.0)),
    "speed nan": ("speed", lambda: order_spectrum(GOOD, float("nan"))),
    "speed in words": ("speed", lambda: order_spectrum(GOOD, "fast")),  # type: ignore[arg-type]
    "speed too low": ("speed", lambda: order_spectrum(GOOD, 0.1)),
    "speed channel stands": (r"n\.values", lambda: angle_from_speed(Channel("n", np.zeros(20), 10.0, "rpm"))),
    "speed elsewhere": ("speed", lambda: order_map(GOOD, Channel("n", np.ones(20), 10.0, "Hz", start=99.0))),
    "angle turns back": (r"p\.values", lambda: order_map(GOOD, Channel("p", -np.arange(20.0), 10.0, "rad"))),
    "tacho silent": (r"k\.values", lambda: angle_from_tacho(Channel("k", np.zeros(200), 10.0, "V"), 1)),
    "tacho of no pulses": ("pulses", lambda: angle_from_tacho(GOOD, 0)),
    "order too high": ("highest", lambda: order_spectrum(GOOD, 60.0, highest=1e4)),
    "orders too close": ("orders", lambda: track_orders(GOOD, 60.0, (3.0, 3.1))),
    "no orders": ("orders", lambda: track_orders(GOOD, 60.0, ())),
    "too many revolutions": ("revolutions", lambda: order_spectrum(GOOD, 60.0, revolutions=400.0)),
    "one period": ("speed", lambda: synchronous_average(GOOD, 60.0, period=15)),
    "line above Nyquist": (r"expected\[1\]", lambda: line_table(GOOD, (100.0, 600.0))),
    "line below zero": (r"expected\[0\]", lambda: line_table(GOOD, (-100.0,))),
    "no expected lines": ("expected", lambda: line_table(GOOD, ())),
    "lines too close": ("expected", lambda: line_table(GOOD, (100.0, 100.5))),
    "line table's window": ("window", lambda: line_table(GOOD, (100.0,), window="flattop")),
    "search": ("search", lambda: line_table(GOOD, (100.0,), search=0.0)),
    "false alarm": ("false_alarm", lambda: line_table(GOOD, (100.0,), false_alarm=1.0)),
}


@pytest.mark.parametrize("case", REFUSED)
def test_analyses__impossible_settings_are_refused(case: str) -> None:
    path, call = REFUSED[case]
    with pytest.raises(InputError, match=rf"^{path} = .*: must .*\. \S.*\.$") as caught:
        call()
    assert len(caught.value.faults) == 1


def test_spectrogram__too_fine_a_one_is_refused() -> None:
    with pytest.raises(InputError, match="overlap"):
        spectrogram(Channel("a", np.zeros(3_000_000), 1e5), overlap=0.95)
