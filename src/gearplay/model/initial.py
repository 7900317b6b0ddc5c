"""Initial states: given values, the rest kinematically consistent; ensemble members drawn by seed."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.starts import HALVINGS, Draws, draw_starts
from gearplay.integrate.switches import make_memory
from gearplay.kernels.layout import OUT_SIZE, omega_of, theta_of, vx_of, vy_of, x_of, y_of
from gearplay.model import matching
from gearplay.model.pack import Packed
from gearplay.model.touch import Touches, gaps_of_mesh, given_rotations, turning_groups
from gearplay.parts.mesh.train import geometry
from gearplay.parts.mesh.train.traversal import mesh_order, rotor_order
from gearplay.parts.rotor.schema import Initial
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case

Floats = NDArray[np.float64]

SPREAD_OF_SPEED = (
    1e-3  # m/s, standard deviation of a member's initial velocity in its sleeve or on its support
)
SHARE_OF_CLEARANCE = 0.9  # members start anywhere within this share of the clearance circle
ROUNDING = 1e-14  # m, depth to which flanks may be inside each other


class _Seats:
    """Initial displacements and velocities of centres, relative to the pins that carry them."""

    def __init__(self, case: "Case", packed: Packed, spins: dict[str, float]) -> None:
        self._system, names, centres = packed.system, list(case.rotors), geometry.centres(case)
        self._speeds = [spins[name] for name in names]
        self.carried: list[
            tuple[int, int, float, float]
        ] = []  # rotor, carrier, arm [m], carriers before what they carry

        def add(name: str) -> None:
            carrier = geometry.carrier_of(case, name)
            if carrier is None or any(names[i] == name for i, *_ in self.carried):
                return
            add(carrier)
            arm = [centres[name][k] - centres[carrier][k] for k in range(2)]
            self.carried.append((names.index(name), names.index(carrier), arm[0], arm[1]))

        for name in names:
            add(name)

    def place(self, y: Floats, own: Floats) -> None:
        """Fill centres and velocities of a state whose rotations are known, from each rotor's own (x, y, vx, vy)."""
        for i, (x, y_own, v_x, v_y) in enumerate(own.tolist()):
            at, speed = x_of(i), vx_of(self._system, i)
            y[at], y[at + 1], y[speed], y[speed + 1] = x, y_own, v_x, v_y
        for i, carrier, arm_x, arm_y in self.carried:
            at, speed = x_of(carrier), vx_of(self._system, carrier)
            turn, spin = float(y[theta_of(carrier)]), self._speeds[carrier]
            sine, cosine_1 = math.sin(turn), -2.0 * math.sin(0.5 * turn) ** 2
            shift_x, shift_y = cosine_1 * arm_x - sine * arm_y, sine * arm_x + cosine_1 * arm_y
            v_x, v_y = (
                float(y[speed]) - spin * (arm_y + shift_y),
                float(y[speed + 1]) + spin * (arm_x + shift_x),
            )
            x, y_own, own_vx, own_vy = own[i].tolist()
            y[x_of(i)], y[y_of(i)] = float(y[at]) + shift_x + x, float(y[at + 1]) + shift_y + y_own
            y[vx_of(self._system, i)], y[vy_of(self._system, i)] = v_x + own_vx, v_y + own_vy


def _given_state(case: "Case", packed: Packed) -> tuple[Floats, Floats, _Seats]:
    """Return the state with given and matching rotations and speeds, the rotors' own (x, y, vx, vy), and their seats."""
    speeds = packed.system.rotors["nominal_speed"]
    spins = dict(zip(case.rotors, matching.matching_speeds(case, speeds).tolist(), strict=True))
    turns = given_rotations(case, turning_groups(case))
    state = np.zeros(packed.state_size)
    for i, (name, rotor) in enumerate(case.rotors.items()):
        omega = spins[name]
        if rotor.drive is not None and rotor.drive.kind == "speed" and rotor.drive.ripple:
            omega = rotor.drive.first_speed
        state[theta_of(i)], state[omega_of(packed.system, i)] = turns[name], omega - speeds[i]
    starts = [rotor.initial for rotor in case.rotors.values()]
    own = np.array([(start.x, start.y, start.vx, start.vy) for start in starts])
    seats = _Seats(case, packed, spins)
    seats.place(state, own)
    return state, own, seats


