"""The study's report as PDF, by typst from the same numbers and figures."""

import json
import tempfile
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from gearplay.files.json_text import finite
from gearplay.vocabulary.optional import load_optional


def check_typst() -> None:
    """Raise `InputError` where the typesetter is not installed."""
    load_optional("typst", "pdf")


def report_pdf(summary: Mapping[str, Any], figures: Mapping[str, bytes]) -> bytes:
    """Return the report as PDF; ``summary`` is the study's document, ``figures`` its PNGs by name.

    Raises `InputError` where typst is not installed.
    """
    check_typst()
    import typst

    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        source = files("gearplay.published").joinpath("report.typ").read_text(encoding="utf-8")
        (place / "report.typ").write_text(source, encoding="utf-8")
        document = finite({**summary, "spectra": [n for n in figures if n.startswith("spectrum-")]})
        (place / "study.json").write_text(json.dumps(document), encoding="utf-8")
        for name, png in figures.items():
            (place / f"{name}.png").write_bytes(png)
        made: bytes = typst.compile(str(place / "report.typ"), root=str(place))
        return made
