"""Meshes at temperature, and the backlash that is left.

A pair of gears meshes at abs(r_a f_a + r_b f_b) as it did at abs(r_a + r_b).
"""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final, NamedTuple

from gearplay.parts.mesh.allowance_range import backlash_range
from gearplay.parts.mesh.runout import runout_loss
from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.mesh.train import geometry
from gearplay.schema.finding import Finding, micrometres
from gearplay.schema.units import ICE
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


ROUNDING: Final = 1e-9
"""Distance of two centres [m] that is none."""


def mesh_at_temperature(case: "Train", j: int, factors: Mapping[str, float]) -> Mesh:
    """Return mesh j with the lengths that its gears have at the expansion ``factors`` of the rotors."""
    mesh = case.meshes[j]
    a, b, r_a, r_b = geometry.signed_radii(case, j)
    f_a, f_b = (factors[geometry.rotor_of(case, name)] for name in (a, b))
    factor = (r_a * f_a + r_b * f_b) / (r_a + r_b)
    pair = geometry.pair_of(case, j)
    normal = math.cos(pair.first.base_helix) if pair.first.helix_angle else 1.0
    update: dict[str, object] = {
        "module": factor * mesh.module,
        "backlash": factor * geometry.working_backlash(case, j) * normal,
    }
    if mesh.center_distance is not None or pair.is_shifted:
        update |= {"center_distance": factor * pair.distance, "center_distance_allowance": None}
    return mesh.model_copy(update=update)


def thermal_texts(case: "Train", hot: "Train") -> dict[str, str]:
    """Return texts on centre distance and backlash at temperature, by the path of the first of equal meshes."""
    texts: dict[str, list[int]] = {}
    cold_centres, hot_centres = geometry.centres(case), geometry.centres(hot)
    for j, mesh in enumerate(case.meshes):
        one, other = mesh.rotors
        cold, warm = (math.dist(at[one], at[other]) for at in (cold_centres, hot_centres))
        play, left = (geometry.installed_backlash(each, j) for each in (case, hot))
        gears = geometry.working_distance(hot, j) - geometry.working_distance(case, j)
        beyond = warm - cold - gears
        pair = geometry.pair_of(case, j)
        first = pair.second.sign * 2.0 * math.sin(pair.working_angle)
        text = (
            f"at temperature the centre distance is {1e3 * warm:.6g} mm, {micrometres(warm - cold)}, which is "
            f"{micrometres(beyond)} beyond its gears; the backlash along the line of action is {1e6 * left:.1f} um, "
            f"{micrometres(left - play)} (2 sin alpha x centre distance: {micrometres(first * beyond)})"
        )
        texts.setdefault(text, []).append(j)
    return {f"meshes.{alike[0]}": _labels(case, alike) + text for text, alike in texts.items()}


class Left(NamedTuple):
    """Normal backlash [m] of mesh j that is left at a temperature [K].

    In the middle, the least by allowances and runouts, and that less the clearances.
    """

    temperature: float
    j: int
    middle: float
    lowest: float
    closed: float


def _left(case: "Train", temperature: float, j: int, hot: "Train") -> Left:
    normal = math.cos(geometry.pair_of(case, j).first.base_helix)
    limits = backlash_range(case, j)
    left = geometry.installed_backlash(hot, j) * normal
    lowest = left
    if limits is not None:
        lowest -= geometry.installed_backlash(case, j) * normal - limits[0]
    lowest -= runout_loss(hot, j) * normal
    closed = lowest - left * geometry.jam_ratio(hot, j) if left > 0.0 else left
    return Left(temperature, j, left, lowest, closed)


def temperature_findings(case: "Train") -> Iterator[Finding]:
    """Yield the remaining backlash at both ends of ``environment.temperature_range``, a warning if there is none, and a verdict.

    Equal meshes are one finding. The verdict on jamming, the last, also covers the temperature of the case. An end at which
    a journal or a rolling bearing is jammed is a warning of its own, and is left out of the others.

    Raises `InputError` where an expansion is needed that is not given.
    """
    environment = case.environment
    if environment is None or not case.meshes:
        return
    if environment.temperature_range is None and case.operating is case:  # nothing changes
        return
    temperatures = dict.fromkeys([*(environment.temperature_range or ()), environment.temperature])
    hot = {}
    for each in temperatures:
        try:
            hot[each] = case.at_temperature(each)
        except InputError as error:
            if any(fault.value == NO_VALUE for fault in error.faults):
                raise
            yield from (_seized(fault, each) for fault in error.faults)
    found = [[_left(case, each, j, hot[each]) for each in hot] for j in range(len(case.meshes))]
    if environment.temperature_range is not None:
        ends = len(hot.keys() & set(environment.temperature_range))
        yield from _of_meshes(case, [each[:ends] for each in found] if ends else [])
    yield _verdict(case, [each for at in found for each in at])


