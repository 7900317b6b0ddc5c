"""`gearplay bifurcation CASE PATH`: settled motion over a field of the case, upwards and downwards."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.arguments import CaseName, Changes, Period, period_of
from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.progress import compile_kernels, progress_bar
from gearplay.vocabulary.errors import Fault, InputError, SimulationError
from gearplay.vocabulary.exit_codes import PARTLY

MOST_TOLD = 5
"""Values at which the state was not carried that are listed."""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(bifurcation)


def bifurcation(
    case: CaseName,
    path: Annotated[str, typer.Argument(help="The field to vary: rotors.pinion.drive.speed.")],
    low: Annotated[str, typer.Option("--low", help="Its least value, with a unit: 60rpm.")],
    high: Annotated[str, typer.Option("--high", help="Its largest value.")],
    signal: Annotated[list[str], typer.Option("--signal", help="What to look at: ring.x. May be repeated.")],
    count: Annotated[int, typer.Option("--count", min=2, max=100_000, help="Number of values.")] = 200,
    settle: Annotated[int, typer.Option("--settle", min=0, help="Periods before looking.")] = 400,
    keep: Annotated[int, typer.Option("--keep", min=1, help="Periods looked at.")] = 100,
    period: Period = "mesh",
    carry: Annotated[bool, typer.Option("--carry/--no-carry", help="Go on from the value before.")] = True,
    branches: Annotated[
        bool, typer.Option("--branches", help="Follow the periodic orbits too, stable and unstable.")
    ] = False,
    order: Annotated[int, typer.Option("--order", help="Periods after which they repeat.")] = 1,
    doublings: Annotated[int, typer.Option("--doublings", help="How many times their order may double.")] = 1,
    orbits: Annotated[int, typer.Option("--orbits", min=2, help="Most orbits of a branch, each way.")] = 500,
    changes: Changes = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/bifurcation-CASE].")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing results.")] = False,
    json: Json = False,
) -> None:
    """Draw what a motion settles to over a range of one field.

    A bifurcation diagram: signals once per period after the motion has settled, at each value of the field.
    """
    import numpy as np

    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.files.netcdf import write_dataset
    from gearplay.model.overrides import parse_override
    from gearplay.model.plan_values import number_in_si
    from gearplay.model.reading import load_case
    from gearplay.nonlinear.analyses import bifurcation as diagram_of
    from gearplay.nonlinear.figures import bifurcation_figure
    from gearplay.nonlinear.orbits.continuation import branches as branches_of
    from gearplay.nonlinear.orbits.continuation import check_branches
    from gearplay.results.provenance import KIND
    from gearplay.solver.deadline import limited

    base = load_case(case, changes or ())
    folder = out if out is not None else Path("out") / f"bifurcation-{Path(case).stem}"
    data, picture, tree = folder / "bifurcation.nc", folder / "bifurcation.png", folder / "branches.nc"
    for each in (data, picture, tree) if branches else (data, picture):
        check_new(each, overwrite=overwrite)
    ends = [
        number_in_si(base, (path,), parse_override(f"{path}={text}")[1], name)
        for name, text in (("--low", low), ("--high", high))
    ]
    if not ends[0] < ends[1]:
        raise InputError(
            Fault("--high", high, f"must be above --low, {low}", "Give both with their unit, the lower first")
        )
    compile_kernels(base, quiet=json)
    if branches:
        check_branches(base, path, order=order, doublings=doublings)
    written = False
    try:
        with (
            interruptible() as stop,
            progress_bar(quiet=json) as report,
            limited(base.run.max_wall_time),
        ):
            found = diagram_of(
                base,
                path,
                np.linspace(ends[0], ends[1], count).tolist(),
                signal,
                settle=settle,
                keep=keep,
                period=period_of(period),
                carry=carry,
                progress=_watching(report, stop),
                stop=stop,
            )
            names = found.names
            found.save(data, overwrite=overwrite)
            write_bytes(picture, bifurcation_figure(found.ds, names))
            written = True
            if not branches:
                tree.unlink(missing_ok=True)  # those of the diagram that was replaced
            document = _summary(found, data, picture)
            if branches:
                watch = _watching(report, stop)
                follow = partial(
                    branches_of,
                    order=order,
                    doublings=doublings,
                    settle=settle,
                    orbits=orbits,
                    progress=watch,
                )
                try:
                    trees = follow(base, path, *ends)
                except SimulationError as error:
                    document |= {"branches": [], "branches_error": str(error)}
                else:
                    levels = trees.levels(names)
                    both = list(zip(trees, levels, strict=True))
                    whole = trees.dataset(names, levels).assign_attrs({KIND: trees.result_kind})
                    write_dataset(whole, tree, overwrite=overwrite)
                    write_bytes(picture, bifurcation_figure(found.ds, names, branches=both))
                    document |= {"tree": str(tree), "branches": _listed(trees)}
                    document |= {"branches_missed": list(trees.missed)}
    except KeyboardInterrupt:
        said = f"{data} is written, its branches are not" if written else "nothing was written"
        raise CommandInterruptedError(f"Interrupted: {said}.") from None
    print_json(document) if json else print_text(_words(document))
    if document["failed"] or "branches_error" in document:
        raise typer.Exit(PARTLY)


def _watching(report: Any, stop: Any) -> Any:
    """Return a progress function for work that only it can end, once stopping is asked for."""

    def watch(what: str, done: float, total: float) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        if report is not None:
            report(what, done, total)

    return watch


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


def _words(d: dict[str, Any]) -> str:
    lines = [f"{d['title'] or 'Bifurcation diagram'}: {d['values']} values up and down, {d['failed']} failed"]
    lines += [f"  {reason}" for reason in d["reasons"]]
    lines += [f"  {where}" for where in d["not_carried"][:MOST_TOLD]]
    if len(d["not_carried"]) > MOST_TOLD:
        lines.append(f"  and {len(d['not_carried']) - MOST_TOLD} more: variable start of {d['out']}")
    written = f"Written: {d['out']}, {d['picture']}"
    if "branches_error" in d:
        lines.append(d["branches_error"])
    lines += [f"  {each}" for each in d.get("branches_missed", [])]
    for branch in d.get("branches", []):
        special = "".join(f", {s['kind']} at {s['value']:.6g}" for s in branch["special"])
        lines.append(
            f"  order {branch['order']}: {branch['orbits']} orbits, {branch['stable']} stable{special}; ends: {branch['ended']}"
        )
    return "\n".join([*lines, written + (f", {d['tree']}" if "tree" in d else "")])
