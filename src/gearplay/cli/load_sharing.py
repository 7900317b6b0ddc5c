"""`gearplay load-sharing CASE`: shares of the planets in the load, at rest under it or along a stored motion."""

from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.options import Changes
from gearplay.cli.output import Json, print_json, print_text, result_lines


def load_sharing(
    case: Annotated[
        str, typer.Argument(metavar="CASE", help="Bundled name or TOML file; a stored result, RUN.nc.")
    ],
    name: Annotated[
        str | None, typer.Option("--name", help="Planetary set; needed where there are several.")
    ] = None,
    changes: Changes = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder [default: out/load-sharing-CASE].")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Show how planets share the load.

    Of a case: at rest under its load, across clearances and pin errors. Of a stored result: along its motion.
    """
    import gearplay as gp
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.pictures.canvas import to_png
    from gearplay.vocabulary.errors import InputError

    stored = case.endswith(".nc")
    if stored and changes:
        rule = "must not be given with a stored result, whose case is fixed"
        raise InputError.of("--set", changes[0], rule, "Name the case, or simulate it anew")
    folder = out if out is not None else Path("out") / f"load-sharing-{Path(case).stem}"
    data, picture = folder / "load-sharing.nc", folder / "load-sharing.png"
    for each in (data, picture):
        check_new(each, overwrite=overwrite)
    source = gp.read_result(case) if stored else gp.load_case(case, changes or ())
    if stored and not isinstance(source, gp.Result):
        rule = "must be a result of gearplay run, whose motion has positions and forces"
        raise InputError.of("case", case, rule, "Name a case, or such a result")
    found = gp.load_sharing(source, name=name)
    drawn = to_png(found.plot())
    found.save(data, overwrite=overwrite)
    write_bytes(picture, drawn)
    if json:
        factors = found.ds["load_sharing_factor"]
        print_json(
            {
                "set": str(found.ds.attrs["set"]),
                "load_sharing_factor": dict(zip(map(str, factors["planet"].values), factors.values.tolist(), strict=True)),
                "out": str(data),
                "picture": str(picture),
            }
        )  # fmt: skip
    else:
        print_text("\n".join([*result_lines(found, Path(case).stem), f"Written: {data}, {picture}"]))
