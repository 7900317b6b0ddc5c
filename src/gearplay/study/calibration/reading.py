"""Doors of calibration: plan files, bundled plans and dictionaries into a `Plan`."""

import os
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from gearplay.model.toml_files import parse_toml, plain_copy, read_text
from gearplay.model.wording import did_you_mean, translate
from gearplay.study.calibration.plan import Plan
from gearplay.vocabulary.errors import Fault, InputError, shorten


def bundled_plans() -> list[str]:
    """Return the names of the plans that come with the package.

    >>> "han2021" in bundled_plans()
    True
    """
    folder = files("gearplay.study.calibration") / "plans"
    return sorted(e.name.removesuffix(".toml") for e in folder.iterdir() if e.name.endswith(".toml"))


def plan_folder(source: str | os.PathLike[str]) -> Path:
    """Return where a plan's records are looked for: beside the plan, or among the package's own."""
    if os.fspath(source) in bundled_plans():
        return Path(str(files("gearplay.study.calibration") / "plans"))
    return Path(source).parent


def load_plan(source: str | os.PathLike[str] | Mapping[str, Any]) -> Plan:
    """Read a calibration plan: a bundled name, the path of a TOML file, or a dictionary laid out as one.

    Raises `InputError` with every fault found.

    >>> len(load_plan("han2021").conditions)
    6
    """
    document = _document(source)
    try:
        return Plan.model_validate(document)
    except ValidationError as error:
        raise InputError(translate(error, document, Plan)) from None


def _document(source: str | os.PathLike[str] | Mapping[str, Any]) -> dict[str, Any]:
    if isinstance(source, Mapping):
        copied: dict[str, Any] = plain_copy(source)
        return copied
    name = os.fspath(source)
    known = bundled_plans()
    if name in known:
        text = (files("gearplay.study.calibration") / "plans" / f"{name}.toml").read_text(encoding="utf-8")
        where = name
    elif not name.endswith(".toml") and not os.path.lexists(name):
        raise InputError(
            Fault(
                "plan",
                name,
                "must be a bundled plan or the path of a file",
                did_you_mean(name, known, "Plans"),
            )
        )
    else:
        text, where = read_text(Path(name)), shorten(Path(name).name)
    return plain_copy(parse_toml(text, where))  # type: ignore[no-any-return]
