"""`gearplay measure CASE`: simulate a case and save the record of the virtual rig."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.interrupts import interruptible
from gearplay.cli.options import CaseName, Changes, si_number
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.progress import progress_bar


def measure(
    case: CaseName,
    out: Annotated[Path, typer.Option("--out", help="Write the record here; the ending names the format.")],
    rig: Annotated[
        Path | None, typer.Option("--rig", help="A rig file; that of Han et al. 2021 if not given.")
    ] = None,
    changes: Changes = None,
    duration: Annotated[
        str | None, typer.Option("--duration", help="Length of the record: 2s; the rig's or the case's.")
    ] = None,
    member: Annotated[int, typer.Option("--member", help="Member of the case's ensemble.")] = 0,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the sensors' noise.")] = 0,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing record.")] = False,
    json: Json = False,
) -> None:
    """Simulate a case and record it as a test rig would."""
    from gearplay.files.measurements import check_record_path, write_record
    from gearplay.model.reading import load_case
    from gearplay.rig import measure as record_of
    from gearplay.rig.plan import load_rig
    from gearplay.vocabulary.quantities import TIME

    length = None if duration is None else si_number("--duration", duration, TIME)
    chosen, built = load_case(case, changes or ()), load_rig(rig)
    check_record_path(out, overwrite=overwrite)
    with interruptible() as stop, progress_bar(quiet=json) as report:
        record = record_of(
            chosen, built, member=member, duration=length, seed=seed, progress=report, stop=stop
        )
    write_record(record, out, overwrite=overwrite)
    document = _summary(record, out)
    if json:
        print_json(document)
    else:
        print_text(_words(document))


def _summary(record: Any, out: Path) -> dict[str, Any]:
    first = record.channels[0]
    about = record.attributes
    return {
        "title": record.source,
        "case_sha256": about["case_sha256"],
        "rig_sha256": about["rig_sha256"],
        "member": int(about["member"]),
        "seed": about["seed"],
        "samples": int(first.values.size),
        "sampling": first.sampling,
        "duration": first.duration,
        "sensors": {
            name: _sensor(record, name)
            for name in (c.name.rpartition(".")[0] for c in record.channels if c.name.endswith(".counts"))
        },
        "out": str(out),
    }


def _sensor(record: Any, name: str) -> dict[str, Any]:
    """Return a summary of one sensor's channels: rms and peak [m/s^2], clipped samples."""
    ideal, recorded = (record.channel(f"{name}.{which}") for which in ("acceleration", "recorded"))
    return {
        "place": record.attributes[f"{name}_place"],
        "sensor": recorded.attributes["sensor"],
        "rms": float((ideal.values**2).mean() ** 0.5),
        "peak": float(abs(ideal.values).max()),
        "recorded_rms": float((recorded.values**2).mean() ** 0.5),
        "recorded_peak": float(abs(recorded.values).max()),
        **{
            key: recorded.attributes[key]
            for key in recorded.attributes
            if key.startswith(("sensor_saturated", "converter_clipped"))
        },
    }


def _words(d: dict[str, Any]) -> str:
    lines = [
        f"{d['title'] or 'untitled'}: {d['samples']} samples at {d['sampling']:g} Hz, {d['duration']:g} s",
        f"{'sensor':<20}{'rms':>16}{'peak':>16}{'recorded rms':>16}{'recorded peak':>16}  [m/s^2]",
    ]
    for name, s in d["sensors"].items():
        lines.append(
            f"{name:<20}{s['rms']:>16.4g}{s['peak']:>16.4g}{s['recorded_rms']:>16.4g}{s['recorded_peak']:>16.4g}"
        )
        for what, words in (
            ("sensor_saturated", "the sensor saturated"),
            ("converter_clipped", "the converter clipped"),
        ):
            if s[what] == "yes":
                share = 100.0 * float(s[f"{what}_share"])
                lines.append(
                    f"{name}: {words} in {share:.3g} % of the samples, first at {s[f'{what}_first']}"
                )
    lines.append(f"Saved to {d['out']}")
    return "\n".join(lines)
