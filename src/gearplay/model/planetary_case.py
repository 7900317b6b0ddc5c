"""`planetary`: a case of one planetary set."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gearplay.model.case import Case
from gearplay.model.reading import load_case


def planetary(
    *,
    name: str = "stage",
    run: Mapping[str, Any] | None = None,
    case: Mapping[str, Any] | None = None,
    **fields: Any,
) -> Case:
    """Return a case of one planetary set, as the table ``[planetary.NAME]`` of a case file defines it.

    Parameters
    ----------
    name
        Of the set; its rotors are ``name.sun``, ``name.ring``, ``name.carrier``, ``name.planet1`` ...
    run
        The case's ``run``; 0.1 s if not given.
    case
        Further fields of the case: title, gravity, couplings ...
    fields
        Fields of the set, numbers in SI or text with a unit: module, pressure_angle, backlash, stiffness, sun, planets, ring,
        carrier, pin or support, pin_errors ...

    Returns
    -------
    Case
        Validated, in SI.

    Raises
    ------
    InputError
        With every fault found, a set that cannot be assembled among them.

    Examples
    --------
    >>> part = {"mass": "1 kg", "inertia": "1e-3 kg m^2"}
    >>> case = planetary(
    ...     module="4 mm",
    ...     backlash="80 um",
    ...     stiffness={"kind": "harmonic", "mean": "3e8 N/m"},
    ...     sun={"teeth": 20, "drive": {"kind": "speed", "speed": "600 rpm"}, **part},
    ...     planets={"count": 4, "teeth": 20, **part},
    ...     ring={"teeth": 60, "fixed": True, **part},
    ...     carrier=part,
    ...     pin={"radial_clearance": "10 um", "stiffness": "1e10 N/m^1.5"},
    ... )
    >>> len(case.rotors), len(case.meshes)
    (7, 8)

    """
    document = {**(case or {}), "planetary": {name: fields}, "run": dict(run or {"duration": 0.1})}
    return load_case(document)
