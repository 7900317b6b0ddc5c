"""Initial rotations: given ones, the others turned until drive flanks touch, outwards along the meshes.

Rotors that joints connect turn as one group. Known are groups of which a rotation is given or prescribed; a train without one
keeps the rotation of its root. From there a tree of meshes is turned into touch mesh by mesh. Where meshes close a loop, as in
planetary sets, or end at given rotations, the drive gaps are as small as they can be together without a flank inside another
(`bounded_gaps`). Carriers keep their rotation, except where a loop needs their turning.
"""

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.starts import MOST_TURNS, ROUNDING, Tree, turn_tree
from gearplay.kernels.layout import OUT_SIZE, theta_of
from gearplay.model.bounded_gaps import nearest_gaps
from gearplay.parts.mesh.geometry import B_T, P_D, gaps_at
from gearplay.parts.mesh.train import geometry
from gearplay.parts.mesh.train.traversal import mesh_order, rotor_order
from gearplay.parts.registry import MESH

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.model.pack import Packed

Floats = NDArray[np.float64]
Shares = dict[str, float]
"""Rotors that turn together, by their share of the group's rotation."""


def is_turned_by_file(case: "Case", name: str) -> bool:
    """Return whether the case itself gives the rotation of a rotor at the start."""
    return case.rotors[name].is_prescribed or case.rotors[name].initial.theta is not None


def turning_groups(case: "Case") -> list[Shares]:
    """Return the groups of rotors that joints couple, with their speed ratios, in the order of `rotor_order`."""
    ties: dict[str, list[Shares]] = {}
    for joint in case.joints:
        if len(factors := dict(joint.rolling())) == 2:
            for name in factors:
                ties.setdefault(name, []).append(factors)
    order, found, groups = rotor_order(case), set[str](), list[Shares]()
    place = {name: k for k, name in enumerate(order)}
    for first in order:
        if first in found:
            continue
        group, pending = {first: 1.0}, [first]
        while pending:
            one = pending.pop(0)
            nexts = [(next(n for n in tie if n != one), tie) for tie in ties.get(one, ())]
            for other, tie in sorted(nexts, key=lambda each: place[each[0]]):
                if other not in group:
                    group[other] = -tie[one] / tie[other] * group[one]
                    pending.append(other)
        groups.append(group)
        found |= group.keys()
    return groups


def given_rotations(case: "Case", groups: Iterable[Shares]) -> dict[str, float]:
    """Return rotations at the start [rad]: those that are given, 0 of groups without one, others unstrained against these."""
    turns = {}
    for group in groups:
        fixed = [name for name in group if is_turned_by_file(case, name)]
        for name, share in group.items():
            lead = name if name in fixed or not fixed else fixed[0]
            turns[name] = (case.rotors[lead].initial.theta or 0.0) / group[lead] * share
    return turns


def gaps_of_mesh(packed: "Packed", j: int, y: Floats, memory: Floats) -> tuple[float, float]:
    """Return (p_d, b_t) [m] of mesh j at state y and t = 0, ``memory`` that of a run not begun; NaN where it cannot mesh."""
    out = np.zeros(OUT_SIZE)
    if gaps_at(packed.system, j, 0.0, y, memory, out) != 0:
        return math.nan, math.nan
    return float(out[P_D]), float(out[B_T])


class _Step(NamedTuple):
    """One mesh that turns one group into touch."""

    mesh: int
    lever: float  # m, change of p_d per rotation of the group
    turned: tuple[tuple[int, float], ...]  # (place in the state, share)


class _Loop(NamedTuple):
    """Meshes whose gaps depend on each other, and the groups that are turned for them."""

    meshes: tuple[int, ...]
    turned: tuple[tuple[tuple[int, float], ...], ...]  # (place in the state, share) of every group
    ways: Floats  # orthonormal changes of p_d, shape [mesh, way]
    turns: Floats  # rad/m, rotations that make these, shape [group, way]

    def make(
        self, packed: "Packed", y: Floats, shares: Floats, memory: Floats, seat: Callable[[Floats], None]
    ) -> bool:
        """Turn in ``y`` so that drive gaps are nearest to their shares of the backlash; False where teeth press."""
        wanted = shares[list(self.meshes)]
        for _ in range(MOST_TURNS):
            p_d, b_t = np.array([gaps_of_mesh(packed, j, y, memory) for j in self.meshes]).T
            if not np.all(np.isfinite(p_d)):
                return False
            z = nearest_gaps(self.ways, -p_d, b_t, wanted * b_t)
            for turn, group in zip((self.turns @ z).tolist(), self.turned, strict=True):
                for place, part in group:
                    y[place] += part * turn
            seat(y)
            if float(np.max(np.abs(z), initial=0.0)) <= ROUNDING:
                break
        return bool(np.all(b_t >= 0.0))


