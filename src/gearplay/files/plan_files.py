"""Plans as raw tables, from a bundled name, a TOML file or a dictionary."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gearplay.model.bundled import bundled, bundled_text
from gearplay.model.case import Case
from gearplay.model.toml_files import parse_toml, plain_copy, read_text
from gearplay.model.wording import did_you_mean
from gearplay.vocabulary.errors import Fault, InputError, shorten

Source = str | os.PathLike[str] | Mapping[str, Any]


def plan_document(source: Source, package: str) -> dict[str, Any]:
    """Return the raw table behind a source; bundled plans are those of ``package``.

    Raises `InputError` where there is no such plan or file, or it is no TOML.
    """
    if isinstance(source, Mapping):
        case = source.get("case")
        table = {**source, "case": case.resolved()} if isinstance(case, Case) else source
        copied: dict[str, Any] = plain_copy(table)
        return copied
    name, known = os.fspath(source), bundled(package, "plans")
    if name in known:
        text = bundled_text(package, "plans", name)
        where = name
    elif not name.endswith(".toml") and not os.path.lexists(name):
        rule = "must be a bundled plan or the path of a file"
        raise InputError(Fault("plan", name, rule, did_you_mean(name, known, "Plans")))
    else:
        text, where = read_text(Path(name), what="plan"), shorten(Path(name).name)
    return plain_copy(parse_toml(text, where))  # type: ignore[no-any-return]
