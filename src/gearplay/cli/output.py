"""What the commands print: one JSON document on standard output, or text; messages on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer

from gearplay.vocabulary.errors import GearplayError, InputError, escape_controls

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")]

_RED, _PLAIN = "\033[31m", "\033[0m"


def print_json(document: Mapping[str, Any]) -> None:
    """Print the one document of a command."""
    sys.stdout.write(json.dumps(document, indent=2, allow_nan=False) + "\n")


def print_text(text: str) -> None:
    """Print a result for people on standard output."""
    _write(sys.stdout, text)


def pictures_in(folder: Path) -> list[str]:
    """Return the line that names every picture in a folder, none where there is no picture."""
    names = sorted(each.name for each in folder.glob("*") if each.suffix in (".png", ".svg", ".pdf", ".gif"))
    return [f"Pictures in {folder}: {', '.join(names)}"] if names else []


def say(text: str) -> None:
    """Print a message for people on standard error."""
    _write(sys.stderr, text)


def say_error(text: str) -> None:
    """Print an error on standard error, red on a terminal."""
    shown = "\n".join(escape_controls(line) for line in text.splitlines())
    _write(sys.stderr, f"{_RED}{shown}{_PLAIN}" if sys.stderr.isatty() else shown)


def error_document(error: BaseException, exit_code: int) -> dict[str, Any]:
    """Return the JSON document of a command that failed."""
    document: dict[str, Any] = {"status": "failed", "exit_code": exit_code, "message": str(error)}
    if isinstance(error, InputError):
        document["faults"] = [fault.as_document() for fault in error.faults]
    if isinstance(error, GearplayError):
        document["error"] = type(error).__name__
    return document


def _write(stream: TextIO, text: str) -> None:
    """Write a line at once, into a pipe too; characters the stream cannot show become escapes."""
    encoding = stream.encoding or "utf-8"
    stream.write(text.encode(encoding, "backslashreplace").decode(encoding) + "\n")
    stream.flush()
