"""Initial states: as given, the rest kinematically matching; ensemble members differ by a seeded draw."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.elements.table import MESH
from gearplay.kernels.layout import OUT_SIZE, theta_of, vx_of, vy_of, x_of, y_of
from gearplay.kernels.mesh_geometry import B_T, P_D, gaps_at
from gearplay.kernels.switches import make_memory
from gearplay.model import geometry, rolling
from gearplay.model.pack import Packed
from gearplay.model.rotor import Initial
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case

Floats = NDArray[np.float64]

SPREAD_OF_SPEED = (
    1e-3  # m/s, standard deviation of a member's initial velocity in its sleeve or on its support
)
SHARE_OF_CLEARANCE = 0.9  # members start anywhere within this share of the clearance circle


def _is_turned_by_file(case: "Case", name: str) -> bool:
    """Return whether the case itself says where a rotor is turned to at the start."""
    drive = case.rotors[name].drive
    return (drive is not None and drive.kind == "speed") or case.rotors[name].initial.theta is not None


def _is_sprung(case: "Case", name: str) -> bool:
    """Return whether a support turns a rotor back to its rotation 0: it is turned into touch where no other rotor can be."""
    return name in case.supports and case.supports[name].torsional_stiffness > 0.0


def _turn_together(case: "Case") -> dict[str, dict[str, float]]:
    """Return for every rotor those that turn with it where no joint is strained, itself too, by their share of its rotation."""
    shares = {name: {name: 1.0} for name in case.rotors}
    for joint in case.joints:
        factors = joint.rolling()
        if len(factors) != 2:
            continue
        (one, c_1), (two, c_2) = factors.items()
        joined = {**shares[one], **{name: -c_1 / c_2 * share for name, share in shares[two].items()}}
        for name, share in joined.items():
            shares[name] = {other: value / share for other, value in joined.items()}
    return shares


def _rotations(case: "Case") -> dict[str, float]:
    """Return the rotations at the start [rad] that are given, the others unstrained against these."""
    turns, shares = {}, _turn_together(case)
    for name in case.rotors:
        fixed = [other for other in shares[name] if _is_turned_by_file(case, other)]
        lead = name if name in fixed or not fixed else fixed[0]
        turns[name] = (case.rotors[lead].initial.theta or 0.0) / shares[name][lead]
    return turns


def _ride(
    case: "Case",
    name: str,
    centres: dict[str, tuple[float, float]],
    turns: dict[str, float],
    spins: dict[str, float],
) -> tuple[float, float, float, float]:
    """Return a rotor's displacement [m] and velocity [m/s] at the start: its own beside those of the pin that carries it."""
    start, carrier = case.rotors[name].initial, geometry.carrier_of(case, name)
    if carrier is None:
        return start.x, start.y, start.vx, start.vy
    x, y, v_x, v_y = _ride(case, carrier, centres, turns, spins)
    arm_x, arm_y = (centres[name][k] - centres[carrier][k] for k in range(2))
    sine, cosine_1 = math.sin(turns[carrier]), -2.0 * math.sin(0.5 * turns[carrier]) ** 2
    shift_x, shift_y = cosine_1 * arm_x - sine * arm_y, sine * arm_x + cosine_1 * arm_y
    v_x -= spins[carrier] * (arm_y + shift_y)
    v_y += spins[carrier] * (arm_x + shift_x)
    return x + shift_x + start.x, y + shift_y + start.y, v_x + start.vx, v_y + start.vy


