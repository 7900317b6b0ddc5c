"""Folder of a data set: records, one file each, rows of finished ones, and the table of labels that completes it."""

import csv
import io
import json
import shutil
import threading
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from gearplay.datasets.evaluate import PER_SENSOR, Dataset
from gearplay.datasets.plan import DatasetPlan
from gearplay.files.atomic import write_bytes, write_text
from gearplay.files.measurements.writing import write_record
from gearplay.files.record import Record
from gearplay.results.outcomes import MISSING
from gearplay.sweeps.cases.points import order_of
from gearplay.vocabulary.progress import Progress
from gearplay.work.claims import PLAN, claim
from gearplay.work.engine import Engine
from gearplay.work.folder import OutputFolder
from gearplay.work.rows import PATTERN, RowStore, StoredRows, remove_failed, store_name

PROGRAM, RECORDS, LABELS, SHEET = "gearplay dataset", "records", "labels.csv", "README.md"
PER_FOLDER: Final = 1000
"""Files of a subfolder of the records."""
ENDINGS: Final[Mapping[str, str]] = {"npy": ".npy", "hdf5": ".h5", "wav": ".wav", "mat": ".mat"}


def output_folder(folder: Path) -> OutputFolder:
    """Return the output folder of a data set."""
    return OutputFolder(folder, lambda path: (path / LABELS).exists(), remove_dataset)


def remove_dataset(folder: Path) -> None:
    """Delete the plan, labels and records of a data set from its folder."""
    for name in (LABELS, SHEET, PLAN):
        (folder / name).unlink(missing_ok=True)
    for path in folder.glob(f"{PATTERN}*"):
        path.unlink()
    shutil.rmtree(folder / RECORDS, ignore_errors=True)


def record_path(plan: DatasetPlan, record: int) -> str:
    """Return the path of a record's file in its folder.

    >>> record_path(DatasetPlan.model_construct(format="npy"), 12345)
    'records/012/0012345.npy'
    """
    return f"{RECORDS}/{record // PER_FOLDER:03d}/{record:07d}{ENDINGS[plan.format]}"


def write_samples(record: Record, path: Path) -> None:
    """Write a record in the format of the path: ``.npy`` has the samples alone, float32, shape [channel, time]."""
    if path.suffix != ".npy":
        write_record(record, path, overwrite=True)
        return
    made = io.BytesIO()
    np.save(made, np.stack([channel.values for channel in record.channels]).astype(np.float32))
    write_bytes(path, made.getvalue())


def jobs_left(made: Dataset, folder: Path, engine: Engine, *, retry: bool = False) -> list[int]:
    """Claim a folder locked by the caller; return the missing records of the engine's shard, in order.

    A record counts as finished when it has a row and, unless it failed, its file. ``retry`` includes failed ones. Raises
    `TakenError` where the folder belongs to another plan or is damaged.
    """
    claim(folder, json.loads(made.plan.model_dump_json(exclude_none=True)), PROGRAM)
    if retry:
        remove_failed(folder, engine.shard)
    with closing(StoredRows(folder, made.size, engine.shard)) as rows:
        known = {address: status for address, (status, _, _) in rows.items_once()}
    left = []
    for job in map(int, engine.share(order_of(len(made.recipe)))):
        status = known.get(made.address_of(job), MISSING)
        if status == MISSING or (status == 0 and not (folder / record_path(made.plan, job)).exists()):
            left.append(job)
    return left


def run_in(
    made: Dataset,
    folder: Path,
    engine: Engine,
    left: Sequence[int],
    *,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> None:
    """Simulate the missing records of a folder locked by the caller: each file is written atomically, then its row."""
    finished = engine.run(
        made,
        left,
        label=made.plan.title or "dataset",
        finished=len(engine.share(range(len(made.recipe)))) - len(left),
        progress=progress,
        stop=stop,
    )
    with closing(RowStore(folder / store_name(engine.shard))) as store, closing(finished):
        for pieces in finished:
            for piece in pieces:
                if piece.record is not None:
                    write_samples(piece.record, folder / record_path(made.plan, piece.outcome.number))
            store.add([piece.outcome for piece in pieces])


def gather(made: Dataset, folder: Path) -> list[dict[str, Any]]:
    """Write the table of labels and the data sheet of all rows in a folder; return the table, row by row."""
    from gearplay.datasets.data_sheet import sheet_of

    with closing(StoredRows(folder, made.size)) as rows:
        known = dict(rows.items_once())
    table = [_row(made, record, known.get(made.address_of(record))) for record in range(len(made.recipe))]
    for stale in (folder / RECORDS).glob("*/.*.part"):
        stale.unlink()
    write_text(folder / SHEET, sheet_of(made, table))
    write_text(folder / LABELS, _as_csv(table, list(made.recipe.columns())))
    return table


def numbers_of(sensors: Sequence[str]) -> list[str]:
    """Return the columns of the numbers in a row: plain names for one sensor."""
    return [f"{kind}_{name}" if len(sensors) > 1 else kind for name in sensors for kind in PER_SENSOR]


def _row(made: Dataset, record: int, found: tuple[int, str, bytes] | None) -> dict[str, Any]:
    status, reason, row = found or (MISSING, "not run yet", b"")
    names = numbers_of(made.sensors)
    numbers = np.frombuffer(row) if row else np.full(len(names), np.nan)
    labels = made.recipe.labels(record)
    file = record_path(made.plan, record) if status == 0 else ""
    return {
        "record": record,
        "path": file,
        **labels,
        **dict(zip(names, numbers.tolist(), strict=True)),
        "status": status,
        "reason": reason.translate({ord(","): ";", ord("#"): None}),
    }


def _as_csv(table: Sequence[Mapping[str, Any]], varied: Sequence[str]) -> str:
    """Return the table as text, empty where a class does not draw a parameter."""
    first = ["record", "path", "label", "split", "group", "machine", "member", *varied]
    heads = [*first, *(name for name in table[0] if name not in {*first, *varied})]
    heads = [*(n for n in heads if n not in ("status", "reason")), "status", "reason"]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    for row in table:
        writer.writerow(["" if (value := row.get(head)) is None else _shown(value) for head in heads])
    return text.getvalue()


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return "" if np.isnan(value) else repr(value)
    return str(value)
