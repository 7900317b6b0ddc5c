"""`gearplay export fmu CASE --inputs motor.drive.torque --outputs load.theta --out drive.fmu`: a case for other simulators."""

from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.options import CaseName, Changes
from gearplay.cli.output import Json, print_json, print_text


def export_fmu(
    case: CaseName,
    out: Annotated[Path, typer.Option("--out", help="The file, drive.fmu.", show_default=False)],
    inputs: Annotated[
        str,
        typer.Option(
            "--inputs", help="Torques and set-points, with commas: pinion.drive.torque,ring.load.torque"
        ),
    ] = "",
    outputs: Annotated[
        str, typer.Option("--outputs", help="Signals, with commas: ring.theta,ring.omega,ring.ax")
    ] = "",
    tune: Annotated[
        str, typer.Option("--tune", help="Fields that become parameters, with commas: meshes.0.backlash")
    ] = "",
    fmi: Annotated[int, typer.Option("--fmi", help="3 or 2: FMI 3.0 or 2.0.")] = 3,
    platforms: Annotated[
        str,
        typer.Option("--platforms", help="Of linux64,win64,aarch64-linux; by default this one."),
    ] = "",
    member: Annotated[
        int, typer.Option("--member", help="Member of the case's ensemble whose start it is.")
    ] = 0,
    changes: Changes = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")] = False,
    json: Json = False,
) -> None:
    """Write a case as an FMU for co-simulation, without Python."""
    import gearplay as gp

    made = gp.export_fmu(
        gp.load_case(case, changes or []),
        out,
        inputs=_listed(inputs),
        outputs=_listed(outputs),
        tune=_listed(tune),
        fmi=fmi,
        platforms=_listed(platforms) or None,
        member=member,
        overwrite=overwrite,
    )
    size = made.stat().st_size / 1e6
    if json:
        print_json({"status": "done", "out": str(made), "size": size})
    else:
        print_text(f"Wrote {made}, {size:.3g} MB, FMI {fmi}.0")


def _listed(text: str) -> list[str]:
    return [each.strip() for each in text.split(",") if each.strip()]
