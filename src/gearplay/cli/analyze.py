"""`gearplay analyze RECORD`: statistics, lines and a report page of a measured or simulated record."""

from dataclasses import asdict
from pathlib import Path
from textwrap import wrap
from typing import Annotated, Any

import typer

from gearplay.cli.alarms import alarm_against, check_alarm
from gearplay.cli.options import Calibrations, Pulses, Units, si_number
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.records import calibration_of, full_scale_of, record_in, speed_of, units_of

ENVELOPE_LINES = 8
"""Number of printed lines of an envelope."""
LISTED = 12
"""Number of channels beyond which only names are printed."""
LEAST_SAMPLES = 64
"""Samples from which a speed is sought."""


def analyze(
    record: Annotated[Path, typer.Argument(help="A measured or simulated record, or a result of a run.")],
    channel: Annotated[
        str | None,
        typer.Option(
            "--channel", help="Channel; of a run for example ring.ax. Not needed where there is only one."
        ),
    ] = None,
    lines: Annotated[
        list[str] | None,
        typer.Option("--line", help="Frequency near which to search a line: 700Hz. May be repeated."),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            "--speed",
            help='Shaft speed for orders: "120 rpm", a channel or a scalar of the file (X097RPM, "rate Hz"), a file of speeds.',
        ),
    ] = None,
    pulses: Pulses = None,
    teeth: Annotated[
        int | None,
        typer.Option("--teeth", min=3, help="Teeth of the gear on the shaft of --speed, for its indicators."),
    ] = None,
    healthy: Annotated[
        Path | None,
        typer.Option("--healthy", help="Folder of healthy records: an alarm where indicators exceed theirs."),
    ] = None,
    false_alarms: Annotated[
        float | None,
        typer.Option("--false-alarms", help="Share of healthy records that raise an alarm [default: 0.02]."),
    ] = None,
    band: Annotated[
        tuple[str, str] | None,
        typer.Option("--band", metavar="LOW HIGH", help="Band of the envelope spectrum: 2kHz 4kHz."),
    ] = None,
    envelope: Annotated[
        bool,
        typer.Option("--envelope", help="Lines of the envelope of the most impulsive band, by a kurtogram."),
    ] = False,
    sampling: Annotated[
        str | None, typer.Option("--sampling", help="Sampling rate of a file without one: 12.8kHz.")
    ] = None,
    units: Units = None,
    calibration: Calibrations = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder of the figures; no figures by default.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing figures.")] = False,
    json: Json = False,
) -> None:
    """Show statistics, lines and figures of a measured channel.

    Lines come with their uncertainty.
    """
    from gearplay.files.json_text import finite
    from gearplay.signals.line_tables import line_table
    from gearplay.signals.statistics import signal_statistics
    from gearplay.vocabulary.quantities import FREQUENCY

    if out is not None:
        from gearplay.signals.figures import check_pictures

        check_pictures(out, overwrite=overwrite)
    rate = None if sampling is None else si_number("--sampling", sampling, FREQUENCY)
    expected = [si_number("--line", text, FREQUENCY) for text in lines or ()]
    ends = (
        None
        if band is None
        else (si_number("--band", band[0], FREQUENCY), si_number("--band", band[1], FREQUENCY))
    )
    own_units = units_of(units or ())
    factors = calibration_of(calibration or (), own_units)
    held, usual = record_in(record, rate, own_units, factors)
    check_alarm(record, healthy, teeth, false_alarms, speed, held)
    chosen, turning = held.channel(channel or usual), speed_of(held, speed, pulses)
    ends = _most_impulsive(chosen, ends) if envelope else ends
    indicators = None if teeth is None else _indicators(chosen, turning, teeth)
    alarm = None
    if healthy is not None and teeth is not None:

        def found_in(path: Path) -> Any:
            each, its = record_in(path, rate, own_units, factors)
            return _gear_indicators(each.channel(channel or its), speed_of(each, speed, pulses), teeth)[0]

        alarm = alarm_against(_gear_indicators(chosen, turning, teeth)[0], healthy, found_in, false_alarms)
    table = line_table(chosen, expected) if expected else None
    found = None if ends is None else _envelope_lines(chosen, *ends)
    figures: list[Path] = []
    if out is not None:
        from gearplay.signals.figures import draw_record

        figures = draw_record(chosen, out, speed=turning, expected=expected, band=ends, overwrite=overwrite)
    document: dict[str, Any] = {
        "record": held.source,
        "format": held.format,
        "channels": [
            {"name": c.name, "unit": c.unit, "samples": c.size, "sampling": c.sampling} for c in held.channels
        ],
        "channel": chosen.name,
        "statistics": asdict(signal_statistics(chosen, remove_mean=True)),
        "lines": [asdict(row) for row in table.rows] if table is not None else [],
        "settings": table.caption if table is not None else "",
        "envelope": found,
        "indicators": indicators,
        "alarm": alarm,
        "full_scale": full_scale_of(held) if chosen.name not in factors else "",
        "left_out": held.attributes.get("left out", ""),
        "figures": [str(path) for path in figures],
    }
    document = finite(document)
    if json:
        print_json(document)
    else:
        print_text(_words(document))


