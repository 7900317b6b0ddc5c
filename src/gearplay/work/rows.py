"""Store of finished rows of numbers by key in SQLite, one file per writer, safe against kills."""

import hashlib
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.files.databases import sqlite_errors

PATTERN = "rows*.sqlite"
COLUMNS = "address, status, reason, seconds, row"
_TABLE = (
    "create table if not exists rows "
    "(address blob primary key, status integer not null, reason text not null, seconds real not null, row blob not null)"
)

DIGEST = 12
"""Bytes of a row's digest, which follows its numbers; no multiple of a number's."""
Shard = tuple[int, int] | None
"""(i, n) for the i-th writer of n; None for the only one."""


class Outcome(NamedTuple):
    """A finished point: its number, the address of its result, status, reason and kept numbers, shape [number]."""

    number: int
    address: bytes
    status: int
    reason: str
    row: NDArray[np.float64]
    seconds: float


def store_name(shard: Shard) -> str:
    """Return the file name of a writer.

    >>> store_name(None), store_name((2, 8))
    ('rows.sqlite', 'rows-2-of-8.sqlite')
    """
    return "rows.sqlite" if shard is None else f"rows-{shard[0]}-of-{shard[1]}.sqlite"


class RowStore:
    """One writer's file. Each job is one transaction: a kill loses nothing that `add` has returned from.

    One process holds the file (write-ahead log, exclusive). Raises `InputError` where it is damaged or in use, `ResourceError`
    where the disk is full.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with _errors_of(path):
            self.connection = sqlite3.connect(path, isolation_level=None)
            try:
                self.connection.execute("pragma locking_mode = exclusive")
                self.connection.execute("pragma journal_mode = wal")
                self.connection.execute("pragma synchronous = normal")
                self.connection.execute(_TABLE)
            except sqlite3.Error:
                self.connection.close()
                raise

    def add(self, outcomes: Sequence[Outcome]) -> None:
        """Store outcomes in one transaction."""
        rows = [(o.address, o.status, o.reason, o.seconds, o.row.tobytes()) for o in outcomes]
        with _errors_of(self.path):
            self.connection.execute("begin")
            self.connection.executemany(
                "insert or replace into rows values (?, ?, ?, ?, ?)",
                [(*row[:4], row[4] + _digest(*row)) for row in rows],
            )
            self.connection.execute("commit")

    def close(self) -> None:
        """Bring the log into the file and release it."""
        with _errors_of(self.path):
            self.connection.close()


class StoredRows(Mapping[bytes, tuple[int, str, bytes]]):
    """Status, reason and row of each address in every writer's file, read on request, as they may exceed the memory.

    Rows of another ``size`` and changed ones count as absent. For a ``shard`` the files of the other shards, which may be in
    use, are left out; they have none of its points.

    Raises `InputError` for a damaged file or one that another process holds.
    """

    def __init__(self, folder: Path, size: int, shard: Shard = None) -> None:
        self.size, self.open = size, ExitStack()
        self.connections: list[tuple[Path, sqlite3.Connection]] = []
        try:
            for path in _files(folder, shard):
                with _errors_of(path):
                    connection = self.open.enter_context(closing(sqlite3.connect(path, isolation_level=None)))
                    if _has_rows(connection):
                        self.connections.append((path, connection))
        except BaseException:
            self.close()
            raise

    def __getitem__(self, address: bytes) -> tuple[int, str, bytes]:
        for path, connection in self.connections:
            with _errors_of(path):
                found = connection.execute(
                    f"select {COLUMNS} from rows where address = ?", (address,)
                ).fetchone()
            if found is not None and (row := self._intact(found)) is not None:
                return found[1], found[2], row
        raise KeyError(address)

    def __iter__(self) -> Iterator[bytes]:
        return iter({address for address, _ in self.items_once()})

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def items_once(self) -> Iterator[tuple[bytes, tuple[int, str, bytes]]]:
        """Yield everything in one pass over the files; an address that several of them have comes several times."""
        for path, connection in self.connections:
            with _errors_of(path):
                for found in connection.execute(f"select {COLUMNS} from rows"):
                    if (row := self._intact(found)) is not None:
                        yield found[0], (found[1], found[2], row)

    def _intact(self, found: tuple[bytes, int, str, float, bytes]) -> bytes | None:
        """Return the numbers of a stored row; None where they are of another size or changed: the point is run again."""
        row, digest = found[4][: 8 * self.size], found[4][8 * self.size :]
        if len(row) < 8 * self.size or digest != _digest(*found[:4], row):
            return None
        return row

    def close(self) -> None:
        """Release the files."""
        self.open.close()


def remove_failed(folder: Path, shard: Shard = None) -> None:
    """Remove points that failed, so that they run again; a shard leaves other shards' files alone."""
    for path in _files(folder, shard):
        with _errors_of(path), closing(sqlite3.connect(path, isolation_level=None)) as connection:
            if _has_rows(connection):
                connection.execute("delete from rows where status != 0")


def _digest(address: bytes, status: int, reason: str, seconds: float, row: bytes) -> bytes:
    text = repr((address, int(status), reason, float(seconds))).encode()
    return hashlib.sha256(text + row).digest()[:DIGEST]


def _files(folder: Path, shard: Shard) -> list[Path]:
    """Return the writers' files that a run may open: all, or for a shard all but those of the other shards."""
    others = set() if shard is None else {store_name((i, shard[1])) for i in range(1, shard[1] + 1)}
    return [
        path
        for path in sorted(folder.glob(PATTERN))
        if path.name not in others or path.name == store_name(shard)
    ]


def _has_rows(connection: sqlite3.Connection) -> bool:
    """Return whether a file has its table: a writer killed at once leaves an empty one."""
    found = connection.execute("select 1 from sqlite_master where type = 'table' and name = 'rows'")
    return found.fetchone() is not None


def _errors_of(path: Path) -> AbstractContextManager[None]:
    return sqlite_errors(path, "be a sweep's readable store", "Choose another folder, or give overwrite=True")
