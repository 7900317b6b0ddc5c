"""Groups of rotors joined by springs for closed-form propagation, and their vibration modes.

Elements that act as springs and dampers between coordinates register a `Spring`; any other permanent action has no closed form.
Rotors that the first join, and none of which the second moves, are a group. Along each axis its coordinates make chains, whose
first-order equations are split into vibrations here, once, when a case is packed (`gearplay.kernels.joined`).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import CHAIN, DECAY, DRIFT, SWING, VIBRATION, Joined

Floats = NDArray[np.float64]

ROTATION = 2  # the axis; 0 and 1 are x and y
LEAST = 1e-12  # part of what is wound up that is rounding
SOFTEST = 1e-6  # part of the largest squared frequency without damping below which one would have lost too many digits
SKEWED = 1e6  # condition of the vibrations from which on closed forms would lose digits


class Spring(NamedTuple):
    """A spring and damper of element ``element`` on the sum of factors times coordinates, by rotor, along one axis."""

    element: int
    axis: int
    factors: Mapping[int, float]
    stiffness: float
    damping: float
    rest: float  # of the sum


class Vibration(NamedTuple):
    """One vibration of a chain: its kind, its decay [1/s] and frequency [rad/s], shapes in all coordinates, shape [k, 1 or 2]."""

    kind: int
    decay: float
    frequency: float
    shapes: Floats

    @property
    def block(self) -> Floats:
        """Its block of D."""
        d, f = self.decay, self.frequency
        if self.kind == DRIFT:
            return np.array([[0.0, 1.0], [0.0, -d]])
        return np.array([[-d]]) if self.kind == DECAY else np.array([[-d, f], [-f, -d]])


class Chain(NamedTuple):
    """Coordinates of ``rotors`` along one axis, those that move first, with their equations and vibrations."""

    axis: int
    rotors: Sequence[int]
    pull: Floats  # [count, 2 all + 1]
    vibrations: Sequence[Vibration]
    left: Floats
    damping: float


@dataclass
class JoinedRows:
    """Rows of `Joined`, found by `join_rotors`."""

    chains: list[Any] = field(default_factory=list)
    vibrations: list[Any] = field(default_factory=list)
    coordinates: list[int] = field(default_factory=list)
    numbers: list[float] = field(default_factory=list)
    places: Any = ()

    def as_arrays(self, stacked: Callable[[np.dtype[Any], Sequence[Any]], Any]) -> Joined:
        """Return them as arrays; ``stacked`` makes one of records."""
        return Joined(
            chains=stacked(CHAIN, self.chains),
            vibrations=stacked(VIBRATION, self.vibrations),
            coordinates=np.array(self.coordinates, dtype=np.int64),
            numbers=np.array(self.numbers, dtype=np.float64),
            places=self.places,
        )


def join_rotors(
    rotors: Sequence[Any], entries: Sequence[Any], springs: Sequence[Spring], gravity: Floats
) -> JoinedRows:
    """Return the groups of rotors propagated together in free motion; mark their rotors and the elements that join them."""
    tables, group = JoinedRows(places=np.tile(np.array([-1, 0], dtype=np.int64), 3 * len(rotors))), 0
    for members in _groups(rotors, entries, springs):
        chains = _chains_of(rotors, members, [s for s in springs if set(s.factors) & members], gravity)
        if not chains:
            continue
        for chain in chains:
            _add(tables, rotors, chain)
        for i in members:
            rotors[i].group = group
        for s in springs:
            if set(s.factors) & members:
                entries[s.element].joins = 1
        group += 1
    return tables


def _is_fixed(rotor: Any) -> bool:
    return bool(rotor.inv_mass == 0.0 and rotor.inv_inertia == 0.0 and rotor.varying == 0)


def _groups(rotors: Sequence[Any], entries: Sequence[Any], springs: Sequence[Spring]) -> Iterator[set[int]]:
    """Yield sets of rotors joined by springs, without rotors on which elements without a closed form always act."""
    linear = {s.element for s in springs}
    barred = {
        i
        for e, entry in enumerate(entries)
        if entry.always and e not in linear
        for i in (entry.a, entry.b, entry.c)
        if i >= 0 and not _is_fixed(rotors[i])
    }
    turned = {i for s in springs if s.axis == ROTATION for i in s.factors}
    for i, r in enumerate(rotors):
        if r.unbalance > 0.0 or (i in turned and (r.varying == 1 or r.friction > 0.0)):
            barred.add(i)
    left = {i for s in springs for i in s.factors}
    while left:
        members = {left.pop()}
        while grown := {i for s in springs if set(s.factors) & members for i in s.factors} - members:
            members |= grown
        left -= members
        if not members & barred:
            yield members


def _chains_of(
    rotors: Sequence[Any], members: set[int], springs: Sequence[Spring], gravity: Floats
) -> list[Chain] | None:
    """Return the chains of a group; None where one has no closed form that keeps its digits."""
    chains = []
    for axis in range(3):
        along = [s for s in springs if s.axis == axis and (s.stiffness > 0.0 or s.damping > 0.0)]
        free = {
            i
            for s in along
            for i in s.factors
            if (rotors[i].inv_inertia if axis == ROTATION else rotors[i].inv_mass) > 0.0
        }
        while free:
            chain = {min(free)}
            while (
                grown := {i for s in along if set(s.factors) & chain for i in s.factors if i in free} - chain
            ):
                chain |= grown
            free -= chain
            found = _chain(rotors, axis, sorted(chain), [s for s in along if set(s.factors) & chain], gravity)
            if found is None:
                return None
            chains.append(found)
    return chains


def _chain(
    rotors: Sequence[Any], axis: int, free: list[int], springs: Sequence[Spring], gravity: Floats
) -> Chain | None:
    """Return the chain of the free coordinates along one axis; None where it has no closed form that keeps its digits."""
    fixed = sorted({i for s in springs for i in s.factors} - set(free))
    order = free + fixed
    n, m = len(free), len(order)
    stiffness, damping, constant = np.zeros((m, m)), np.zeros((m, m)), np.zeros(m)
    for s in springs:
        factors = np.array([s.factors.get(i, 0.0) for i in order])
        turning = (
            [s.factors.get(i, 0.0) * rotors[i].nominal_speed for i in order] if axis == ROTATION else [0.0]
        )
        if s.stiffness > 0.0 and abs(sum(turning)) > LEAST * max(map(abs, turning)):
            return None  # it winds up
        stiffness += s.stiffness * np.outer(factors, factors)
        damping += s.damping * np.outer(factors, factors)
        constant += factors * (
            s.stiffness * s.rest - (s.damping * sum(turning) if s.stiffness == 0.0 else 0.0)
        )
    of_springs = damping[:n, :n].copy()
    inverse = np.zeros(n)
    for k, i in enumerate(free):
        r = rotors[i]
        own = r.drag if axis == ROTATION else r.radial_damping
        damping[k, k] += own
        constant[k] += r.torque - r.drag * r.nominal_speed if axis == ROTATION else r.mass * gravity[axis]
        inverse[k] = r.inv_inertia if axis == ROTATION else r.inv_mass
    pull = np.hstack([-stiffness[:n], -damping[:n], constant[:n, None]]) * inverse[:, None]
    held = np.array([[s.factors.get(i, 0.0) for i in free] for s in springs if s.stiffness > 0.0])
    try:
        vibrations = _vibrations(stiffness[:n, :n], damping[:n, :n], inverse, n - _rank(held))
    except np.linalg.LinAlgError:  # two of them coincide
        vibrations = None
    if vibrations is None:
        return None
    speeds = np.hstack([v.shapes @ v.block for v in vibrations])
    shapes = np.vstack([np.hstack([v.shapes for v in vibrations]), speeds])
    left = np.asarray(np.linalg.inv(shapes), dtype=np.float64)
    return Chain(axis, order, pull, vibrations, left, float(np.trace(of_springs * inverse[:, None])))


def _rank(factors: Floats) -> int:
    """Return the rank of the springs' factors: the number of independent directions that they restrain."""
    return (
        int(np.linalg.matrix_rank(factors / np.abs(factors).max(axis=1, keepdims=True)))
        if factors.size
        else 0
    )


