"""Output of commands: one JSON document or text on standard output, messages on standard error."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, TextIO

import typer

from gearplay.vocabulary.errors import GearplayError, InputError, ResourceError, escape_controls

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")]

_NO_ROOM: Final = (errno.ENOSPC, errno.EIO, errno.EFBIG, errno.EDQUOT)
_RED, _PLAIN = "\033[31m", "\033[0m"


def print_json(document: Mapping[str, Any]) -> None:
    """Print the one document of a command."""
    _write(sys.stdout, json.dumps(document, indent=2, allow_nan=False))


def print_text(text: str) -> None:
    """Print a result for people on standard output."""
    _write(sys.stdout, text)


def result_lines(result: Any, title: str, *, most: int = 20) -> list[str]:
    """Return the message of a result, titled, and its rows, ``most`` at most, as lines for people."""
    rows = list(result.rows())
    wide = max((len(name) for name, _ in rows[:most]), default=0)
    lines = [f"{title}: {result.message}", *(f"  {name:>{wide}}  {value}" for name, value in rows[:most])]
    return lines if len(rows) <= most else [*lines, f"  and {len(rows) - most} more"]


def pictures_in(folder: Path) -> list[str]:
    """Return the line that names every picture in a folder, none where there is no picture."""
    names = sorted(each.name for each in folder.glob("*") if each.suffix in (".png", ".svg", ".pdf", ".gif"))
    return [f"Pictures in {folder}: {', '.join(names)}"] if names else []


def say(text: str) -> None:
    """Print a message on standard error; ignore a failure to write it."""
    with contextlib.suppress(OSError):
        _write(sys.stderr, text)


def say_error(text: str) -> None:
    """Print an error on standard error, red on a terminal."""
    shown = "\n".join(escape_controls(line) for line in text.splitlines())
    say(f"{_RED}{shown}{_PLAIN}" if sys.stderr.isatty() else shown)


def error_document(error: BaseException, exit_code: int) -> dict[str, Any]:
    """Return the JSON document of a command that failed."""
    document: dict[str, Any] = {"status": "failed", "exit_code": exit_code, "message": str(error)}
    if isinstance(error, InputError):
        document["faults"] = [fault.as_document() for fault in error.faults]
    if isinstance(error, GearplayError):
        document["error"] = type(error).__name__
    return document


def _write(stream: TextIO, text: str) -> None:
    """Write a line and flush; characters that the stream cannot encode become escapes."""
    encoding = stream.encoding or "utf-8"
    stream.write(text.encode(encoding, "backslashreplace").decode(encoding) + "\n")
    stream.flush()


def output_failure(error: Exception) -> Exception:
    """Return a `ResourceError` for an error of writing standard output, any other error unchanged."""
    if not isinstance(error, OSError) or error.errno not in _NO_ROOM or error.filename is not None:
        return error
    try:
        os.write(1, b" ")  # without a buffer the failed write has left nothing to flush
        sys.stdout.flush()
    except OSError:
        silence(1)
    else:
        return error
    return ResourceError(
        f"Standard output cannot be written ({error.strerror}); files that the command names are complete. Send it elsewhere."
    )


def silence(number: int) -> None:
    """Send a standard stream, 0 to 2, to the null device, so that the interpreter can flush it at its end."""
    empty = os.open(os.devnull, os.O_RDWR)
    if empty != number:
        os.dup2(empty, number)
        os.close(empty)


def open_streams() -> None:
    """Open closed standard streams on the null device, so that no file gets their number and writing does not fail."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            silence(number)
        if getattr(sys, name) is None:
            stream = open(number, "r" if number == 0 else "w", encoding="utf-8", closefd=False)  # noqa: SIM115
            setattr(sys, name, stream)
