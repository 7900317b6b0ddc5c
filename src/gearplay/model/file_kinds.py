"""Kinds of TOML files, by their tables: a file of another kind is refused in one sentence, not field by field."""

from collections.abc import Mapping
from typing import Any, Final

from gearplay.model.torsional_pair import FIELD
from gearplay.vocabulary.errors import NO_VALUE, InputError

MARKS: Final[Mapping[str, tuple[frozenset[str], str]]] = {
    "plan of a data set": (frozenset({"classes"}), "Run it with gearplay dataset"),
    "calibration plan": (frozenset({"targets", "conditions", "sensor"}), "Run it with gearplay calibrate"),
    "sweep plan": (frozenset({"reduce", "axes", "design"}), "Run it with gearplay sweep"),
    "rig": (frozenset({"accelerometers", "collector"}), "Name it as the rig of a measurement"),
    "case": (frozenset({"rotors", "planetary", FIELD}), "Name it in a {wanted}: case = FILE"),
}
"""Tables that only files of a kind have, the most particular kind first, and what to do with such a file."""


def check_kind(document: Mapping[str, Any], wanted: str, field: str, value: object = NO_VALUE) -> None:
    """Raise `InputError` for the raw table of a file that is of another kind in ``MARKS`` than the one wanted.

    A table with a mark of the wanted kind passes, and one without any mark. The error names ``field`` and ``value``.

    >>> check_kind({"rotors": {}, "run": {}}, "case", "case")
    >>> check_kind({"rotors": {}, "run": {}}, "rig", "rig")
    Traceback (most recent call last):
    gearplay.vocabulary.errors.InputError: rig: must be a rig, but this is a case. Choose another file.
    """
    if not isinstance(document, Mapping) or document.keys() & MARKS[wanted][0]:
        return
    for kind, (marks, cure) in MARKS.items():
        if not document.keys() & marks:
            continue
        if kind == "case":
            cure = "Choose another file" if wanted == "rig" else cure.format(wanted=wanted)
        elif wanted == "case":
            cure = f"{cure}, or name its case" if "case" in document else cure
        raise InputError.of(field, value, f"must be a {wanted}, but this is a {kind}", cure)
