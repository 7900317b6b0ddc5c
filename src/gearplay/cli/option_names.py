"""Translation of argument names in errors to options of the command line."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final

from gearplay.vocabulary.errors import GearplayError, InputError

OPTIONS: Final = {
    **{name: f"--{name}" for name in ("at", "doublings", "keep", "member", "orbits", "order", "period")},
    **{name: f"--{name}" for name in ("periods", "settle", "show", "signal", "window")},
    "change": "--set",
    "ensemble": "--members",
}
"""Options by the names of the arguments that they set."""
PHRASES: Final = {
    "or overwrite it": "or say --overwrite",
    "Write it piece by piece (zarr)": "Say --zarr, which writes it piece by piece",
    "Draw a history": "Draw a history: --kind history",
}
"""Cures in terms of Python, and of the command line."""


def with_options(error: GearplayError) -> GearplayError:
    """Return an error with the option names of the command line; the same object where nothing changes.

    >>> from gearplay.vocabulary.errors import Fault
    >>> print(with_options(InputError(Fault("at", "rim", "must be a rotor", "Choose another, or overwrite it"))))
    --at = "rim": must be a rotor. Choose another, or say --overwrite.
    """
    if isinstance(error, InputError):
        faults = [
            replace(each, path=OPTIONS.get(each.path, each.path), cure=_translated(each.cure))
            for each in error.faults
        ]
        return error if faults == error.faults else type(error)(faults)
    text = str(error)
    return error if _translated(text) == text else type(error)(_translated(text))


def _translated(text: str) -> str:
    for there, here in PHRASES.items():
        text = text.replace(there, here)
    return re.sub(r"See help\(gearplay\.(\w+)\)", r"See gearplay \1 --help", text)
