"""`gearplay calibrate PLAN`: parameters and models from measurements."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.output import Json, pictures_in, print_json, print_text
from gearplay.cli.progress import progress_bar


def calibrate(
    plan: Annotated[
        str, typer.Argument(help="A plan file, or the name of a bundled plan: han2021, tutorial.")
    ],
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/calibrate-PLAN].")] = None,
    evaluations: Annotated[
        int | None,
        typer.Option(
            "--evaluations", min=8, help="Trials per model in place of the plan's; a larger number continues."
        ),
    ] = None,
    recover: Annotated[
        int | None,
        typer.Option(
            "--recover",
            min=1,
            help="Test the recovery of known parameters with this number of synthetic data sets.",
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Discard existing trials.")] = False,
    json: Json = False,
) -> None:
    """Fit the parameters of a plan's models and compare the models.

    The same command continues after an interruption. With --recover, synthetic data of known parameters test how well the
    plan recovers them.
    """
    from gearplay.calibration import calibrate as calibration
    from gearplay.calibration.reading import load_plan, plan_folder
    from gearplay.work.folder import STAGING

    loaded = load_plan(plan) if evaluations is None else _with_evaluations(plan, evaluations)
    folder = out if out is not None else Path("out") / f"calibrate-{Path(plan).stem}"
    try:
        with interruptible() as stop, progress_bar(quiet=json) as report:
            options: dict[str, Any] = {"overwrite": overwrite, "progress": report, "stop": stop}
            if recover is not None:
                document = calibration.recover(loaded, folder, recover, **options)
            else:
                found = calibration.calibrate(loaded, folder, records=plan_folder(plan), **options)
                document = dict(found.document)
    except KeyboardInterrupt:
        place = folder / STAGING if (folder / STAGING).exists() else folder
        raise CommandInterruptedError(
            f"Interrupted. Finished trials are kept in {place}: the same command continues there."
        ) from None
    if json:
        print_json(document)
    else:
        print_text(_words(document, folder) if recover is None else _recovery_words(document, folder))


def _with_evaluations(plan: str, evaluations: int) -> Any:
    """Return the plan with another number of trials; a smaller one shortens all phases in proportion."""
    from gearplay.calibration.reading import load_plan

    loaded = load_plan(plan)
    share = evaluations / loaded.effort.evaluations
    document = loaded.model_dump(mode="json", exclude_none=True)
    effort = document["effort"]
    effort["evaluations"] = evaluations
    if share < 1.0:
        effort["startup"] = max(4, int(effort["startup"] * share))
        effort["polish"] = max(0, min(int(effort["polish"] * share), evaluations - effort["startup"]))
    return load_plan(document)


def _words(document: dict[str, Any], folder: Path) -> str:
    lines = [document["title"] or "Calibration", *document["answer"], *document["statement"]["words"][1:]]
    lines += [f"Report: {folder / 'report.html'}", *pictures_in(folder / "figures")]
    return "\n".join(lines)


def _recovery_words(document: dict[str, Any], folder: Path) -> str:
    count = document["data_sets"]
    lines = [f"{document['title'] or 'Recovery'}: {count} data sets of the model {document['model']}"]
    lines.append(f"{'parameter':<24}{'identified':>12}{'median error':>14}{'90 % intervals hold':>22}")
    for row in document["parameters"]:
        error = "-" if row["median_error"] is None else f"{row['median_error']:.1f} %"
        lines.append(
            f"{row['name']:<24}{row['identified']:>8}/{count:<3}{error:>14}{100 * row['coverage']:>20.0f} %"
        )
    lines.append(f"All intervals: {100 * document['coverage']:.1f} %. Written: {folder / 'recovery.json'}")
    return "\n".join(lines)