def _most_impulsive(channel: Any, band: tuple[float, float] | None) -> tuple[float, float]:
    """Return the most impulsive band; `InputError` where one is given."""
    from gearplay.signals.envelopes import most_impulsive_band
    from gearplay.vocabulary.errors import InputError

    if band is not None:
        rule = "must not be given with --band, which names the band"
        raise InputError.of("--envelope", "given", rule, "Leave one of them out")
    return most_impulsive_band(channel)


def _indicators(channel: Any, speed: Any, teeth: int) -> dict[str, Any]:
    """Return the condition indicators of the gear on the shaft that turns with a speed."""
    found, settings = _gear_indicators(channel, speed, teeth)
    return {**asdict(found), "settings": settings}


def _gear_indicators(channel: Any, speed: Any, teeth: int) -> tuple[Any, str]:
    """Return the condition indicators of a gear, and the settings of their average as text.

    A given speed is sought at the mesh lines, as in a diagnosis: an average at one off by a turn in the record holds no tooth.
    """
    from gearplay.diagnosis.shaft_speed import speed_of_gear
    from gearplay.signals.checks import TWO_PI, check_channel
    from gearplay.signals.indicators import gear_indicators
    from gearplay.signals.synchronous import synchronous_average
    from gearplay.vocabulary.errors import InputError

    if speed is None:
        rule = "must be given with --teeth: indicators are of the average over the turns of the gear's shaft"
        raise InputError.of("--speed", "nothing", rule, 'Write for example --speed "1500 rpm"')
    if not isinstance(speed, float):
        average = synchronous_average(channel, speed)
        return gear_indicators(average, teeth), average.caption
    check_channel(channel, LEAST_SAMPLES)
    found = speed_of_gear(channel, teeth, abs(speed) / TWO_PI)
    average = synchronous_average(channel, TWO_PI * found.frequency)
    return gear_indicators(average, teeth), f"{average.caption}; {found.words}"


def _envelope_lines(channel: Any, low: float, high: float) -> dict[str, Any]:
    """Return the largest lines of the envelope spectrum of a band: local maxima up to half the width of the band."""
    import numpy as np

    from gearplay.signals.envelopes import envelope_spectrum

    made = envelope_spectrum(channel, low, high)
    frequency, values = made.spectrum.frequency, made.spectrum.values
    inside = frequency <= 0.5 * (high - low)
    frequency, values = frequency[inside], values[inside]
    peaks = [k for k in range(2, values.size - 1) if values[k - 1] < values[k] >= values[k + 1]]
    largest = sorted(peaks, key=lambda k: -values[k])[:ENVELOPE_LINES]
    return {
        "low": low,
        "high": high,
        "median": float(np.median(values)),
        "lines": [{"frequency": float(frequency[k]), "amplitude": float(values[k])} for k in largest],
        "settings": made.caption,
    }


