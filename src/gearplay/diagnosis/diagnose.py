"""`diagnose`: named lines, indices and ranked hypotheses of a record of a machine."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from gearplay.diagnosis.bearing_combs import PARTS, Key
from gearplay.diagnosis.checks import Checks, checked, revised
from gearplay.diagnosis.dataset import dataset_of
from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.hypotheses import ranked
from gearplay.diagnosis.machine import Machine, described
from gearplay.diagnosis.measures import Measures, measured
from gearplay.diagnosis.named_lines import NamedLine, named_envelope, named_spectrum
from gearplay.diagnosis.quantisation import quantisation_step
from gearplay.diagnosis.result import Diagnosis
from gearplay.diagnosis.shaft_speed import FoundSpeed, found_speed
from gearplay.files.record import Channel, Record
from gearplay.model.case import Case
from gearplay.model.reading import Source, load_case
from gearplay.results.spectra import amplitude_spectrum
from gearplay.rig.plan import Rig, load_rig, placements
from gearplay.signals.angle import ShaftAngle
from gearplay.signals.averaging import averaged_spectrum
from gearplay.signals.checks import TWO_PI, check_channel
from gearplay.signals.envelopes import envelope
from gearplay.signals.resampling import resampled
from gearplay.vocabulary.errors import InputError, shorten
from gearplay.vocabulary.progress import Progress

LEAST_SAMPLES: Final = 2048
LEAST_TURNS: Final = 10
"""Least length of a record, in turns of the first shaft."""


MEMBERS = 3
NOT_SIMULATED = "must be given with a case that is simulated"


def diagnose(
    record: Record | Channel,
    *,
    case: Source | None = None,
    teeth: str | None = None,
    bearings: str | Sequence[str] = (),
    speed: float | str | Channel | ShaftAngle | None = None,
    healthy: Record | Channel | None = None,
    channel: str | None = None,
    quick: bool = False,
    rig: Rig | str | os.PathLike[str] | Mapping[str, Any] | None = None,
    members: int | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Diagnosis:
    """Diagnose a machine from a record: named lines, indices, periodic events, ranked hypotheses.

    The speed is sought within 2.5 % of the given one, at the mesh harmonics, else at the turns of the shafts, for bearings also
    in envelopes. Averages over the turns of each shaft show damaged teeth and eccentric gears; what repeats with no shaft is
    searched for the envelope lines of bearings and of rattling flanks. Each hypothesis has its evidence against a threshold, and
    a confidence; below 0.7 the cause counts as not told. A healthy record of the same machine replaces general thresholds.

    With a case the likeliest hypotheses, worn flanks and worn bushes are simulated in three severities at the speed of the
    record, through the same rig, and the features of these records (levels, lines, sidebands, indices, envelopes) compared with
    those of the record. Causes that agree alike are listed under what cannot be told; hypotheses that the simulations do not
    support keep 0.6 of confidence at most.

    Source: Randall, Vibration-based Condition Monitoring (2011), chapters 5 and 6; ranking and thresholds: ours.

    Parameters
    ----------
    record
        Vibration: a `Record`, or one channel.
    case
        Case with the gears: as `load_case` takes it. Or ``teeth``.
    teeth
        Teeth of driver and driven gear, the driver on the first shaft: "23:61"; of several stages "23:61, 19:47".
    bearings
        Rolling bearings, each "elements, diameter, pitch diameter" with an optional contact angle and shaft: "8, 7.9mm, 33.5mm",
        "9, 7.9mm, 39mm, 15deg @2", or a designation of the catalogue: "6205", "ER-10K", "NICE", "UER204"; the outer ring stands.
    speed
        Of the first shaft: "1797 rpm" or [rad/s], to within 2 %; or a channel of speeds or angles, or a `ShaftAngle`, taken as
        it is. Needed without a case.
    healthy
        Record of the same machine and sensor without damage.
    channel
        Name of the channel, where the record has several.
    quick
        Whether nothing is simulated.
    rig
        Rig of the record, as `measure` takes it; its sampling rate is the record's. The channel ``NAME.recorded`` is compared
        with its accelerometer ``NAME``, any other with the first one.
    members
        Simulated records of each cause and severity, from different starts with different noise, 2 or more; 3 if not given.
    threads
        Threads; the cores by default. It changes nothing in the result.
    progress
        Called with what is running, simulated records done, and of how many.
    stop
        An event that ends the simulations early, with `KeyboardInterrupt`.

    Returns
    -------
    Diagnosis
        ``message``, ``hypotheses()``, ``checks()``, ``lines()``, ``indices()``, ``cannot_be_told``, ``ds``, ``plot()``.

    Raises
    ------
    InputError
        For a machine that is not described or in two ways, a record that is too short, does not vary or is not finite, a
        speed that the record cannot show, and a rig that does not fit the case.
    KeyboardInterrupt
        Where it was interrupted.

    Examples
    --------
    >>> import numpy as np, gearplay as gp
    >>> t = np.arange(60_000) / 12_000.0
    >>> shocks = np.exp(-800.0 * (t % (1 / 107.4))) * np.sin(2 * np.pi * 3000.0 * (t % (1 / 107.4)))
    >>> noise = 0.1 * np.random.default_rng(0).standard_normal(t.size)
    >>> found = gp.diagnose(gp.Channel("acc", shocks + noise, 12_000.0, "g"), bearings="9, 7.94mm, 39.04mm", speed="1797 rpm")
    >>> found.hypotheses()[0]["name"], found.told
    ('bearing, outer ring', True)

    """
    chosen = _channel("record", record, channel)
    with _of_file(case):
        built = None if case is None else case if isinstance(case, Case) else load_case(case)
    machine = described(built, teeth, bearings)
    instruments = _rig(rig, built, quick=quick)
    if members is not None and (built is None or quick):
        raise InputError.of(
            "members", members, NOT_SIMULATED, "Give the case, without quick, or leave it out"
        )
    taken, found, spectrum = _prepared("record", chosen, machine, speed)
    before = earlier = None
    if healthy is not None:
        sound = _channel("healthy", healthy, channel)
        steady = None if isinstance(speed, (Channel, ShaftAngle)) else speed
        nominal = steady if steady is not None else TWO_PI * found.frequency
        before = measured_with_lines(sound, machine, nominal)
        earlier = before[0]
    result = measured(taken, machine, found, earlier, step=quantisation_step(chosen.values))
    every = ranked(machine, result, earlier)
    low, high = _band(every[0], result)
    first = (every[0].place, every[0].kind)
    placed = {first: result.bearings[first].frequency} if first in result.bearings else {}
    named, shown = _lines(taken, result, machine, spectrum, (low, high), placed)
    old = _healthy_lines(before, machine, (low, high)) if before is not None else {}
    checks = Checks()
    if built is not None and not quick:
        checks = checked(
            taken, before[1] if before is not None else None, built, instruments, machine, result.speed,
            earlier.speed if earlier is not None else result.speed, every,
            members=members or MEMBERS, threads=threads, progress=progress, stop=stop,
        )  # fmt: skip
        every = revised(every, checks)
    source = record.source if isinstance(record, Record) and record.source else chosen.name
    return Diagnosis(dataset_of(source, taken, machine, result, earlier, every, named, old, shown, checks))


def measured_with_lines(
    channel: Channel, machine: Machine, speed: float | str
) -> tuple[Measures, Channel, Any]:
    """Return measures, the signal and the spectrum of a healthy record."""
    taken, found, spectrum = _prepared("healthy", channel, machine, speed)
    return measured(taken, machine, found, step=quantisation_step(channel.values)), taken, spectrum


def _channel(path: str, record: Any, name: str | None) -> Channel:
    """Return the channel of a record; `InputError` where it is no record."""
    if isinstance(record, Channel):
        return record
    if not isinstance(record, Record):
        rule = "must be a Record or a Channel"
        raise InputError.of(path, record, rule, "Read it with gearplay.read_measurement")
    return record.channel(name)


def _rig(rig: Any, case: Case | None, *, quick: bool) -> Rig:
    """Return the rig of a record; `InputError` where there is nothing to simulate with it, or it does not fit."""
    if rig is not None and (case is None or quick):
        raise InputError.of("rig", "given", NOT_SIMULATED, "Give the case, without quick, or leave it out")
    with _of_file(rig):
        built = load_rig(rig)
        if case is not None and not quick:
            placements(built, case)
    return built


@contextmanager
def _of_file(source: object) -> Iterator[None]:
    """Name the file, of the case or the rig, in the faults of its fields; where it cannot be read it is named already."""
    try:
        yield
    except InputError as error:
        if not isinstance(source, (str, os.PathLike)):
            raise
        name = shorten(Path(source).name)
        faults = [f if f.value == str(source) else f._replace(path=f"{name}: {f.path}") for f in error.faults]
        raise InputError(faults) from None


def _nominal(path: str, machine: Machine, speed: float | str | None) -> float:
    """Return the given speed of the first shaft, else the nominal one of the case [Hz]."""
    from gearplay.schema.units import quantity_of
    from gearplay.vocabulary.quantities import ANGULAR_SPEED

    if speed is None:
        if machine.speed is None:
            rule = "must be given, within 2 % of the first shaft's"
            raise InputError.of("speed", "nothing", rule, 'Write for example "1797 rpm"')
        return machine.speed
    omega = abs(quantity_of("speed", speed, ANGULAR_SPEED))
    if omega == 0.0:
        raise InputError.of(
            "speed", speed, "must not be 0: lines count by it", f"Give the speed of the {path}"
        )
    return omega / TWO_PI


def _prepared(path: str, channel: Channel, machine: Machine, speed: Any) -> tuple[Channel, FoundSpeed, Any]:
    """Return the signal, over equal angles where the speed is a signal, the speed and the amplitude spectrum."""
    values = check_channel(channel, LEAST_SAMPLES)
    if float(np.ptp(values)) <= 1e-12 * float(np.max(np.abs(values))):
        rule = "must vary: a signal at rest shows nothing"
        raise InputError.of(f"{path}.{channel.name}", float(values[0]), rule, "Choose another channel")
    if isinstance(speed, (Channel, ShaftAngle)):
        turned = resampled(channel, speed)
        mean = float(np.mean(turned.speed)) / TWO_PI
        # Angle over mean speed: lines of the shaft are sharp, frequencies are those at the mean speed.
        taken = Channel(channel.name, turned.values, turned.samples_per_revolution * mean, channel.unit)
        nominal, given = mean, FoundSpeed(mean, float(np.std(turned.speed)) / TWO_PI, "measured")
    else:
        taken, given, nominal = channel, None, _nominal(path, machine, speed)
    if nominal * taken.duration < LEAST_TURNS:
        rule = f"must last {LEAST_TURNS} turns of the first shaft or more, {LEAST_TURNS / nominal:.4g} s"
        raise InputError.of(path, f"{taken.duration:.4g} s", rule, "Take a longer record, or check the speed")
    if nominal > 0.1 * taken.sampling:
        rule = f"must be below {0.1 * taken.sampling:.4g} Hz, a tenth of the sampling rate"
        raise InputError.of("speed", f"{nominal:.4g} Hz", rule, "Sample faster, or check the speed")
    taken = Channel(taken.name, taken.values - np.mean(taken.values), taken.sampling, taken.unit)
    spectrum = amplitude_spectrum(taken.values, taken.sampling, unit=taken.unit)
    return taken, given if given is not None else found_speed(spectrum, machine, nominal), spectrum


def _band(first: Hypothesis, result: Measures) -> tuple[float, float]:
    """Return the band whose envelope is shown: that of the leading bearing, of the mesh, else the most impulsive one."""
    combs = []
    if first.kind in PARTS:
        combs = [comb for (_, part), comb in result.bearings.items() if part == first.kind]
    elif first.kind == "rattle":
        combs = list(result.mesh)
    best = max(combs, key=lambda comb: comb.height, default=None)
    return (best.low, best.high) if best is not None and best.high > best.low else result.band


def _lines(
    channel: Channel,
    result: Measures,
    machine: Machine,
    spectrum: Any,
    band: tuple[float, float],
    placed: Mapping[Key, float] | None = None,
) -> tuple[list[NamedLine], dict[str, Any]]:
    """Return the named lines of spectrum and envelope, and both spectra as far as they are shown."""
    named = named_spectrum(spectrum.frequency, spectrum.amplitude, machine, result.speed)
    low, high = band
    if high <= low:  # too short a record for bands: all of it
        low, high = 0.02 * channel.sampling, 0.45 * channel.sampling
    made = envelope(result.rest, low, high).channel
    beat = averaged_spectrum(made, window="hann", segment=made.size)
    inside = beat.frequency <= 0.5 * (high - low)
    beats = named_envelope(beat.frequency[inside], beat.values[inside], machine, result.speed, placed)
    shown = {"frequency": spectrum.frequency, "spectrum": spectrum.amplitude, "low": low, "high": high,
             "envelope_frequency": beat.frequency[inside], "envelope": beat.values[inside]}  # fmt: skip
    return [*named, *beats], shown


def _healthy_lines(before: Any, machine: Machine, band: tuple[float, float]) -> dict[tuple[str, str], float]:
    """Return the amplitudes of the lines of a healthy record by domain and name."""
    result, channel, spectrum = before
    if band[1] > 0.5 * channel.sampling:
        band = (0.0, 0.0)
    named, _ = _lines(channel, result, machine, spectrum, band)
    return {(each.domain, each.name): each.amplitude for each in named}
