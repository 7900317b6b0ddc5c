"""What SQLite says of a file, in one sentence: of a full disk, of another process, of a file that is no database."""

import sqlite3
from pathlib import Path

import pytest

from gearplay.files.databases import sqlite_errors
from gearplay.vocabulary.errors import GearplayError, InputError, ResourceError, TakenError

FILE = Path("kept") / "trials.sqlite"


def raised(error: Exception, *, wrapped: bool, foreign: bool = False) -> Exception:
    """Return what an error becomes, within a library's own or by itself."""
    try:
        with sqlite_errors(FILE, "hold trials", "Overwrite it", foreign=foreign):
            if not wrapped:
                raise error
            try:
                raise error
            except Exception as cause:
                raise RuntimeError("the commit failed") from cause
    except Exception as told:
        return told
    raise AssertionError("nothing was raised")


@pytest.mark.parametrize("wrapped", [False, True])
@pytest.mark.parametrize(
    ("words", "kind", "told"),
    [
        ("disk I/O error", ResourceError, "cannot be written (disk I/O error). What is stored stays valid"),
        ("database or disk is full", ResourceError, "the same command goes on"),
        ("database is locked", InputError, "must not be in use by another process. Wait for it"),
        ("file is not a database", TakenError, "must hold trials (file is not a database). Overwrite it."),
    ],
)
def test_an_error_of_sqlite_is_one_sentence(
    wrapped: bool, words: str, kind: type[GearplayError], told: str
) -> None:
    found = raised(sqlite3.OperationalError(words), wrapped=wrapped)
    assert type(found) is kind
    assert told in str(found)
    assert "trials.sqlite" in str(found)


def test_another_error_is_a_foreign_file_or_comes_through() -> None:
    assert type(raised(KeyError("version"), wrapped=False)) is KeyError
    found = raised(KeyError("version"), wrapped=False, foreign=True)
    assert type(found) is TakenError
    assert "must hold trials (KeyError)" in str(found)
