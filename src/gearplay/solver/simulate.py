"""`simulate`: run one case, one member or many, on threads, with progress, limits and a clean stop."""

import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import islice
from typing import TypeVar

import numpy as np

from gearplay.model.case import Case
from gearplay.model.pack import Packed, pack
from gearplay.solver.continuation import End
from gearplay.solver.deadline import in_request
from gearplay.solver.integration import Course
from gearplay.solver.job import Job, Simulation, Watch
from gearplay.solver.limits import check_estimate, estimate
from gearplay.solver.members import Members, Pool
from gearplay.solver.trajectory import Trajectory, choose_columns
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.progress import Tick

R = TypeVar("R")
MOST_WRITTEN = 1e7
"""Numbers of one case that are written during a run whose motion is kept, too: 80 MB."""


def _load(case: Case, packed: Packed) -> None:
    """Load the kernels and the data common to all runs, before threads share them."""
    Course(case, packed, np.zeros(packed.state_size)).take_chunk(0.0, 0)


def run_members(
    case: Case,
    members: Iterable[int],
    *,
    signals: list[str] | None = None,
    duration: float | None = None,
    transient: float | None = None,
    sampling: float | None = None,
    progress: Tick | None = None,
    threads: int | None = None,
    stop: threading.Event | None = None,
) -> Sequence[Trajectory]:
    """Simulate ensemble members of one case on threads; the result does not depend on their number.

    ``signals`` names what to keep (`choose_columns`), ``duration`` and ``transient`` [s] and ``sampling`` [Hz] default to
    the case's. Setting ``stop`` stops every member at its next chunk and returns what was computed, status INTERRUPTED;
    Ctrl-C sets it.

    Raises `InputError` for an impossible case and `ResourceError` for one that is too large.
    """
    return run_batch(
        [(case, list(members))],
        signals=signals,
        duration=duration,
        transient=transient,
        sampling=sampling,
        progress=progress,
        threads=threads,
        stop=stop,
    )[0]


def run_one(
    case: Case,
    member: int = 0,
    *,
    signals: list[str] | None = None,
    stop: threading.Event | None = None,
    origin: End | None = None,
) -> Trajectory:
    """Simulate one member on the caller's thread, for callers with a pool of their own; see `run_members`.

    ``origin`` is the end of an earlier run of the same mechanism, from which this one continues.
    """
    one = _simulation(case, signals, 1)
    return Job(0, one, member, origin).run(Watch(one.ends[-1], None, stop or threading.Event()))


def run_few(
    case: Case,
    members: Sequence[int],
    pool: Pool,
    *,
    signals: list[str] | None = None,
    stop: threading.Event | None = None,
) -> Sequence[Trajectory]:
    """Simulate members on the caller's thread, on runs of a pool; see `run_one`."""
    one = _simulation(case, signals, len(members))
    watch = Watch(one.ends[-1], None, stop or threading.Event())
    if one.differs_by_member:
        return [Job(0, one, member).run(watch) for member in members]
    found = Members(0, one, members, pool)
    for call in found.calls(watch):
        call()
    return found


def _simulation(case: Case, signals: list[str] | None, members: int) -> Simulation:
    """Return the simulation of ``members`` members of a case; `ResourceError` where it is too large."""
    packed, run = pack(case), case.run
    kept = choose_columns(packed, signals)
    check_estimate(
        estimate(
            case,
            packed,
            columns=len(kept[0]),
            members=members,
            sampling=run.sampling,
            duration=run.duration,
            transient=run.transient,
        )
    )
    return Simulation(case, packed, kept, run.sampling, run.duration, run.transient)


def run_batch(
    jobs: Sequence[tuple[Case, Sequence[int]]],
    *,
    signals: list[str] | None = None,
    duration: float | None = None,
    transient: float | None = None,
    sampling: float | None = None,
    progress: Tick | None = None,
    threads: int | None = None,
    stop: threading.Event | None = None,
    keep_motion: bool = False,
    packs: Sequence[Packed] | None = None,
) -> list[Sequence[Trajectory]]:
    """Simulate several cases, each with its members, on one pool of threads; see `run_members`.

    ``packs`` are the cases as packed for their own durations, where the caller has them.

    With ``keep_motion`` signals are computed on request (`KeptSamples`); those that ``signals`` names are written during the
    run, up to `MOST_WRITTEN` numbers a case. The result has the order of ``jobs`` and does not depend on the number of
    threads. Every case is checked before any runs.
    """
    cases: list[Simulation] = []
    found: list[Members | list[Job]] = []
    pool = Pool()
    bytes_, steps, total, place = 0.0, 0.0, 0.0, 0
    for at, (case, members) in enumerate(jobs):
        run = case.run
        span = run.duration if duration is None else duration
        lead = run.transient if transient is None else transient
        rate = run.sampling if sampling is None else sampling
        packed = pack(case, span=lead + span) if packs is None else packs[at]
        kept = choose_columns(packed, signals)
        numbers = span * rate * len(kept[0]) * len(members)
        sample = not keep_motion or (signals is not None and numbers <= MOST_WRITTEN)
        cost = estimate(
            case,
            packed,
            columns=len(kept[0]),
            members=len(members),
            sampling=rate if sample else 0.0,
            duration=span,
            transient=lead,
        )
        check_estimate(cost)
        bytes_, steps = bytes_ + cost.bytes, steps + cost.steps
        check_estimate(cost._replace(bytes=bytes_, steps=steps))
        total += (span + lead) * len(members)
        one = Simulation(case, packed, kept, rate, span, lead, keep=keep_motion, sample=sample)
        cases.append(one)
        if (len(members) > 1 or not keep_motion) and not one.differs_by_member:
            if 0 in members:  # what cannot mesh is refused before anything runs
                one.starts.of_member(0)
            found.append(Members(place, one, members, pool))
        else:
            found.append([Job(place + k, one, m) for k, m in enumerate(members)])
        place += len(members)
    if cases:
        _load(cases[0].case, cases[0].packed)
    watch, count = Watch(total, progress, stop or threading.Event()), threads or worker_count()
    calls: list[Sequence[Callable[[], Trajectory | None]]] = [
        each.calls(watch, count) if isinstance(each, Members) else [partial(job.run, watch) for job in each]
        for each in found
    ]
    done = iter(_on_threads([call for its in calls for call in its], watch, count))
    pool.idle.clear()
    made = [[run for run in islice(done, len(its)) if run is not None] for its in calls]
    return [each if isinstance(each, Members) else its for each, its in zip(found, made, strict=True)]


def _on_threads(calls: Sequence[Callable[[], R]], watch: Watch, threads: int) -> list[R]:
    """Return the results of calls made on threads; Ctrl-C cancels the runs.

    Even a single call is made off the main thread, so that Ctrl-C reaches Python while the kernel works.
    """
    with ThreadPoolExecutor(max(1, min(threads, len(calls)))) as pool:
        futures = [pool.submit(in_request(call)) for call in calls]
        try:
            return [future.result() for future in futures]
        except KeyboardInterrupt:
            watch.stop.set()
            return [future.result() for future in futures]
