"""`gearplay bifurcation CASE PATH`: bifurcation diagram over a field of the case."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.options import CaseName, Changes, Period, period_of
from gearplay.cli.output import Json, print_json, print_text, result_lines
from gearplay.cli.progress import progress_bar
from gearplay.vocabulary.errors import InputError, SimulationError
from gearplay.vocabulary.exit_codes import PARTLY

MOST_LISTED = 10
"""Largest number of listed failures and restarts."""


def bifurcation(
    case: CaseName,
    path: Annotated[str, typer.Argument(help="The field to vary: rotors.pinion.drive.speed.")],
    low: Annotated[str, typer.Option("--low", help="Lowest value, with a unit: 60rpm.")],
    high: Annotated[str, typer.Option("--high", help="Highest value.")],
    signal: Annotated[
        list[str], typer.Option("--signal", help="Signal of the section: ring.x. May be repeated.")
    ],
    count: Annotated[int, typer.Option("--count", min=2, max=100_000, help="Number of values.")] = 200,
    settle: Annotated[int, typer.Option("--settle", min=0, help="Periods that pass at each value.")] = 400,
    keep: Annotated[int, typer.Option("--keep", min=1, help="Periods of the section.")] = 100,
    period: Period = "mesh",
    carry: Annotated[
        bool, typer.Option("--carry/--no-carry", help="Continue from the final state of the previous value.")
    ] = True,
    branches: Annotated[
        bool, typer.Option("--branches", help="Also follow the periodic orbits, stable and unstable.")
    ] = False,
    order: Annotated[
        int,
        typer.Option(
            "--order", min=1, max=1000, help="Order of the orbits: periods after which they repeat."
        ),
    ] = 1,
    doublings: Annotated[
        int, typer.Option("--doublings", min=0, max=8, help="Largest number of period doublings.")
    ] = 1,
    orbits: Annotated[
        int, typer.Option("--orbits", min=2, help="Largest number of orbits of a branch, each way.")
    ] = 500,
    changes: Changes = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/bifurcation-CASE].")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Draw the settled motion over a range of one field.

    A bifurcation diagram: signals once per period after the motion has settled, at each value of the field.
    """
    import numpy as np

    import gearplay as gp
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.model.overrides import parse_override
    from gearplay.model.plan_values import number_in_si
    from gearplay.nonlinear.orbits.continuation import check_branches
    from gearplay.pictures.canvas import to_png
    from gearplay.solver.deadline import limited

    base = gp.load_case(case, changes or ())
    folder = out if out is not None else Path("out") / f"bifurcation-{Path(case).stem}"
    data, picture, tree = folder / "bifurcation.nc", folder / "bifurcation.png", folder / "branches.nc"
    for each in (data, picture, tree) if branches else (data, picture):
        check_new(each, overwrite=overwrite)
    ends = [
        number_in_si(base, (path,), parse_override(f"{path}={text}")[1], name)
        for name, text in (("--low", low), ("--high", high))
    ]
    if not ends[0] < ends[1]:
        raise InputError.of(
            "--high", high, f"must be above --low, {low}", "Give both with their unit, the lower first"
        )
    if branches:
        check_branches(base, path)
    document: dict[str, Any] = {}
    lines: list[str] = []
    try:
        with (
            interruptible() as stop,
            progress_bar(quiet=json) as report,
            limited(base.run.max_wall_time),
        ):
            watch = _watching(report, stop)
            found = gp.bifurcation(
                base,
                path,
                np.linspace(ends[0], ends[1], count).tolist(),
                signal,
                settle=settle,
                keep=keep,
                period=period_of(period),
                carry=carry,
                progress=watch,
                stop=stop,
            )
            found.save(data, overwrite=overwrite)
            write_bytes(picture, to_png(found.plot()))
            document = _summary(found, data, picture)
            lines = result_lines(found, base.title or "Bifurcation diagram", most=MOST_LISTED)
            if branches:
                orbit_options = {"order": order, "doublings": doublings, "settle": settle, "orbits": orbits}
                try:
                    trees = gp.branches(base, path, *ends, **orbit_options, progress=watch)
                except SimulationError as error:
                    document |= {"branches": [], "branches_error": str(error)}
                    lines.append(str(error))
                else:
                    write_bytes(picture, _write_branches(found, trees, tree, overwrite=overwrite))
                    document |= {"tree": str(tree), "branches": _listed(trees)}
                    document |= {"branches_missed": list(trees.missed)}
                    lines += result_lines(trees, "Branches")
            else:
                tree.unlink(missing_ok=True)  # branches of the diagram that was replaced
    except KeyboardInterrupt:
        state = f"{data} is written, its branches are not" if document else "nothing was written"
        raise CommandInterruptedError(f"Interrupted: {state}.") from None
    written = ", ".join(document[key] for key in ("out", "picture", "tree") if key in document)
    print_json(document) if json else print_text("\n".join([*lines, f"Written: {written}"]))
    if document["failed"] or "branches_error" in document:
        raise typer.Exit(PARTLY)


def _watching(report: Any, stop: Any) -> Any:
    """Return a progress callback that raises `KeyboardInterrupt` once ``stop`` is set, for work without a stop event."""

    def watch(label: str, done: float, total: float) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        if report is not None:
            report(label, done, total)

    return watch


def _write_branches(found: Any, trees: Any, tree: Path, *, overwrite: bool) -> bytes:
    """Write branches with the signals of a diagram; return the picture of both as PNG."""
    from gearplay.files.netcdf import write_dataset
    from gearplay.nonlinear.figures import bifurcation_drawing
    from gearplay.pictures.canvas import to_png
    from gearplay.results.provenance import KIND

    levels = trees.levels(found.names)
    dataset = trees.dataset(found.names, levels).assign_attrs({KIND: trees.result_kind})
    write_dataset(dataset, tree, overwrite=overwrite)
    both = list(zip(trees, levels, strict=True))
    return to_png(bifurcation_drawing(found.ds, found.names, branches=both))


def _listed(trees: Any) -> list[dict[str, Any]]:
    return [
        {
            "order": branch.order,
            "orbits": len(branch.orbits),
            "stable": int(branch.stable.sum()),
            "special": [{"kind": s.kind, "value": s.orbit.parameter} for s in branch.special],
            "ended": branch.ended,
        }
        for branch in trees
    ]


def _summary(found: Any, data: Path, picture: Path) -> dict[str, Any]:
    return {
        "title": found.case.title,
        "values": len(found.parameters),
        **found.account.as_document(),
        "not_carried": list(found.interruptions),
        "out": str(data),
        "picture": str(picture),
    }
