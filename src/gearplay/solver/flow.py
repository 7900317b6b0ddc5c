"""The flow map of a case: from a state to a later one, with its exact derivative on request."""

import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.run import EVENTS
from gearplay.model.case import Case
from gearplay.model.initial import member_state
from gearplay.model.pack import pack
from gearplay.solver.frames import CarrierFrames
from gearplay.solver.integration import Course
from gearplay.solver.observables import state_names

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Passage:
    """Result of the flow map: state, shape [state], and stored impact speeds [m/s], shape [impact speed]; propagated changes,
    shape [change, state + impact speed]; contact changes on the way (t, contact, 1 onset / 0 release, rate), shape [change, 4];
    closed contacts, shape [contact]; number of events; integral of the divergence, NaN unless requested.
    """

    state: Floats
    impact_speeds: Floats
    changes: Floats
    log: Floats
    closed: NDArray[np.bool_]
    events: int
    divergence: float


class Flow:
    """The motion of a case as a map of its state.

    A state holds, like the kernels', positions [m, rad] then velocities of every rotor, rotations relative to the nominal ones,
    then the integrals of servos. ``free`` are its entries that are not prescribed, ``natural`` the natural sizes of all,
    ``sizes`` those and of the stored impact speeds behind them; ``impact_contacts`` the contacts that store one, shape
    [impact speed]; ``frames`` the rotating carriers as frames of sections.
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
        self.size = self.packed.state_size
        self.impact_contacts = np.flatnonzero(self.packed.system.contacts["impact_slot"] >= 0)
        self.impact_count = len(self.impact_contacts)
        self.frames = CarrierFrames(self.packed.system)
        # A stored impact speed is of the size of a velocity.
        self.sizes = np.concatenate([self.natural, np.full(self.impact_count, self.natural[3 * n])])

    @property
    def free_names(self) -> list[str]:
        """Names of the free entries, ``rotor.signal``; integrals of servos have none."""
        names = state_names(self.packed)
        return [names[i] for i in self.free if i < len(names)]

    def start(self, member: int = 0) -> Floats:
        """Return the initial state of a member of the case's ensemble."""
        return member_state(self.case, self.packed, member)

    def seen(self, t: float, state: Floats) -> Floats:
        """Return the free entries of a state at t [s], centres of planetary sets in the frames of their carriers."""
        found: Floats = self.frames.seen(t, state)[self.free]
        return found

    def begin(
        self,
        state: Floats,
        *,
        impact_speeds: Floats | None = None,
        changes: Floats | None = None,
        divergence: bool = False,
        stop: threading.Event | None = None,
    ) -> Course:
        """Return the integration from ``state`` at t = 0, to be advanced in chunks; it ends once ``stop`` is set.

        ``impact_speeds`` holds the impact speeds of contacts that are closed at the start, where known; ``changes``, shape
        [change, state + impact speed], small changes of both that are moved on to first order.
        """
        course = Course(self.case, self.packed, state, changes=changes, divergence=divergence, stop=stop)
        if impact_speeds is not None:
            course.set_impact_speeds(impact_speeds)
        return course

    def go(
        self,
        state: Floats,
        span: float,
        *,
        impact_speeds: Floats | None = None,
        changes: Floats | None = None,
        divergence: bool = False,
    ) -> Passage:
        """Follow the motion from ``state`` at t = 0 over ``span`` [s]; see `begin`.

        Raises `SimulationError` where the motion cannot be followed to the end.
        """
        course = self.begin(state, impact_speeds=impact_speeds, changes=changes, divergence=divergence)
        course.advance(span)
        return Passage(
            state=course.state.copy(),
            impact_speeds=course.impact_speeds.copy(),
            changes=course.changes.copy(),
            log=course.whole_log,
            closed=course.closed,
            events=int(course.run.counts[EVENTS]),
            divergence=course.divergence,
        )
