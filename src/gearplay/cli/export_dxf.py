"""`gearplay export dxf CASE --out gears.dxf`: the gears of a case as a drawing."""

from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.options import CaseName, Changes
from gearplay.cli.output import Json, print_json, print_text


def export_dxf(
    case: CaseName,
    out: Annotated[Path | None, typer.Option("--out", help="The file [default: CASE.dxf].")] = None,
    changes: Changes = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")] = False,
    json: Json = False,
) -> None:
    """Write the gears of a case as a DXF drawing."""
    import gearplay as gp

    place = Path(f"{Path(case).stem}.dxf") if out is None else out
    made = gp.export_dxf(gp.load_case(case, changes or ()), place, overwrite=overwrite)
    size = made.stat().st_size / 1e6
    if json:
        print_json({"status": "done", "out": str(made), "size": size})
    else:
        print_text(f"Wrote {made}, {size:.3g} MB")
