"""`gearplay sweep PLAN` and `gearplay resume FOLDER`: many cases, resumable."""

import re
import shutil
from functools import partial
from pathlib import Path
from time import process_time
from typing import Annotated, Any

import typer

from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.output import Json, pictures_in, print_json, print_text
from gearplay.cli.progress import compile_kernels, progress_bar
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.exit_codes import PARTLY

Workers = Annotated[
    int | None,
    typer.Option("--workers", min=1, help="Number of threads or processes; the cores by default."),
]
EngineKind = Annotated[str, typer.Option("--engine", help="Kind of workers: threads or processes.")]
Scheduler = Annotated[str | None, typer.Option("--scheduler", help="Address of a Dask scheduler to run on.")]
Shard = Annotated[str | None, typer.Option("--shard", help="Run part i of n only: --shard 3/8.")]
Zarr = Annotated[bool, typer.Option("--zarr", help="Also write sweep.zarr.")]
Tls = Annotated[Path | None, typer.Option(help="TLS file for the scheduler.")]


def sweep(
    plan: Annotated[
        str,
        typer.Argument(
            help="A plan file, or a bundled plan: han2021-map, han2021-tolerances, space-temperature."
        ),
    ],
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/sweep-PLAN].")] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PATH=VALUE",
            help="Change the base case: --set run.duration=0.2s. May be repeated.",
        ),
    ] = None,
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
    from gearplay.sweeps.running.engines import Engine
    from gearplay.sweeps.running.evaluate import Sweep
    from gearplay.sweeps.tolerances.results import limit_of

    made = Sweep(_changed(load_sweep(plan), changes or []).frozen())
    if made.plan.tolerance is not None:
        limit_of(made)  # a wrong unit is said now, not after the simulations
    if dry_run:
        _forecast(made, workers, json=json)
        return
    folder = out if out is not None else Path("out") / f"sweep-{Path(plan).stem}"
    if overwrite and shard is not None:
        rule = "must not be given with --shard: it would forget what other shards have done"
        raise InputError(Fault("--overwrite", True, rule, "Remove it, or choose another folder"))
    chosen = Engine(
        engine, workers, scheduler, _security(scheduler, tls_ca, tls_cert, tls_key), _shard(shard)
    )
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
    from gearplay.files.replacement import settle_alone
    from gearplay.sweeps.running.engines import Engine
    from gearplay.sweeps.running.evaluate import Sweep
    from gearplay.sweeps.running.folder import plan_in

    chosen = Engine(
        engine, workers, scheduler, _security(scheduler, tls_ca, tls_cert, tls_key), _shard(shard)
    )
    settle_alone(folder, _forget)  # its plan may lie beside its place
    _run(Sweep(plan_in(folder)), folder, chosen, json=json, retry=retry, zarr=zarr)


