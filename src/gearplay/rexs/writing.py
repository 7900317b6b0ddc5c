"""A case file as text: tables with comments; fields that the schema does not have become comments."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, get_args

from pydantic import BaseModel

from gearplay.model.toml_files import inline_value
from gearplay.rexs.notes import Notes

WIDTH: Final = 110


@dataclass
class Entry:
    """A field: its value as text, a number or an inline table, and a comment."""

    key: str
    value: Any
    comment: str = ""


@dataclass
class Table:
    """A table of the case, the model of its fields, and comments above it."""

    header: str
    model: type[BaseModel] | None
    comments: list[str] = field(default_factory=list)
    entries: list[Entry] = field(default_factory=list)

    def add(self, key: str, value: Any, comment: str = "") -> None:
        """Add a field; None is left out."""
        if value is not None:
            self.entries.append(Entry(key, value, comment))

    def accepts(self, key: str) -> bool:
        """Return whether the schema of this version has a field."""
        return self.model is None or key in self.model.model_fields

    def lines(self, notes: Notes) -> Iterator[str]:
        """Yield the text; fields that the schema does not have become comments, and are noted."""
        yield ""
        for comment in self.comments:
            yield from commented(comment)
        yield self.header
        for entry in self.entries:
            text = f"{entry.key} = {inline_value(entry.value)}"
            known = self.accepts(entry.key)
            comment = (
                entry.comment if known else ", ".join(filter(None, ["not in this version", entry.comment]))
            )
            if not known:
                notes.leave_out(
                    f"{self.header} {text}: not in this version of gearplay; it is a comment there"
                )
            yield ("" if known else "# ") + text + (f"  # {one_line(comment)}" if comment else "")


def one_line(text: str) -> str:
    """Return text without line breaks and control characters, as a comment may have it."""
    return "".join(each if each.isprintable() else " " for each in text)


def commented(text: str) -> Iterator[str]:
    """Yield a text as lines of comments."""
    for k, line in enumerate(textwrap.wrap(one_line(text), WIDTH - 4, break_on_hyphens=False) or [""]):
        yield f"# {'  ' if k else ''}{line}"


def kinds_of(model: type[BaseModel], name: str) -> dict[str, type[BaseModel]]:
    """Return the models of a field that is a union by ``kind``, by their kinds."""
    found: dict[str, type[BaseModel]] = {}

    def look(annotation: Any) -> None:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            kind = annotation.model_fields.get("kind")
            if kind is not None:
                found[str(kind.default)] = annotation
            return
        for inner in get_args(annotation):
            look(inner)

    if name in model.model_fields:
        look(model.model_fields[name].annotation)
    return found


def case_text(head: Iterable[str], top: Mapping[str, Any], tables: Iterable[Table], notes: Notes) -> str:
    """Return the text of a case file: notes, fields of the case, tables."""
    body = [line for table in tables for line in table.lines(notes)]
    lines = [line for text in head for line in commented(text)]
    lines += [line for note in notes.every for line in commented(f"- {note}")]
    lines += ["", *(f"{key} = {inline_value(value)}" for key, value in top.items() if value is not None)]
    return "\n".join([*lines, *body]) + "\n"
