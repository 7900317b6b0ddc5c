"""Plans as raw tables, from a bundled name, a TOML file or a dictionary."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gearplay.files.atomic import shown_path
from gearplay.model.bundled import bundled, bundled_text
from gearplay.model.case import Case
from gearplay.model.reading import bundled_names
from gearplay.model.toml_files import parse_toml, plain_copy, toml_text
from gearplay.vocabulary.errors import InputError, shorten
from gearplay.vocabulary.suggestions import did_you_mean

Source = str | os.PathLike[str] | Mapping[str, Any]


def plan_document(source: Source, package: str) -> dict[str, Any]:
    """Return the raw table behind a source; bundled plans are those of ``package``.

    A path of its ``case`` counts from the folder of the file; that of a dictionary from the current one.

    Raises `InputError` where there is no such plan, file or case, or it is no TOML.
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
        raise InputError.of("plan", name, rule, did_you_mean(name, known, "Plans"))
    else:
        text, where = toml_text(Path(name), what="plan"), shorten(Path(name).name)
    document: dict[str, Any] = plain_copy(parse_toml(text, where))
    if name not in known and isinstance(case := document.get("case"), str) and case not in bundled_names():
        document["case"] = _case_path(Path(name), case)
    return document


def _case_path(plan: Path, case: str) -> str:
    """Return the path of a plan's case, relative to the plan's folder; `InputError` where there is no file."""
    place = plan.parent / Path(case).expanduser()
    if not os.path.lexists(place):
        rule = f"must be a bundled case, or a file relative to the plan's folder: {shown_path(place)} does not exist"
        raise InputError.of("case", case, rule, did_you_mean(case, bundled_names(), "Cases"))
    return str(place)
