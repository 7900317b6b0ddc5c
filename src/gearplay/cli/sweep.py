"""`gearplay sweep PLAN` and `gearplay resume FOLDER`: many cases, resumable."""

from functools import partial
from pathlib import Path
from time import process_time
from typing import Annotated, Any

import typer

from gearplay.cli.engines import EngineKind, Scheduler, Shard, Tls, Workers, chosen_engine
from gearplay.cli.interrupts import CommandInterruptedError
from gearplay.cli.options import Changes
from gearplay.cli.output import Json, pictures_in, print_json, print_text
from gearplay.cli.progress import watched
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.exit_codes import PARTLY

Zarr = Annotated[bool, typer.Option("--zarr", help="Also write sweep.zarr.")]


def sweep(
    plan: Annotated[
        str,
        typer.Argument(
            help="A plan file, or a bundled plan: han2021-map, han2021-tolerances, space-temperature."
        ),
    ],
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/sweep-PLAN].")] = None,
    changes: Changes = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Estimate the number of cases, time and size; write nothing.")
    ] = False,
    engine: EngineKind = "threads",
    workers: Workers = None,
    scheduler: Scheduler = None,
    tls_ca: Tls = None,
    tls_cert: Tls = None,
    tls_key: Tls = None,
    shard: Shard = None,
    zarr: Zarr = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the results in the folder.")
    ] = False,
    json: Json = False,
) -> None:
    """Simulate every case of a plan and store its reductions.

    Each finished case is stored at once; the same command, or gearplay resume, continues after an interruption.
    """
    from gearplay.sweeps.plans.reading import load_sweep
    from gearplay.sweeps.running.evaluate import Sweep
    from gearplay.sweeps.tolerances.page import limit_of

    made = Sweep(_changed(load_sweep(plan), changes or []).frozen())
    if made.plan.tolerance is not None:
        limit_of(made)  # a wrong unit is reported now, not after the simulations
    if dry_run:
        _forecast(made, workers, json=json)
        return
    folder = out if out is not None else Path("out") / f"sweep-{Path(plan).stem}"
    if overwrite and shard is not None:
        rule = "must not be given with --shard: it would remove the results of other shards"
        raise InputError.of("--overwrite", True, rule, "Remove it, or choose another folder")
    chosen = chosen_engine(engine, workers, scheduler, (tls_ca, tls_cert, tls_key), shard)
    _run(made, folder, chosen, json=json, overwrite=overwrite, zarr=zarr)


def resume(
    folder: Annotated[Path, typer.Argument(help="The folder of a sweep.")],
    retry: Annotated[bool, typer.Option("--retry", help="Run failed cases again.")] = False,
    engine: EngineKind = "threads",
    workers: Workers = None,
    scheduler: Scheduler = None,
    tls_ca: Tls = None,
    tls_cert: Tls = None,
    tls_key: Tls = None,
    shard: Shard = None,
    zarr: Zarr = False,
    json: Json = False,
) -> None:
    """Continue an interrupted sweep, or gather its shards.

    FOLDER is the --out of the sweep.
    """
    from gearplay.sweeps.running.evaluate import Sweep
    from gearplay.sweeps.running.folder import output_folder, plan_in

    chosen = chosen_engine(engine, workers, scheduler, (tls_ca, tls_cert, tls_key), shard)
    output_folder(folder).finish_replacement()  # its plan may still be in the staging directory
    _run(Sweep(plan_in(folder)), folder, chosen, json=json, retry=retry, zarr=zarr)


