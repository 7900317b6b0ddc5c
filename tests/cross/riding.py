"""Rotors on carriers: a case file counts their start from the pin, the reference in fixed axes."""

from typing import Any

from cross.reference import Reference
from cross.reference_laws import turned


def carriers_of(document: dict[str, Any]) -> dict[str, str]:
    """Return the carrier of every rotor whose sleeve, bearing or support is on one."""
    found = {}
    for table in ("supports", "bearings", "sleeves"):
        for name, part in document.get(table, {}).items():
            if part.get("on") is not None:
                found[name] = part["on"]
    return found


def ridden(document: dict[str, Any]) -> dict[str, Any]:
    """Return the document as the reference takes it: starts of carried rotors in fixed axes."""
    rotors = {
        name: {**rotor, "initial": dict(rotor.get("initial", {}))}
        for name, rotor in document["rotors"].items()
    }
    carriers = carriers_of(document)
    if not carriers:
        return document
    reference = Reference(document)
    places = {rotor.name: rotor.position for rotor in reference.rotors}
    state = reference.initial_state().tolist()
    for name, carrier in carriers.items():
        start, own = rotors[name]["initial"], rotors[carrier]["initial"]
        assert carrier not in carriers, "one carrier is enough here"
        arm = [places[name][k] - places[carrier][k] for k in range(2)]
        turned_arm = turned(own.get("theta", 0.0), *arm)
        spin = reference.body(reference.index[carrier], 0.0, state).omega
        for key, more in (
            ("x", own.get("x", 0.0) + turned_arm[0] - arm[0]),
            ("y", own.get("y", 0.0) + turned_arm[1] - arm[1]),
            ("vx", own.get("vx", 0.0) - spin * turned_arm[1]),
            ("vy", own.get("vy", 0.0) + spin * turned_arm[0]),
        ):
            start[key] = start.get(key, 0.0) + more
    return {**document, "rotors": rotors}
