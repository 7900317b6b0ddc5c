"""Diagrams over a field, exponents, classification and basins of a case."""

import math
import threading
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gearplay.model.families import Family, Varied
from gearplay.model.reading import Source
from gearplay.nonlinear.basins import Basins, Grid, basins_of_attraction
from gearplay.nonlinear.diagrams import Diagram, bifurcation_diagram
from gearplay.nonlinear.least_spans import check_span
from gearplay.nonlinear.lyapunov import Exponents, lyapunov_exponents
from gearplay.nonlinear.motion import Motion, identify_motion
from gearplay.nonlinear.section_choice import AUTO
from gearplay.nonlinear.tolerances import sharp
from gearplay.results.simulate import case_of
from gearplay.solver.deadline import limited
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import ResourceError
from gearplay.vocabulary.progress import Progress, ticking

MOST_VALUES = 100_000
"""Values of the parameter on one diagram."""


def bifurcation(
    case: Source | Family,
    path: str,
    values: Sequence[Any],
    signals: Sequence[str],
    *,
    settle: int = 400,
    keep: int = 100,
    period: str | float = "common",
    directions: Sequence[str] = ("up", "down"),
    carry: bool = True,
    threads: int | None = None,
    keep_load: bool = False,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Diagram:
    """Return the bifurcation diagram over a field of a case: signals once per period of the settled motion.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; or a function that returns a `Case` for a value of a parameter.
    path
        The field: ``rotors.pinion.drive.speed``; of a function the name of its parameter.
    values
        Its values, rising: numbers in SI or texts with a unit; of a function plain numbers.
    signals
        ``ring.x``, ``pinion-ring.drive_penetration`` ...: those that follow from the state.
    settle, keep
        Periods that pass at each value, and periods that are kept.
    period
        "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"), or a time [s].
    directions
        "up", "down" or both: the ways along the values.
    carry
        Whether each value continues from the final state of the one before it, so that jumps show where a branch ends.
    threads
        Threads; the cores by default. It changes nothing in the result.
    keep_load
        Whether loads stay what they are at the case's own speeds, although drag follows the speed.
    progress
        Called with what is running, how much is done, and of how much.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.

    Returns
    -------
    Diagram
        ``ds`` has a variable for each signal over ``direction``, the field's name and ``section``, ``reason`` where a value
        failed, and ``start`` where one did not go on from the end of the one before it, with the reason.

    Raises
    ------
    InputError
        For a field, value or signal that cannot be.

    Examples
    --------
    >>> found = bifurcation("han2021", "meshes.0.backlash", ["90 um", "100 um"], ["ring.x"], settle=2, keep=3, period="mesh")
    >>> dict(found.ds.sizes), found.ds["ring.x"].attrs["units"]
    ({'direction': 2, 'backlash': 2, 'section': 3}, 'm')

    """
    varied = Varied(case, path)
    if len(values) > MOST_VALUES:
        raise ResourceError(
            f"bifurcation: {len(values)} values, more than {MOST_VALUES} on one diagram. Give fewer."
        )
    numbers = [varied.number(value, f"values.{at}") for at, value in enumerate(values)]
    base = varied.case(numbers[0] if numbers else 0.0)
    found = bifurcation_diagram(
        varied.family(base, keep_load=keep_load),
        numbers,
        signals,
        settle=settle,
        keep=keep,
        period=period,
        directions=directions,
        carry=carry,
        threads=worker_count() if threads is None else threads,
        progress=ticking(progress, base.title or "diagram"),
        stop=stop,
    )
    return replace(found, case=base, path=path)


def lyapunov(
    case: Source,
    *,
    count: int | None = None,
    duration: float | None = None,
    transient: float | None = None,
    member: int = 0,
    progress: Progress | None = None,
) -> Exponents:
    """Return the Lyapunov exponents of a case's motion: how fast neighbouring motions part, from the exact tangent.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; computed at its tolerance, at 1e-9 if that is looser.
    count
        How many, the largest first; all if not given.
    duration, transient
        Record and time before it [s]; the case's if not given. The record must hold 20 mesh periods and 25 slow swings of the
        motion, for its scatter: one whose duration is not given is made longer until it does.
    member
        Member of the ensemble, 0 for the unperturbed start.
    progress
        Called with what is running, how much is done, and of how much.

    Returns
    -------
    Exponents
        ``values`` and half-widths ``errors`` of their 95 % intervals [1/s], shape [exponent].

    Raises
    ------
    InputError
        For a count or times that cannot be, and for a record that is too short for an interval.
    SimulationError
        Where the motion cannot be followed.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.lyapunov(gp.torsional_pair(0.7), count=1, duration=0.2, transient=0.1)
    >>> bool(found.largest[0] < 0.0), found.ds["values"].attrs["units"]
    (True, '1/s')

    """
    base = sharp(case_of(case))
    span = base.run.duration if duration is None else duration
    if isinstance(span, (int, float)) and 0.0 < span < math.inf:
        check_span(base, "duration", span, span)
    return lyapunov_exponents(
        base,
        count=count,
        duration=duration,
        transient=transient,
        member=member,
        checked=True,
        progress=ticking(progress, "exponents"),
    )


def motion(
    case: Source,
    *,
    periods: int = 1000,
    settle: int = 300,
    period: str | float = AUTO,
    ensemble: int = 12,
    compare: bool = True,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Motion:
    """Return what kind of motion a case settles to, with the evidence: periodic, quasi-periodic, chaotic, at rest, an artefact.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; computed at its tolerance, at 1e-9 if that is looser.
    periods
        Number of sections that are evaluated, 100 or more.
    settle
        Periods before.
    period
        Between sections: "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"),
        or a time [s]. "auto" is the common one up to 20 mesh periods, else, as with hunting teeth, that of the mesh.
    ensemble
        Members of each ensemble that is compared, 4 or more.
    compare
        Whether ensembles are repeated with other numbers of the method: what changes then beyond its spread is an artefact.
    progress
        Called with what is running, how much is done, and of how much.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.

    Returns
    -------
    Motion
        ``kind``, ``reason``, the largest exponent [1/s] with the half-width of its 95 % interval, and the comparisons.

    Raises
    ------
    InputError
        For a case without a period or numbers that cannot be.
    SimulationError
        Where the motion cannot be followed.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.motion(gp.torsional_pair(0.7, force=0.05), periods=200, compare=False)
    >>> found.kind, found.order
    ('periodic', 1)

    """
    base = sharp(case_of(case))
    if not isinstance(period, str) and 0.0 < period < math.inf:
        check_span(base, "period", period, periods * period, per=1.0 / periods)
    with limited(base.run.max_wall_time) as time_left:
        found = identify_motion(
            base,
            periods=periods,
            settle=settle,
            period=period,
            ensemble=ensemble,
            compare=compare,
            progress=progress,
            stop=stop,
        )
    if not time_left.has_stopped:
        return found
    known = found.response
    reason = f"{known.reason} Within run.max_wall_time it was not compared with other numbers of the method."
    return replace(found, kind=known.kind, order=known.order, reason=reason, comparisons=(), limit=math.inf)


def basins(
    case: Source,
    first: tuple[str, float, float, int],
    second: tuple[str, float, float, int],
    *,
    settle: int = 300,
    period: str | float = "common",
    threads: int | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> Basins:
    """Return which motion each initial state of a grid leads to.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    first, second
        An entry of the state, its least and largest value [SI], and their number: ``("ring.vx", -0.1, 0.1, 50)``. Of a
        torsional pair also its displacement and velocity in half backlashes, ``("x", -2, 2, 50)`` and ``("x'", -2, 2, 50)``,
        velocity over the natural frequency.
    settle
        Periods before the motions are compared, 1 or more.
    period
        "common" (after which all that excites begins anew), that of the first "mesh", of its driver ("shaft"), or a time [s].
    threads
        Threads; the cores by default. It changes nothing in the result.
    progress
        Called with what is running, how much is done, and of how much.
    stop
        An event that ends the work early, with `KeyboardInterrupt`.

    Returns
    -------
    Basins
        ``labels``, shape [second, first]: the place of the motion in ``attractors``; -1 does not repeat, -2 cannot be followed,
        -3 was not reached within ``run.max_wall_time``.

    Raises
    ------
    InputError
        For entries, ranges or a case that cannot be.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.basins(gp.torsional_pair(0.7, force=0.05), ("x", 1.0, 1.2, 2), ("x'", -0.1, 0.1, 2), settle=300)
    >>> found.labels.shape, len(found.attractors)
    ((2, 2), 2)

    """
    base = case_of(case)
    return basins_of_attraction(
        base,
        Grid(*first),
        Grid(*second),
        settle=settle,
        period=period,
        threads=worker_count() if threads is None else threads,
        progress=ticking(progress, "starts"),
        stop=stop,
    )