def _takers(case: "Train", j: int) -> str:
    """Return what takes backlash of a mesh beside the temperature as text; empty for nothing."""
    allowed = ["allowances"] if backlash_range(case, j) is not None else []
    return " and ".join(allowed + (["runouts"] if runout_loss(case, j) != 0.0 else []))


def _seized(fault: Fault, temperature: float) -> Finding:
    rule = fault.rule.replace(" at temperature", "")
    return Finding("warning", fault.path, f"at {_degrees(temperature)} it {rule}. {fault.cure}.")


def _of_meshes(case: "Train", found: list[list[Left]]) -> Iterator[Finding]:
    """Yield the backlash of every mesh at both ends of a range."""
    texts: dict[tuple[bool, str, str], list[int]] = {}
    for j, ends in enumerate(found):
        middle = geometry.installed_normal_backlash(case, j)
        by = _takers(case, j)
        words = [
            f"{1e6 * end.middle:.4g} um at {_degrees(end.temperature)}"
            + (f", {1e6 * end.lowest:.4g} um by its {by}" if by else "")
            for end in ends
        ]
        jams = any(not end.lowest >= 0.0 for end in ends)
        texts.setdefault((jams, f"{1e6 * middle:.4g} um of normal backlash", " and ".join(words)), []).append(
            j
        )
    for (jams, whole, left), alike in texts.items():
        names = ", ".join(case.meshes[j].label for j in alike)
        yield Finding(
            "warning" if jams else "note",
            f"meshes.{alike[0]}.backlash",
            f"of {whole} of {names} are left {left}"
            f"{': it jams there. Raise the backlash, or take materials that expand alike' if jams else ''}.",
        )


def _verdict(case: "Train", found: list[Left]) -> Finding:
    """Return whether teeth jam at any temperature, and the least backlash with its place."""
    jams = [each for each in found if not each.lowest >= 0.0]
    least = min(jams or found, key=lambda each: -math.inf if math.isnan(each.lowest) else each.lowest)
    closest = min(found, key=lambda each: each.closed)
    alike = [
        each.j
        for each in found
        if each.temperature == least.temperature and math.isclose(each.lowest, least.lowest, rel_tol=1e-6)
    ]
    where = f"{_labels(case, alike or [least.j])[:-2] or case.meshes[least.j].label} at {_degrees(least.temperature)}"
    span = sorted({each.temperature for each in found})
    over = " to ".join(dict.fromkeys((_degrees(span[0]), _degrees(span[-1]))))
    at = f"over {over}" if len(span) > 1 else f"at {over}"
    amount = "the flanks cannot mesh" if math.isnan(least.lowest) else f"{1e6 * least.lowest + 0.0:.4g} um"
    takers = _takers(case, least.j)
    by = f", by its {takers}" if takers else ""
    hit = " and ".join(dict.fromkeys(_degrees(each.temperature) for each in jams))
    text = f"{f'jams at {hit}' if jams else f'does not jam {at}'}: the least normal backlash is {amount}, of {where}{by}."
    if not jams and closest.closed < 0.0:
        label, degrees = case.meshes[closest.j].label, _degrees(closest.temperature)
        text += f" Within the clearances of its bearings {label} can jam at {degrees}."
    return Finding("note", "environment", text + _without_housing(case))


def _without_housing(case: "Train") -> str:
    """Return a sentence on meshes whose centre distance does not follow the housing; empty if all do."""
    if case.environment.housing is None:
        return ""
    centres = geometry.centres(case)

    def seat(name: str) -> tuple[float, float]:
        carrier = geometry.carrier_of(case, name)
        return centres[name] if carrier is None else seat(carrier)

    meshes = [j for j, mesh in enumerate(case.meshes) if math.dist(*map(seat, mesh.rotors)) < ROUNDING]
    if not meshes:
        return ""
    sets = [
        name for name in case.planetary if any(case.meshes[j].label.startswith(f"{name}.") for j in meshes)
    ]
    names = ", ".join(sets) or ", ".join(case.meshes[j].label for j in meshes)
    return (
        f" The housing has no effect on the backlash of {names}, whose gears are on one axis with their carrier: "
        "the materials of carrier and gears decide."
    )


def _labels(case: "Train", meshes: list[int]) -> str:
    """Return the names of meshes before a text; empty where the case has one mesh."""
    return "" if len(case.meshes) == 1 else ", ".join(case.meshes[j].label for j in meshes) + ": "


def _degrees(temperature: float) -> str:
    return f"{round(temperature - ICE, 6) + 0.0:.6g} degC"
