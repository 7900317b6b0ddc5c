"""The flow of a case: from a state to a later one, with its exact derivative where that is wanted."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import run_state, stepper, tangent
from gearplay.kernels.layout import DRIVE_SPEED, OPEN
from gearplay.model.case import Case
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from gearplay.solver.status import WORDS, Status
from gearplay.vocabulary.errors import SimulationError

Floats = NDArray[np.float64]
CHUNK_STEPS, LOG_CAPACITY = 20_000, 16_384


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
    then the integrals of servos. ``free`` are its entries that are not prescribed, ``natural`` their natural sizes.
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
        self.prescribed = bool(np.any(rotors.drive == DRIVE_SPEED))

    def start(self, member: int = 0) -> Floats:
        """Return the initial state of a member of the case's ensemble."""
        return initial_state(self.case, self.packed, member=member)

    def go(
        self,
        state: Floats,
        span: float,
        *,
        latch: Floats | None = None,
        changes: Floats | None = None,
        divergence: bool = False,
    ) -> Passage:
        """Follow the motion from ``state`` at t = 0 over ``span`` [s].

        ``latch`` holds the impact speeds of sleeves that are in contact at the start, where known; ``changes``, shape
        [change, state + sleeve], small changes of both that are moved on to first order.

        Raises `SimulationError` where the motion cannot be followed to the end.
        """
        packed = self.packed
        meshes, known = packed.system.meshes.copy(), packed.system.known_angles.copy()
        system = packed.system._replace(meshes=meshes, known_angles=known)
        motion = run_state.make_motion(
            system,
            state,
            packed.natural,
            packed.restart_step,
            packed.stops,
            np.zeros(0, dtype=np.int64),
            np.zeros((0, 0)),
            LOG_CAPACITY,
            self.case.run.tolerance,
        )
        if latch is not None:
            motion.latch[: self.sleeves] = np.nextafter(latch, np.inf)
        rows = np.zeros((0, self.size + self.sleeves)) if changes is None else changes
        moved = tangent.make_tangent(system, motion, rows.copy(), divergence=divergence)
        motion.clock[run_state.T_END] = span
        log: list[Floats] = []
        plain = changes is None and not divergence
        while True:
            if plain:
                status = stepper.advance(system, motion, CHUNK_STEPS)
            else:
                status = tangent.advance_tangent(system, motion, moved, CHUNK_STEPS)
            logged = int(motion.counts[run_state.LOGGED])
            log.append(motion.log[:logged].copy())
            motion.counts[run_state.LOGGED] = 0
            if status == Status.PAUSED:
                continue
            if status != Status.DONE:
                at = float(motion.clock[run_state.T])
                raise SimulationError(f"flow: {WORDS[Status(status)]} Stopped at t = {at:.9g} s.")
            break
        contacts = self.sleeves + 2 * system.meshes.size
        return Passage(
            state=motion.y.copy(),
            latch=motion.latch[: self.sleeves].copy(),
            changes=moved.changes,
            log=np.concatenate(log),
            closed=motion.modes[:contacts] != OPEN,
            events=int(motion.counts[run_state.EVENTS]),
            divergence=float(moved.totals[0]) if divergence else float("nan"),
        )
