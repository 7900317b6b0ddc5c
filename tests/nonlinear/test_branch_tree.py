"""Branches that hang together: the cascade of the torsional pair, and a shaft that swings in its sleeve."""

import math
from itertools import pairwise

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.families import along
from gearplay.nonlinear.orbits.branch_tree import joined
from gearplay.nonlinear.orbits.branches import DOUBLING, FOLD, Branch
from gearplay.nonlinear.orbits.period_map import StrobeMap
from gearplay.nonlinear.orbits.results import Branches
from gearplay.nonlinear.orbits.shooting import constants, find_orbit
from gearplay.vocabulary.errors import InputError, SimulationError

FORCE = "meshes.0.transmission_error.0.amplitude"
TORQUE = "rotors.ring.load.torque"


def pair() -> gp.Case:
    return gp.torsional_pair(0.6, mean_force=0.1, force=0.15, damping_ratio=0.1)


@pytest.fixture(scope="module")
def tree() -> Branches:
    return gp.branches(pair(), FORCE, "16 um", "36 um", doublings=2, settle=300)


@pytest.mark.slow
def test_branches_of_both_ends_and_their_doublings(tree: Branches) -> None:
    """One branch from the low end doubles, doubles again; another begins at a fold and is met at the high end only."""
    assert [branch.order for branch in tree] == [1, 1, 2, 4]
    one, other, two, four = tree
    assert [s.kind for s in one.special] == [DOUBLING]
    assert FOLD in [s.kind for s in other.special]
    doubling = one.special[0].orbit
    assert np.min(np.abs(doubling.multipliers + 1.0)) < 1e-8
    # Where a branch doubles, the next one begins.
    assert two.orbits[0].parameter == pytest.approx(doubling.parameter, abs=2e-9)
    assert np.max(np.abs(two.orbits[0].states[0] - two.orbits[0].states[1])) < 0.2 * np.max(
        np.abs(two.orbits[len(two.orbits) // 2].states[0] - two.orbits[len(two.orbits) // 2].states[1])
    )
    second = next(s for s in two.special if s.kind == DOUBLING)
    assert four.orbits[0].parameter == pytest.approx(second.orbit.parameter, abs=2e-9)


def test_a_branch_followed_both_ways_is_one_line(tree: Branches) -> None:
    branch = tree[0]
    parameters = branch.parameters
    assert parameters[0] < 16e-6 < 36e-6 < parameters[-1]
    assert np.all(np.diff(parameters) > 0.0)
    for special in branch.special:
        assert parameters[special.place] <= special.orbit.parameter <= parameters[special.place + 1]
    assert [not s for s in branch.stable] == [p > branch.special[0].orbit.parameter for p in parameters]


def test_joining_turns_the_first_round(tree: Branches) -> None:
    branch = tree[0]
    middle = len(branch.orbits) // 2
    low = Branch(branch.orbits[middle::-1], (), "low end", 1)
    high = Branch(branch.orbits[middle:], (), "high end", 1)
    whole = joined(low, high)
    assert whole.orbits == branch.orbits
    assert whole.ended == "low end; high end"


@pytest.mark.slow
def test_stable_orbits_are_where_the_motion_settles(tree: Branches) -> None:
    """The section of a sweep at a value of the second branch's stable part is its pair of states."""
    two = tree[2]
    at = next(i for i, orbit in enumerate(two.orbits) if orbit.stable and orbit.parameter > 23.5e-6)
    value = two.orbits[at].parameter
    found = gp.bifurcation(pair(), FORCE, [value], ["wheel.theta"], settle=600, keep=2, directions=["up"])
    levels = tree.levels(["wheel.theta"])[2][at, :, 0]
    assert np.sort(found.ds["wheel.theta"].values.ravel()) == pytest.approx(np.sort(levels), abs=1e-9)


@pytest.mark.slow
def test_the_table_holds_every_orbit_and_point(tree: Branches) -> None:
    table = tree.table(["wheel.theta"])
    assert table.sizes["orbit"] == sum(len(branch.orbits) for branch in tree)
    assert table.sizes["special"] == sum(len(branch.special) for branch in tree)
    assert table.amplitude.attrs == {"units": "m", "long_name": FORCE}
    stable = table.stable.values.astype(bool)
    assert np.all(table.multiplier.values[stable] < 1.0)
    assert np.all(table.multiplier.values[~stable] >= 1.0)


def loaded(torque: float) -> gp.Case:
    """Return the article's pair under load, round, a little damped: the teeth press the ring into its sleeve."""
    changes = {
        "rotors.pinion.runout.amplitude": 0.0,
        "rotors.ring.runout.amplitude": 0.0,
        "rotors.ring.radial_damping": 1.0,
        TORQUE: torque,
    }
    return gp.replace(gp.load_case("han2021"), {"run.tolerance": 1e-9, **changes})


@pytest.mark.slow
def test_a_pressed_shaft_is_a_pendulum_that_the_mesh_shakes() -> None:
    """Pressed by F = T / r_b, mass m swings in its clearance c like a pendulum, w^2 = F / (m c).

    At half the mesh frequency the first tongue of Mathieu's equation makes the straight motion unstable, by period doubling.
    """
    half = 0.5 * 2.0 * math.pi * 40.0
    base_radius = 0.5 * 60 * 4e-3 * math.cos(math.radians(20.0))
    resonant = 0.8 * 100e-6 * half**2 * base_radius
    period_map = StrobeMap(along(loaded(resonant), TORQUE), resonant)
    state = period_map.settle(period_map.start(0.3), 0.3, 300)
    assert find_orbit(period_map, state, 0.3).stable
    tongue = []
    for torque in (0.8 * resonant, resonant, 1.2 * resonant):
        orbit = find_orbit(period_map, state, torque)
        assert len(orbit.multipliers) == 6  # the stored impact speed of the closed sleeve is a constant
        tongue.append(min(orbit.multipliers.real))
        state = orbit.states[0]
    assert tongue[1] < -1.0 < min(tongue[0], tongue[2])


def test_constants_of_a_map() -> None:
    matrix = np.diag([0.5, 1.0, 1.0])
    matrix[1, 0] = 1e-12
    assert constants(matrix).tolist() == [False, False, True]


def test_branch__an_invalid_request_is_reported() -> None:
    with pytest.raises(
        SimulationError, match=r"no periodic orbit of order 2 .* repeats after 1 of 2 periods"
    ):
        gp.branches(pair(), FORCE, "16 um", "17 um", order=2)
    with pytest.raises(InputError, match="doublings = 9"):
        gp.branches(pair(), FORCE, "16 um", "36 um", doublings=9)
    near = r'^path = "meshes.0.transmission_error.0.amplitud": must be a field of the case. Did you mean .amplitude.\?$'
    with pytest.raises(InputError, match=near):
        gp.branch(pair(), FORCE[:-1], "16 um", "36 um")
    own = r"^meshes.0.transmission_error.0.amplitude = .*: the branch begins at the case's own value. Widen the bounds"
    with pytest.raises(InputError, match=own):
        gp.branch(pair(), FORCE, "600 um", "900 um")
    with pytest.raises(InputError, match=r"^start = 1e-06: must lie between low and high, 0.0006 and 0.0009"):
        gp.branch(pair(), FORCE, "600 um", "900 um", start="1 um")
    with pytest.raises(InputError, match=r"high = .*must be above low"):
        gp.branches(pair(), FORCE, "36 um", "16 um")


def test_pieces_of_a_branch_lie_next_to_each_other(tree: Branches) -> None:
    """No jump: neighbours are nearer than the longest step allowed."""
    for branch in tree:
        for a, b in pairwise(branch.orbits):
            assert abs(a.parameter - b.parameter) <= 0.2 * 0.1 * 20e-6 * 1.01
