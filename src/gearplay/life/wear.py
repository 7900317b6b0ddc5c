"""`wear`: Archard's law over the life of a mechanism, quasi-static between simulated blocks."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.life.bushes import ANGLES, DIRECTIONS, SURFACES, bush_rates, clearance_of_wear, wearing_bushes
from gearplay.life.flanks import (
    HEIGHTS,
    SIDES,
    Flanks,
    added_backlash,
    deflections,
    flank_rates,
    starting_depths,
    thickest_wear,
    wearing_flanks,
    worn_volume,
)
from gearplay.life.result import COLUMNS, COORDINATES, Wear, worn
from gearplay.parts.mesh.train import geometry
from gearplay.parts.sleeve.schema import MOST_CLEARANCE
from gearplay.results.provenance import provenance
from gearplay.results.simulate import case_of, simulate
from gearplay.vocabulary.errors import NO_VALUE, InputError, SimulationError

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.model.reading import Source
    from gearplay.results.result import Result
    from gearplay.vocabulary.progress import Progress

BLOCKS = 10
SIGNALS = ["theta", "omega"]


def wear(
    case: Source,
    *,
    turns: float,
    blocks: int = BLOCKS,
    rotor: str | None = None,
    progress: Progress | None = None,
) -> Wear:
    """Wear flanks and plain bearings of a case over its life.

    Archard's law with the coefficients of ``wear`` in the case's meshes and sleeves. Each block starts with a simulation of the
    case as it is then, whose mean loads act for its share of the turns: on a flank the depth k w |v1 - v2| / v each time that
    it meets another, w the line load at that place (Flodin and Andersson 1997); on a journal k F / L a turn, on the arc of the
    bush 2 pi k F / (arc L). Then worn profiles and clearances are written into the case.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; meshes that wear have ``wear`` and the contact that it needs.
    turns
        Life, in turns of the reference rotor.
    blocks
        Number of simulated blocks.
    rotor
        The reference rotor; the first with a drive if not given.
    progress
        Called with what is running, blocks done, and of how many.

    Returns
    -------
    Wear
        ``.ds`` with depths, volumes, line loads, backlash and clearance over life; ``.worn_case``; ``.plot()``.

    Raises
    ------
    InputError
        For a case without ``wear``, or whose flanks it cannot be computed for; for a life that wears off half of a tooth.
    SimulationError
        Where a simulated block does not reach its end.

    Examples
    --------
    >>> import gearplay as gp
    >>> bush = {"coefficient": "1e-16 m^2/N", "length": "10 mm"}
    >>> case = gp.replace("han2021", {"sleeves.ring.wear": bush, "run.duration": 1.6, "run.transient": 0.0})
    >>> worn = gp.wear(case, turns=1e6, blocks=1)
    >>> worn.ds["radial_clearance"].values[:, 0].round(6)[0].item()
    0.0001

    """
    first = case_of(case)
    reference = reference_rotor(first, rotor)
    flanks, bushes = wearing_flanks(first), wearing_bushes(first)
    if not flanks and not bushes:
        raise InputError.of(
            "wear", NO_VALUE, "is required in a mesh or a sleeve", "Give its coefficient there"
        )
    step = turns / blocks
    depths = [starting_depths(first, flanks)]
    worn_off = [{name: {each: np.zeros(DIRECTIONS) for each in SURFACES} for name in bushes}]
    loads: list[dict[tuple[int, str], Any]] = []
    deepest = bent = 0.0
    now = worn(first, depths[0], worn_off[0]) if flanks else first
    for block in range(blocks):
        result = _simulated(now, flanks, bushes, _part_of(progress, block, blocks))
        speed = _speed(result, reference)
        rates, load = flank_rates(result, flanks)
        loads.append(load)
        time = step * 2.0 * math.pi / speed
        if rates:
            deepest = max(deepest, time * max(float(np.max(rate)) for rate in rates.values()))
            bent = max(bent, *deflections(now, load).values())
        depths.append({key: depths[-1][key] + time * rates[key] for key in flanks})
        found = {name: bush_rates(result, name) for name in bushes}
        before = worn_off[-1]
        worn_off.append(
            {
                name: {each: before[name][each] + time * found[name][each] for each in SURFACES}
                for name in bushes
            }
        )
        _check_left(first, flanks, depths[-1], worn_off[-1], turns, step * (block + 1))
        now = worn(first, depths[-1], worn_off[-1])
    about = provenance(first, rotor=reference, blocks=blocks, deepest_step=deepest, deflection=bent)
    tables = [_flank_tables(first, flanks, depths, loads), _bush_tables(first, worn_off)]
    variables = {name: values for table, _ in tables for name, values in table.items()}
    coordinates = {"turns": step * np.arange(blocks + 1)}
    coordinates |= {name: values for _, table in tables for name, values in table.items()}
    return Wear(_dataset(variables, coordinates, about))


def _check_left(
    case: Case,
    flanks: Flanks,
    depth: dict[tuple[str, str], Any],
    bushes: dict[str, Any],
    turns: float,
    by: float,
) -> None:
    """Refuse a life that wears off half of a tooth, or a clearance beyond the bound of its field."""
    rule = ""
    for key, contacts in flanks.items():
        worst, most = float(np.max(depth[key])), thickest_wear(case, contacts)
        if worst > most:
            rule = f"must wear off at most {1e3 * most:.3g} mm of a flank: {' '.join(key)} lacks {1e3 * worst:.3g} mm"
    for name, depths in bushes.items():
        clearance = case.sleeves[name].radial_clearance + clearance_of_wear(depths)
        if clearance > MOST_CLEARANCE:
            rule = (
                f"must leave a radial clearance of at most {1e3 * MOST_CLEARANCE:g} mm: "
                f"that of {name} is {1e3 * clearance:.3g} mm"
            )
    if rule:
        cure = "Give fewer turns, or a smaller wear coefficient"
        raise InputError.of("turns", turns, f"{rule} at {by:g} turns", cure)


def _flank_tables(
    case: Case,
    flanks: Flanks,
    depths: list[dict[tuple[str, str], Any]],
    loads: list[dict[tuple[int, str], Any]],
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return variables and coordinates of worn flanks by name, none where no flank wears."""
    if not flanks:
        return {}, {}
    meshes = sorted({contact.mesh for contacts in flanks.values() for contact in contacts})
    labels = [case.meshes[j].label for j in meshes]
    variables = {
        "depth": [list(each.values()) for each in depths],
        "worn_volume": [[worn_volume(case, flanks[key], each[key]) for key in flanks] for each in depths],
        "line_load": [[load[j, side] for j in meshes for side in SIDES] for load in loads],
        "backlash": [
            [geometry.working_backlash(case, j) + added_backlash(case, j, each, flanks) for j in meshes] for each in depths
        ],
    }  # fmt: skip
    sides = [f"{label}:{side}" for label in labels for side in SIDES]
    flank_names = [" ".join(key) for key in flanks]
    return variables, {"height": HEIGHTS, "flank": flank_names, "mesh": labels, "side": sides}


