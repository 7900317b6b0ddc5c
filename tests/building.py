"""Builders shared by the tests: cases as plain dictionaries, their kernels, their energy and momentum."""

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import run as kernel
from gearplay.integrate import stepper
from gearplay.integrate.active_set import make_active_set
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.switches import make_branch
from gearplay.kernels.layout import OUT_SIZE
from gearplay.model.case import Case
from gearplay.model.initial import initial_state
from gearplay.model.pack import Packed, pack
from gearplay.parts.mesh.geometry import P_B, P_D, PSI, mesh_geometry
from gearplay.parts.mesh.tooth_stiffness import mesh_stiffness
from gearplay.parts.registry import MESH, SLEEVE
from gearplay.parts.sleeve.law import DELTA, sleeve_geometry
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


def dynamic_backlash(A: float, A0: float, alpha0: float, b0: float, s: float) -> float:
    """Return b_t = b0 - 2 s c0 (inv alpha_w - inv alpha0) [m] at centre distance A [m], theory T3; s = 1 internal, -1 else."""
    c0 = A0 * math.cos(alpha0)
    alpha_w = math.acos(c0 / A)
    return b0 - 2.0 * s * c0 * ((math.tan(alpha_w) - alpha_w) - (math.tan(alpha0) - alpha0))


def mesh_at(packed: Packed, j: int, y: Floats, t: float = 0.0) -> Floats:
    """Return the kinematics of mesh j (slots: `kernels.mesh_geometry`); fail the test where it cannot mesh."""
    out, memory = np.zeros(OUT_SIZE), make_branch(packed.system).memory
    assert mesh_geometry(packed.system, j, t, y, memory, out) == 0
    return out


def sleeve_at(packed: Packed, k: int, y: Floats, t: float = 0.0) -> Floats:
    """Return the kinematics of sleeve k (slots: `gearplay.parts.sleeve.law`)."""
    out = np.zeros(OUT_SIZE)
    sleeve_geometry(packed.system, k, t, y, out)
    return out


class Instant:
    """Forces and energies of a packed system at one state, with every overlapping contact loaded."""

    def __init__(self, packed: Packed) -> None:
        self.packed, self.system = packed, packed.system
        self.loads, self.branch = make_loads(packed.system), make_branch(packed.system)
        self.active_set = make_active_set(packed.system, packed.state_size)  # everyone takes part
        self.branch.impact_speeds[:] = 1.0
        self.dy = np.zeros(packed.state_size)

    @property
    def contacts(self) -> Floats:
        """The contact table, shape [contact, column]."""
        return self.loads.contacts

    def potential(self, t: float, y: Floats) -> float:
        """Return the elastic energy [J] of all point contacts, written apart from the forces."""
        total = 0.0
        for k, sleeve in enumerate(self.system.records[SLEEVE]):
            depth = max(sleeve_at(self.packed, k, y, t)[DELTA], 0.0)
            total += sleeve.stiffness / (sleeve.exponent + 1.0) * depth ** (sleeve.exponent + 1.0)
        for j, mesh in enumerate(self.system.records[MESH]):
            out = mesh_at(self.packed, j, y, t)
            psi = out[PSI]
            k = mesh_stiffness(mesh, self.system, psi, np.cos(psi), np.sin(psi), 0)
            total += 0.5 * k * sum(max(p, 0.0) ** 2 for p in (out[P_D], out[P_B]))
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


def run_of(case: Case, packed: Packed, member: int = 0, **changes: Any) -> kernel.Run:
    """Return a run at t = 0 that keeps no samples, ready for `stepper.advance`."""
    start = changes.pop("start", None)
    run = kernel.make_run(
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
    assert stepper.begin(packed.system, run) == kernel.DONE
    return run


def states_along(document: Document, times: Floats, member: int = 0) -> tuple[Packed, Floats, kernel.Run]:
    """Return the states at given times, exactly at step ends, shape [time, state]."""
    case = case_of(document)
    packed = pack(case)
    run = run_of(case, packed, member, log_capacity=100_000)
    states = []
    for t in times:
        run.clock[kernel.T_END] = t
        status = stepper.advance(packed.system, run, 10_000_000)
        assert status == kernel.DONE, status
        states.append(run.y.copy())
    return packed, np.array(states), run


def forum_pair(damping: Document, **run: Any) -> Document:
    """Return a loaded pair whose tooth error, 20 um, throws it across its backlash of 9 um.

    From a public question about gears of 62 and 42 teeth; with a ratio of 0.2 and a depth of 1 um an independent DOP853 finds
    peaks of 2011.1 N and 1917.6 N.
    """
    return {
        "rotors": {
            "g": {
                "teeth": 62,
                "mass": 11.8,
                "inertia": 0.024173,
                "drive": {"kind": "torque", "torque": 7.6469},
                "initial": {"omega": 523.5987755983, "theta": 0.0},
            },
            "p": {
                "teeth": 42,
                "mass": 5.36,
                "inertia": 0.011093,
                "load": {"torque": 5.1801},
                "initial": {"omega": -772.9315258832, "theta": 0.0},
            },
        },
        "meshes": [
            {
                "driver": "g",
                "driven": "p",
                "module": 2.5e-3,
                "backlash": 9e-6,
                "stiffness": {"kind": "harmonic", "mean": 2.3426e7},
                "damping": damping,
                "transmission_error": [{"order": 1, "amplitude": 2e-5}],
            }
        ],
        "run": {"duration": 5e-3, "sampling": 2e5, **run},
    }