def _must_mesh(case: "Case", packed: Packed, y: Floats, memory: Floats) -> None:
    """Raise `InputError` where a mesh cannot be at state y."""
    for j in range(len(case.meshes)):
        if math.isnan(gaps_of_mesh(packed, j, y, memory)[0]):
            raise InputError.of(
                case.settable_path(f"meshes.{j}"),
                "initial positions",
                "the teeth must be able to mesh at the start",
                "Move initial.x, initial.y of its rotors nearer to 0.",
            )


def starts_centred(case: "Case") -> bool:
    """Return whether member 0 starts at the exact centre of a clearance, which symmetry may keep it from leaving."""
    said = any(rotor.initial != Initial.model_construct() for rotor in case.rotors.values())
    return not said and any((part.clearance() or 0.0) > 0.0 for _, _, part in case.every_holder())


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
    """Initial states of a case's members, with their common data computed once."""

    def __init__(self, case: "Case", packed: Packed) -> None:
        self._case = case = case.operating
        names = list(case.rotors)
        self.packed = packed
        self._seed, self._is_drawn = case.run.seed, case.run.start == "drawn"
        self._base, self._own, self._seats = _given_state(case, packed)
        self._touches = Touches(case, packed)
        self._order, self._allowed = list(mesh_order(case)), np.zeros(0)
        order = rotor_order(case)
        clearances = {name: geometry.clearance_of(case, name) for name in order}
        self._in_clearance = [(names.index(n), c) for n, c in clearances.items() if c is not None]
        self._elastic = [
            names.index(name)
            for name in order
            if clearances[name] is None and case.holders(name) and not geometry.is_held(case, name)
        ]

    def of_member(self, member: int) -> Floats:
        """Return the start of a member; where ``run.start`` is "drawn" the members are the draws 1, 2, ..."""
        return self.state(member + 1 if self._is_drawn else member)

    def of_members(self, members: Sequence[int]) -> Floats:
        """Return the starts of members, shape [member, state]."""
        numbers = [member + 1 for member in members] if self._is_drawn else list(members)
        drawn = [number for number in numbers if number > 0]
        found = dict(zip(drawn, self._drawn_states(drawn), strict=True)) if self._is_plain else {}
        states = [found[number] if number in found else self.state(number) for number in numbers]
        return np.array(states).reshape(-1, self.packed.state_size)

    @property
    def _is_plain(self) -> bool:
        """Whether starts need no more than turning a tree of meshes: no loops of them, nothing on carriers."""
        return not (self._touches.loops or self._touches.leaves_gaps or self._seats.carried)

    def _draw(self, members: Sequence[int]) -> tuple[Floats, ...]:
        """Return the draws of members: radii, angles, velocities in clearances, places between flanks, other velocities."""
        sizes = (len(self._in_clearance), len(self._order), len(self._elastic))
        circles, kicks, places, pushes = _drawn(self._seed, tuple(members), *sizes)
        shares = np.zeros(places.shape)
        shares[:, self._order] = places
        radii = SHARE_OF_CLEARANCE * np.sqrt(circles[:, 0])
        return radii, 2.0 * math.pi * circles[:, 1], SPREAD_OF_SPEED * kicks, shares, SPREAD_OF_SPEED * pushes

    def _drawn_states(self, members: Sequence[int]) -> Floats:
        """Return the states of several members that draw, shape [member, state]; see `state`."""
        memory = make_memory(self.packed.system)
        radii, angles, kicks, shares, pushes = self._draw(members)
        draws = Draws(
            self._base,
            self._own,
            np.array([i for i, _ in self._in_clearance], dtype=np.int64),
            np.array([clearance for _, clearance in self._in_clearance], dtype=np.float64),
            np.array(self._elastic, dtype=np.int64),
            radii,
            angles,
            kicks,
            shares,
            pushes,
            blank=memory,
            memory=memory.copy(),
            out=np.zeros(OUT_SIZE),
            starts=np.zeros((len(members), self._base.size)),
            sound=np.zeros(len(members), dtype=np.int64),
        )
        draw_starts(self.packed.system, self._touches.tree, draws)
        for m in np.flatnonzero(draws.sound == 0).tolist():
            _must_mesh(self._case, self.packed, draws.starts[m], make_memory(self.packed.system))
        return draws.starts

    def state(self, member: int) -> Floats:
        """Return the state [m, rad (relative), m/s, rad/s] at t = 0, shape [state].

        Member 0 starts as specified by the case, drive flanks just touching where no angle is given. Every other member draws,
        from (run.seed, member), shaft positions within 0.9 of each clearance circle, velocities of 1 mm/s standard deviation
        there and on supports, and a place between the flanks, in the order of `traversal`. What would put flanks into each other
        is drawn in, down to the start of member 0. A rotor whose ``initial`` gives an angle keeps it.

        Raises `InputError` where the given centres cannot mesh.
        """
        meshes, memory = len(self._order), make_memory(self.packed.system)
        if member == 0:
            y, _ = self._start(self._own, np.zeros(meshes), memory)
            _must_mesh(self._case, self.packed, y, memory)
            return y
        if self._is_plain:
            drawn: Floats = self._drawn_states([member])[0]
            return drawn
        radii, angles, kicks, shares, pushes = (each[0] for each in self._draw([member]))
        for shrink in (*(0.5**n for n in range(HALVINGS)), 0.0):
            own = self._own.copy()
            for (i, clearance), radius, angle, kick in zip(
                self._in_clearance, radii.tolist(), angles.tolist(), kicks, strict=True
            ):
                own[i, 0] += shrink * radius * clearance * math.cos(angle)
                own[i, 1] += shrink * radius * clearance * math.sin(angle)
                own[i, 2:] += kick
            for i, push in zip(self._elastic, pushes, strict=True):
                own[i, 2:] += push
            y, is_free = self._start(own, shares, memory)
            if is_free and self._is_sound(y, memory):
                return y
        _must_mesh(self._case, self.packed, y, memory)
        return y

    def _start(self, own: Floats, shares: Floats, memory: Floats) -> tuple[Floats, bool]:
        """Return a state of centres by their own displacements and rotations in touch, and whether no mesh is wedged."""
        y = self._base.copy()
        self._seats.place(y, own)
        return y, self._touches.make(y, shares, memory, lambda y: self._seats.place(y, own))

    def _is_sound(self, y: Floats, memory: Floats) -> bool:
        """Return whether no flank is inside another at a state, deeper than at that of member 0."""
        if not self._touches.leaves_gaps:
            return True
        if not self._allowed.size:
            base, _ = self._start(self._own, np.zeros(len(self._order)), memory)
            self._allowed = np.maximum(self._depths(base, memory), ROUNDING)
        return bool(np.all(self._depths(y, memory) <= self._allowed))

    def _depths(self, y: Floats, memory: Floats) -> Floats:
        """Return the larger of the two flank penetrations of every mesh [m], shape [mesh]; negative for gaps."""
        found = [gaps_of_mesh(self.packed, j, y, memory) for j in range(len(self._order))]
        return np.array([max(p_d, -b_t - p_d) for p_d, b_t in found])


@lru_cache(maxsize=64)
def _drawn(seed: int, members: tuple[int, ...], held: int, meshes: int, elastic: int) -> tuple[Floats, ...]:
    """Return the random draws of members from (seed, member); cached, since the cases of a sweep have the same members."""
    from gearplay.model.seeds import generators  # NumPy's generators are loaded where members are drawn

    circles, kicks = np.zeros((len(members), 2, held)), np.zeros((len(members), held, 2))
    places, pushes = np.zeros((len(members), meshes)), np.zeros((len(members), elastic, 2))
    for m, generator in enumerate(generators(seed, members)):
        generator.random(out=circles[m])
        generator.standard_normal(out=kicks[m])
        generator.random(out=places[m])
        generator.standard_normal(out=pushes[m])
    return circles, kicks, places, pushes
