"""Measures that a map can show, and their reductions in a sweep."""

from typing import Any

from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.quantities import CONTACT_STATISTICS

KEPT = "value"
OF_ROTOR = {"rms": "rms acceleration", "peak": "largest acceleration", "line": "acceleration, line at f_m"}
OF_CONTACT = {
    name: CONTACT_STATISTICS[name].long_name
    for name in ("share_of_time", "impacts_per_second", "rms_impact_speed", "peak_force")
}


def measures(case: Case) -> list[dict[str, str]]:
    """Return the measures available for a map of a case: name, label, and rotor or contact.

    >>> from gearplay.model.reading import load_case
    >>> found = measures(load_case("han2021"))
    >>> found[3]["measure"], found[3]["of"], len(found), found[-1]["words"], found[-1]["of"]
    ('rms', 'ring', 18, 'largest normal force', 'pinion-ring:back')
    """
    rotors = {name: words for name, words in OF_ROTOR.items() if name != "line" or case.meshes}
    of = [(rotors, rotor) for rotor in case.rotors]
    of += [(OF_CONTACT, contact) for contact in pack(case).contact_labels]
    return [
        {"measure": name, "words": words, "of": element}
        for known, element in of
        for name, words in known.items()
    ]


def reduction_of(case: Case, measure: str, of: str) -> dict[str, Any]:
    """Return the reduction of a sweep that keeps a measure of a rotor or contact.

    Raises `InputError` for a measure that the case does not have.
    """
    if not any(each["measure"] == measure and each["of"] == of for each in measures(case)):
        names = ", ".join((*OF_ROTOR, *OF_CONTACT))
        rule = "must be a measure of a rotor or contact of the case"
        raise InputError(Fault("measure", f"{measure} of {of}", rule, f"Choose from: {names}"))
    if measure in OF_CONTACT:
        return {"kind": "contact", "name": KEPT, "contact": of, "statistic": measure}
    if measure == "line":
        return {"kind": "line", "name": KEPT, "signal": "ax", "at": of, "order": 1}
    return {"kind": "statistic", "name": KEPT, "signal": "ax", "at": of, "statistic": measure}


def words_of(measure: str, of: str) -> str:
    """Return the label of a measure."""
    return f"{(OF_ROTOR | OF_CONTACT)[measure]} of {of}"
