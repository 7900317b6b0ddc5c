"""`gearplay export RESULT.nc --out FULL.nc`: samples of a result for other programs."""

from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.options import si_number
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.plot import Run, result_in


def export(
    run: Run,
    out: Annotated[
        Path, typer.Option("--out", help="A .nc (netCDF-4, CF), .csv or .mat.", show_default=False)
    ],
    signals: Annotated[
        list[str] | None,
        typer.Option("--signal", help="A signal, ax or ring.ax; by default all. May be repeated."),
    ] = None,
    sampling: Annotated[
        str | None,
        typer.Option("--sampling", help="Samples per second: 10kHz; by default those of the record."),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")] = False,
    json: Json = False,
) -> None:
    """Write signals of a result as plain netCDF, CSV or MAT."""
    from gearplay.files.atomic import check_new
    from gearplay.files.netcdf import check_ending
    from gearplay.vocabulary.quantities import FREQUENCY

    check_ending(out)
    check_new(out, overwrite=overwrite)
    rate = None if sampling is None else si_number("--sampling", sampling, FREQUENCY)
    result = result_in(run)
    result.save(
        out, overwrite=overwrite, signals=signals, sampling=rate, full=signals is None and rate is None
    )
    size = out.stat().st_size / 1e6
    if json:
        print_json({"status": "done", "out": str(out), "size": size})
    else:
        print_text(f"Wrote {out}, {size:.3g} MB")