def _run(
    made: Any,
    folder: Path,
    chosen: Any,
    *,
    json: bool,
    retry: bool = False,
    overwrite: bool = False,
    zarr: bool = False,
) -> None:
    from gearplay.files.folder_lock import locked
    from gearplay.files.replacement import renewal, renewed, replace_old, settle_alone
    from gearplay.results.outcomes import Account
    from gearplay.sweeps.report.page import write_sweep_report
    from gearplay.sweeps.running.folder import CUBE, PRODUCT, gather, gather_cube, jobs_left, run_in
    from gearplay.sweeps.running.zarr_export import tidy_cube
    from gearplay.sweeps.tolerances.page import PAGE
    from gearplay.sweeps.tolerances.results import answer
    from gearplay.vocabulary.optional import load_optional

    large = zarr and made.is_large
    if zarr:
        load_optional("zarr", "cluster")
    if not large or made.plan.tolerance is not None:
        made.check_size()
    part = "" if chosen.shard is None else f"{chosen.shard[0]}-of-{chosen.shard[1]}"
    settle_alone(folder, _forget)  # shards are in the folder together
    with locked(folder, part=part):
        if not part:
            tidy_cube(folder / CUBE)  # one that was being replaced counts as whole
        of = made.plan.model_dump_json(exclude_none=True)
        begin = partial(renewal, folder, overwrite=overwrite, of=of, whole=(PRODUCT, CUBE), forget=_forget)
        look = partial(jobs_left, made, shard=chosen.shard, retry=retry)
        place, left = renewed(
            begin, look, overwrite=overwrite
        )  # a wrong folder is said before kernels are compiled
        try:
            if (left or made.plan.tolerance) and chosen.scheduler is None and chosen.kind == "threads":
                compile_kernels(made.template.base, quiet=json)
            with interruptible() as stop, progress_bar(quiet=json) as report, chosen.lasting() as engine:
                count = run_in(made, place, engine, left, progress=report, stop=stop)
                if chosen.shard is not None:
                    document = {"title": made.plan.title, "shard": part, "ran": count, "out": str(folder)}
                    words = f"Shard {part}: {count} cases run. gearplay resume {folder} gathers all shards."
                    print_json(document) if json else print_text(words)
                    return
                document = {"title": made.plan.title, "cases": len(made.template.points), "ran": count}
                if zarr:
                    document |= gather_cube(made, place).as_document() | {"cube": str(folder / CUBE)}
                if not large:
                    product = gather(made, place)
                    write_sweep_report(made, product, place)
                    written = {"out": str(folder / PRODUCT), "report": str(folder / "report.html")}
                    ended = Account.of(product["status"].values, product["reason"].values)
                    document |= ended.as_document() | written
                if made.plan.tolerance is not None:
                    found = answer(made, product, place, engine=engine, progress=report, stop=stop)
                    document |= {"tolerance": found, "tolerance_page": str(folder / PAGE)}
        except KeyboardInterrupt:
            raise CommandInterruptedError(
                f"Interrupted. Finished cases are kept: gearplay resume {folder} continues there."
                if place == folder
                else f"Interrupted. The result in {folder} is as it was; the same command goes on with the new one."
            ) from None
        replace_old(folder, place, _forget)
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
    compile_kernels(made.template.base, quiet=json)
    found = forecast(made, search=search_cases(made.plan), workers=workers, begun=begun)
    if json:
        print_json({"title": made.plan.title, **asdict(found)})
        return
    print_text(
        f"{made.plan.title or 'Sweep'}: {found.cases} cases"
        + (f" and at most {found.search} of the search for a safe size" if found.search else "")
        + f", about {_duration(found.seconds + found.beside)} on {found.workers} workers "
        f"(from {found.pilots} of them; {_duration(found.beside)} of it for start and report), "
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
    from gearplay.model.overrides import parse_override
    from gearplay.sweeps.plans.reading import load_sweep

    document = plan.model_dump(mode="json", exclude_none=True)
    document["set"] = {**document["set"], **dict(parse_override(text) for text in changes)}
    return load_sweep(document)


def _security(
    scheduler: str | None, ca: Path | None, cert: Path | None, key: Path | None
) -> dict[str, Path] | None:
    given = {"tls_ca_file": ca, "tls_client_cert": cert, "tls_client_key": key}
    found = {name: path for name, path in given.items() if path is not None}
    if found and scheduler is None:
        rule = "must be given together with --scheduler"
        raise InputError(
            Fault("--tls", ", ".join(map(str, found.values())), rule, "Give its address, or remove it")
        )
    return found or None


def _shard(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        rule = "must be i/n with 1 <= i <= n"
        raise InputError(Fault("--shard", text, rule, "Write for example --shard 3/8"))
    return int(found[1]), int(found[2])


def _forget(folder: Path) -> None:
    from gearplay.sweeps.running.folder import CUBE, PLAN, PRODUCT
    from gearplay.sweeps.running.store import PATTERN
    from gearplay.sweeps.running.zarr_export import beside

    for name in (PLAN, PRODUCT, "report.html", "tolerance.html", "tolerance.json"):
        (folder / name).unlink(missing_ok=True)
    for path in folder.glob(f"{PATTERN}*"):
        path.unlink()
    for path in (*beside(folder / CUBE), *(folder / name for name in ("figures", CUBE, "tolerance"))):
        shutil.rmtree(path, ignore_errors=True)
