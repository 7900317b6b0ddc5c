"""`gearplay portrait CASE`: orbits in the clearance circles and phase portraits of the settled motion."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.options import CaseName, Changes, Period, period_of
from gearplay.cli.output import Json, print_json, print_text, result_lines


def portrait(
    case: CaseName,
    rotor: Annotated[
        list[str] | None, typer.Option("--rotor", help="A rotor to draw; all if not given. May be repeated.")
    ] = None,
    settle: Annotated[int, typer.Option("--settle", help="Periods that pass first.")] = 200,
    keep: Annotated[int, typer.Option("--keep", help="Periods of the sections and onsets.")] = 500,
    show: Annotated[int, typer.Option("--show", help="Periods of the path.")] = 60,
    period: Period = "mesh",
    changes: Changes = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/portrait-CASE].")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Draw orbits, phase portraits and sections of a motion.

    The motion has settled; sections are taken once per period and at each onset of a contact.
    """
    import gearplay as gp
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.pictures.canvas import to_png
    from gearplay.vocabulary.errors import InputError

    base = gp.load_case(case, changes or ())
    for name in rotor or ():
        if name not in base.rotors:
            rule = "must be a rotor of the case"
            raise InputError.of("--rotor", name, rule, f"Choose from: {', '.join(base.rotors)}")
    folder = out if out is not None else Path("out") / f"portrait-{Path(case).stem}"
    data, picture = folder / "portrait.nc", folder / "portrait.png"
    for each in (data, picture):
        check_new(each, overwrite=overwrite)
    found = gp.portrait(base, settle=settle, keep=keep, show=show, period=period_of(period))
    drawn = to_png(found.plot(rotors=tuple(rotor or ())))
    found.save(data, overwrite=overwrite)
    write_bytes(picture, drawn)
    document: dict[str, Any] = {
        "title": base.title,
        "period": found.ds.attrs["period"],
        "sections": int(found.ds.sizes["section_time"]),
        "onsets": int(found.ds.sizes["onset_time"]),
        "late": found.ds.attrs["late"],
        "out": str(data),
        "picture": str(picture),
    }
    if json:
        print_json(document)
    else:
        print_text("\n".join([*result_lines(found, base.title or "Portrait"), f"Written: {data}, {picture}"]))
