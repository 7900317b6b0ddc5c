"""What every table of results says about itself: words and units of its signals, and the case behind it."""

import json
from typing import Any

from gearplay.model.case import Case
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.vocabulary.version import VERSION


def signal_words(signal: str) -> dict[str, str]:
    """Return unit and long name of a signal of one element; rotations in sections count from the nominal ones.

    >>> signal_words("ring.vx")
    {'units': 'm/s', 'long_name': "velocity of the rotor's centre along x, ring"}
    """
    label, _, kind = signal.rpartition(".")
    quantity = RESULT_VARIABLES[kind]
    beside = ", less the nominal one" if kind in ("theta", "omega") else ""
    return {"units": quantity.unit, "long_name": f"{quantity.long_name}{beside}, {label}"}


def provenance(case: Case, **more: Any) -> dict[str, Any]:
    """Return the attributes of a table: title, case and its digest, what more is given, version."""
    return {
        "title": case.title,
        "case": json.dumps(case.resolved()),
        "case_sha256": case.sha256,
        **more,
        "gearplay_version": VERSION,
    }
