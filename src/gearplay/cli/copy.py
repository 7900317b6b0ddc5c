"""`gearplay copy NAME`: a bundled case or plan as a file to edit; without a name, the list of them."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Annotated, Final

import typer

from gearplay.cli.output import Json, print_json, print_text
from gearplay.vocabulary.errors import InputError

PLACES: Final = {
    "case": ("gearplay.model", "cases"),
    "sweep": ("gearplay.sweeps", "plans"),
    "calibration": ("gearplay.calibration", "plans"),
    "dataset": ("gearplay.datasets", "plans"),
}
"""Folders of the bundled files by kind."""
FIRST_STEPS: Final = {
    "case": "gearplay check {0}; gearplay run {0} --out run.nc",
    "sweep": "gearplay sweep {0} --dry-run",
    "calibration": "gearplay calibrate {0}",
    "dataset": "gearplay dataset {0}",
}
Kind = Annotated[
    str | None,
    typer.Option(
        "--kind",
        help="case, sweep, calibration or dataset, for a name of two kinds: han2021.",
        show_default=False,
    ),
]


def copy(
    name: Annotated[
        str | None,
        typer.Argument(help="A bundled case or plan; without it, the list of all.", show_default=False),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", help="File [default: NAME.toml].")] = None,
    kind: Kind = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing file.")] = False,
    json: Json = False,
) -> None:
    """Copy a bundled case or plan to change it, or list them."""
    from gearplay.files.atomic import check_new, write_bytes, write_text
    from gearplay.model.bundled import bundled_text

    known = names()
    if name is None:
        print_json({"status": "done", **known}) if json else print_text(_listed(known))
        return
    of, others = _kinds_of(name, kind, known)
    target = out or Path(f"{name}.toml")
    text = bundled_text(*PLACES[of], name)
    records = {target.parent / place: content for place, content in _records(of, text).items()}
    for path in (target, *records):
        check_new(path, overwrite=overwrite)
    for path, content in records.items():
        write_bytes(path, content)
    write_text(target, text)
    steps = FIRST_STEPS[of].format(target)
    if json:
        print_json({"status": "done", "kind": of, "out": str(target), "records": [str(p) for p in records]})
        return
    lines = [f"Wrote {path}" for path in (*records, target)]
    lines += [f"There is a {other} plan {name} too: --kind {other}" for other in others]
    print_text("\n".join([*lines, f"Next: {steps}"]))


def names() -> dict[str, list[str]]:
    """Return the names of all bundled cases and plans by kind."""
    from gearplay.model.bundled import bundled

    return {kind: bundled(*place) for kind, place in PLACES.items()}


def _kinds_of(name: str, kind: str | None, known: dict[str, list[str]]) -> tuple[str, list[str]]:
    """Return the kind of a bundled name, and other kinds of the same name.

    Raises `InputError` where there is none.
    """
    from gearplay.vocabulary.suggestions import did_you_mean

    if kind is not None and kind not in PLACES:
        rule = "must be case, sweep, calibration or dataset"
        raise InputError.of("--kind", kind, rule, did_you_mean(kind, PLACES))
    found = [each for each in ([kind] if kind else PLACES) if name in known[each]]
    if not found:
        everything = sorted({each for of in ([kind] if kind else PLACES) for each in known[of]})
        raise InputError.of(
            "name", name, "must be a bundled case or plan", did_you_mean(name, everything, "Bundled")
        )
    return found[0], found[1:]


def _records(kind: str, text: str) -> dict[str, bytes]:
    """Return the files of a calibration plan's records, by path relative to the plan."""
    if kind != "calibration":
        return {}
    from importlib.resources import files

    from gearplay.model.toml_files import parse_toml

    conditions = parse_toml(text, "plan")["conditions"]
    folders = {PurePosixPath(c["record"]).parent for c in conditions if "record" in c}
    source = files(PLACES[kind][0]) / PLACES[kind][1]
    found = {
        f"{folder}/{entry.name}": entry for folder in folders for entry in (source / str(folder)).iterdir()
    }
    return {place: found[place].read_bytes() for place in sorted(found)}


def _listed(known: dict[str, list[str]]) -> str:
    from gearplay.model.bundled import bundled_text
    from gearplay.model.toml_files import parse_toml

    wide = 2 + max(len(name) for of in known.values() for name in of)
    lines = []
    for kind, of in known.items():
        lines.append(f"{kind}s" + (", for gearplay calibrate" if kind == "calibration" else ""))
        for name in of:
            title = parse_toml(bundled_text(*PLACES[kind], name), name).get("title", "")
            lines.append(f"  {name:<{wide}}{title}")
    return "\n".join([*lines, "Copy one to change it: gearplay copy han2021"])