def _run(made: Any, folder: Path, engine: Any, *, json: bool, zarr: bool, **options: bool) -> None:
    from gearplay.sweeps.running.folder import CUBE, PRODUCT, output_folder
    from gearplay.sweeps.sweep import sweep_in
    from gearplay.sweeps.tolerances.page import PAGE

    try:
        found = sweep_in(
            made, folder, engine, report=True, zarr=zarr, watch=partial(watched, quiet=json), **options
        )
    except KeyboardInterrupt:
        raise CommandInterruptedError(
            f"Interrupted. The result in {folder} is as it was; the same command goes on with the new one."
            if output_folder(folder).is_staging
            else f"Interrupted. Finished cases are kept: gearplay resume {folder} continues there."
        ) from None
    if found.account is None:
        shard = "{}-of-{}".format(*engine.shard)
        document = {"title": made.plan.title, "shard": shard, "ran": found.ran, "out": str(folder)}
        words = f"Shard {shard}: {found.ran} cases run. gearplay resume {folder} gathers all shards."
        print_json(document) if json else print_text(words)
        return
    document = {"title": made.plan.title, "cases": len(made.template.points), "ran": found.ran}
    document |= found.account.as_document()
    if zarr:
        document["cube"] = str(folder / CUBE)
    if found.product is not None:
        document |= {"out": str(folder / PRODUCT), "report": str(folder / "report.html")}
    if found.tolerance is not None:
        document |= {"tolerance": found.tolerance, "tolerance_page": str(folder / PAGE)}
    print_json(document) if json else print_text(_words(document))
    if document["failed"] or document["missing"]:
        raise typer.Exit(PARTLY)


def _words(d: dict[str, Any]) -> str:
    lines = [f"{d['title'] or 'Sweep'}: {d['cases']} cases, {d['ran']} run now, {d['failed']} failed"]
    if d["missing"]:
        lines[0] += f", {d['missing']} not run yet"
    lines += [f"  {reason}" for reason in d["reasons"]]
    if "tolerance" in d:
        sentences = [*d["tolerance"]["answer"]]
        for each in d["tolerance"]["conditions"][:10]:
            sentences += each["words"]
        if d["tolerance"]["search"]:
            sentences += d["tolerance"]["search"]["words"]
        lines += dict.fromkeys(sentences)  # the conclusion first, no sentence twice
    lines.append(
        "Written: " + ", ".join(d[key] for key in ("report", "tolerance_page", "out", "cube") if key in d)
    )
    if "report" in d:
        lines += pictures_in(Path(d["report"]).parent / "figures")
    return "\n".join(lines)


def _forecast(made: Any, workers: int | None, *, json: bool) -> None:
    from dataclasses import asdict

    from gearplay.sweeps.running.forecast import forecast
    from gearplay.sweeps.tolerances.allowable import search_cases

    begun = process_time()
    found = forecast(made, search=search_cases(made.plan), workers=workers, begun=begun)
    if json:
        print_json({"title": made.plan.title, **asdict(found)})
        return
    print_text(
        f"{made.plan.title or 'Sweep'}: {found.cases} cases"
        + (f" and at most {found.search} of the search for a safe size" if found.search else "")
        + f", about {_duration(found.seconds + found.overhead)} on {found.workers} workers "
        f"(from {found.pilots} of them; {_duration(found.overhead)} of it for start and report), "
        f"{found.bytes / 1e6:.3g} MB. Nothing was written."
    )
    if found.failed:
        print_text(f"{found.failed} of these {found.pilots} failed: {found.reason}")


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.2g} s"
    return f"{seconds / 60.0:.2g} min" if seconds < 5400.0 else f"{seconds / 3600.0:.2g} h"


def _changed(plan: Any, changes: list[str]) -> Any:
    if not changes:
        return plan
    from gearplay.model.case import Case
    from gearplay.model.overrides import parse_override
    from gearplay.sweeps.plans.reading import load_sweep

    document = plan.model_dump(mode="json", exclude_none=True)
    given = dict(parse_override(text) for text in changes)
    for path in given:
        field = path.partition(".")[0].strip()
        if field in type(plan).model_fields and field not in Case.model_fields:
            rule = f"must be a field of the case, and {field} is one of the plan"
            raise InputError.of("--set", path, rule, "Change it in the plan's file")
    document["set"] = {**document["set"], **given}
    return load_sweep(document)