def _vibrations(stiffness: Floats, damping: Floats, inverse: Floats, still: int) -> list[Vibration] | None:
    """Return the vibrations of M q'' + C q' + K q = 0, in ``still`` ways without a spring.

    None where they are too much alike, or too unlike, to keep their digits.
    """
    n = len(inverse)
    half = np.sqrt(inverse)
    k, c = stiffness * np.outer(half, half), damping * np.outer(half, half)
    values, vectors = np.linalg.eigh(k)
    scale = float(np.sqrt(max(values[-1], np.abs(c).max() ** 2)))
    if still > 1 or scale == 0.0 or (still < n and values[still] < SOFTEST * values[-1]):
        return None
    found = []
    if still == 1:
        drift = _drift(k, c, vectors[:, 0])
        if drift is None:
            return None
        found.append(drift)
    a = (
        np.block([[np.zeros((n, n)), scale * np.eye(n)], [-k / scale, -c]]) / scale
    )  # of (q, q' / scale), time times scale
    roots, right = np.linalg.eig(a)
    left_over = list(range(2 * n))
    for drift in found:
        for root in (0.0, -drift.decay / scale):
            left_over.remove(min(left_over, key=lambda at: abs(roots[at] - root)))
    for at in left_over:
        root, vector = scale * roots[at], right[:n, at]
        if root.imag < 0.0:
            continue
        if root.imag == 0.0:
            found.append(Vibration(DECAY, -float(root.real), 0.0, vector.real[:, None]))
        else:
            shapes = np.column_stack([vector.real, vector.imag])
            found.append(Vibration(SWING, -float(root.real), float(root.imag), shapes))
    found = [Vibration(v.kind, max(v.decay, 0.0), v.frequency, v.shapes) for v in found]
    columns = np.vstack(
        [np.hstack([v.shapes for v in found]), np.hstack([v.shapes @ v.block / scale for v in found])]
    )
    if (
        columns.shape != (2 * n, 2 * n)
        or not np.linalg.cond(columns / np.linalg.norm(columns, axis=0)) < SKEWED
    ):
        return None
    return [Vibration(v.kind, v.decay, v.frequency, v.shapes * half[:, None]) for v in found]


