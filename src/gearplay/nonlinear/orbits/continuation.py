"""Periodic orbits of a case and their branches over one of its fields."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model.case import Case
from gearplay.model.families import Family, Varied, along
from gearplay.model.pack import pack
from gearplay.model.plan_values import number_in_si, value_at
from gearplay.model.reading import Source
from gearplay.nonlinear.orbits.autonomous import AutonomousMap
from gearplay.nonlinear.orbits.branch_tree import branch_tree, settled_orbits
from gearplay.nonlinear.orbits.branches import Settings, follow_branch
from gearplay.nonlinear.orbits.period_map import StrobeMap, sharp
from gearplay.nonlinear.orbits.results import Branches, OneBranch, PeriodicOrbit
from gearplay.nonlinear.orbits.sampled import SampledMap, sample_time, sampled_orbit
from gearplay.nonlinear.orbits.shooting import find_orbit
from gearplay.parts.mesh.train import rolling
from gearplay.results.simulate import case_of
from gearplay.solver.deadline import limited
from gearplay.solver.integration import refuse_fixed_steps
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.progress import Progress, ticking

if TYPE_CHECKING:
    from gearplay.linear.response import FrequencyResponse


def periodic_orbit(
    case: Source,
    *,
    order: int = 1,
    settle: int = 200,
    autonomous: bool = False,
    section: str | None = None,
) -> PeriodicOrbit:
    """Return the periodic orbit of an order near the settled motion of a case.

    With ``autonomous`` it is a limit cycle of a case that nothing excites, as a loop that hunts in its play: its period is an
    unknown too. Of a sampled control it is a whole number of samples, the order, where the motion is locked to them; it need not
    be, and then there is no such orbit.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; computed at its tolerance, at 1e-9 if that is looser.
    order
        Common periods after which the orbit repeats, 1 to 1000.
    settle
        Common periods before the search begins; of a limit cycle returns to the section, of a sampled control to its contact.
    autonomous
        Whether nothing excites the case, and the period is sought too.
    section
        Contact change that a limit cycle is cut at, ``CONTACT:opens`` or ``CONTACT:closes``; the first that opens if not given.

    Returns
    -------
    PeriodicOrbit
        States at the section, shape [order, state], SI: free positions and rotations, their velocities, stored impact speeds;
        Floquet multipliers, the largest first.

    Raises
    ------
    InputError
        For a case without a period.
    SimulationError
        Where no orbit is near.

    Examples
    --------
    >>> import gearplay as gp
    >>> pair = gp.torsional_pair(0.7, force=0.05)
    >>> gp.periodic_orbit(pair, settle=300).stable
    True

    """
    base = sharp(case_of(case))
    refuse_fixed_steps(base)
    _check_limit_cycle(autonomous, section, order)
    family = _map_of(lambda _: base, 0.0, autonomous, section)
    with limited(base.run.max_wall_time):
        if isinstance(family, SampledMap):
            found = sampled_orbit(family, 0.0, settle)
        else:
            found = find_orbit(family, family.settle(family.start(0.0), 0.0, settle), 0.0, order=order)
    return PeriodicOrbit(**vars(found), case=base)


def branch(
    case: Source | Family,
    path: str,
    low: Any,
    high: Any,
    *,
    order: int = 1,
    settle: int = 200,
    size: float | None = None,
    orbits: int = 500,
    upwards: bool = True,
    start: Any = None,
    keep_load: bool = False,
    autonomous: bool = False,
    section: str | None = None,
    progress: Progress | None = None,
) -> OneBranch:
    """Return the branch of periodic orbits over a field of a case, from an orbit near the settled motion of the case.

    The branch is followed upwards (or downwards) from the case's own value, through folds, stable and unstable, until the field
    leaves its bounds; see `branches` for both ways at once.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; or a function that returns a `Case` for a value of a parameter; computed
        at its tolerance, at 1e-9 if that is looser.
    path
        The field: ``rotors.ring.load``; of a function the name of its parameter.
    low, high
        Its bounds, in SI or with a unit; of a function plain numbers.
    order
        Common periods after which the orbits repeat, 1 to 1000.
    settle
        Common periods before the search for the first orbit.
    size
        Natural size of the field [SI]; a tenth of the range if not given.
    orbits
        Most orbits of the branch.
    upwards
        Which way to go.
    start
        Value of the field where the first orbit is sought, the case's own (of a function ``low``) if not given; or a
        `frequency_response` to the error of a mesh: the speed at which that mesh meets its largest resonance.
    keep_load
        Whether loads stay what they are at the case's own speeds, although drag follows the speed.
    autonomous, section
        Limit cycles of a case that nothing excites, as of `periodic_orbit`; of a sampled control those of one number of samples,
        as far as the motion is locked to it.
    progress
        Called with what is running, how much is done, and of how much.

    Returns
    -------
    OneBranch
        The orbits in order, the special points between them, and why the branch ends.

    Raises
    ------
    InputError
        For an unknown field or invalid bounds.
    SimulationError
        Where there is no orbit to start from.

    Examples
    --------
    >>> import gearplay as gp
    >>> pair = gp.torsional_pair(0.7, force=0.05)
    >>> found = gp.branch(pair, "meshes.0.transmission_error.0.amplitude", "2 um", "9 um", settle=300, orbits=3)
    >>> len(found.orbits), found.order
    (3, 1)

    """
    varied, settings, base = _prepared(case, path, low, high, size, orbits)
    first = settings.low if varied.is_function and start is None else _first_value(varied, base, start)
    if not settings.low <= first <= settings.high:
        within = f"must lie between low and high, {settings.low:g} and {settings.high:g}"
        if start is None:
            rule = f"{within}: the branch begins at the case's own value"
            raise InputError.of(path, first, rule, "Widen the bounds, or give a start within them")
        raise InputError.of("start", first, within, "Give another start, or widen the bounds")
    _check_limit_cycle(autonomous, section, order)
    family = _map_of(_sharp_family(varied, base, keep_load=keep_load), first, autonomous, section)
    with limited(base.run.max_wall_time):
        if isinstance(family, SampledMap):
            found = sampled_orbit(family, first, settle)
        else:
            (found,), _ = settled_orbits(family, [first], order=order, settle=settle)
        tick = ticking(progress, "orbits")
        whole = follow_branch(family, found, settings, upwards=upwards, progress=tick)
    return OneBranch((whole,), base, path, keep_load, family=family.family)


def branches(
    case: Source | Family,
    path: str,
    low: Any,
    high: Any,
    *,
    order: int = 1,
    doublings: int = 1,
    settle: int = 200,
    size: float | None = None,
    orbits: int = 500,
    progress: Progress | None = None,
) -> Branches:
    """Return all connected branches of periodic orbits over a field: both ways, and those that leave at period doublings.

    Starts are near what the case settles to at its own value of the field, if that lies within the bounds, and at these; a
    start on the branch of another is left out.

    Parameters
    ----------
    case, path, low, high, order, settle, size, progress
        As of `branch`.
    doublings
        How many times the order may double, 0 to 8.
    orbits
        Most orbits of each branch, each way.

    Returns
    -------
    Branches
        A sequence of branches; ``.table(signals)`` has signals at the sections of their orbits, ``.missed`` the starts near
        which there is no such orbit, with the reason.

    Raises
    ------
    InputError
        For an unknown field or invalid bounds.
    SimulationError
        Where there is no orbit to start from.

    Examples
    --------
    >>> import gearplay as gp
    >>> pair = gp.torsional_pair(0.7, force=0.05)
    >>> found = gp.branches(pair, "meshes.0.transmission_error.0.amplitude", "4 um", "6 um", orbits=20, doublings=0)
    >>> found[0].order, found.path
    (1, 'meshes.0.transmission_error.0.amplitude')

    """
    varied, settings, base = _prepared(case, path, low, high, size, orbits)
    now = settings.low if varied.is_function else _value_now(base, path)
    places = [now] if settings.low <= now <= settings.high else []
    places += [end for end in (settings.low, settings.high) if end != now]
    family = StrobeMap(_sharp_family(varied, base), places[0])
    with limited(base.run.max_wall_time):
        starts, missed = settled_orbits(family, places, order=order, settle=settle)
        tick = ticking(progress, "orbits")
        found, late = branch_tree(family, starts, settings, doublings=doublings, progress=tick)
    return Branches(found, base, path, missed=(*missed, *late), family=family.family)


def _map_of(family: Family, parameter: float, autonomous: bool, section: str | None) -> StrobeMap:
    """Return the period map of a family: forced, autonomous, or of a sampled control, from sample to sample."""
    if not autonomous:
        return StrobeMap(family, parameter)
    if sample_time(pack(family(parameter))) is None:
        return AutonomousMap(family, parameter, section)
    if section is not None:
        rule = "must be left out for a sampled control, whose orbits are cut at its samples"
        raise InputError.of("section", section, rule, "Remove it")
    return SampledMap(family, parameter)


def _check_limit_cycle(autonomous: bool, section: str | None, order: int) -> None:
    """Raise `InputError` for a section of a forced orbit, and an order of a limit cycle."""
    if section is not None and not autonomous:
        rule = "must be left out for a case that is excited, which is cut once per period"
        raise InputError.of("section", section, rule, "Remove it, or give autonomous = True")
    if autonomous and order != 1:
        rule = "must be 1 for a limit cycle, whose period is sought and may be any"
        raise InputError.of("order", order, rule, "Leave it out")


def check_branches(case: Source, path: str) -> None:
    """Raise `InputError` for a case whose branches cannot be followed, before long work begins."""
    base = sharp(case_of(case))
    now = _value_now(base, path)
    flow = StrobeMap(along(base, path), now).member(now).flow
    flow.begin(flow.start(), changes=np.zeros((1, flow.size + flow.impact_count)))


def _sharp_family(varied: Varied, base: Case, *, keep_load: bool = False) -> Family:
    """Return the family of cases at a tolerance fine enough for derivatives (`sharp`)."""
    found = varied.family(base, keep_load=keep_load)
    return (lambda value: sharp(found(value))) if varied.is_function else found


def _first_value(varied: Varied, base: Case, start: Any) -> float:
    """Return the value of the field at the first orbit of a branch [SI]."""
    if start is None:
        return _value_now(base, varied.path)
    from gearplay.linear.response import FrequencyResponse

    if isinstance(start, FrequencyResponse):
        return resonant_value(base, varied.path, start)
    return varied.number(start, "start")


def resonant_value(case: Case, path: str, response: "FrequencyResponse") -> float:
    """Return the speed [rad/s] that a field prescribes where a mesh meets the largest resonance of a response to its error.

    Raises `InputError` for a field that is no speed of a drive, or a response to something else than a mesh's error.
    """
    from gearplay.linear.inputs import ERROR

    label, _, kind = str(response.ds.attrs["force"]).rpartition(".")
    labels = [mesh.label for mesh in case.meshes]
    if kind != ERROR or label not in labels:
        rule = "must be a response to the error of a mesh of the case"
        raise InputError.of("start", str(response.ds.attrs["force"]), rule, "Give the value itself")
    if not path.endswith(".drive.speed"):
        rule = "must be the speed of a drive for a start on a resonance"
        raise InputError.of("path", path, rule, "Give the value itself as start")
    now = _value_now(case, path)
    frequency = rolling.mesh_frequency(case, labels.index(label))
    if frequency == 0.0 or now == 0.0:
        raise InputError.of(path, now, "must not be 0 for a start on a resonance", "Choose a speed")
    amplitude = response.ds["amplitude"].values
    at = float(response.ds["frequency"].values[int(np.argmax(amplitude.max(axis=0)))])
    return now * at / frequency


def _value_now(base: Case, path: str) -> float:
    """Return the case's own value of a field [SI]."""
    return number_in_si(base, (path,), value_at(base, path), path)


def _prepared(
    case: Source | Family, path: str, low: Any, high: Any, size: float | None, orbits: int
) -> tuple[Varied, Settings, Case]:
    """Return the family of cases, the settings of its branches, and its first case at the tolerance of derivatives."""
    varied = Varied(case, path)
    ends = [varied.number(value, name) for name, value in (("low", low), ("high", high))]
    if not ends[0] < ends[1]:
        raise InputError.of("high", high, f"must be above low, {low}", "Give the lower first")
    natural = 0.1 * (ends[1] - ends[0]) if size is None else size
    base = sharp(varied.case(ends[0]))
    refuse_fixed_steps(base)
    return varied, Settings(low=ends[0], high=ends[1], size=natural, orbits=orbits), base
