"""Initial states: as given, the rest kinematically matching; ensemble members differ by a seeded draw."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.elements.table import MESH
from gearplay.kernels.layout import OUT_SIZE
from gearplay.kernels.mesh_geometry import B_T, P_D, mesh_geometry
from gearplay.kernels.switches import make_branch
from gearplay.model import geometry
from gearplay.model.pack import Packed
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case

Floats = NDArray[np.float64]

SPREAD_OF_SPEED = 1e-3  # m/s, standard deviation of a member's initial velocity in its sleeve
SHARE_OF_CLEARANCE = 0.9  # members start anywhere within this share of the clearance circle


def _given_state(case: "Case", packed: Packed) -> Floats:
    """Return the state with every given value set and the others matching."""
    n, speeds = len(case.rotors), geometry.nominal_speeds(case)
    centres, names = geometry.centres(case), list(case.rotors)
    actual = geometry.starting_speeds(case)
    y = np.zeros(packed.state_size)
    for i, (name, rotor) in enumerate(case.rotors.items()):
        start = rotor.initial
        v_x, v_y = start.vx, start.vy
        carrier = geometry.carrier_of(case, name)
        if carrier is not None:
            spin = actual[names.index(carrier)]
            v_x -= spin * (centres[name][1] - centres[carrier][1])
            v_y += spin * (centres[name][0] - centres[carrier][0])
        y[3 * i : 3 * i + 3] = start.x, start.y, start.theta or 0.0
        omega = start.omega if start.omega is not None else actual[i]
        if rotor.drive is not None and rotor.drive.kind == "speed" and rotor.drive.ripple:
            swing = sum(term.amplitude * math.sin(term.phase) for term in rotor.drive.ripple)
            omega = speeds[i] * (1.0 + swing)
        y[3 * (n + i) : 3 * (n + i) + 3] = v_x, v_y, omega - speeds[i]
    return y


def _mesh_at(packed: Packed, j: int, y: Floats) -> tuple[float, float]:
    """Return (p_d, b_t) [m] of mesh j at state y and t = 0; NaN where it cannot mesh."""
    out, e = np.zeros(OUT_SIZE), int(np.flatnonzero(packed.system.elements["kind"] == MESH)[j])
    if mesh_geometry(packed.system, e, 0.0, y, make_branch(packed.system).memory, out) != 0:
        return math.nan, math.nan
    return float(out[P_D]), float(out[B_T])


def _turn_into_touch(case: "Case", packed: Packed, y: Floats, shares: Floats) -> bool:
    """Turn free rotors, mesh after mesh, so that the drive gap is ``shares`` of the backlash; False if wedged."""
    names = list(case.rotors)
    for j, mesh in enumerate(case.meshes):
        turned = None
        for name in (mesh.driven, mesh.driver):
            rotor = case.rotors[name]
            prescribed = rotor.drive is not None and rotor.drive.kind == "speed"
            if not prescribed and rotor.initial.theta is None:
                turned = name
                break
        m = packed.system.records[MESH][j]
        for _ in range(3):  # an eccentric toothing moves a little as it turns
            p_d, b_t = _mesh_at(packed, j, y)
            if not math.isfinite(p_d) or b_t < 0.0:
                return False
            if turned is None:
                break
            i = names.index(turned)
            rho = m.rho_a if m.a == i else m.rho_b
            y[3 * i + 2] += (-shares[j] * b_t - p_d) / (m.sigma * rho)
    return True


def initial_state(case: "Case", packed: Packed, *, member: int = 0) -> Floats:
    """Return the state [m, rad (relative), m/s, rad/s] at t = 0, shape [state].

    Member 0 starts as the case says, drive flanks just touching where no angle is given. Every other member draws,
    from (run.seed, member), shaft positions within 0.9 of each clearance circle, velocities of 1 mm/s standard deviation
    and a place between the flanks, all without wedging. A rotor whose ``initial`` gives an angle keeps it.

    Raises `InputError` where the given centres cannot mesh.
    """
    base = _given_state(case, packed)
    meshes = len(case.meshes)
    y = base.copy()
    if member == 0:
        _turn_into_touch(case, packed, y, np.zeros(meshes))
        for j in range(meshes):
            if math.isnan(_mesh_at(packed, j, y)[0]):
                raise InputError(
                    [
                        Fault(
                            f"meshes.{j}",
                            "initial positions",
                            "the teeth must be able to mesh at the start",
                            "Move initial.x, initial.y of its rotors nearer to 0.",
                        )
                    ]
                )
        return y
    generator = np.random.default_rng([case.run.seed, member])
    n, names = len(case.rotors), list(case.rotors)
    sleeves = [(names.index(k), s.radial_clearance) for k, s in case.sleeves.items()]
    radii = SHARE_OF_CLEARANCE * np.sqrt(generator.random(len(sleeves)))
    angles = 2.0 * math.pi * generator.random(len(sleeves))
    kicks = SPREAD_OF_SPEED * generator.standard_normal((len(sleeves), 2))
    shares = generator.random(meshes)
    for shrink in np.append(0.5 ** np.arange(12), 0.0):
        y = base.copy()
        for (i, clearance), radius, angle, kick in zip(sleeves, radii, angles, kicks, strict=True):
            y[3 * i] += shrink * radius * clearance * math.cos(angle)
            y[3 * i + 1] += shrink * radius * clearance * math.sin(angle)
            y[3 * (n + i)] += kick[0]
            y[3 * (n + i) + 1] += kick[1]
        if _turn_into_touch(case, packed, y, shares):
            break
    return y
