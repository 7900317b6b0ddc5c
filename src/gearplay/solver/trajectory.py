"""Result of a simulated member: sampled signals, contact statistics, contact log, status."""

import math
import threading
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.run import (
    DEPTH_MAX,
    FORCE_MAX,
    ONSETS,
    SPEED_MAX,
    SPEED_SQUARES,
    SPEED_SUM,
    TIME,
    WEDGED,
)
from gearplay.kernels.layout import OUT_SIZE
from gearplay.model.pack import Packed
from gearplay.model.variables import VARIABLES
from gearplay.parts.mesh.geometry import DISTANCE, MESH, gaps_at
from gearplay.solver.continuation import End
from gearplay.solver.housing import HousingMotion
from gearplay.solver.status import WORDS, Status
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.suggestions import listed, nearest

Floats = NDArray[np.float64]


class Column(NamedTuple):
    """One sampled signal of one element."""

    signal: str
    dimension: str  # rotor or a kind of element: sleeve, mesh
    label: str


def all_columns(packed: Packed) -> tuple[Column, ...]:
    """Return every signal in the order of the kernel's rows."""
    return _every(tuple(packed.labels.items()))


def _every(labels: tuple[tuple[str, tuple[str, ...]], ...]) -> tuple[Column, ...]:
    return tuple(
        Column(quantity.name, dimension, label)
        for dimension, names in labels
        for label in names
        for quantity in VARIABLES[dimension]
    )


def choose_columns(packed: Packed, wanted: list[str] | None) -> tuple[tuple[Column, ...], NDArray[np.int64]]:
    """Return the requested columns and their indices in a full row.

    ``wanted`` holds signal names (``ax``) or one element's signal (``ring.ax``); None keeps all.

    Raises `InputError` for a name that is no signal.
    """
    every, places = _chosen(tuple(packed.labels.items()), None if wanted is None else tuple(wanted))
    return every, np.array(places, dtype=np.int64)


@lru_cache(maxsize=256)
def _chosen(
    labels: tuple[tuple[str, tuple[str, ...]], ...], wanted: tuple[str, ...] | None
) -> tuple[tuple[Column, ...], tuple[int, ...]]:
    """Return the columns as `choose_columns` for a mechanism of such elements; cached, since the cases of a sweep are alike."""
    every = _every(labels)
    if wanted is None:
        return every, tuple(range(len(every)))
    chosen: list[int] = []
    for name in wanted:
        found = [i for i, c in enumerate(every) if name in (c.signal, f"{c.label}.{c.signal}")]
        if not found:
            raise InputError.of("signals", name, "must be a signal of this case", _cure(name, every))
        chosen.extend(i for i in found if i not in chosen)
    return tuple(every[i] for i in chosen), tuple(chosen)


def _cure(name: str, every: Sequence[Column]) -> str:
    """Return what to write instead of a name that is no signal: of which part of it is known, the other part."""
    label, _, signal = name.rpartition(".")
    having = {c.label: None for c in every if c.signal == signal}
    own = {c.signal: None for c in every if c.label == label}
    if label and having:
        close = nearest(label, having)
        return f"Did you mean '{close}.{signal}'?" if close else f"Elements with {signal}: {listed(having)}"
    if own:
        close = nearest(signal, own)
        return f"Did you mean '{label}.{close}'?" if close else f"Signals of {label}: {', '.join(own)}"
    known = sorted({c.signal for c in every})
    close = nearest(name, [*known, *(f"{c.label}.{c.signal}" for c in every)])
    return f"Did you mean '{close}'?" if close else f"Choose from: {', '.join(known)}"


class ContactStatistics(NamedTuple):
    """Statistics of every contact after the transient: sleeves by name, flanks as ``mesh:drive``, ``mesh:back``.

    Arrays have shape [contact]: share of time in contact [1], onsets per second [1/s], mean, rms and largest onset speed
    [m/s], largest force [N], largest penetration [m]; where ``angular`` is true, of a coupling, in rad/s, N m and rad.
    """

    labels: tuple[str, ...]
    share_of_time: Floats
    impacts_per_second: Floats
    mean_impact_speed: Floats
    rms_impact_speed: Floats
    max_impact_speed: Floats
    peak_force: Floats
    max_penetration: Floats
    angular: NDArray[np.bool_]


