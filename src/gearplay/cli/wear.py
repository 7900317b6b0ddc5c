"""`gearplay wear CASE`: wear of flanks and plain bearings over the life of a case."""

from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.interrupts import interruptible
from gearplay.cli.options import CaseName, Changes
from gearplay.cli.output import Json, print_json, print_text, result_lines
from gearplay.cli.progress import progress_bar


def wear(
    case: CaseName,
    turns: Annotated[float, typer.Option("--turns", help="Life in turns of the reference rotor: 1e6.")],
    blocks: Annotated[int, typer.Option("--blocks", min=1, help="Simulated blocks.")] = 10,
    rotor: Annotated[
        str | None, typer.Option("--rotor", help="Rotor whose turns count [default: the first with a drive].")
    ] = None,
    changes: Changes = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/wear-CASE].")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Show how flanks and plain bearings wear over life.

    Writes the result, its picture and the worn case, worn.toml, which every other command takes.
    """
    import gearplay as gp
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.model.reading import to_toml
    from gearplay.pictures.canvas import to_png

    folder = out if out is not None else Path("out") / f"wear-{Path(case).stem}"
    data, picture, worn = (folder / name for name in ("wear.nc", "wear.png", "worn.toml"))
    for place in (data, picture, worn):
        check_new(place, overwrite=overwrite)
    with interruptible(), progress_bar(quiet=json) as report:
        found = gp.wear(
            gp.load_case(case, changes or ()), turns=turns, blocks=blocks, rotor=rotor, progress=report
        )
    drawn, text = to_png(found.plot()), to_toml(found.worn_case)
    found.save(data, overwrite=overwrite)
    write_bytes(picture, drawn)
    write_bytes(worn, text.encode())
    if json:
        ds = found.ds
        last = {
            name: dict(zip(map(str, ds[dim].values), values.tolist(), strict=True))
            for name, dim in (("backlash", "mesh"), ("radial_clearance", "sleeve"))
            if name in ds
            for values in [ds[name].values[-1]]
        }
        places = {"out": str(data), "picture": str(picture), "worn_case": str(worn)}
        print_json({"message": found.message, "turns": turns, **last, **places})
    else:
        lines = result_lines(found, Path(case).stem)
        print_text("\n".join([*lines, f"Written: {data}, {picture}, {worn}"]))