class Touches:
    """Plan of the rotations that bring flanks into contact, the same for all members."""

    def __init__(self, case: "Case", packed: "Packed") -> None:
        self._packed = packed
        names = list(case.rotors)
        self._groups = turning_groups(case)
        self._places = [
            tuple([(theta_of(names.index(name)), share) for name, share in group.items()])
            for group in self._groups
        ]
        of = {name: g for g, group in enumerate(self._groups) for name in group}
        self._order = mesh_order(case)
        self._levers = [self._levers_of(j, names, of) for j in range(len(case.meshes))]
        self._inputs = [of[mesh.rotors[0]] for mesh in case.meshes]
        known = {of[name] for name in names if is_turned_by_file(case, name)}
        sprung = {of[n] for _, n, part in case.every_holder() if part.holds_rotation()}
        carriers = {of[c] for n in names if (c := geometry.carrier_of(case, n)) is not None} - known
        self.steps: list[_Step] = []
        self.loops: list[_Loop] = []
        self._plan(known, carriers, sprung)
        turned = [each for step in self.steps for each in step.turned]
        self.tree = Tree(
            np.array([step.mesh for step in self.steps], dtype=np.int64),
            np.array([step.lever for step in self.steps], dtype=np.float64),
            np.cumsum([len(step.turned) for step in self.steps], dtype=np.int64),
            np.array([place for place, _ in turned], dtype=np.int64),
            np.array([part for _, part in turned], dtype=np.float64),
        )

    def make(self, y: Floats, shares: Floats, memory: Floats, seat: Callable[[Floats], None]) -> bool:
        """Turn groups in ``y``, ``shares`` of the backlash between drive flanks, shape [mesh]; False where teeth press or leave.

        ``seat`` puts carried rotors on their carriers.
        """
        found = [turn_tree(self._packed.system, self.tree, shares, y, memory, np.zeros(OUT_SIZE))]
        found += [loop.make(self._packed, y, shares, memory, seat) for loop in self.loops]
        return all(found)

    @property
    def leaves_gaps(self) -> bool:
        """Whether flanks could be inside each other, since not every mesh is one of a tree that is turned."""
        return len(self.steps) < len(self._levers)

    def _levers_of(self, j: int, names: list[str], of: dict[str, int]) -> dict[int, float]:
        """Return the derivatives of p_d of mesh j by the rotations of groups [m/rad], without those that vanish."""
        m = self._packed.system.records[MESH][j]
        levers: dict[int, float] = {}
        for i, radius in ((m.a, m.rho_a), (m.b, m.rho_b), (m.frame, -(m.rho_a + m.rho_b))):
            if i >= 0:
                g = of[names[i]]
                levers[g] = levers.get(g, 0.0) + float(m.sigma * radius) * self._groups[g][names[i]]
        least = 1e-9 * max(abs(m.rho_a), abs(m.rho_b))
        return {g: lever for g, lever in levers.items() if abs(lever) > least}

    def _plan(self, known: set[int], carriers: set[int], sprung: set[int]) -> None:
        """Partition the meshes into trees, which are turned step by step, and loops."""
        free = {g for levers in self._levers for g in levers} - known
        roots = set[int]()
        for component in _components(free - carriers, self._levers):
            mine = [j for j in self._order if component & self._levers[j].keys()]
            if not any(len(self._levers[j].keys() & component) == 1 for j in mine):
                reached = [g for j in mine for g in (self._inputs[j], *sorted(self._levers[j]))]
                among = component & sprung or component
                roots.add(next(g for g in reached if g in among))
        for component in _components(free - roots, self._levers):
            mine = [j for j in self._order if component & self._levers[j].keys()]
            steps = self._tree(mine, component - carriers)
            if steps is None:
                self.loops.append(self._loop(mine, component - carriers, component & carriers))
            else:
                self.steps += steps

    def _tree(self, meshes: list[int], turned: set[int]) -> list[_Step] | None:
        """Return the steps that turn groups outwards, each by one mesh; None where they are no trees."""
        left, unknown, steps = list(meshes), set(turned), list[_Step]()
        while left:
            j = next((j for j in left if len(self._levers[j].keys() & unknown) == 1), None)
            if j is None:
                return None
            left.remove(j)
            (g,) = self._levers[j].keys() & unknown
            unknown.remove(g)
            steps.append(_Step(j, self._levers[j][g], self._places[g]))
        return None if unknown else steps

    def _loop(self, meshes: list[int], turned: set[int], carriers: set[int]) -> _Loop:
        """Return a loop; its carriers are turned too only where that adds attainable gaps."""
        groups = sorted(turned)
        left, sizes, right = self._ways(meshes, groups)
        more = [*groups, *sorted(carriers)]
        all_left, all_sizes, all_right = self._ways(meshes, more)
        if len(all_sizes) > len(sizes):
            groups, left, sizes, right = more, all_left, all_sizes, all_right
        return _Loop(tuple(meshes), tuple([self._places[g] for g in groups]), left, right.T / sizes)

    def _ways(self, meshes: list[int], groups: list[int]) -> tuple[Floats, Floats, Floats]:
        matrix = np.array([[self._levers[j].get(g, 0.0) for g in groups] for j in meshes])
        left, sizes, right = np.linalg.svd(matrix.reshape(len(meshes), len(groups)), full_matrices=False)
        rank = int(np.sum(sizes > 1e-9 * np.max(sizes, initial=0.0)))
        return left[:, :rank], sizes[:rank], right[:rank]


def _components(groups: set[int], levers: list[dict[int, float]]) -> list[set[int]]:
    """Return the sets of groups that meshes connect, meshes with a group outside ``groups`` not beyond that one."""
    found: list[set[int]] = []
    for each in levers:
        mine = groups & each.keys()
        if mine:
            apart = [other for other in found if not other & mine]
            found = [*apart, mine.union(*(other for other in found if other & mine))]
    return sorted(found, key=min)