def statistics_of(packed: Packed, tallies: Floats, span: float) -> ContactStatistics:
    """Turn the kernel's tallies over ``span`` seconds into statistics."""
    onsets = np.maximum(tallies[:, ONSETS], 1.0)
    span = span if span > 0.0 else np.nan
    return ContactStatistics(
        labels=packed.contact_labels,
        share_of_time=tallies[:, TIME] / span,
        impacts_per_second=tallies[:, ONSETS] / span,
        mean_impact_speed=tallies[:, SPEED_SUM] / onsets,
        rms_impact_speed=np.sqrt(tallies[:, SPEED_SQUARES] / onsets),
        max_impact_speed=tallies[:, SPEED_MAX].copy(),
        peak_force=tallies[:, FORCE_MAX].copy(),
        max_penetration=tallies[:, DEPTH_MAX].copy(),
        angular=packed.angular,
    )


class Counters(NamedTuple):
    """Work done, transient included."""

    steps: int = 0
    rejected_steps: int = 0
    events: int = 0
    calls: int = 0  # evaluations of the right-hand side by the stepper, sampling excluded


def wedged_meshes(packed: Packed, tallies: Floats, span: float) -> dict[str, float]:
    """Return the share of ``span`` [s] for which both flanks of a mesh touched and only one could act; no entry for the others.

    Nothing of a run that ended before its record began.
    """
    if span <= 0.0:
        return {}
    return {
        packed.contact_labels[k].partition(":")[0]: float(tallies[k, WEDGED] / span)
        for k in np.flatnonzero(tallies[:, WEDGED] > 0.0)
    }


def mesh_that_left(packed: Packed, t: float, y: Floats, memory: Floats) -> str:
    """Return the mesh whose centre distance is nearest the ends of its range where a run ended at t [s], or past them."""
    out, system, least = np.zeros(OUT_SIZE), packed.system, (math.inf, "")
    for j, mesh in enumerate(system.records[MESH]):
        gaps_at(system, j, t, y, memory, out)
        room = min(out[DISTANCE] - mesh.A_min, mesh.A_max - out[DISTANCE]) / (mesh.A_max - mesh.A_min)
        least = min(least, (float(room), packed.labels["mesh"][j]))
    return least[1]


def _doubt(mesh: str, share: float) -> str:
    return (
        f" Mesh {mesh} was wedged (negative backlash) for {100.0 * share:.2g} % of the time: as published only one flank"
        " then acts, and energy may be created; formulation = geometric lets both act."
    )


class Samples(Protocol):
    """The samples of a run, shape [time, column], stored during the run or computed on request."""

    @property
    def left(self) -> float:
        """Time [s] that the limit on the run's leaves for them."""

    @property
    def count(self) -> int:
        """Number of times."""

    @property
    def values(self) -> Floats:
        """All signals, shape [time, column], in SI units."""

    def some(self, columns: Sequence[int]) -> Floats:
        """Return some signals, shape [time, column]."""

    def keep(self, columns: Sequence[int]) -> None:
        """Compute some signals together, if they have to be computed, and keep them."""

    def thinned(self, columns: Sequence[int], stride: int) -> Floats:
        """Return every ``stride``-th sample of some signals, shape [time, column]; not kept."""

    def blocks(self, size: int, stop: threading.Event) -> Iterator[Floats]:
        """Yield all samples in blocks of ``size`` times, shape [time, column], each valid until the next; not kept.

        Raises once ``stop`` is set.
        """


@dataclass(frozen=True)
class WrittenSamples:
    """Samples written while the run went on, shape [time, column]; the time [s] that the run's limit had left."""

    values: Floats
    left: float = math.inf

    @property
    def count(self) -> int:
        """Number of times."""
        return len(self.values)

    def some(self, columns: Sequence[int]) -> Floats:
        """Return some signals, shape [time, column]."""
        return self.values[:, list(columns)]

    def keep(self, columns: Sequence[int]) -> None:
        """Do nothing: they were written during the run."""

    def thinned(self, columns: Sequence[int], stride: int) -> Floats:
        """Return every ``stride``-th sample of some signals, shape [time, column]."""
        return self.values[::stride, list(columns)]

    def blocks(self, size: int, stop: threading.Event) -> Iterator[Floats]:
        """Yield all samples in blocks of ``size`` times, shape [time, column]."""
        yield from (self.values[at : at + size] for at in range(0, self.count, size))


