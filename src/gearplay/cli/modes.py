"""`gearplay modes CASE`: natural frequencies about the loaded equilibrium, mode shapes, a Campbell diagram."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.options import CaseName, Changes
from gearplay.cli.output import Json, print_json, print_text, result_lines


def modes(
    case: CaseName,
    load: Annotated[
        str, typer.Option("--load", help="operating: torques and gravity as in the case; none.")
    ] = "operating",
    speed: Annotated[
        str | None,
        typer.Option("--speed", help="Speed of the leading rotor, of a train with carriers: 800rpm."),
    ] = None,
    campbell: Annotated[
        str | None, typer.Option("--campbell", help="Draw natural frequencies up to a speed: 3000rpm.")
    ] = None,
    changes: Changes = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/modes-CASE].")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Show natural frequencies, damping and shapes under load."""
    import numpy as np

    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.linear.analyses import campbell as campbell_of
    from gearplay.linear.analyses import modes as modes_of
    from gearplay.linear.analyses import speed_of
    from gearplay.model.reading import load_case
    from gearplay.pictures.canvas import to_png

    base = load_case(case, changes or ())
    folder = out if out is not None else Path("out") / f"modes-{Path(case).stem}"
    names = ["modes.nc", "modes.png"] + (["campbell.nc", "campbell.png"] if campbell is not None else [])
    places = [folder / name for name in names]
    for place in places:
        check_new(place, overwrite=overwrite)
    highest = speed_of(campbell, "--campbell")
    found = modes_of(base, load=load, speed=speed)
    diagram = None
    if highest is not None:
        diagram = campbell_of(base, np.linspace(highest / 200.0, highest, 200), load=load)
    pictures = [to_png(each.plot()) for each in (found, diagram) if each is not None]
    # Nothing is written before all of it has been found.
    found.save(places[0], overwrite=overwrite)
    write_bytes(places[1], pictures[0])
    lines = [f"{base.title or Path(case).stem}: {found.message}", *_table(found)]
    document: dict[str, Any] = _document(base, found, places)
    if diagram is not None:
        diagram.save(places[2], overwrite=overwrite)
        write_bytes(places[3], pictures[1])
        document["crossings"] = [{"speed": speed, "meets": words} for speed, words in diagram.rows()]
        lines += ["", *result_lines(diagram, "Campbell diagram")]
    if json:
        print_json(document)
        return
    print_text("\n".join([*lines, f"Written: {', '.join(map(str, places))}"]))


def _table(found: Any) -> list[str]:
    return [f"  {k:>3}  {frequency:>14}  {words}" for k, (frequency, words) in enumerate(found.rows())]


def _document(base: Any, found: Any, places: list[Path]) -> dict[str, Any]:
    ds = found.ds
    names = ("frequency", "damping_ratio", "kind", "multiplicity")
    return {
        "title": base.title,
        "case_sha256": base.sha256,
        "message": found.message,
        "modes": [
            {name: ds[name].values[m].item() if name != "kind" else str(ds[name].values[m]) for name in names}
            for m in range(ds.sizes["mode"])
        ],
        "out": str(places[0]),
        "picture": str(places[1]),
    }
