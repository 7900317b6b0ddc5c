"""The flow of a case: from a state to a later one, with its exact derivative where that is wanted."""

import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import run_state, stepper, tangent
from gearplay.kernels.layout import OPEN
from gearplay.model.case import Case
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from gearplay.solver.observables import state_names
from gearplay.solver.status import WORDS, Status
from gearplay.vocabulary.errors import Fault, InputError, SimulationError

Floats = NDArray[np.float64]
CHUNK_STEPS, LOG_CAPACITY = 20_000, 16_384
MOST_STEPS = 50_000_000
"""Steps of one course from which on it counts as run away: some minutes; a case's own ``run.max_steps`` may be less."""


@dataclass(frozen=True)
class Passage:
    """Where the flow has led: state, shape [state], and latched impact speeds [m/s], shape [sleeve]; the moved changes, shape
    [change, state + sleeve]; contact changes on the way (t, contact, 1 onset / 0 release, rate), shape [change, 4]; which
    contacts are closed, shape [contact]; events passed; the divergence summed up along the way, NaN where it was not asked for.
    """

    state: Floats
    latch: Floats
    changes: Floats
    log: Floats
    closed: NDArray[np.bool_]
    events: int
    divergence: float


class Flow:
    """The motion of a case as a map of its state.

    A state holds, like the kernels', positions [m, rad] then velocities of every rotor, rotations relative to the nominal ones,
    then the integrals of servos. ``free`` are its entries that are not prescribed, ``natural`` the natural sizes of all,
    ``sizes`` those and of the latched impact speeds behind them.
    """

    def __init__(self, case: Case) -> None:
        self.case, self.packed = case, pack(case)
        rotors: Any = self.packed.system.rotors
        n = rotors.size
        moves, turns = rotors.inv_mass > 0.0, rotors.inv_inertia > 0.0
        of_rotor = np.stack([moves, moves, turns], axis=1).ravel()
        servos = np.ones(self.packed.state_size - 6 * n, dtype=bool)
        self.free = np.flatnonzero(np.concatenate([of_rotor, of_rotor, servos]))
        self.natural = np.array(self.packed.natural)
        self.size, self.sleeves = self.packed.state_size, self.packed.system.sleeves.size
        # A latched impact speed is of the size of a velocity.
        self.sizes = np.concatenate([self.natural, np.full(self.sleeves, self.natural[3 * n])])

    @property
    def free_names(self) -> list[str]:
        """Names of the free entries, ``rotor.signal``; integrals of servos have none."""
        names = state_names(self.packed)
        return [names[i] for i in self.free if i < len(names)]

    def start(self, member: int = 0) -> Floats:
        """Return the initial state of a member of the case's ensemble."""
        return initial_state(self.case, self.packed, member=member)

    def begin(
        self,
        state: Floats,
        *,
        latch: Floats | None = None,
        changes: Floats | None = None,
        divergence: bool = False,
        stop: threading.Event | None = None,
    ) -> "Course":
        """Return the motion from ``state`` at t = 0, to be followed piece by piece; once ``stop`` is set, no further.

        ``latch`` holds the impact speeds of sleeves that are in contact at the start, where known; ``changes``, shape
        [change, state + sleeve], small changes of both that are moved on to first order.
        """
        return Course(self, state, latch, changes, divergence, stop)

    def go(
        self,
        state: Floats,
        span: float,
        *,
        latch: Floats | None = None,
        changes: Floats | None = None,
        divergence: bool = False,
    ) -> Passage:
        """Follow the motion from ``state`` at t = 0 over ``span`` [s]; see `begin`.

        Raises `SimulationError` where the motion cannot be followed to the end.
        """
        course = self.begin(state, latch=latch, changes=changes, divergence=divergence)
        course.advance(span)
        return course.passage()


def prepare_tangent(case: Case) -> None:
    """Compile the kernels of the exact derivative, or load them from their cache: half a minute once after an installation."""
    flow = Flow(case)
    flow.go(flow.start(), 0.0, changes=np.zeros((1, flow.size + flow.sleeves)))


