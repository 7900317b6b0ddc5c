"""Metadata of tables of results: names and units of signals, and the case."""

import json
from typing import Any, Final

from gearplay.model.case import Case
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.vocabulary.version import VERSION

KIND: Final = "gearplay_kind"
"""Attribute of a dataset: the kind of result that it belongs to."""


def signal_words(signal: str) -> dict[str, str]:
    """Return unit and long name of a signal of one element; in Poincaré sections rotations are relative to nominal ones.

    >>> signal_words("ring.vx")
    {'units': 'm/s', 'long_name': "velocity of the rotor's centre along x, ring"}
    """
    label, _, kind = signal.rpartition(".")
    if kind == "x" and (not label or "-" in label):  # of a mesh
        return {"units": "1", "long_name": f"displacement in half backlashes{', ' if label else ''}{label}"}
    if signal == "x'":
        return {"units": "1", "long_name": "rate of x, in half backlashes, over the natural frequency"}
    quantity = RESULT_VARIABLES[kind]
    relative = ", relative to the nominal one" if kind in ("theta", "omega") else ""
    return {"units": quantity.unit, "long_name": f"{quantity.long_name}{relative}, {label}"}


def provenance(case: Case, *, title: str | None = None, name: str = "case", **more: Any) -> dict[str, Any]:
    """Return the provenance attributes of a table: title, the case and its digest, version, and the given ones.

    ``name`` is what the case is to the table: "case", or "base_case" of a sweep.
    """
    return {
        "title": case.title if title is None else title,
        "Conventions": "CF-1.11",
        name: json.dumps(case.resolved()),
        f"{name}_sha256": case.sha256,
        "gearplay_version": VERSION,
        **({"changed": json.dumps(case.changed)} if case.changed else {}),
        **more,
    }
