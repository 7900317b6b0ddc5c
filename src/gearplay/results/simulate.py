"""`simulate`: one case or several, to results."""

import threading
from collections.abc import Sequence
from typing import Any, TypedDict, Unpack, overload

from gearplay.model.case import Case
from gearplay.model.policy import Policy
from gearplay.model.reading import Source, load_case, replace
from gearplay.results.result import Result
from gearplay.solver.simulate import run_batch
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.progress import Progress, ticking


def _numbers(members: Sequence[int], ensemble: int | None) -> list[int]:
    """Return the numbers of members; `InputError` for none, a negative or repeated one, or ``ensemble`` given as well."""
    numbers = [int(member) for member in members]
    if ensemble is not None:
        rule = "must be left out where members are given, which it would number"
        raise InputError.of("ensemble", ensemble, rule, "Give one of the two")
    if not numbers or min(numbers) < 0 or len(set(numbers)) < len(numbers) or list(members) != numbers:
        rule = "must be different whole numbers from 0 on, at least one"
        raise InputError.of("members", str(members), rule, "Give for example range(1, 9)")
    return numbers


def case_of(source: Source, **run: Any) -> Case:
    """Return a case as it is, or read it: a file, the name of a bundled case, or a mapping; ``run`` overrides fields of its run.

    >>> case_of("han2021", duration=0.5, seed=None).run.duration
    0.5
    """
    case = load_case(source)
    given = {f"run.{name}": value for name, value in run.items() if value is not None}
    return replace(case, given) if given else case


class _Options(TypedDict, total=False):
    """Keyword arguments of `simulate`."""

    duration: float | None
    transient: float | None
    sampling: float | None
    ensemble: int | None
    members: Sequence[int] | None
    tolerance: float | None
    policy: Policy | None
    signals: list[str] | None
    progress: Progress | None
    threads: int | None
    stop: threading.Event | None


@overload
def simulate(case: Source, **options: Unpack[_Options]) -> Result: ...


@overload
def simulate(case: list[Any] | tuple[Any, ...], **options: Unpack[_Options]) -> list[Result]: ...


def simulate(
    case: Source | list[Any] | tuple[Any, ...],
    *,
    duration: float | None = None,
    transient: float | None = None,
    sampling: float | None = None,
    ensemble: int | None = None,
    members: Sequence[int] | None = None,
    tolerance: float | None = None,
    policy: Policy | None = None,
    signals: list[str] | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
    stop: threading.Event | None = None,
) -> Result | list[Result]:
    """Simulate a case and return its `Result`, whatever its status; for a list of cases, the list of their results.

    Nothing is raised once a run has started: look at ``result.success`` and ``result.message``.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping; or a list of these.
    duration, transient
        Recorded time and time before it [s]; the case's if not given.
    sampling
        Samples per second [Hz]; the case's if not given.
    ensemble
        Number of members, from perturbed starts; the case's if not given.
    members
        Numbers of the members to simulate, each with the start that it has in any ensemble; 0 to ``ensemble`` - 1 if not given.
    tolerance
        Error tolerance on scaled states [1]; the policy's or the case's if not given.
    policy
        How to compute, in place of the case's own tolerance, method and limits.
    signals
        Names of signals to keep, ``ax`` or ``ring.ax``, sampled during the run; all by default, computed on request.
    progress
        Called with what is running, simulated seconds done, and of how many.
    threads
        Threads that all members of all cases share; the cores by default. It changes nothing in the results.
    stop
        An event that ends the work early; what was computed until then is returned.

    Returns
    -------
    Result or list of Result

    Raises
    ------
    InputError
        For bad input.
    ResourceError
        For a run that is too large.

    Examples
    --------
    >>> result = simulate("han2021", duration=0.01, transient=0.0)
    >>> result.success, sorted(result.ds.sizes)[:2]
    (True, ['contact', 'mesh'])
    >>> [r.success for r in simulate(["han2021", "external-pair"], duration=0.001, transient=0.0)]
    [True, True]

    """
    given = {
        "duration": duration,
        "transient": transient,
        "sampling": sampling,
        "ensemble": ensemble,
        "tolerance": tolerance,
    }
    changes = {} if policy is None else policy.changes()
    changes |= {f"run.{name}": value for name, value in given.items() if value is not None}
    cases = [case_of(source) for source in (case if isinstance(case, (list, tuple)) else [case])]
    cases = [replace(each, changes) if changes else each for each in cases]
    if members is not None:
        members = _numbers(members, ensemble)
    jobs = [(each, range(each.run.ensemble) if members is None else members) for each in cases]
    label = (cases[0].title or "simulation") if len(cases) == 1 else f"{len(cases)} cases"
    tick = ticking(progress, label)
    runs = run_batch(jobs, signals=signals, progress=tick, threads=threads, stop=stop, keep_motion=True)
    results = [Result(each, its) for each, its in zip(cases, runs, strict=True)]
    return results if isinstance(case, (list, tuple)) else results[0]
