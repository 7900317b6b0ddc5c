"""`gearplay study han2021`: reproduce the published study and write its report."""

import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.output import Json, pictures_in, print_json, print_text, say
from gearplay.cli.progress import compile_kernels, progress_bar
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.exit_codes import PARTLY

if TYPE_CHECKING:
    from gearplay.published.settings import Settings
    from gearplay.vocabulary.progress import Progress

ALL = "all"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(study)


def study(
    name: Annotated[str, typer.Argument(help="The published study: han2021.")] = "han2021",
    out: Annotated[Path | None, typer.Option("--out", help="Output folder [default: out/NAME].")] = None,
    parameters: Annotated[
        str,
        typer.Option(
            "--parameters",
            help="calibrated (fitted to the test) | assumed | geometric-inertia (assumed, inertias of discs) | all.",
        ),
    ] = "calibrated",
    members: Annotated[
        int, typer.Option("--members", min=2, max=10_000, help="Ensemble members per condition and model.")
    ] = 24,
    duration: Annotated[
        float, typer.Option("--duration", min=1.0, max=1e4, help="Record length of each member [s].")
    ] = 4.0,
    claims: Annotated[
        bool,
        typer.Option(
            "--claims",
            help="Try the article's claims afresh over ranges of its unknown parameters (half an hour on two cores).",
        ),
    ] = False,
    points: Annotated[
        int, typer.Option("--points", min=2, max=100_000, help="Sobol points of --claims.")
    ] = 128,
    fit_drag: Annotated[
        bool, typer.Option("--fit-drag", help="Fit the assumed drag to the six measured f_r first (slow).")
    ] = False,
    pdf: Annotated[bool, typer.Option("--pdf", help="Write report.pdf too, by typst (make extras).")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing report.")] = False,
    json: Json = False,
) -> None:
    """Reproduce the article's study and write its report.

    Six conditions, both models, tables, figures and verdicts.
    """
    from gearplay.published.settings import CALIBRATED, PARAMETERS, Settings

    if name != "han2021":
        raise InputError(
            [Fault("study", name, "must be a study that is known", "The one there is: han2021.")]
        )
    chosen = list(PARAMETERS) if parameters == ALL else [parameters]
    if chosen[0] not in PARAMETERS:
        known = f"must be one of {', '.join(PARAMETERS)}, {ALL}"
        raise InputError([Fault("--parameters", parameters, known, "Leave it out for the calibrated set.")])
    if fit_drag and CALIBRATED in chosen:
        rule = "must go with assumed parameters: the calibrated drag is fitted already"
        raise InputError([Fault("--fit-drag", parameters, rule, "Say --parameters assumed.")])
    if pdf:
        from gearplay.published.pdf import check_typst

        check_typst()
    folder = out if out is not None else Path("out") / name
    documents = []
    for each in chosen:
        place = folder if each == chosen[0] else folder / each
        settings = Settings(parameters=each, members=members, duration=duration)
        wanted = points if claims and each == chosen[0] else 0
        beside = {other: _way(each, other, chosen[0]) for other in chosen if other != each}
        documents.append(_one(settings, place, wanted, fit_drag, pdf, overwrite, json, beside))
    if json:
        print_json(documents[0] if len(documents) == 1 else {"studies": documents})
    else:
        for document in documents:
            print_text(_words(document))
    if any(document["failures"] for document in documents):
        say("Some members did not finish; the report names them.")
        raise typer.Exit(PARTLY)


def _way(here: str, there: str, first: str) -> str:
    """Return the address of one parameter set's report in that of another; the first lies in the folder itself."""
    return ("" if here == first else "../") + ("" if there == first else f"{there}/") + "report.html"


def _one(
    settings: "Settings",
    folder: Path,
    points: int,
    fit: bool,
    pdf: bool,
    overwrite: bool,
    quiet: bool,
    beside: dict[str, str],
) -> dict[str, Any]:
    from gearplay.files.atomic import check_new, make_folder
    from gearplay.published.settings import base_case

    check_new(folder / "report.html", overwrite=overwrite)
    make_folder(folder)
    compile_kernels(base_case(settings.variants[0], settings), quiet=quiet)
    try:
        with interruptible() as stop, progress_bar(quiet=quiet) as report:
            document = _written(settings, folder, points, fit, pdf, report, stop, beside)
    except KeyboardInterrupt:
        raise CommandInterruptedError(
            f"Interrupted. Finished parts are kept in {folder / 'parts'}: the same command goes on there."
        ) from None
    return {
        **document,
        "report": str(folder / "report.html"),
        "pdf": str(folder / "report.pdf") if pdf else None,
    }


def _written(
    settings: "Settings",
    folder: Path,
    points: int,
    fit: bool,
    pdf: bool,
    report: "Progress | None",
    stop: threading.Event,
    beside: dict[str, str],
) -> dict[str, Any]:
    """Run what is wanted and write it; finished parts are kept beside it."""
    from dataclasses import replace

    from gearplay.files.parts import FolderStore
    from gearplay.published.claims.points import ClaimSettings
    from gearplay.published.claims.summary import run_claims, shipped_claims
    from gearplay.published.drag import fit_drag
    from gearplay.published.han2021 import run_study
    from gearplay.published.report import Study, write_study

    store, fitted = FolderStore(folder / "parts"), {}
    if fit:
        trials = fit_drag(settings, progress=report, stop=stop)
        settings = replace(settings, drag=trials[0].drag)
        fitted["drag_trials"] = [
            {"drag": t.drag, "mean_error": t.mean_error, "ratios": t.ratios} for t in trials
        ]
    results = run_study(settings, progress=report, store=store, stop=stop)
    document = (
        run_claims(ClaimSettings(points=points), settings, progress=report, store=store, stop=stop)
        if points
        else shipped_claims()
    )
    if report is not None:
        report("report", 1.0, 1.0)
    return {**write_study(Study(results, settings, document), folder, pdf=pdf, beside=beside), **fitted}


def _words(document: dict[str, Any]) -> str:
    lines = [
        f"Study han2021, {document['parameters']} parameters, {document['members']} members per condition and model."
    ]
    for trial in document.get("drag_trials", []):
        lines.append(
            f"  drag {trial['drag']:.4g} N m s/rad: mean error of f_r {100 * trial['mean_error']:.1f} %"
        )
    lines += [each["answer"] for each in document["story"][1:]]
    lines += [f"  {f['verdict']:<13} {f['claim']}" for f in document["findings"]]
    lines.append(f"Report: {document['report']}")
    if document["pdf"]:
        lines.append(f"PDF: {document['pdf']}")
    lines += pictures_in(Path(document["report"]).parent / "figures")
    return "\n".join(lines)
