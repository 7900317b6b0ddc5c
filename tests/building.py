"""Builders shared by the tests: cases as plain dictionaries, their kernels, their energy and momentum."""

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import run_state, stepper
from gearplay.kernels.layout import LOADED, MARGIN, OUT_SIZE, System, mode_count
from gearplay.kernels.mesh import mesh_geometry, mesh_stiffness
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.roster import make_roster
from gearplay.kernels.sleeve import sleeve_geometry
from gearplay.model.case import Case
from gearplay.model.initial import initial_state
from gearplay.model.pack import Packed, pack
from gearplay.solver.simulate import run_members
from gearplay.solver.trajectory import Trajectory

Floats = NDArray[np.float64]
Document = dict[str, Any]
Measured = Callable[[str, float, str], None]

ALPHA = math.radians(20.0)


def merged(base: Document, changes: Document) -> Document:
    """Return a deep copy of ``base`` with nested ``changes``; a value of None removes its key."""
    result = copy.deepcopy(base)
    for key, value in changes.items():
        if value is None:
            result.pop(key, None)
        elif isinstance(value, dict) and isinstance(result.get(key), dict):
            result[key] = merged(result[key], value)
        else:
            result[key] = copy.deepcopy(value)
    return result


def pair_document(kind: str = "internal", mesh: Document | None = None, **changes: Any) -> Document:
    """Return an undamped, undriven pair 20/60 of module 4 mm with a sleeve each and constant stiffness."""
    wheel = "ring" if kind == "internal" else "wheel"
    sleeve = {
        "radial_clearance": 100e-6,
        "law": "hunt-crossley",
        "stiffness": 1e10,
        "exponent": 1.5,
        "restitution": 1.0,
    }
    base: Document = {
        "rotors": {
            "pinion": {"teeth": 20, "mass": 0.235, "inertia": 1.88e-4},
            wheel: {"teeth": 60, "internal": kind == "internal", "mass": 0.8, "inertia": 9.0e-3},
        },
        "sleeves": {"pinion": dict(sleeve), wheel: dict(sleeve)},
        "meshes": [
            merged(
                {
                    "driver": "pinion",
                    "driven": wheel,
                    "module": 4e-3,
                    "pressure_angle": ALPHA,
                    "backlash": 100e-6,
                    "stiffness": {"kind": "harmonic", "mean": 1.3e8},
                },
                mesh or {},
            )
        ],
        "run": {"duration": 0.01, "sampling": 1e5, "tolerance": 1e-10},
    }
    if mesh and "stiffness" in mesh:
        base["meshes"][0]["stiffness"] = copy.deepcopy(mesh["stiffness"])
    return merged(base, changes)


def case_of(document: Document) -> Case:
    """Validate a document of SI numbers."""
    return Case.model_validate(document)


def pair_case(kind: str = "internal", mesh: Document | None = None, **changes: Any) -> Case:
    """Return `pair_document` as a case."""
    return case_of(pair_document(kind, mesh, **changes))


def floating_document(kind: str = "internal", mesh: Document | None = None, **changes: Any) -> Document:
    """Return a pair without sleeves, both gears free in the plane."""
    document = pair_document(kind, mesh, **changes)
    document["sleeves"] = {}
    for rotor in document["rotors"].values():
        rotor["floating"] = True
    return document


def single_rotor_document(sleeve: Document, **rotor: Any) -> Document:
    """Return one disc in one sleeve, no gears."""
    return {
        "rotors": {"disc": merged({"mass": 0.5, "inertia": 1e-4}, rotor)},
        "sleeves": {"disc": sleeve},
        "run": {"duration": 0.01, "sampling": 1e5, "tolerance": 1e-11},
    }


def simulate_one(
    document: Document, member: int = 0, signals: list[str] | None = None, **policy: Any
) -> Trajectory:
    """Simulate one member of a document; fail the test where the run fails."""
    trajectory = run_members(case_of(document), [member], signals=signals, **policy)[0]
    assert trajectory.success, trajectory.message
    return trajectory


def free_pair_case(kind: str, model: str, seed: int) -> Document:
    """Return an undamped free pair that rattles: random positions, velocities and spins from ``seed``."""
    rng = np.random.default_rng([17, seed])
    document = pair_document(kind, backlash_model=model)
    arms = {"pinion": 0.04, "ring": 0.12, "wheel": 0.12}
    for name, rotor in document["rotors"].items():
        angle, radius = 2.0 * math.pi * rng.random(), 8e-5 * math.sqrt(rng.random())
        v_x, v_y, spin = 0.05 * rng.standard_normal(3)
        rotor["initial"] = {
            "x": radius * math.cos(angle),
            "y": radius * math.sin(angle),
            "vx": v_x,
            "vy": v_y,
            "omega": spin / arms[name],
        }
    return document