def _bush_tables(
    case: Case, worn_off: list[dict[str, dict[str, Any]]]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return variables and coordinates of worn plain bearings by name, none where none wears."""
    bushes = list(worn_off[0])
    if not bushes:
        return {}, {}
    variables: dict[str, Any] = {
        f"{surface}_depth": [[each[name][surface] for name in bushes] for each in worn_off] for surface in SURFACES
    }  # fmt: skip
    variables["radial_clearance"] = [
        [case.sleeves[name].radial_clearance + clearance_of_wear(each[name]) for name in bushes]
        for each in worn_off
    ]
    return variables, {"direction": ANGLES, "sleeve": bushes}


def _dataset(variables: dict[str, Any], coordinates: dict[str, Any], about: dict[str, Any]) -> Any:
    import xarray as xr

    def of(column: Any, values: Any) -> tuple[Any, Any, dict[str, str]]:
        attributes = {"units": column.unit} if column.unit else {}
        array = np.array(values, dtype=None if column.unit else object)
        return column.dims, array, attributes | {"long_name": column.words}

    return xr.Dataset(
        {name: of(COLUMNS[name], values) for name, values in variables.items()},
        coords={name: of(COORDINATES[name], values) for name, values in coordinates.items()},
        attrs=about,
    )


def reference_rotor(case: Case, rotor: str | None) -> str:
    """Return the rotor whose turns are counted: the given one, or the first with a drive."""
    if rotor is not None:
        if rotor not in case.rotors:
            rule = "must be a rotor of the case"
            raise InputError.of("rotor", rotor, rule, f"Rotors: {', '.join(list(case.rotors)[:24])}")
        return rotor
    return next(
        (name for name, each in case.rotors.items() if each.drive is not None), next(iter(case.rotors))
    )


def _simulated(case: Case, flanks: Any, bushes: list[str], progress: Progress | None) -> Result:
    signals = [*SIGNALS, *(["pair_force", "pair_place"] if flanks else [])]
    signals += [f"{name}.sleeve_force_{axis}" for name in bushes for axis in "xy"]
    result = simulate(case, signals=signals, progress=progress)
    if not result.success:
        raise SimulationError(f"{case.title or 'case'}: {result.message}")
    return result


def _part_of(
    progress: Progress | None, block: int, blocks: int
) -> Callable[[str, float, float], None] | None:
    if progress is None:
        return None
    return lambda _, done, total: progress("wear", block + done / total, float(blocks))


def _speed(result: Result, rotor: str) -> float:
    """Return the mean speed of a rotor in a block [rad/s], either way; `InputError` where it stands."""
    members = range(len(result.runs))
    speed = float(np.mean([np.mean(np.abs(result.signal("omega", rotor, member))) for member in members]))
    if speed < 1e-6:
        raise InputError.of("rotor", rotor, "must turn, since its turns are counted", "Name another rotor")
    return speed
