"""Store of finished points: rows by key in SQLite, one file per writer, safe against kills."""

import hashlib
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from pathlib import Path

from gearplay.files.databases import sqlite_errors
from gearplay.sweeps.running.evaluate import Outcome

PATTERN = "rows*.sqlite"
_TABLE = (
    "create table if not exists rows "
    "(address blob primary key, status integer not null, reason text not null, seconds real not null, row blob not null)"
)

DIGEST = 12
"""Bytes of a row's digest, which stands behind its numbers; no multiple of a number's."""


def store_name(shard: tuple[int, int] | None) -> str:
    """Return the file name of a writer: of the whole sweep, or of shard i of n.

    >>> store_name(None), store_name((2, 8))
    ('rows.sqlite', 'rows-2-of-8.sqlite')
    """
    return "rows.sqlite" if shard is None else f"rows-{shard[0]}-of-{shard[1]}.sqlite"


class RowStore:
    """One writer's file. Each job is one transaction: what `add` returned from is not lost by a kill.

    One process holds the file (write-ahead log, exclusive). Raises `InputError` where it is damaged or in use, `ResourceError`
    where the disk is full.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with _in_words(path):
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
        """Store what was finished together, in one transaction."""
        rows = [(o.address, o.status, o.reason, o.seconds, _sealed(o)) for o in outcomes]
        with _in_words(self.path):
            self.connection.execute("begin")
            self.connection.executemany("insert or replace into rows values (?, ?, ?, ?, ?)", rows)
            self.connection.execute("commit")

    def close(self) -> None:
        """Bring the log into the file and let go of it."""
        with _in_words(self.path):
            self.connection.close()


def read_rows(
    folder: Path, size: int, shard: tuple[int, int] | None = None
) -> Iterator[tuple[bytes, int, str, float, bytes]]:
    """Yield (address, status, reason, seconds, row) of every writer's file; rows of another ``size`` are left out.

    A shard leaves out those of its fellows, who may hold theirs; they have none of its points.

    Raises `InputError` for a damaged file or one that another process holds.
    """
    for path in _files(folder, shard):
        with _in_words(path), closing(sqlite3.connect(path, isolation_level=None)) as connection:
            if not _has_rows(connection):
                continue
            for found in connection.execute("select address, status, reason, seconds, row from rows"):
                if (row := _whole(found, size)) is not None:
                    yield (*found[:4], row)


class StoredRows(Mapping[bytes, tuple[int, str, bytes]]):
    """The rows of every writer's file by address, read on request, as they may exceed the memory.

    Raises `InputError` for a damaged file or one that another process holds.
    """

    def __init__(self, folder: Path, size: int) -> None:
        self.size, self.open = size, ExitStack()
        self.connections: list[tuple[Path, sqlite3.Connection]] = []
        for path in _files(folder, None):
            with _in_words(path):
                connection = self.open.enter_context(closing(sqlite3.connect(path, isolation_level=None)))
                if _has_rows(connection):
                    self.connections.append((path, connection))

    def __getitem__(self, address: bytes) -> tuple[int, str, bytes]:
        for path, connection in self.connections:
            with _in_words(path):
                asked = connection.execute(
                    "select address, status, reason, seconds, row from rows where address = ?", (address,)
                )
                found: tuple[bytes, int, str, float, bytes] | None = asked.fetchone()
            if found is not None and (row := _whole(found, self.size)) is not None:
                return found[1], found[2], row
        raise KeyError(address)

    def __iter__(self) -> Iterator[bytes]:
        seen: set[bytes] = set()
        for path, connection in self.connections:
            with _in_words(path):
                for found in connection.execute("select address, status, reason, seconds, row from rows"):
                    if found[0] not in seen and _whole(found, self.size) is not None:
                        seen.add(found[0])
                        yield found[0]

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def close(self) -> None:
        """Let go of the files."""
        self.open.close()


def _sealed(outcome: Outcome) -> bytes:
    """Return a row with the digest of all that is stored of its point."""
    row = outcome.row.tobytes()
    return row + _digest(outcome.address, outcome.status, outcome.reason, outcome.seconds, row)


def _digest(address: bytes, status: int, reason: str, seconds: float, row: bytes) -> bytes:
    told = repr((address, int(status), reason, float(seconds))).encode()
    return hashlib.sha256(told + row).digest()[:DIGEST]


def _whole(found: tuple[bytes, int, str, float, bytes], size: int) -> bytes | None:
    """Return a stored row of ``size`` numbers, or None where it is another's or was changed: its point is run again."""
    row, digest = found[4][: 8 * size], found[4][8 * size :]
    if len(row) < 8 * size or digest != _digest(*found[:4], row):
        return None
    return row


def _files(folder: Path, shard: tuple[int, int] | None) -> list[Path]:
    """Return the writers' files that a run may open: all, or for a shard all but those of its fellows, who may hold theirs."""
    fellows = set() if shard is None else {store_name((i, shard[1])) for i in range(1, shard[1] + 1)}
    return [
        path
        for path in sorted(folder.glob(PATTERN))
        if path.name not in fellows or (shard is not None and path.name == store_name(shard))
    ]


def _has_rows(connection: sqlite3.Connection) -> bool:
    """Return whether a file has its table: a writer killed at once leaves an empty one."""
    found = connection.execute("select 1 from sqlite_master where type = 'table' and name = 'rows'")
    return found.fetchone() is not None


def _in_words(path: Path) -> AbstractContextManager[None]:
    return sqlite_errors(path, "be a sweep's readable store", "Choose another folder, or overwrite it")


def forget_failed(folder: Path, shard: tuple[int, int] | None = None) -> None:
    """Remove points that failed, so that they run again; a shard leaves other shards' files alone."""
    for path in _files(folder, shard):
        with _in_words(path), closing(sqlite3.connect(path, isolation_level=None)) as connection:
            if _has_rows(connection):
                connection.execute("delete from rows where status != 0")
