"""`gearplay diagnose RECORD`: named lines, indices and ranked hypotheses of a record of a machine."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.options import Calibrations, Pulses, Units, si_number
from gearplay.cli.output import Json, print_json, print_text

LISTED = 3
"""Number of hypotheses printed with their evidence."""


def diagnose(
    record: Annotated[Path, typer.Argument(help="A measured or simulated record, or a result of a run.")],
    case: Annotated[
        str | None, typer.Option("--case", help="A case file, or a bundled case, with the gears.")
    ] = None,
    teeth: Annotated[
        str | None,
        typer.Option("--teeth", help='Teeth of driver and driven gear: 23:61; of stages "23:61, 19:47".'),
    ] = None,
    bearings: Annotated[
        list[str] | None,
        typer.Option(
            "--bearing",
            help='Elements, their diameter, pitch diameter: 8,7.9mm,33.5mm, or 6205; on shaft 2 "...@2". May be repeated.',
        ),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            "--speed",
            help='Speed of the first shaft, within 2 %: "1797 rpm", a channel, a scalar, or a file of speeds.',
        ),
    ] = None,
    pulses: Pulses = None,
    healthy: Annotated[
        Path | None, typer.Option("--healthy", help="Record of the same machine without damage.")
    ] = None,
    channel: Annotated[
        str | None, typer.Option("--channel", help="Channel; not needed where there is only one.")
    ] = None,
    sampling: Annotated[
        str | None, typer.Option("--sampling", help="Sampling rate of a file without one: 12kHz.")
    ] = None,
    units: Units = None,
    calibration: Calibrations = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Simulate nothing: hypotheses from the record alone.")
    ] = False,
    rig: Annotated[
        Path | None, typer.Option("--rig", help="Rig file of the record, for its simulated ones.")
    ] = None,
    members: Annotated[
        int | None,
        typer.Option(
            "--members", min=2, max=64, help="Simulated records of each cause and severity [default: 3]."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder of result and picture; none by default.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Name the lines of a record and rank what may be wrong.

    Each hypothesis comes with its evidence in figures and a confidence; what the record cannot decide is said. With --case the
    hypotheses, worn flanks and worn bushes are simulated and compared with the record.
    """
    import gearplay as gp
    from gearplay.cli.interrupts import interruptible
    from gearplay.cli.progress import progress_bar
    from gearplay.cli.records import calibration_of, record_in, speed_of, units_of
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.files.json_text import finite
    from gearplay.pictures.canvas import to_png
    from gearplay.vocabulary.quantities import FREQUENCY

    files = [] if out is None else [out / "diagnosis.nc", out / "diagnosis.png"]
    for each in files:
        check_new(each, overwrite=overwrite)
    rate = None if sampling is None else si_number("--sampling", sampling, FREQUENCY)
    own_units = units_of(units or ())
    factors = calibration_of(calibration or (), own_units)
    held, usual = record_in(record, rate, own_units, factors)
    name = channel or usual
    turning = speed_of(held, speed, pulses)
    sound = None if healthy is None else record_in(healthy, rate, own_units, factors)[0]
    with interruptible() as stop, progress_bar(quiet=json) as report:
        found = gp.diagnose(
            held,
            case=case,
            teeth=teeth,
            bearings=list(bearings or ()),
            speed=turning,
            healthy=sound,
            channel=name,
            quick=quick,
            rig=rig,
            members=members,
            progress=report,
            stop=stop,
        )
    if out is not None:
        drawn = to_png(found.plot())
        found.save(files[0], overwrite=overwrite)
        write_bytes(files[1], drawn)
    if json:
        print_json(finite(_document(found, files)))
    else:
        print_text(
            "\n".join([*_words(found), *(f"Written: {', '.join(map(str, files))}" for _ in files[:1])])
        )


def _document(found: Any, files: list[Path]) -> dict[str, Any]:
    return {
        "summary": found.message,
        "told": found.told,
        "stated_confidence": float(found.ds.attrs["stated_confidence"]),
        "channel": found.ds.attrs["channel"],
        "shaft_speed": float(found.ds["shaft_speed"]),
        "shaft_speed_uncertainty": float(found.ds["shaft_speed_uncertainty"]),
        "speed_source": found.ds.attrs["speed_source"],
        "hypotheses": found.hypotheses(),
        "checks": found.checks(),
        "cannot_be_told": found.cannot_be_told,
        "indices": found.indices(),
        "lines": found.lines(),
        "files": [str(path) for path in files],
    }


def _words(found: Any) -> list[str]:
    """Return the report as text: conclusion, hypotheses, limits of the record, lines, indices."""
    unit = found.ds["spectrum"].attrs["units"]
    rows = [found.message, "hypotheses:"]
    for each in found.hypotheses()[:LISTED]:
        rows.append(f"  {each['confidence']:.2f}  {each['name']}")
        rows += [
            f"          {e['words']}: {e['value']:.3g} (counts from {e['threshold']:.3g})"
            for e in each["evidence"]
        ]
    if found.checks():
        rows.append("simulated records of the case, deviation over spread and allowed error:")
        rows += [_check(each) for each in found.checks()]
    rows += (
        ["cannot be told:", *(f"  {sentence}" for sentence in found.cannot_be_told)]
        if found.cannot_be_told
        else []
    )
    low, high = found.ds.attrs["envelope_low"], found.ds.attrs["envelope_high"]
    for domain, title in (
        ("spectrum", "spectrum:"),
        ("envelope", f"envelope from {low:.5g} to {high:.5g} Hz:"),
    ):
        lines = [line for line in found.lines(domain) if line["frequency"] == line["frequency"]]
        rows += [title, *(_line(line, unit) for line in lines)] if lines else [f"{title} no line stands out"]
    with_healthy = any(index["healthy"] == index["healthy"] for index in found.indices())
    rows.append("indices, against the healthy record:" if with_healthy else "indices:")
    for index in found.indices():
        against = f" (healthy {index['healthy']:.4g})" if index["healthy"] == index["healthy"] else ""
        rows.append(f"  {index['name']}: {index['value']:.4g}{against}")
    return rows


def _check(each: dict[str, Any]) -> str:
    level = f", {each['level']}" if each["level"] else ""
    alike = "" if each["alike"] else " (further off than chance)"
    return f"  {each['deviation']:.2f} ± {each['spread']:.2f}  {each['name']}{level}{alike}"


def _line(line: dict[str, Any], unit: str) -> str:
    expected = f", expected {line['expected']:.6g} Hz" if line["expected"] == line["expected"] else ""
    healthy = f", healthy {line['healthy']:.3g}" if line["healthy"] == line["healthy"] else ""
    height = f"{line['amplitude']:.3g}{'' if unit == '1' else f' {unit}'}"
    return f"  {line['frequency']:.6g} Hz: {height}{healthy}, {line['name']}{expected}"
