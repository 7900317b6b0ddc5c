"""Starts of members: drawn places in clearances, and rotors turned until drive flanks touch."""

import math
from dataclasses import dataclass

from gearplay.kernels.arrays import Cubes, Floats, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import System, vx_of, x_of
from gearplay.parts.mesh.geometry import B_T, P_D, mesh_gaps

LEAST_TURNS, MOST_TURNS = 3, 60  # an eccentric toothing moves a little as it turns
ROUNDING = 1e-15  # m, error that a gap may keep
HALVINGS = 12  # of the drawn displacements, before they are left out


@dataclass(frozen=True, eq=False)
class Tree(Group):
    """Meshes that are turned into touch one after another, each by turning one group of rotors."""

    meshes: Ints
    levers: Floats  # m, change of p_d per rotation of the group
    ends: Ints  # where the group of each ends in the lists below
    places: Ints  # of its rotations in the state
    parts: Floats  # share of each of the group's rotation


@dataclass(frozen=True, eq=False)
class Draws(Group):
    """Random draws of the members, and their common data."""

    base: Floats  # [state]: rotations and speeds
    own: Rows  # [rotor, 4]: given displacements and velocities of centres
    held: Ints  # rotors in a clearance
    clearances: Floats  # m
    elastic: Ints  # rotors that springs alone hold
    radii: Rows  # [member, rotor in a clearance], share of it
    angles: Rows  # rad
    kicks: Cubes  # [member, rotor in a clearance, 2], m/s
    shares: Rows  # [member, mesh], of the backlash
    pushes: Cubes  # [member, elastic rotor, 2], m/s
    blank: Rows  # memory of the elements of a run that has not begun
    memory: Rows  # the same, for use
    out: Floats  # scratch of a mesh
    starts: Rows  # [member, state]
    sound: Ints  # [member]: 1 where no mesh is wedged


@compiled_inline
def turn_mesh(
    system: System, tree: Tree, step: int, share: float, y: Floats, memory: Floats, out: Floats
) -> bool:
    """Turn in ``y`` so that a drive gap is its share of the backlash, half of a negative one; False where both flanks press."""
    lever = tree.levers[step]
    is_free, before = True, math.inf
    for k in range(MOST_TURNS):
        if mesh_gaps(system, tree.meshes[step], 0.0, y, memory, out) != 0:
            return False
        p_d, b_t = out[P_D], out[B_T]
        if not math.isfinite(p_d):
            return False
        is_free = b_t >= 0.0
        turn = (-(share if is_free else 0.5) * b_t - p_d) / lever
        for c in range(tree.ends[step - 1] if step > 0 else 0, tree.ends[step]):
            y[tree.places[c]] += tree.parts[c] * turn
        if k + 1 >= LEAST_TURNS and turn * turn * abs(lever) <= ROUNDING * before:
            break  # turns shrink by one factor
        before = abs(turn)
    return is_free


@compiled_once
def turn_tree(system: System, tree: Tree, shares: Floats, y: Floats, memory: Rows, out: Floats) -> bool:
    """Turn the meshes of a tree into touch, ``shares`` of the backlash open, shape [mesh]; False where one is wedged."""
    found = True
    for step in range(tree.meshes.size):
        if not turn_mesh(system, tree, step, shares[tree.meshes[step]], y, memory, out):
            found = False
    return found


@compiled_once
def draw_starts(system: System, tree: Tree, draws: Draws) -> None:
    """Fill the starts of all members; a draw that would wedge a mesh is scaled down, at most to the given displacements."""
    for m in range(draws.starts.shape[0]):
        for e in range(draws.memory.shape[0]):
            for k in range(draws.memory.shape[1]):
                draws.memory[e, k] = draws.blank[e, k]
        draws.sound[m] = 0
        for n in range(HALVINGS + 1):
            place_member(system, draws, m, 0.5**n if n < HALVINGS else 0.0)
            if turn_tree(system, tree, draws.shares[m], draws.starts[m], draws.memory, draws.out):
                draws.sound[m] = 1
                break


@compiled_inline
def place_member(system: System, draws: Draws, m: int, shrink: float) -> None:
    """Fill the start of a member before its meshes are turned, drawn displacements multiplied by ``shrink``."""
    y = draws.starts[m]
    for k in range(y.size):
        y[k] = draws.base[k]
    for i in range(draws.own.shape[0]):
        for axis in range(2):
            y[x_of(i) + axis], y[vx_of(system, i) + axis] = draws.own[i, axis], draws.own[i, 2 + axis]
    for c in range(draws.held.size):
        i, reach = draws.held[c], shrink * draws.radii[m, c] * draws.clearances[c]
        y[x_of(i)] += reach * math.cos(draws.angles[m, c])
        y[x_of(i) + 1] += reach * math.sin(draws.angles[m, c])
        for axis in range(2):
            y[vx_of(system, i) + axis] += draws.kicks[m, c, axis]
    for c in range(draws.elastic.size):
        for axis in range(2):
            y[vx_of(system, draws.elastic[c]) + axis] += draws.pushes[m, c, axis]
