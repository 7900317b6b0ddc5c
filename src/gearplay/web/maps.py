"""Maps of a measure over two fields: available measures, their reductions in a sweep, and the uncertainty of each cell."""

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.parts.mesh.train.geometry import rotor_of
from gearplay.parts.protocol import without_slots
from gearplay.results.spectra import student_widening
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.progress import Tick
from gearplay.vocabulary.quantities import CONTACT_STATISTICS
from gearplay.web.frames import pack_frame
from gearplay.web.jobs import Job, averaged_case, axis_of, failures_of, heading, limited_case, whole

Floats = NDArray[np.float64]
MOST_CELLS = 2500
FEW = 30
"""Impacts of all members of a cell below which its value is unreliable, unless a contact is closed most of the time."""

MOSTLY = 0.5
SQUARES = ("rms", "line", "rms_impact_speed")
LARGEST = ("peak", "peak_force")
KEPT = "value"
OF_ROTOR = {"rms": "rms acceleration", "peak": "largest acceleration", "line": "acceleration, line at f_m"}
OF_CONTACT = {
    name: CONTACT_STATISTICS[name].long_name
    for name in ("share_of_time", "impacts_per_second", "rms_impact_speed", "peak_force")
}


def make_map(job: Job, report: Tick, stop: threading.Event) -> bytes:
    """Run a small map over two fields; return a measure at each of its points, its spread, and where it is unreliable."""
    from gearplay.sweeps.sweep import sweep

    case, members = averaged_case(job)
    columns, rows = (whole(job, name, 2, 60) for name in ("columns", "rows"))
    if columns * rows > MOST_CELLS:
        raise InputError.of("columns x rows", columns * rows, f"must be at most {MOST_CELLS}", "Lower one")
    first, second = axis_of(job, "first"), axis_of(job, "second")
    if first[0] == second[0]:
        raise InputError.of("second.path", second[0], "must be another field than first", "Choose another")
    measure, of = str(job.get("measure", "")), str(job.get("of", ""))
    across, up = np.linspace(*first[1:], columns), np.linspace(*second[1:], rows)
    contacts = contacts_of(case, of)
    found = sweep(
        case,
        {second[0]: up.tolist(), first[0]: across.tolist()},
        reduce=[reduction_of(case, measure, of), *_counted(contacts)],
        ensemble=members,
        threads=1,
        progress=lambda _, done, total: report(done, total),
        stop=stop,
    )
    table = found.ds
    kept = table[KEPT if KEPT in table else f"{KEPT}_amplitude"]
    ways = {name: _by_member(table[name].values, members) for name in table.data_vars if name != "reason"}
    values, spread = pooled(_by_member(kept.values, members), measure)
    count = [ways[f"impacts_{k}"] for k in range(len(contacts))]
    closed = [ways[f"closed_{k}"] for k in range(len(contacts))]
    seconds = case.run.duration
    impacts = seconds * np.sum(count, axis=(0, -1)) if count else np.zeros(values.shape)
    share = np.max(np.mean(closed, axis=-1), axis=0) if closed else np.ones(values.shape)
    reasons = _by_member(table["reason"].values, members)
    return pack_frame(
        {
            **heading("map", job, limited_case(job)),
            "measure": words_of(measure, of),
            "unit": kept.attrs["units"],
            "paths": [first[0], second[0]],
            "units": [table[kept.dims[at]].attrs["units"] for at in (1, 0)],
            "x": across,
            "y": up,
            "values": values,
            "spread": spread,
            "impacts": impacts,
            "doubtful": doubtful(values, spread, impacts, share),
            "members": members,
            "duration": seconds,
            "transient": case.run.transient,
            "few": FEW,
            "failures": failures_of(_first_reasons(reasons)),
            **found.account.as_document(),
        }
    )