def _given_state(case: "Case", packed: Packed) -> Floats:
    """Return the state with every given value set and the others matching."""
    speeds = packed.system.rotors["nominal_speed"]
    spins = dict(zip(case.rotors, map(float, rolling.starting_speeds(case, speeds)), strict=True))
    spins |= {n: r.initial.omega for n, r in case.rotors.items() if r.initial.omega is not None}
    turns, centres = _rotations(case), geometry.centres(case)
    state = np.zeros(packed.state_size)
    for i, (name, rotor) in enumerate(case.rotors.items()):
        x, y, v_x, v_y = _ride(case, name, centres, turns, spins)
        omega = spins[name]
        if rotor.drive is not None and rotor.drive.kind == "speed" and rotor.drive.ripple:
            swing = sum(term.amplitude * math.sin(term.phase) for term in rotor.drive.ripple)
            omega = speeds[i] * (1.0 + swing)
        place, speed = x_of(i), vx_of(packed.system, i)
        state[place : place + 3] = x, y, turns[name]
        state[speed : speed + 3] = v_x, v_y, omega - speeds[i]
    return state


def _mesh_at(packed: Packed, j: int, y: Floats, memory: Floats) -> tuple[float, float]:
    """Return (p_d, b_t) [m] of mesh j at state y and t = 0, ``memory`` that of a run not begun; NaN where it cannot mesh."""
    out = np.zeros(OUT_SIZE)
    if gaps_at(packed.system, j, 0.0, y, memory, out) != 0:
        return math.nan, math.nan
    return float(out[P_D]), float(out[B_T])


@dataclass(frozen=True)
class _Touch:
    """How a mesh is turned into touch: by rotations at some places in the state, each by its share of that of one rotor."""

    mesh: int
    lever: float  # m, of that rotor
    turned: tuple[tuple[int, float], ...]  # (place, share); none where no rotor may be turned

    def make(self, packed: Packed, y: Floats, share: float, memory: Floats) -> bool:
        """Turn in ``y`` so that the drive gap is ``share`` of the backlash; False if wedged."""
        for _ in range(3):  # an eccentric toothing moves a little as it turns
            p_d, b_t = _mesh_at(packed, self.mesh, y, memory)
            if not math.isfinite(p_d) or b_t < 0.0:
                return False
            if not self.turned:
                break
            turn = (-share * b_t - p_d) / self.lever
            for place, part in self.turned:
                y[place] += part * turn
        return True


def _touches(case: "Case", packed: Packed) -> list[_Touch]:
    """Return how free rotors are turned, mesh after mesh; what is coupled to such a rotor turns with it."""
    names, together, touches = list(case.rotors), _turn_together(case), []
    for j, mesh in enumerate(case.meshes):
        free = [
            name
            for name in mesh.rotors[::-1]
            if not any(_is_turned_by_file(case, other) for other in together[name])
        ]
        free.sort(key=lambda name: any(_is_sprung(case, other) for other in together[name]))
        lever, turned = 1.0, {}
        if free:
            m = packed.system.records[MESH][j]
            lever = float(m.sigma * (m.rho_a if m.a == names.index(free[0]) else m.rho_b))
            turned = {theta_of(names.index(name)): share for name, share in together[free[0]].items()}
        touches.append(_Touch(j, lever, tuple(turned.items())))
    return touches


def _must_mesh(packed: Packed, meshes: int, y: Floats, memory: Floats) -> None:
    """Raise `InputError` where a mesh cannot be at state y."""
    for j in range(meshes):
        if math.isnan(_mesh_at(packed, j, y, memory)[0]):
            raise InputError(
                Fault(
                    f"meshes.{j}",
                    "initial positions",
                    "the teeth must be able to mesh at the start",
                    "Move initial.x, initial.y of its rotors nearer to 0.",
                )
            )


def starts_centred(case: "Case") -> bool:
    """Return whether member 0 starts in the exact centre of a clearance: nothing may ever push it from there."""
    said = any(rotor.initial != Initial() for rotor in case.rotors.values())
    return not said and any(sleeve.radial_clearance > 0.0 for sleeve in case.sleeves.values())


