"""`gearplay study han2021`: reproduce the published study and write its report."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.output import Json, pictures_in, print_json, print_text, say
from gearplay.cli.progress import progress_bar
from gearplay.files.atomic import check_new, make_folder, write_bytes, write_figures, write_text
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.exit_codes import PARTLY
from gearplay.vocabulary.optional import load_optional
from gearplay.work.pieces import PieceStore

if TYPE_CHECKING:
    from gearplay.studies.han2021.simulation import Settings, Work

ALL = "all"


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
            help="Compute the article's claims afresh over ranges of its unknown parameters (half an hour on two cores).",
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
    from gearplay.studies.han2021.simulation import CALIBRATED, PARAMETERS, Settings

    if name != "han2021":
        raise InputError.of("study", name, "must be a known study", "Choose han2021.")
    chosen = list(PARAMETERS) if parameters == ALL else [parameters]
    if chosen[0] not in PARAMETERS:
        known = f"must be one of {', '.join(PARAMETERS)}, {ALL}"
        raise InputError.of("--parameters", parameters, known, "Leave it out for the calibrated set.")
    if fit_drag and CALIBRATED in chosen:
        rule = "must go with assumed parameters: the calibrated drag is fitted already"
        raise InputError.of("--fit-drag", parameters, rule, "Say --parameters assumed.")
    if pdf:
        load_optional("typst", "pdf")
    folder = out if out is not None else Path("out") / name
    documents = []
    for each in chosen:
        place = folder if each == chosen[0] else folder / each
        settings = Settings(parameters=each, members=members, duration=duration)
        wanted = points if claims and each == chosen[0] else 0
        others = {other: _address(each, other, chosen[0]) for other in chosen if other != each}
        documents.append(_one(settings, place, wanted, fit_drag, pdf, overwrite, json, others))
    if json:
        print_json(documents[0] if len(documents) == 1 else {"studies": documents})
    else:
        for document in documents:
            print_text(_words(document))
    if any(document["failures"] for document in documents):
        say("Some members did not finish; the report names them.")
        raise typer.Exit(PARTLY)


def _address(here: str, there: str, first: str) -> str:
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
    others: dict[str, str],
) -> dict[str, Any]:
    """Run the study with one parameter set, write it into a folder, and return its document."""
    from gearplay.studies.han2021.simulation import Work

    check_new(folder / "report.html", overwrite=overwrite)
    make_folder(folder)
    try:
        with interruptible() as stop, progress_bar(quiet=quiet) as report:
            work = Work(report or _silent, stop, PieceStore(folder / "parts").keep)
            document = _written(settings, folder, points, fit, pdf, work, others)
    except KeyboardInterrupt:
        raise CommandInterruptedError(
            f"Interrupted. Finished parts are kept in {folder / 'parts'}: the same command continues there."
        ) from None
    return {
        **document,
        "report": str(folder / "report.html"),
        "pdf": str(folder / "report.pdf") if pdf else None,
    }


def _silent(label: str, done: float, total: float) -> None:
    """Report no progress."""


def _written(
    settings: "Settings",
    folder: Path,
    points: int,
    fit: bool,
    pdf: bool,
    work: "Work",
    others: dict[str, str],
) -> dict[str, Any]:
    """Run the study and write its files; return its document."""
    from gearplay.pictures.pages import render_page
    from gearplay.studies.han2021.article import PACKAGE, stored
    from gearplay.studies.han2021.claims import ClaimSettings, run_claims
    from gearplay.studies.han2021.drag import fit_drag
    from gearplay.studies.han2021.report import Study
    from gearplay.studies.han2021.simulation import run_study

    fitted = {}
    if fit:
        trials = fit_drag(settings, work)
        settings = replace(settings, drag=trials[0].drag)
        fitted["drag_trials"] = [trial._asdict() for trial in trials]
    results = run_study(settings, work)
    claims = run_claims(ClaimSettings(points=points), settings, work) if points else stored("claims")
    work.progress("report", 1.0, 1.0)
    study = Study(results, settings, claims)
    write_figures(folder, study.figures)
    for name, text in study.texts().items():
        write_text(folder / name, text)
    write_text(folder / "report.html", render_page(PACKAGE, "report.html", **study.page_values(others)))
    if pdf:
        write_bytes(folder / "report.pdf", study.pdf())
    return {**study.document, **fitted}


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
