"""Cases as the page takes them over: fields in SI, controls, names, suggestions."""

from functools import cache
from typing import Any

from gearplay.model.bundled import bundled_text
from gearplay.model.case import Case
from gearplay.model.initial import usual_member
from gearplay.model.pack import pack
from gearplay.model.reading import load_case
from gearplay.web.controls import controls
from gearplay.web.lost_motion import suggested
from gearplay.web.maps import measures

PAGE_RUN = {"duration": 0.5, "sampling": 2e4}
LONGEST_TRANSIENT = 1.0  # s


@cache
def bundled_description(name: str) -> dict[str, Any]:
    """Return the description of a bundled case."""
    return description(load_case(name), source=bundled_text("gearplay.model", "cases", name))


def description(case: Case, *, source: str | None = None) -> dict[str, Any]:
    """Return a case with its controls; one from a file, ``source``, is shortened to the limits of a page.

    >>> from gearplay.model.reading import load_case
    >>> description(load_case("han2021"))["rotors"]
    ['pinion', 'ring']
    """
    if source is not None:
        document = case.resolved()
        transient = min(case.run.transient, LONGEST_TRANSIENT)
        drawn = {"start": "drawn"} if usual_member(case) else {}
        document["run"] |= PAGE_RUN | {"transient": transient, "ensemble": 1} | drawn
        case = load_case(document)
    return {
        "case": case.resolved(),
        "controls": controls(case),
        "measures": measures(case),
        "rotors": list(case.rotors),
        "displacements": list(pack(case).half_backlashes),
        "lost_motion": suggested(case),
        "title": case.title,
        "source": source,
    }
