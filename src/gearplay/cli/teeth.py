"""`gearplay teeth CASE`: a gear pair as drawn, its path of contact, stiffness and contact ratio."""

from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.options import CaseName, Changes
from gearplay.cli.output import Json, print_json, print_text


def teeth(
    case: CaseName,
    mesh: Annotated[
        str | None, typer.Option("--mesh", help="Mesh, DRIVER-DRIVEN; needed where there are several.")
    ] = None,
    changes: Changes = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/teeth-CASE].")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Show a gear pair as drawn, its path of contact and stiffness."""
    import gearplay as gp
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.pictures.canvas import to_png

    folder = out if out is not None else Path("out") / f"teeth-{Path(case).stem}"
    data, picture = folder / "teeth.nc", folder / "teeth.png"
    for each in (data, picture):
        check_new(each, overwrite=overwrite)
    found = gp.teeth(gp.load_case(case, changes or ()), mesh)
    drawn = to_png(found.plot())
    found.save(data, overwrite=overwrite)
    write_bytes(picture, drawn)
    if json:
        stiffness = found.ds["mesh_stiffness"].values
        print_json(
            {
                "mesh": str(found.ds.attrs["mesh"]),
                "gears": found.gears,
                "pair": found.values,
                "stiffness": {
                    "mean": found.values["mean_stiffness"],
                    "least": float(stiffness.min()),
                    "largest": float(stiffness.max()),
                },
                "out": str(data),
                "picture": str(picture),
            }
        )  # fmt: skip
        return
    width = max(len(name) for name, _ in found.rows())
    lines = [f"{name:<{width}}  {value}" for name, value in found.rows()]
    print_text("\n".join([*lines, found.message, f"Written: {data}, {picture}"]))
