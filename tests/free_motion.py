"""Dense looks into flights: does a touch come before the one that was found?"""

import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from building import Document, case_of, run_of
from gearplay.integrate import run as kernel
from gearplay.integrate import stepper
from gearplay.integrate.active_set import state_of
from gearplay.integrate.dispatch import contact_kinematics
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.run import Run
from gearplay.kernels.compiled import INTERPRETED
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import PENETRATION, Loads, System
from gearplay.model.pack import pack
from small_library import load_small

LOOKS = 1500  # at each flight


@compiled_once
def deepest_unseen(system: System, motion: Run, t_0: float, t_1: float, looks: int, loads: Loads) -> float:
    """Return the largest gap function [m] of all contacts, dense looks within (t_0, t_1), while every rotor flies."""
    deepest = -1.0
    y = motion.y_try
    for s in range(1, looks):
        # half of the looks crowd towards the end, where a miss would be
        share = s / looks if s % 2 == 0 else 1.0 - (1.0 - s / looks) ** 6
        t = t_0 + share * (t_1 - t_0)
        for i in range(system.rotors.size):
            state_of(system, motion.active_set, i, t, motion.y, y)
        for e in range(system.elements.size):
            contact_kinematics(system, e, t, y, motion.branch, loads)
        for c in range(loads.contacts.shape[0]):
            deepest = max(deepest, loads.contacts[c, PENETRATION])
    return deepest


@cache
def load_deepest_unseen() -> None:
    """Build the library of the kernel above."""
    if not INTERPRETED:
        load_small(Path(tempfile.mkdtemp()), deepest_unseen)


def oversights(documents: Iterator[Document], wanted: int) -> tuple[float, int]:
    """Return the deepest touch [m] that dense looks see in so many flights, and how many flights end within 1 nm of one."""
    load_deepest_unseen()
    flights, grazing = 0, 0
    worst = -1.0
    while flights < wanted:
        document = next(documents)
        case = case_of(document)
        packed = pack(case)
        motion = run_of(case, packed, member=1)
        motion.clock[kernel.T_END] = 0.3
        for _ in range(4000):
            flying, t_0 = motion.active_set.active[0] == 0, float(motion.clock[kernel.T])
            active_set = motion.active_set
            flight = (active_set.body_states, active_set.since, active_set.origin, active_set.modal_rates)
            before = [array.copy() for array in flight]
            status = stepper.advance(packed.system, motion, 1)
            t_1 = float(motion.clock[kernel.T])
            if flying:
                after = [array.copy() for array in flight]
                for array, kept in zip(flight, before, strict=True):
                    array[:] = kept
                deepest = deepest_unseen(packed.system, motion, t_0, t_1, LOOKS, make_loads(packed.system))
                for array, kept in zip(flight, after, strict=True):
                    array[:] = kept
                worst = max(worst, deepest)
                grazing += deepest > -1e-9
                flights += 1
            if status != kernel.PAUSED or flights >= wanted:
                break
    return worst, grazing