def usual_member(case: "Case") -> int:
    """Return the member that a single motion is of: the first that is drawn, where member 0 would start exactly centred.

    >>> from gearplay.model.reading import load_case
    >>> usual_member(load_case("han2021")), usual_member(load_case("han2021", ["rotors.ring.initial.x=10um"]))
    (1, 0)
    """
    return 1 if case.run.start == "given" and starts_centred(case) else 0


def member_state(case: "Case", packed: Packed, member: int) -> Floats:
    """Return the state at t = 0 of a member of the case's ensemble, shape [state]; see `Starts`."""
    return Starts(case, packed).of_member(member)


def initial_state(case: "Case", packed: Packed, *, member: int = 0) -> Floats:
    """Return the state [m, rad (relative), m/s, rad/s] at t = 0, shape [state]; see `Starts.state`."""
    return Starts(case, packed).state(member)


class Starts:
    """The starts of a case's members: what they have in common is found once."""

    def __init__(self, case: "Case", packed: Packed) -> None:
        case = case.operating
        names = list(case.rotors)
        self.packed = packed
        self._seed, self._is_drawn = case.run.seed, case.run.start == "drawn"
        self._base, self._touches = _given_state(case, packed), _touches(case, packed)
        self._sleeves = [(names.index(k), s.radial_clearance) for k, s in case.sleeves.items()]
        self._supported = [
            i
            for i, name in enumerate(names)
            if name in case.supports and name not in case.sleeves and not geometry.is_held(case, name)
        ]

    def of_member(self, member: int) -> Floats:
        """Return the start of a member; where ``run.start`` is "drawn" the members are the draws 1, 2, ..."""
        return self.state(member + 1 if self._is_drawn else member)

    def state(self, member: int) -> Floats:
        """Return the state [m, rad (relative), m/s, rad/s] at t = 0, shape [state].

        Member 0 starts as the case says, drive flanks just touching where no angle is given. Every other member draws,
        from (run.seed, member), shaft positions within 0.9 of each clearance circle, velocities of 1 mm/s standard deviation
        there and on supports, and a place between the flanks, all without wedging. A rotor whose ``initial`` gives an angle
        keeps it.

        Raises `InputError` where the given centres cannot mesh.
        """
        packed, meshes = self.packed, len(self._touches)
        y, memory = self._base.copy(), make_memory(packed.system)
        if member == 0:
            self._turn_into_touch(y, np.zeros(meshes), memory)
            _must_mesh(packed, meshes, y, memory)
            return y
        generator = np.random.default_rng([self._seed, member])
        count = len(self._sleeves)
        radii = (SHARE_OF_CLEARANCE * np.sqrt(generator.random(count))).tolist()
        angles = (2.0 * math.pi * generator.random(count)).tolist()
        kicks = SPREAD_OF_SPEED * generator.standard_normal((count, 2))
        shares = generator.random(meshes)
        pushes = SPREAD_OF_SPEED * generator.standard_normal((len(self._supported), 2))
        for shrink in (*(0.5**n for n in range(12)), 0.0):
            y = self._base.copy()
            for (i, clearance), radius, angle, kick in zip(self._sleeves, radii, angles, kicks, strict=True):
                y[x_of(i)] += shrink * radius * clearance * math.cos(angle)
                y[y_of(i)] += shrink * radius * clearance * math.sin(angle)
                y[vx_of(packed.system, i)] += kick[0]
                y[vy_of(packed.system, i)] += kick[1]
            for i, push in zip(self._supported, pushes, strict=True):
                y[vx_of(packed.system, i)] += push[0]
                y[vy_of(packed.system, i)] += push[1]
            if self._turn_into_touch(y, shares, memory):
                return y
        _must_mesh(packed, meshes, y, memory)
        return y

    def _turn_into_touch(self, y: Floats, shares: Floats, memory: Floats) -> bool:
        """Turn free rotors so that each drive gap is its share of the backlash; False if wedged."""
        found = zip(self._touches, shares.tolist(), strict=True)
        return all(touch.make(self.packed, y, share, memory) for touch, share in found)
