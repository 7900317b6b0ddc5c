"""Options of commands whose work runs on threads, processes, a cluster, or in parts."""

import re
from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.vocabulary.errors import InputError

Workers = Annotated[
    int | None,
    typer.Option("--workers", min=1, help="Number of threads or processes; the cores by default."),
]
EngineKind = Annotated[str, typer.Option("--engine", help="Kind of workers: threads or processes.")]
Scheduler = Annotated[str | None, typer.Option("--scheduler", help="Address of a Dask scheduler to run on.")]
Shard = Annotated[str | None, typer.Option("--shard", help="Run part i of n only: --shard 3/8.")]
Tls = Annotated[Path | None, typer.Option(help="TLS file for the scheduler.")]


def chosen_engine(
    kind: str,
    workers: int | None,
    scheduler: str | None,
    tls: tuple[Path | None, Path | None, Path | None],
    shard: str | None,
) -> Any:
    """Return the engine that the options name; `InputError` for options that do not fit together."""
    from gearplay.work.engine import Engine

    names = ("tls_ca_file", "tls_client_cert", "tls_client_key")
    files = {name: path for name, path in zip(names, tls, strict=True) if path is not None}
    if files and scheduler is None:
        rule = "must be given together with --scheduler"
        raise InputError.of(
            "--tls", ", ".join(map(str, files.values())), rule, "Give its address, or remove it"
        )
    return Engine(kind, workers, scheduler, files or None, _shard(shard))


def _shard(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        rule = "must be i/n with 1 <= i <= n"
        raise InputError.of("--shard", text, rule, "Write for example --shard 3/8")
    return int(found[1]), int(found[2])
