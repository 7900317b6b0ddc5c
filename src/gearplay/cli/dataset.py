"""`gearplay dataset PLAN`: labelled records for learning, resumable."""

from collections import Counter
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from gearplay.cli.engines import EngineKind, Scheduler, Shard, Tls, Workers, chosen_engine
from gearplay.cli.interrupts import CommandInterruptedError
from gearplay.cli.options import Changes
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.progress import watched
from gearplay.vocabulary.exit_codes import PARTLY


def dataset(
    plan: Annotated[str, typer.Argument(help="A plan file, or a bundled plan: bearing-dents.")],
    out: Annotated[Path | None, typer.Option("--out", help="Folder [default: out/dataset-PLAN].")] = None,
    changes: Changes = None,
    retry: Annotated[bool, typer.Option("--retry", help="Simulate failed records again.")] = False,
    engine: EngineKind = "threads",
    workers: Workers = None,
    scheduler: Scheduler = None,
    tls_ca: Tls = None,
    tls_cert: Tls = None,
    tls_key: Tls = None,
    shard: Shard = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the data set in the folder.")
    ] = False,
    json: Json = False,
) -> None:
    """Simulate labelled records of a plan, for learning.

    Each finished record is stored at once; the same command continues after an interruption, or gathers shards.
    """
    from gearplay.datasets.evaluate import Dataset
    from gearplay.datasets.make_dataset import dataset_in
    from gearplay.datasets.reading import load_dataset_plan
    from gearplay.model.overrides import parse_override

    read = load_dataset_plan(plan)
    read = read.model_copy(update={"set": {**read.set, **dict(map(parse_override, changes or ()))}})
    made = Dataset(read.frozen())
    folder = out if out is not None else Path("out") / f"dataset-{Path(plan).stem}"
    chosen = chosen_engine(engine, workers, scheduler, (tls_ca, tls_cert, tls_key), shard)

    try:
        ran, found = dataset_in(
            made, folder, chosen, overwrite=overwrite, retry=retry, watch=partial(watched, quiet=json)
        )
    except KeyboardInterrupt:
        raise CommandInterruptedError(
            f"Interrupted. Finished records in {folder} are kept: the same command continues there."
        ) from None
    if found is None:
        words = (
            f"Shard {shard}: {ran} records simulated. The same command without --shard gathers all shards."
        )
        document: dict[str, Any] = {"title": made.plan.title, "shard": shard, "ran": ran, "out": str(folder)}
        print_json(document) if json else print_text(words)
        return
    done = found.ds["status"].values == 0
    parts = Counter(map(str, found.ds["split"].values[done]))
    document = {"title": made.plan.title, "records": len(made.recipe), "ran": ran, "split": dict(parts)}
    document |= found.account.as_document() | {"out": str(folder)}
    print_json(document) if json else print_text(f"{found.message}. {ran} simulated now.\nWritten: {folder}")
    if not found.account.complete:
        raise typer.Exit(PARTLY)
