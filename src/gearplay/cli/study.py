"""`gearplay study han2021`: reproduce the published study and write its report."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.output import Json, print_json, print_text, say
from gearplay.cli.progress import compile_kernels, interruptible, progress_bar
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.exit_codes import INTERRUPTED, PARTLY

BOTH = "both"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(study)


def study(
    name: Annotated[str, typer.Argument(help="The published study: han2021.")] = "han2021",
    out: Annotated[Path | None, typer.Option("--out", help="Output folder [default: out/NAME].")] = None,
    members: Annotated[
        int, typer.Option("--members", min=2, max=10_000, help="Ensemble members per condition and model.")
    ] = 64,
    duration: Annotated[
        float, typer.Option("--duration", min=1.0, max=1e4, help="Record length of each member [s].")
    ] = 16.0,
    inertia: Annotated[
        str, typer.Option("--inertia", help="printed | geometric | both: which moments of inertia.")
    ] = "printed",
    fit_drag: Annotated[
        bool, typer.Option("--fit-drag", help="Fit the drag to the six measured f_r first (slow).")
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing report.")] = False,
    json: Json = False,
) -> None:
    """Reproduce the article's study: six conditions, both models, tables, figures, findings and a report."""
    if name != "han2021":
        raise InputError(
            [Fault("study", name, "must be a study that is known", "The one there is: han2021.")]
        )
    cases = {"printed": ["han2021"], "geometric": ["han2021-geometric-inertia"]}
    cases[BOTH] = cases["printed"] + cases["geometric"]
    if inertia not in cases:
        raise InputError(
            [
                Fault(
                    "--inertia",
                    inertia,
                    "must be printed, geometric or both",
                    "Leave it out for the printed set.",
                )
            ]
        )
    folder = out if out is not None else Path("out") / name
    documents = []
    for case in cases[inertia]:
        place = folder if case == cases[inertia][0] else folder / case
        documents.append(_one(case, place, members, duration, fit_drag, overwrite, json))
    if json:
        print_json(documents[0] if len(documents) == 1 else {"studies": documents})
    else:
        for document in documents:
            print_text(_words(document))
    if any(document["failures"] for document in documents):
        say("Some members did not finish; the report names them.")
        raise typer.Exit(PARTLY)


def _one(
    case: str, folder: Path, members: int, duration: float, fit: bool, overwrite: bool, quiet: bool
) -> dict[str, Any]:
    from dataclasses import replace

    from gearplay.files.atomic import check_new, make_folder
    from gearplay.files.parts import FolderStore
    from gearplay.published.han2021 import Settings, base_case, fit_drag, run_study
    from gearplay.published.report import write_study

    check_new(folder / "report.html", overwrite=overwrite)
    make_folder(folder)
    settings = Settings(case=case, members=members, duration=duration)
    fitted: dict[str, Any] = {}
    compile_kernels(base_case(settings), quiet=quiet)
    try:
        with interruptible() as stop, progress_bar(quiet=quiet) as report:
            if fit:
                trials = fit_drag(settings, progress=report, stop=stop)
                settings = replace(settings, drag=trials[0].drag)
                fitted = {
                    "drag_trials": [
                        {"drag": t.drag, "mean_error": t.mean_error, "ratios": t.ratios} for t in trials
                    ]
                }
            results = run_study(settings, progress=report, store=FolderStore(folder / "parts"), stop=stop)
            if report is not None:
                report("report", 1.0, 1.0)
            document = write_study(results, settings, folder)
    except KeyboardInterrupt:
        say(
            f"Interrupted. Finished conditions are kept in {folder / 'parts'}: the same command goes on there."
        )
        raise typer.Exit(INTERRUPTED) from None
    return {**document, **fitted, "report": str(folder / "report.html")}


def _words(document: dict[str, Any]) -> str:
    lines = [f"Study {document['case']}, {document['members']} members per condition and model."]
    for trial in document.get("drag_trials", []):
        lines.append(
            f"  drag {trial['drag']:.4g} N m s/rad: mean error of f_r {100 * trial['mean_error']:.1f} %"
        )
    lines += [f"  {f['verdict']:<15} {f['claim']}" for f in document["findings"]]
    lines.append(f"Report: {document['report']}")
    return "\n".join(lines)
