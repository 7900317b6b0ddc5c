"""`gearplay analyze RECORD`: look at a measured or simulated record: statistics, lines and a page of figures."""

import math
from dataclasses import asdict
from pathlib import Path
from textwrap import wrap
from typing import Annotated, Any

import typer

from gearplay.cli.output import Json, pictures_in, print_json, print_text

LISTED = 12
"""Of more channels only the names are printed."""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(analyze)


def analyze(
    record: Annotated[Path, typer.Argument(help="A measured or simulated record, or a result of a run.")],
    channel: Annotated[
        str | None,
        typer.Option("--channel", help="Which channel, of a run ring.ax; not needed where there is one."),
    ] = None,
    lines: Annotated[
        list[float] | None,
        typer.Option("--line", help="Frequency [Hz] to look for a line near. May be repeated."),
    ] = None,
    speed: Annotated[
        str | None, typer.Option("--speed", help='Shaft speed for orders: "120 rpm", or a channel\'s name.')
    ] = None,
    band: Annotated[
        tuple[float, float] | None,
        typer.Option("--band", metavar="LOW HIGH", help="Band of the envelope spectrum [Hz]."),
    ] = None,
    sampling: Annotated[
        float | None, typer.Option("--sampling", help="Sampling rate [Hz] where the file does not say it.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder of the figures; none if not given.")
    ] = None,
    json: Json = False,
) -> None:
    """Show statistics, lines and figures of a measured channel.

    Lines come with their uncertainty.
    """
    from gearplay.signals.line_tables import line_table
    from gearplay.signals.statistics import signal_statistics

    held, usual = _read(record, sampling)
    chosen, turning = held.channel(channel or usual), _speed(held, speed)
    table = line_table(chosen, lines) if lines else None
    figures: list[Path] = []
    if out is not None:
        from gearplay.signals.figures import draw_record

        figures = draw_record(chosen, out, speed=turning, expected=lines or (), band=band)
    document: dict[str, Any] = {
        "record": held.source,
        "format": held.format,
        "channels": [
            {"name": c.name, "unit": c.unit, "samples": int(c.values.size), "sampling": c.sampling}
            for c in held.channels
        ],
        "channel": chosen.name,
        "statistics": asdict(signal_statistics(chosen, remove_mean=True)),
        "lines": [asdict(row) for row in table.rows] if table is not None else [],
        "settings": table.caption if table is not None else "",
        "figures": [str(path) for path in figures],
    }
    document = _finite(document)
    if json:
        print_json(document)
    else:
        print_text(_words(document))


def _read(path: Path, sampling: float | None) -> tuple[Any, str | None]:
    """Return the record in a file, or the run in a file as one, and the channel of a run that says most."""
    from gearplay.files.measurements import read_measurement

    if path.suffix.lower() in (".nc", ".nc4") and path.is_file() and sampling is None:
        from gearplay.files.netcdf import read_dataset
        from gearplay.python_door import kind_of
        from gearplay.results.recorded import record_of, usual_channel
        from gearplay.results.result import Result

        dataset = read_dataset(path)
        if kind_of(dataset) == Result.answer:
            result = Result.from_dataset(dataset)
            return record_of(result), usual_channel(result)
    return read_measurement(path, sampling=sampling), None


def _speed(held: Any, speed: str | None) -> Any:
    """Return a speed in rad/s, or the channel of that name."""
    if speed is None or speed in held.names:
        return None if speed is None else held.channel(speed)
    from gearplay.model.units import UnitError, parse_quantity
    from gearplay.vocabulary.errors import Fault, InputError
    from gearplay.vocabulary.quantities import ANGULAR_SPEED

    try:
        return parse_quantity(speed, ANGULAR_SPEED)
    except UnitError as error:
        cure = f"Or name a channel: {', '.join(held.names[:12])}"
        raise InputError(Fault("--speed", speed, error.rule, cure)) from None


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _words(document: dict[str, Any]) -> str:
    s = document["statistics"]
    unit = s["unit"] or "1"
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
    rows.append(f"{document['channel']}: rms {s['rms']:.4g} {unit}, peak {s['peak']:.4g} {unit}{shape}")
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
    if document["figures"]:
        rows += pictures_in(Path(document["figures"][0]).parent)
    return "\n".join(rows)