def _drift(k: Floats, c: Floats, whole: Floats) -> Vibration | None:
    """Return the rigid-body drift for unit masses: r_0 = (whole, 0) and r_1 with A r_1 = r_0 - d r_1; None if there is none.

    With r_1 = (u, whole - d u): (K - d C + d^2) u = (d - C) whole, u across ``whole``. Slow damping makes d by iteration.
    """
    across = np.eye(len(whole)) - np.outer(whole, whole)
    u, d = np.zeros(len(whole)), 0.0
    for _ in range(100):
        before = d
        d = float(whole @ c @ whole) / (1.0 + float(whole @ c @ u))
        matrix = across @ (k - d * c + d * d * np.eye(len(whole))) @ across + np.outer(whole, whole)
        u = across @ np.linalg.solve(matrix, across @ (d * whole - c @ whole))
        if abs(d - before) <= 4e-16 * abs(d):
            return Vibration(DRIFT, d, 0.0, np.column_stack([whole, u]))
    return None


def _add(tables: JoinedRows, rotors: Sequence[Any], chain: Chain) -> None:
    """Append a chain to the tables, and store its fastest oscillation in its rotors."""
    count = len(chain.pull)
    row = SimpleNamespace(
        first=len(tables.coordinates),
        count=count,
        fixed=len(chain.rotors) - count,
        right=0,
        left=0,
        pull=0,
        vibration=len(tables.vibrations),
        vibrations=len(chain.vibrations),
        modal_rates=2 * sum(each.count for each in tables.chains),
        damping=chain.damping,
    )
    shapes = np.hstack([v.shapes for v in chain.vibrations])
    for name, matrix in (("right", shapes), ("left", chain.left), ("pull", chain.pull)):
        setattr(row, name, len(tables.numbers))
        tables.numbers += matrix.ravel().tolist()
    column = 0
    for v in chain.vibrations:
        tables.vibrations.append(
            SimpleNamespace(kind=v.kind, column=column, decay=v.decay, frequency=v.frequency)
        )
        column += v.shapes.shape[1]
    for k, i in enumerate(chain.rotors):
        q = 3 * i + chain.axis
        tables.coordinates.append(q)
        if k < count:
            tables.places[2 * q], tables.places[2 * q + 1] = len(tables.chains), k
            fastest = max(v.frequency for v in chain.vibrations)
            rotors[i].modal_rate = max(rotors[i].modal_rate, fastest)
    tables.chains.append(row)
