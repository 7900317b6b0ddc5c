"""``gearplay import FILE``: a case from the file of a gearbox program."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gearplay.cli.output import Json, print_json, print_text, say


def import_(
    path: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="A gearbox in REXS 1.0 to 1.6: XML, JSON or zip.", show_default=False
        ),
    ],
    out: Annotated[Path, typer.Option("--out", help="Case file.")] = Path("case.toml"),
    load_case: Annotated[
        int | None, typer.Option("--load-case", help="Number of a load case; the first if not given.")
    ] = None,
    gear_bodies: Annotated[
        str,
        typer.Option(
            "--gear-bodies", help="solid adds gears, solid to the reference circle, to the shafts' mass."
        ),
    ] = "none",
    allowance: Annotated[
        str, typer.Option("--allowance", help="Series of DIN 3967 for pairs that have none in the file.")
    ] = "c25",
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")] = False,
    json: Json = False,
) -> None:
    """Import a gearbox from another program as a case."""
    from gearplay.files.atomic import check_new
    from gearplay.rexs.importing import import_rexs

    check_new(out, overwrite=overwrite)
    found = import_rexs(path, load_case=load_case, gear_bodies=gear_bodies, allowance=allowance)
    found.save(out, overwrite=overwrite)
    if json:
        notes = [{"kind": note.kind, "text": note.text} for note in found.notes]
        print_json({"status": "done", "out": str(out), "sha256": found.case.sha256, "notes": notes})
        return
    for note in found.notes:
        say(str(note))
    print_text(f"{found.message}\nWrote {out}\nNext: gearplay check {out}; gearplay run {out}")