@dataclass(frozen=True)
class Trajectory:
    """One member's run. ``values`` has shape [time, column], from ``samples``; ``log`` rows are (t, contact, 1 onset / 0
    release, rate); ``wedged`` holds the share of time of meshes that were wedged as published; ``housing`` is the motion of the
    housing, where it moves; ``left_mesh`` is the mesh that stopped the run by its centre distance.
    """

    member: int
    first_sample: float  # s
    sampling: float  # Hz
    samples: "Samples" = field(repr=False)
    columns: tuple[Column, ...]
    statistics: ContactStatistics
    log: Floats
    status: Status
    counters: Counters
    reached: float  # s, simulated time
    wall_time: float  # s
    final_state: Floats = field(repr=False)
    end: End = field(repr=False)
    wedged: dict[str, float] = field(default_factory=dict)
    housing: HousingMotion | None = field(default=None, repr=False)
    left_mesh: str = ""

    @property
    def time(self) -> Floats:
        """Times of the samples [s], shape [time]."""
        return self.first_sample + np.arange(self.samples.count) / self.sampling

    @property
    def values(self) -> Floats:
        """All signals that were kept, shape [time, column], SI units; see `KeptSamples` for when they are computed."""
        return self.samples.values

    @property
    def success(self) -> bool:
        """Whether the run reached its end."""
        return self.status == Status.DONE

    @property
    def message(self) -> str:
        """The status and the warnings of the run as text."""
        place = "" if self.success else f" Stopped at t = {self.reached:.9g} s."
        if self.left_mesh:
            place += f" It is {self.left_mesh}."
        return WORDS[self.status] + place + "".join(_doubt(*wedge) for wedge in self.wedged.items())

    def signal(self, name: str, label: str) -> Floats:
        """Return one signal, shape [time], SI units; `KeyError` where it was not kept."""
        return self.samples.some([self._place(name, label)])[:, 0]

    def compute(self, wanted: Collection[tuple[str, str]]) -> None:
        """Compute signals, (signal, element), by one replay instead of one each; those that were not kept are left out."""
        self.samples.keep(
            [at for at, column in enumerate(self.columns) if (column.signal, column.label) in wanted]
        )

    def _place(self, name: str, label: str) -> int:
        for i, column in enumerate(self.columns):
            if column.signal == name and column.label == label:
                return i
        raise KeyError(f"{label}.{name} was not kept")

    def thinned(self, wanted: Sequence[tuple[str, str]], stride: int) -> Floats:
        """Return every ``stride``-th sample of signals, (signal, element), shape [time, signal]; NaN where not kept."""
        places = {(column.signal, column.label): at for at, column in enumerate(self.columns)}
        known = [(k, places[each]) for k, each in enumerate(wanted) if each in places]
        samples = self.samples.thinned([at for _, at in known], stride)
        if len(known) == len(wanted):
            return samples
        found = np.full((len(samples), len(wanted)), np.nan)
        found[:, [k for k, _ in known]] = samples
        return found

    def mean_acceleration(self, rotor: str) -> Floats:
        """Return the mean acceleration of a rotor's centre in each sampling interval [m/s^2], shape [2, time - 1].

        Along x and y in space, as a sensor on the rotor feels it: the increments of its velocity relative to the housing and of
        the housing's own velocity, over the interval. Exact whatever happens in between, so that impacts of 0.1 ms do not alias.
        Needs `acceleration_signals`.
        """
        velocities = self.samples.some([self._place(name, rotor) for name in ACCELERATIONS.values()])
        found = np.ascontiguousarray(np.diff(velocities, axis=0).T) * self.sampling
        return found if self.housing is None else found + self.housing.means(self.time)

    def relative_mean_acceleration(self, signal: str, rotor: str) -> Floats:
        """Return the mean of ``ax`` or ``ay`` in each sampling interval [m/s^2], relative to the housing, shape [time - 1].

        Needs the velocity of the same axis (`ACCELERATIONS`).
        """
        return np.diff(self.signal(ACCELERATIONS[signal], rotor)) * self.sampling


ACCELERATIONS = {"ax": "vx", "ay": "vy"}
"""The signal whose increments are the means of an acceleration."""


def acceleration_signals(rotors: Iterable[str]) -> list[str]:
    """Return the signals that `Trajectory.mean_acceleration` of some rotors needs."""
    return [f"{rotor}.{name}" for rotor in rotors for name in ACCELERATIONS.values()]


@dataclass(frozen=True)
class Work:
    """Work of all members: steps, rejected steps, events, and the sum of their core seconds."""

    steps: int
    rejected_steps: int
    events: int
    wall_time: float


def work_of(runs: Sequence[Trajectory]) -> Work:
    """Return the work of all runs."""
    done = [run.counters for run in runs]
    return Work(
        steps=sum(each.steps for each in done),
        rejected_steps=sum(each.rejected_steps for each in done),
        events=sum(each.events for each in done),
        wall_time=sum(run.wall_time for run in runs),
    )


def worst_of(runs: Sequence[Trajectory]) -> Trajectory:
    """Return the run with the worst status, among equals the one that was wedged for longest."""
    return max(runs, key=lambda run: (int(run.status), sum(run.wedged.values())))