class Instant:
    """Forces and energies of a packed system at one state, with every overlapping contact loaded."""

    def __init__(self, packed: Packed) -> None:
        self.system: System = packed.system
        n_c = packed.system.sleeves.size + 2 * packed.system.meshes.size
        self.contacts, self.force, self.out = (
            np.zeros((n_c, 6)),
            np.zeros((packed.system.rotors.size, 3)),
            np.zeros(OUT_SIZE),
        )
        self.modes = np.zeros(mode_count(packed.system), dtype=np.int64)
        self.roster = make_roster(packed.system, packed.state_size)  # everyone takes part
        self.latch = np.ones(packed.system.sleeves.size)
        self.dy = np.zeros(packed.state_size)

    def generalised_forces(self, t: float, y: Floats) -> Floats:
        """Return all forces and torques [N, N m], shape [3 rotor]."""
        args = (
            self.system,
            self.roster,
            t,
            y,
            self.modes,
            self.latch,
            self.dy,
            self.contacts,
            self.force,
            self.out,
        )
        self.modes[: len(self.contacts)] = 0
        assert right_hand_side(*args) == 0
        self.modes[: len(self.contacts)] = np.where(self.contacts[:, 0] > 0.0, LOADED, 0)
        assert right_hand_side(*args) == 0
        assert np.all(self.contacts[: self.system.sleeves.size, MARGIN] > 0.0)
        return self.force.ravel().copy()

    def potential(self, t: float, y: Floats) -> float:
        """Return the elastic energy [J] of all point contacts, written apart from the forces."""
        total = 0.0
        for sleeve in self.system.sleeves:
            sleeve_geometry(sleeve, self.system, t, y, self.out)
            total += (
                sleeve.stiffness / (sleeve.exponent + 1.0) * max(self.out[0], 0.0) ** (sleeve.exponent + 1.0)
            )
        for j, mesh in enumerate(self.system.meshes):
            assert mesh_geometry(self.system, j, t, y, self.out) == 0
            psi = self.out[12]
            k = mesh_stiffness(mesh, self.system, psi, np.cos(psi), np.sin(psi), 0)
            total += 0.5 * k * sum(max(p, 0.0) ** 2 for p in self.out[:2])
        return total

    def kinetic(self, y: Floats) -> float:
        """Return the kinetic energy [J]."""
        n = self.system.rotors.size
        v = y[3 * n : 6 * n].reshape(n, 3).copy()
        v[:, 2] += self.system.rotors.nominal_speed
        return 0.5 * float(
            np.sum(self.system.rotors.mass * (v[:, 0] ** 2 + v[:, 1] ** 2))
            + np.sum(self.system.rotors.inertia * v[:, 2] ** 2)
        )

    def energy(self, t: float, y: Floats) -> float:
        """Return the total energy [J]."""
        return self.kinetic(y) + self.potential(t, y)


def motion_of(case: Case, packed: Packed, member: int = 0, **changes: Any) -> run_state.Motion:
    """Return a run at t = 0 that keeps no samples, ready for `stepper.advance`."""
    start = changes.pop("start", None)
    motion = run_state.make_motion(
        packed.system,
        initial_state(case, packed, member=member) if start is None else start,
        packed.natural,
        packed.restart_step,
        packed.stops,
        np.zeros(0, dtype=np.int64),
        np.empty((0, 0)),
        changes.pop("log_capacity", 4096),
        changes.pop("tolerance", case.run.tolerance),
    )
    assert not changes
    assert stepper.begin(packed.system, motion) == run_state.DONE
    return motion


def states_along(
    document: Document, times: Floats, member: int = 0
) -> tuple[Packed, Floats, run_state.Motion]:
    """Return the states at given times, exactly at step ends, shape [time, state]."""
    case = case_of(document)
    packed = pack(case)
    motion = motion_of(case, packed, member, log_capacity=100_000)
    states = []
    for t in times:
        motion.clock[run_state.T_END] = t
        status = stepper.advance(packed.system, motion, 10_000_000)
        assert status == run_state.DONE, status
        states.append(motion.y.copy())
    return packed, np.array(states), motion
