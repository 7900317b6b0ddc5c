"""`gearplay lost-motion CASE`: lost motion, backlash and stiffness of a train whose input is held, or of a measured curve."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.interrupts import interruptible
from gearplay.cli.options import Changes
from gearplay.cli.output import Json, print_json, print_text, result_lines
from gearplay.cli.progress import progress_bar


def lost_motion(
    case: Annotated[
        str, typer.Argument(metavar="CASE", help="Bundled name or TOML file; a measured curve, RECORD.csv.")
    ],
    at: Annotated[str | None, typer.Option("--at", help="Rotor that the torque acts on: the output.")] = None,
    hold: Annotated[
        list[str] | None, typer.Option("--hold", help="Rotor that is held: the input. May be repeated.")
    ] = None,
    torque: Annotated[
        str | None,
        typer.Option("--rated-torque", "--torque", help="Rated torque: 200Nm; of a record its largest one."),
    ] = None,
    stages: Annotated[
        str | None, typer.Option("--stages", help="Torques that end the stages K1 and K2: 28Nm,96Nm.")
    ] = None,
    positions: Annotated[
        int | None, typer.Option("--positions", min=1, help="Positions over a turn of the output.")
    ] = None,
    members: Annotated[
        int | None, typer.Option("--members", min=1, help="Drawn members, for the spread over tolerances.")
    ] = None,
    tolerances: Annotated[
        str | None,
        typer.Option("--tolerances", help="Sweep plan with a [design]; else each clearance within 20 %."),
    ] = None,
    temperatures: Annotated[
        str | None, typer.Option("--temperatures", help="Temperatures: -40degC,20degC,80degC.")
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option("--columns", help="Columns of a record, torque and rotation: 'T [N m],phi [deg]'."),
    ] = None,
    changes: Changes = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/lost-motion-CASE].")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Show lost motion, stiffness and the part of each clearance.

    The torque on the output rises and falls slowly while the input is held. Of a measured curve the same numbers with intervals.
    """
    import gearplay as gp
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.hysteresis.page import report_page
    from gearplay.pictures.canvas import to_png
    from gearplay.vocabulary.errors import InputError

    measured = case.lower().endswith(".csv")
    if measured:
        given = {"--set": changes, "--at": at, "--hold": hold, "--positions": positions, "--members": members,
                 "--tolerances": tolerances, "--temperatures": temperatures}  # fmt: skip
        for option, value in given.items():
            if value:
                rule = "must not be given with a measured curve"
                raise InputError.of(option, str(value), rule, "Leave it out, or name a case")
    elif columns is not None:
        raise InputError.of("--columns", columns, "is for a measured curve, RECORD.csv", "Leave it out")
    folder = out if out is not None else Path("out") / f"lost-motion-{Path(case).stem}"
    names = ("lost-motion.nc", "lost-motion.png", "report.html")
    places = [folder / name for name in names]
    for place in places:
        check_new(place, overwrite=overwrite)
    split: dict[str, Any] = {
        name: None if text is None else [each.strip() for each in text.split(",")]
        for name, text in (("stages", stages), ("temperatures", temperatures), ("columns", columns))
    }
    with interruptible(), progress_bar(quiet=json) as report:
        found = gp.lost_motion(
            case if measured else gp.load_case(case, changes or ()),
            at=at, hold=hold or None, torque=torque, positions=positions, members=members, tolerances=tolerances,
            progress=report, **split,
        )  # fmt: skip
    drawn = to_png(found.plot())
    page = report_page(found, Path(case).stem, drawn)
    found.save(places[0], overwrite=overwrite)
    write_bytes(places[1], drawn)
    write_bytes(places[2], page.encode())
    if json:
        print_json(_document(found, places))
    else:
        lines = result_lines(found, Path(case).stem)
        print_text("\n".join([*lines, f"Written: {', '.join(map(str, places))}"]))


def _document(found: Any, places: list[Path]) -> dict[str, Any]:
    ds = found.ds
    document: dict[str, Any] = {
        name: float(ds[name])
        for name in (
            "lost_motion", "lost_motion_arcmin", "backlash", "backlash_arcmin", "torsional_stiffness",
            "torsional_stiffness_arcmin", "hysteresis_loss",
        )
    }  # fmt: skip
    document["stiffness"] = dict(
        zip(map(str, ds["stage"].values), ds["stiffness"].values.tolist(), strict=True)
    )
    if "clearance" in ds.dims:
        parts = ds["lost_motion_part"]
        document["lost_motion_part"] = dict(
            zip(map(str, parts["clearance"].values), parts.values.tolist(), strict=True)
        )
    for name, values in ds.data_vars.items():
        if str(name).endswith(("_interval", "_by_member", "_by_position", "_by_temperature")):
            document[str(name)] = values.values.tolist()
    names = ("out", "picture", "report")
    return {"message": found.message, **document, **dict(zip(names, map(str, places), strict=True))}
