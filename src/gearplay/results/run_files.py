"""Files of runs: the motion, from which every signal is computed when it is read, and plain samples for other programs.

The root group is a dataset by CF conventions, as `Result.ds`, with those signals that are stored as samples. The group ``motion``
has the checkpoints of every member, its contact log and counters (docs/files.md).
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.files.netcdf_streams import CHUNK, Writer, write_streamed
from gearplay.files.stored import Stored
from gearplay.integrate.run import LOG_COLUMNS
from gearplay.kernels.layout import MEMORY
from gearplay.model.case import Case
from gearplay.model.pack import Packed, pack
from gearplay.results.dataset import (
    TIME,
    SignalTable,
    attributes_of,
    coordinate_tables,
    signal_tables,
    statistics_tables,
)
from gearplay.solver.checkpoints import KeptMotion
from gearplay.solver.continuation import end_of
from gearplay.solver.deadline import Deadline
from gearplay.solver.housing import HousingMotion
from gearplay.solver.kept_samples import KeptSamples
from gearplay.solver.status import Status
from gearplay.solver.stored_motion import kernels_digest, motion_of, tables_of, widths_of
from gearplay.solver.trajectory import (
    ContactStatistics,
    Counters,
    Trajectory,
    all_columns,
    choose_columns,
)
from gearplay.vocabulary.quantities import CONTACT_STATISTICS

Floats = NDArray[np.float64]
KERNELS: Final = "kernels_sha256"
"""Attribute of a file: the digest of the kernels that its motion can be replayed with."""
MOTION: Final = "motion"
CHECKPOINTS, CHANGES, LEFT, MOST = 1, 2, 4, 1 << 53
"""Columns of the integers of a member, and their largest value."""


def write_run(
    case: Case, runs: Sequence[Trajectory], plain: Sequence[Trajectory], path: Path, *, overwrite: bool
) -> None:
    """Write members atomically: their motion where it was kept, and all samples of ``plain``, the same members.

    Raises `InputError` where the file exists and ``overwrite`` is false, or cannot be written, and the errors of sampling.
    """
    packed = pack(case)
    tables = signal_tables(packed, plain[0].columns)
    motions = [run.samples.motion for run in runs if isinstance(run.samples, KeptSamples)]
    numbers = sum(run.samples.count * (len(run.columns) + 1) for run in plain if run.columns)

    def make(file: Writer) -> None:
        file.attributes(attributes_of(case, runs))
        longest = max(plain, key=lambda run: run.samples.count)
        length = longest.samples.count if tables else 0
        file.variable("time", ("time",), (length,), float, TIME)
        for first in range(0, length, CHUNK):
            places = np.arange(first, min(first + CHUNK, length))
            file.put("time", slice(first, first + CHUNK), longest.first_sample + places / longest.sampling)
        for name, (dims, values, words) in (
            coordinate_tables(packed, plain) | statistics_tables(runs)
        ).items():
            file.table(name, dims, values, words)
        _write_samples(file, tables, plain, length)
        if len(motions) == len(runs):
            file.attributes({KERNELS: kernels_digest()})
            _write_motions(file.subgroup(MOTION), packed, runs, motions)

    write_streamed(path, make, overwrite=overwrite, size=8.0 * numbers)


def _write_samples(
    file: Writer, tables: Sequence[SignalTable], plain: Sequence[Trajectory], length: int
) -> None:
    """Write the samples of all members, block by block where they are many."""
    if len(plain) == 1 and 0 < length <= CHUNK:
        (block,) = plain[0].samples.blocks(length, file.stop)
        for table in tables:
            file.table(table.name, table.dims, table.fill(block[:, table.columns]), table.attributes)
        return
    own = ("member",) if len(plain) > 1 else ()
    for table in tables:
        shape = (len(plain),) * len(own) + table.shape(length)
        file.variable(table.name, (*own, *table.dims), shape, table.dtype, table.attributes)
    for m, run in enumerate(plain if tables else ()):
        first = 0
        for block in run.samples.blocks(CHUNK, file.stop):
            last = first + len(block)
            for table in tables:
                values = table.fill(block[:, table.columns])
                file.put(table.name, (m,) * len(own) + (slice(first, last),), values)
            first = last


def _write_motions(
    file: Writer, packed: Packed, runs: Sequence[Trajectory], motions: Sequence[KeptMotion]
) -> None:
    counts, integers, floats = tables_of(motions)
    columns = runs[0].columns
    names = None if columns == all_columns(packed) else [f"{c.label}.{c.signal}" for c in columns]
    file.attributes({"signals": json.dumps(names)})
    mesh = {label: at for at, label in enumerate(packed.labels.get("mesh", ()))}
    whole, real = [], []
    for run, checkpoints in zip(runs, counts, strict=True):
        done, ended = run.counters, (int(run.status), mesh.get(run.left_mesh, -1))
        sizes = (run.member, checkpoints, len(run.log), *ended)
        whole.append([*sizes, done.steps, done.rejected_steps, done.events, done.calls])
        wedged = [run.wedged.get(label, 0.0) for label in mesh]
        ends = (run.final_state, run.end.memory.ravel(), run.end.impact_speeds)
        real.append(np.concatenate([[run.reached, run.wall_time], wedged, *ends]))
    log = np.concatenate([run.log for run in runs]).T
    tables: dict[str, Any] = {
        "run_integers": whole,
        "run_floats": real,
        "log": log,
        "integers": integers.T,
        "floats": floats.T,
    }
    for name, values in tables.items():
        file.variable(name, (), np.shape(values), np.asarray(values).dtype, {}, values=values)


def can_replay(file: Stored) -> bool:
    """Return whether a file has checkpoints that these kernels can replay."""
    return MOTION in file and file.attribute(KERNELS, str, "") == kernels_digest()


def log_of(file: Stored, case: Case) -> list[Floats]:
    """Return the contact log of every member of a file, also one written by other kernels."""
    group = file.subgroup(MOTION)
    members = _members(group)
    log = _log(group, members, pack(case), case.run.transient + case.run.duration)
    return np.split(log, np.cumsum(members[:, CHANGES])[:-1])


def read_motions(file: Stored, case: Case, source: str) -> list[Trajectory]:
    """Return the members of a file that these kernels can replay.

    Raises `ValueError`, whose text is a predicate, where an array is missing or holds what a run of the case cannot.
    """
    group, settings = file.subgroup(MOTION), case.run
    ends = settings.transient, settings.transient + settings.duration
    packed, own = pack(case, span=ends[-1]), case.differs_by_member
    members = _members(group)
    statistics = _statistics(file, packed, len(members))
    log = np.split(_log(group, members, packed, ends[-1]), np.cumsum(members[:, CHANGES])[:-1])
    columns, places = choose_columns(packed, json.loads(group.attribute("signals", str)))
    meshes, slots = packed.labels.get("mesh", ()), packed.system.elements.size * MEMORY
    parts = np.cumsum([2, len(meshes), packed.state_size, slots])
    speeds = int((packed.system.contacts["impact_slot"] >= 0).sum())
    real = group.numbers("run_floats", "f", (len(members), int(parts[-1]) + speeds))
    widths, marks = widths_of(case, packed), members[:, CHECKPOINTS]
    integers, floats = (
        np.split(group.numbers(name, kind, (width, int(marks.sum()))).T, np.cumsum(marks)[:-1])
        for name, kind, width in zip(("integers", "floats"), "if", widths, strict=True)
    )
    runs = []
    for m, (number, _, _, code, left, *counters) in enumerate(members.tolist()):
        (reached, seconds), wedged, state, memory, impacts = np.split(real[m], parts)
        if (
            not -1 <= left < len(meshes)
            or not np.isfinite([reached, seconds, *wedged, *state, *impacts]).all()
        ):
            raise ValueError("a number of its members is none of a run")
        status = Status(code)
        if not 0.0 <= reached <= ends[-1] or (status == Status.DONE and reached < ends[-1]):
            raise ValueError("its members did not reach what their status says")
        mine = pack(case, span=ends[-1], member=number) if own else packed
        motion = motion_of(case, mine, ends, float(reached), integers[m], floats[m], source)
        motion.left = Deadline(settings.max_wall_time).left()
        runs.append(
            Trajectory(
                member=number,
                first_sample=ends[0],
                sampling=settings.sampling,
                samples=KeptSamples(motion, places, settings.sampling),
                columns=columns,
                statistics=statistics[m],
                log=log[m],
                status=status,
                counters=Counters(*counters),
                reached=float(reached),
                wall_time=float(seconds),
                final_state=state,
                end=end_of(mine.system, float(reached), state, memory.reshape(-1, MEMORY), impacts),
                wedged={label: float(w) for label, w in zip(meshes, wedged, strict=True) if w > 0.0},
                housing=HousingMotion.of(mine.system),
                left_mesh=meshes[left] if left >= 0 else "",
            )
        )
    return runs


def _members(group: Stored) -> NDArray[np.int64]:
    """Return the integers of all members, shape [member, 9]: number, checkpoints, changes, status, mesh that left, counters."""
    found = group.numbers("run_integers", "i", (None, 9))
    numbers, others = found[:, 0], np.delete(found, LEFT, axis=1)
    if (
        not len(found)
        or len(set(numbers.tolist())) < len(found)
        or (others < 0).any()
        or (found > MOST).any()
    ):
        raise ValueError("a number of its members is none of a run")
    return found


def _log(group: Stored, members: NDArray[np.int64], packed: Packed, end: float) -> Floats:
    """Return the contact changes of all members, shape [change, 4], until ``end`` [s]."""
    log = np.ascontiguousarray(group.numbers("log", "f", (LOG_COLUMNS, int(members[:, CHANGES].sum()))).T)
    times, contacts, kinds, rates = log.T
    known = np.isin(contacts, np.arange(len(packed.contact_labels))) & np.isin(kinds, (0.0, 1.0))
    if not (known & (times >= 0.0) & (times <= end) & np.isfinite(rates)).all():
        raise ValueError("its contact log has impossible changes")
    return log


def _statistics(file: Stored, packed: Packed, count: int) -> list[ContactStatistics]:
    contacts = len(packed.contact_labels)
    shape = (count, contacts) if count > 1 else (contacts,)
    tables = {name: file.numbers(name, "f", shape).reshape(count, contacts) for name in CONTACT_STATISTICS}
    return [
        ContactStatistics(
            labels=packed.contact_labels,
            angular=packed.angular,
            **{name: each[m] for name, each in tables.items()},
        )
        for m in range(count)
    ]