class Course:
    """A motion in progress. ``changes``, shape [change, state + sleeve], may be replaced in place between pieces."""

    def __init__(
        self,
        flow: Flow,
        state: Floats,
        latch: Floats | None,
        changes: Floats | None,
        divergence: bool,
        stop: threading.Event | None,
    ) -> None:
        packed, self.flow, self.stop = flow.packed, flow, stop
        self.most_steps = min(flow.case.run.max_steps or MOST_STEPS, MOST_STEPS)
        meshes, known = packed.system.meshes.copy(), packed.system.known_angles.copy()
        self.system = packed.system._replace(meshes=meshes, known_angles=known)
        self.motion = run_state.make_motion(
            self.system,
            state,
            packed.natural,
            packed.restart_step,
            packed.stops,
            np.zeros(0, dtype=np.int64),
            np.zeros((0, 0)),
            LOG_CAPACITY,
            flow.case.run.tolerance,
            flow.case.run.fixed_step,
        )
        if latch is not None:  # above the floor that means: not latched yet
            self.motion.latch[: flow.sleeves] = np.nextafter(latch, np.inf)
        rows = np.zeros((0, flow.size + flow.sleeves)) if changes is None else changes.copy()
        self.tangent = tangent.make_tangent(self.system, self.motion, rows, divergence=divergence)
        self.plain = changes is None and not divergence
        if not self.plain and flow.case.run.fixed_step is not None:
            raise InputError(
                Fault(
                    "run.fixed_step",
                    flow.case.run.fixed_step,
                    "must be absent where the derivative of the motion is wanted: it needs located contacts",
                    "Remove it",
                )
            )
        self.log: list[Floats] = []

    @property
    def changes(self) -> Floats:
        """The changes as they have moved on."""
        return self.tangent.changes

    @property
    def closed(self) -> NDArray[np.bool_]:
        """Which contacts are closed, shape [contact]: sleeves, then two flanks a mesh."""
        contacts = self.flow.sleeves + 2 * self.system.meshes.size
        return np.asarray(self.motion.modes[:contacts] != OPEN)

    @property
    def divergence(self) -> float:
        """The divergence [1] summed up so far; NaN where it was not asked for."""
        totals = self.tangent.totals
        return float(totals[0]) if totals[1] == 1.0 else float("nan")

    def advance(self, t_end: float) -> None:
        """Go on to t_end [s]; `SimulationError` where the motion cannot be followed so far."""
        motion = self.motion
        motion.clock[run_state.T_END] = t_end
        status: int = Status.PAUSED
        while status == Status.PAUSED:
            steps = max(0, min(CHUNK_STEPS, self.most_steps - int(motion.counts[run_state.STEPS])))
            if self.plain:
                status = stepper.advance(self.system, motion, steps)
            else:
                status = tangent.advance_tangent(self.system, motion, self.tangent, steps)
            self.log.append(motion.log[: int(motion.counts[run_state.LOGGED])].copy())
            motion.counts[run_state.LOGGED] = 0
            if status == Status.PAUSED and self.stop is not None and self.stop.is_set():
                status = Status.INTERRUPTED
            if status == Status.PAUSED and motion.counts[run_state.STEPS] >= self.most_steps:
                status = Status.TOO_MANY_STEPS
        if status != Status.DONE:
            at = float(motion.clock[run_state.T])
            raise SimulationError(f"flow: {WORDS[Status(status)]} Stopped at t = {at:.9g} s.")

    @property
    def time(self) -> float:
        """Where the motion is now [s]."""
        return float(self.motion.clock[run_state.T])

    @property
    def state(self) -> Floats:
        """The state now, shape [state]: a view that changes with the motion."""
        return self.motion.y

    def advance_to_change(self, t_end: float) -> Floats:
        """Go on to the end of the first step with a contact change, at most to t_end [s].

        Returns the changes there as rows (t, contact, 1 onset / 0 release, rate), none at t_end. The motion is that of `advance`.
        """
        motion = self.motion
        motion.clock[run_state.T_END] = t_end
        while True:
            status = stepper.advance(self.system, motion, 1)
            logged = int(motion.counts[run_state.LOGGED])
            rows = motion.log[:logged].copy()
            motion.counts[run_state.LOGGED] = 0
            if status not in (Status.DONE, Status.PAUSED):
                raise SimulationError(f"flow: {WORDS[Status(status)]} Stopped at t = {self.time:.9g} s.")
            if logged or status == Status.DONE:
                stepper.synchronise(self.system, motion)
                return rows

    def passage(self) -> Passage:
        """Return where the motion is now."""
        return Passage(
            state=self.motion.y.copy(),
            latch=self.motion.latch[: self.flow.sleeves].copy(),
            changes=self.changes.copy(),
            log=np.concatenate(self.log) if self.log else np.zeros((0, 4)),
            closed=self.closed,
            events=int(self.motion.counts[run_state.EVENTS]),
            divergence=self.divergence,
        )
