"""The initial-value problems that every solver of the benchmark gets, with exact answers and one common right-hand side.

Peers see each contact's branch chosen by the state alone. The sleeve's restitution is 1, so that the impact speed, which
they cannot latch, plays no part; everything else is the bundled case at 120 rpm.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from gearplay.kernels.mesh import mesh_geometry
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.sleeve import sleeve_geometry

import gearplay as gp
from gearplay.kernels import run_state, stepper
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import FORCE, LOADED, OPEN, OUT_SIZE, mode_count
from gearplay.kernels.roster import make_roster
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack

STATES = 12  # x, y, theta of pinion and ring, then their rates


@compiled_inline
def decide(system, roster, t, y, modes, out):
    """Choose every contact's branch by the state alone; list the elements that touch."""
    n_s = system.sleeves.size
    roster.sleeves[0] = roster.meshes[0] = 0
    for k in range(n_s):
        sleeve_geometry(system.sleeves[k], system, t, y, out)
        modes[k] = LOADED if out[0] > 0.0 else OPEN
        if out[0] > 0.0:
            roster.sleeves[0] += 1
            roster.sleeves[roster.sleeves[0]] = k
    for j in range(system.meshes.size):
        if mesh_geometry(system, j, t, y, out) != 0:
            return 1
        for flank in range(2):
            modes[n_s + 2 * j + flank] = LOADED if out[flank] > 0.0 else OPEN
            past = out[flank] >= system.meshes[j].depth  # the end of the damping ramp
            modes[n_s + 2 * system.meshes.size + 2 * j + flank] = 1 if past else 0
        if out[0] > 0.0 or out[1] > 0.0:
            roster.meshes[0] += 1
            roster.meshes[roster.meshes[0]] = j
    return 0


@compiled_inline
def derivative(system, roster, modes, latch, contacts, force, out, t, y, dy):
    """Fill dy = f(t, y) without any memory of contacts; NaN where the pair cannot mesh. The peers' right-hand side."""
    if decide(system, roster, t, y, modes, out) != 0:
        for i in range(dy.size):
            dy[i] = np.nan
        return
    right_hand_side(system, roster, t, y, modes, latch, dy, contacts, force, out)
    pulled = False
    for c in range(1, roster.meshes[0] + 1):
        for row in range(
            system.sleeves.size + 2 * roster.meshes[c], system.sleeves.size + 2 * roster.meshes[c] + 2
        ):
            if modes[row] == LOADED and contacts[row, FORCE] < 0.0:
                modes[row] = OPEN
                pulled = True
    if pulled:  # damping would pull: no force, as in (17)
        right_hand_side(system, roster, t, y, modes, latch, dy, contacts, force, out)


@dataclass(frozen=True, eq=False)
class Problem:
    """One span of motion from given states."""

    name: str
    case: gp.Case
    span: float  # s, from t = 0
    members: tuple[int, ...]

    @cached_property
    def packed(self):
        """Return the packed case."""
        return pack(self.case)

    def start(self, member):
        """Return the initial state."""
        return initial_state(self.case, self.packed, member=member)

    def arguments(self):
        """Return fresh leading arguments of `derivative`: (system, roster, modes, latch, contacts, force, out)."""
        system = self.packed.system
        n_c = system.sleeves.size + 2 * system.meshes.size
        return (
            system,
            make_roster(system, self.packed.state_size),
            np.zeros(mode_count(system), dtype=np.int64),
            np.ones(system.sleeves.size),
            np.zeros((n_c, 6)),
            np.zeros((system.rotors.size, 3)),
            np.zeros(OUT_SIZE),
        )

    def motion(self, member, tolerance):
        """Return our own run at its start."""
        p = self.packed
        return run_state.make_motion(
            p.system,
            self.start(member),
            p.natural,
            p.restart_step,
            p.stops,
            np.arange(0),
            np.empty((0, 0)),
            4096,
            tolerance,
        )

    def ours(self, member, tolerance):
        """Return our final state and the run."""
        motion = self.motion(member, tolerance)
        self.finish(motion)
        return motion.y.copy(), motion

    def finish(self, motion):
        """Advance our own run to its end."""
        motion.clock[run_state.T_END] = self.span
        while stepper.advance(self.packed.system, motion, 10**9) == run_state.PAUSED:
            motion.counts[run_state.LOGGED] = 0

    @lru_cache  # noqa: B019 - a handful of problems live as long as the program
    def answer(self, member):
        """Return the final state at tolerance 1e-13."""
        return self.ours(member, 1e-13)[0]

    def error(self, member, y):
        """Return the largest error [m] of displacements and of rotations times the base radius."""
        lengths = np.array([1.0, 1.0, 0.0376, 1.0, 1.0, 0.1128])
        return float(np.max(np.abs(np.asarray(y)[:6] - self.answer(member)[:6]) * lengths))


BASE = gp.replace(gp.load_case("han2021"), {"sleeves.ring.restitution": 1.0, "run.transient": 0.0})
LIVELY = Problem("lively", gp.replace(BASE, {"rotors.ring.initial.vx": 0.05}), 0.02, (1, 2, 3, 4, 5))
QUIET = Problem("quiet", BASE, 0.1, (1, 2, 3, 4, 5))