def measures(case: Case) -> list[dict[str, str]]:
    """Return the measures available for a map of a case: name, label, and rotor or contact.

    >>> from gearplay.model.reading import load_case
    >>> found = measures(load_case("han2021"))
    >>> found[3]["measure"], found[3]["of"], len(found), found[-1]["words"], found[-1]["of"]
    ('rms', 'ring', 18, 'largest force', 'pinion-ring:back')
    """
    rotors = {name: words for name, words in OF_ROTOR.items() if name != "line" or case.meshes}
    of = [(rotors, rotor) for rotor in case.rotors]
    of += [(OF_CONTACT, contact) for contact in without_slots(pack(case).contact_labels)]
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
        raise InputError.of("measure", f"{measure} of {of}", rule, f"Choose from: {names}")
    if measure in OF_CONTACT:
        return {"kind": "contact", "name": KEPT, "contact": of, "statistic": measure}
    if measure == "line":
        return {"kind": "line", "name": KEPT, "signal": "ax", "at": of, "order": 1}
    return {"kind": "statistic", "name": KEPT, "signal": "ax", "at": of, "statistic": measure}


def words_of(measure: str, of: str) -> str:
    """Return the label of a measure."""
    return f"{(OF_ROTOR | OF_CONTACT)[measure]} of {of}"


def contacts_of(case: Case, of: str) -> list[str]:
    """Return the contacts that move a rotor, or the contact itself.

    >>> from gearplay.model.reading import load_case
    >>> contacts_of(load_case("han2021"), "ring"), contacts_of(load_case("han2021"), "pinion-ring:back")
    (['ring', 'pinion-ring:drive', 'pinion-ring:back'], ['pinion-ring:back'])
    """
    labels = without_slots(pack(case).contact_labels)
    if of not in case.rotors:
        return [of]
    touched = {of} | {
        mesh.label for mesh in case.meshes if of in (rotor_of(case, mesh.driver), rotor_of(case, mesh.driven))
    }
    return [label for label in labels if label.split(":")[0] in touched]


def _counted(contacts: list[str]) -> list[dict[str, Any]]:
    """Return the reductions that count the impacts of contacts and keep for how long they were closed."""
    kept = {"impacts": "impacts_per_second", "closed": "share_of_time"}
    return [
        {"kind": "contact", "name": f"{name}_{k}", "contact": contact, "statistic": statistic}
        for k, contact in enumerate(contacts)
        for name, statistic in kept.items()
    ]


def _by_member(values: Any, members: int) -> Any:
    """Return a table with the member axis last, added where missing."""
    return values if members > 1 else values[..., None]


def _first_reasons(reasons: Any) -> Any:
    """Return the first reason of each cell's members, "" where none failed."""
    texts = reasons.astype(str)
    flat = [next(filter(None, row), "") for row in texts.reshape(-1, texts.shape[-1])]
    return np.array(flat, dtype=object).reshape(texts.shape[:-1])


def pooled(values: Floats, measure: str) -> tuple[Floats, Floats]:
    """Return a measure of all members, shape [row, column], and half its 95 % interval by Student's t; NaN for one member.

    Root mean squares are pooled as such, of largest values the largest is taken, of the others the mean. The interval of a root
    mean square is that of the mean square, which its largest member decides.

    >>> [each.round(3).tolist() for each in pooled(np.array([[[3.0, 4.0, 5.0]]]), "rms")]
    [[[4.082]], [[2.44]]]
    """
    if measure in SQUARES:
        whole_value = np.sqrt(np.mean(values**2, axis=-1))
    else:
        whole_value = (np.max if measure in LARGEST else np.mean)(values, axis=-1)
    count = values.shape[-1]
    if count < 2:
        return whole_value, np.full(whole_value.shape, np.nan)
    widening = student_widening(count)
    if measure in SQUARES:
        error = np.std(values**2, axis=-1, ddof=1) / (2.0 * np.maximum(whole_value, 1e-300))
    else:
        error = np.std(values, axis=-1, ddof=1)
    return whole_value, widening * error


def doubtful(values: Floats, spread: Floats, impacts: Floats, share: Floats) -> Floats:
    """Return 1 where a cell is unreliable: few impacts and no contact mostly closed, or a spread of more than half its value.

    >>> share, impacts = np.array([0.0, 0.0, 0.0, 1.0]), np.array([3, 400, 400, 0])
    >>> doubtful(np.array([0.0, 1.0, 1.0, 1.0]), np.array([0.0, 0.1, 0.6, 0.0]), impacts, share).tolist()
    [1.0, 0.0, 1.0, 0.0]
    """
    few = (impacts < FEW) & (share < MOSTLY)
    return np.where(few | (spread > 0.5 * np.abs(values)), 1.0, 0.0)
