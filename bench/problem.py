"""The initial-value problems that every solver of the benchmark gets, with exact answers and one common right-hand side.

Peers see each contact's branch chosen by the state alone. The sleeve's restitution is 1, so that the impact speed, which
they cannot impact_speeds, plays no part; everything else is the bundled case at 120 rpm.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

import gearplay as gp
from gearplay.integrate import run as kernel
from gearplay.integrate import stepper
from gearplay.integrate.active_set import add, make_active_set
from gearplay.integrate.right_hand_side import make_loads, right_hand_side
from gearplay.integrate.switches import make_branch
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import FORCE, LOADED, OPEN
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from gearplay.parts.mesh.geometry import P_B, P_D, mesh_geometry
from gearplay.parts.registry import MESH, SLEEVE
from gearplay.parts.sleeve.law import DELTA, sleeve_geometry

STATES = 12  # x, y, theta of pinion and ring, then their rates


@compiled_inline
def decide(system, active_set, t, y, branch, out):
    """Choose every contact's branch by the state alone; list the elements that touch."""
    modes, sleeves, meshes = branch.modes, system.records[SLEEVE], system.records[MESH]
    active_set.acting[0] = 0
    for n in range(sleeves.size):
        sleeve_geometry(system, n, t, y, out)
        modes[sleeves[n].contact] = LOADED if out[DELTA] > 0.0 else OPEN
        if out[DELTA] > 0.0 or system.elements[sleeves[n].element].always == 1:
            add(active_set.acting, sleeves[n].element)
    for n in range(meshes.size):
        if mesh_geometry(system, n, t, y, branch.memory, out) != 0:
            return 1
        for flank in range(2):
            modes[meshes[n].contact + flank] = LOADED if out[P_D + flank] > 0.0 else OPEN
            modes[meshes[n].mode + flank] = (
                1 if out[P_D + flank] >= meshes[n].depth else 0
            )  # past the damping ramp
        if out[P_D] > 0.0 or out[P_B] > 0.0:
            add(active_set.acting, meshes[n].element)
    for e in range(system.elements.size):
        element = system.elements[e]
        if element.kind != SLEEVE and element.kind != MESH and element.always == 1:
            add(active_set.acting, e)
    return 0


@compiled_inline
def derivative(system, active_set, branch, loads, t, y, dy):
    """Fill dy = f(t, y) without any memory of contacts; NaN where the pair cannot mesh. The peers' right-hand side."""
    if decide(system, active_set, t, y, branch, loads.out) != 0:
        for i in range(dy.size):
            dy[i] = np.nan
        return
    right_hand_side(system, active_set, t, y, branch, dy, loads)
    pulled, modes, meshes = False, branch.modes, system.records[MESH]
    for n in range(meshes.size):
        for k in range(meshes[n].contact, meshes[n].contact + 2):
            if modes[k] == LOADED and loads.contacts[k, FORCE] < 0.0:
                modes[k] = OPEN
                pulled = True
    if pulled:  # damping would pull: no force, as in (17)
        right_hand_side(system, active_set, t, y, branch, dy, loads)


def spread(ratios):
    """Return the least and the largest of some ratios in words, as "2.2 to 13" times."""
    return " to ".join(
        f"{ratio:.1f}" if ratio < 9.95 else f"{ratio:.0f}" for ratio in (min(ratios), max(ratios))
    )


@dataclass(frozen=True, eq=False)
class Problem:
    """One span of motion from given states."""

    name: str
    case: gp.Case
    span: float  # s
    members: tuple[int, ...]
    begin: float = 0.0  # s

    @cached_property
    def packed(self):
        """Return the packed case."""
        return pack(self.case)

    def start(self, member):
        """Return the initial state."""
        return initial_state(self.case, self.packed, member=member)

    def arguments(self):
        """Return fresh leading arguments of `derivative`: (system, active_set, branch, loads)."""
        system = self.packed.system
        branch = make_branch(system)
        branch.impact_speeds[:] = 1.0
        return system, make_active_set(system, self.packed.state_size), branch, make_loads(system)

    def run(self, member, tolerance):
        """Return our own run at its start."""
        p = self.packed
        return kernel.make_run(
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
        run = self.run(member, tolerance)
        self.finish(run)
        return run.y.copy(), run

    def finish(self, run):
        """Advance our own run to its end."""
        run.clock[kernel.T_END] = self.span
        while stepper.advance(self.packed.system, run, 10**9) == kernel.PAUSED:
            run.counts[kernel.LOGGED] = 0

    @lru_cache  # noqa: B019 - a handful of problems live as long as the program
    def answer(self, member):
        """Return the final state at tolerance 1e-13."""
        return self.ours(member, 1e-13)[0]

    def error(self, member, y):
        """Return the largest error [m] of displacements and of rotations times the base radius."""
        lengths = np.array([1.0, 1.0, 0.0376, 1.0, 1.0, 0.1128])
        return float(np.max(np.abs(np.asarray(y)[:6] - self.answer(member)[:6]) * lengths))


BASE = gp.replace(gp.load_case("han2021"), {"sleeves.ring.restitution": 1.0, "run.transient": 0.0})
LIVELY = Problem("rattling", gp.replace(BASE, {"rotors.ring.initial.vx": 0.05}), 0.02, (1, 2, 3, 4, 5))
QUIET = Problem("quiet", BASE, 0.1, (1, 2, 3, 4, 5))