def _words(document: dict[str, Any]) -> str:
    s = document["statistics"]
    unit = s["unit"] or "?"
    rows = [f"{document['record']} ({document['format']})"]
    channels = document["channels"]
    if len(channels) > LISTED:
        names = ", ".join(c["name"] for c in channels)
        rows += wrap(
            f"{len(channels)} channels: {names}",
            118,
            initial_indent="  ",
            subsequent_indent="    ",
            break_on_hyphens=False,
        )
        channels = [c for c in channels if c["name"] == document["channel"]]
    rows += [
        f"  {c['name']} [{c['unit'] or '?'}]: {c['samples']} samples at {c['sampling']:g} Hz"
        for c in channels
    ]
    shape = "".join(
        f", {words} {s[key]:.3g}"
        for key, words in (
            ("crest_factor", "crest factor"),
            ("kurtosis", "kurtosis"),
            ("skewness", "skewness"),
        )
        if s[key] is not None
    )
    level = f"mean {s['mean']:.4g} {unit}; about it rms {s['rms']:.4g} {unit}, peak {s['peak']:.4g} {unit}"
    rows.append(f"{document['channel']}: {level}{shape}")
    for line in document["lines"]:
        if not line["found"]:
            rows.append(f"  {line['expected']:.6g} Hz: {line['remark']}")
            continue
        rows.append(
            f"  {line['frequency']:.6g} ± {line['frequency_uncertainty']:.2g} Hz:"
            f" {line['amplitude']:.4g} ± {line['amplitude_uncertainty']:.2g} {unit}"
        )
    if document["settings"]:
        rows.append(f"  ({document['settings']})")
    if document["envelope"] is not None:
        found = document["envelope"]
        rows.append(
            f"envelope from {found['low']:.6g} to {found['high']:.6g} Hz, median {found['median']:.3g} {unit}:"
        )
        rows += [f"  {line['frequency']:.6g} Hz: {line['amplitude']:.4g} {unit}" for line in found["lines"]]
    if document["indicators"] is not None:
        rows += _indicator_rows(document["indicators"])
    if document["alarm"] is not None:
        alarm = document["alarm"]
        verdict = "ALARM" if alarm["raised"] else "no alarm"
        rows += [
            f"{verdict}: score {alarm['score']:.3g}, threshold {alarm['threshold']:.3g}",
            f"  ({alarm['settings']})",
        ]
    if document["full_scale"]:
        rows.append(
            f"{document['full_scale']}: full scale of the file is 1 {unit}; set another with --calibration"
            f' "{document["channel"]}=9.81 m/s^2"'
        )
    if document["left_out"]:
        rows.append(f"left out, as they are no evenly sampled real numbers: {document['left_out']}")
    if document["figures"]:
        made = [Path(each) for each in document["figures"]]
        rows.append(f"Pictures in {made[0].parent}: {', '.join(sorted(each.name for each in made))}")
    return "\n".join(rows)


def _indicator_rows(found: dict[str, Any]) -> list[str]:
    """Return the indicators as lines of text, those of one scale beside each other."""
    unit = found["unit"] or "?"
    rows = [f"indicators of the gear of {found['teeth']} teeth, from the average over its turn:"]
    names = {"rms": "rms", "kurtosis": "kurtosis", "crest_factor": "crest factor", "fm0": "FM0", "fm4": "FM4", "m6a": "M6A",
             "m8a": "M8A", "na4": "NA4", "nb4": "NB4", "energy_ratio": "energy ratio", "sideband_index": "sideband index",
             "sideband_level_factor": "sideband level factor"}  # fmt: skip
    for name, words in names.items():
        value = "not defined" if found[name] is None else f"{found[name]:.4g}"
        rows.append(f"  {words:>21}  {value}{f' {unit}' if name in ('rms', 'sideband_index') else ''}")
    return [*rows, f"  ({found['settings']})"]
