"""Where closed forms of joined rotors end: long flights, springs too unlike, vibrations that coincide, centres that are held."""

import math
from decimal import Decimal, getcontext
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, case_of
from gearplay.kernels.layout import SWING
from gearplay.model.pack import pack
from gearplay.vocabulary.errors import InputError


def disc_in_sleeve(stiffness: float, damping: float, duration: float) -> Document:
    """Return a disc on a support that swings in its clearance, and touches nothing."""
    return {
        "rotors": {"disc": {"mass": 1.0, "inertia": 1e-3, "initial": {"x": 5e-5}}},
        "supports": {"disc": {"stiffness": [stiffness, stiffness], "damping": [damping, damping]}},
        "sleeves": {"disc": {"radial_clearance": 1e-4, "stiffness": 1e10, "restitution": 0.9}},
        "run": {"duration": duration, "sampling": 100.0, "tolerance": 1e-8},
    }


def test_a_swing_that_has_died_needs_no_looks() -> None:
    """Bounds of its acceleration die with it: hundreds of looks in 100 s, where the first bound would need millions."""
    (run,) = gp.simulate(case_of(disc_in_sleeve(1e8, 100.0, 100.0))).runs
    assert run.success
    assert run.counters.calls < 20_000


def test_undamped_oscillation__free_motion_lasts_the_requested_time() -> None:
    """Looks go on as the swing does, half a million times; it is no contact that hovers."""
    run = gp.simulate(case_of(disc_in_sleeve(1e8, 0.0, 60.0)), signals=["x"])
    assert run.success
    assert run.runs[0].counters.calls > 200_000
    x, t = run.ds.x.to_numpy().ravel(), run.time()
    assert np.abs(x - 5e-5 * np.cos(1e4 * t)).max() < 1e-12 * 1e4 * 60.0


def test_a_touch_after_ever_so_many_looks_is_found() -> None:
    """Two discs that swing fast against each other drift to the sleeve in 200 s."""
    document: Document = {
        "rotors": {
            "a": {"mass": 1.0, "inertia": 1e-3, "initial": {"vx": 1e-6, "x": 5e-6}},
            "b": {"mass": 1.0, "inertia": 1e-3, "floating": True, "initial": {"vx": 1e-6}},
        },
        "sleeves": {"a": {"radial_clearance": 1e-4, "stiffness": 1e10, "restitution": 0.9}},
        "couplings": [{"between": ["a", "b"], "torsional_stiffness": 100.0, "lateral_stiffness": 1e8, "lateral_damping": 0.0}],
        "run": {"duration": 150.0, "sampling": 10.0, "tolerance": 1e-8},
    }  # fmt: skip
    found = gp.simulate(case_of(document))
    assert found.success
    assert len(found.runs[0].log) > 0
    assert found.ds.sleeve_penetration.to_numpy().max() < 1e-6


def chained(coupling: float, support: float) -> Document:
    """Return two discs joined by a coupling, one of them held by a torsional spring."""
    return {
        "rotors": {
            "a": {"mass": 1.0, "inertia": 1e-3, "initial": {"theta": 1.0, "omega": 0.0}},
            "b": {"mass": 1.0, "inertia": 2e-3, "initial": {"theta": 1.0, "omega": 0.0}},
        },
        "couplings": [{"between": ["a", "b"], "torsional_stiffness": coupling}],
        "supports": {"a": {"torsional_stiffness": support}},
        "run": {"duration": 0.1, "sampling": 100.0, "tolerance": 1e-8},
    }


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e3, 1e5])
def test_slow_swings_beside_fast_ones_keep_their_digits(ratio: float) -> None:
    """Against the roots of the quadratic in 50 digits."""
    joined: Any = pack(case_of(chained(1e3 * ratio, 1e3))).system.joined
    getcontext().prec = 50
    one, two, k, s = (Decimal(x) for x in (1e-3, 2e-3, 1e3 * ratio, 1e3))
    b, c = (k + s) / one + k / two, s * k / (one * two)
    slow = (b - (b * b - 4 * c).sqrt()) / 2
    found = min(v.frequency for v in joined.vibrations if v.kind == SWING)
    assert found == pytest.approx(math.sqrt(float(slow)), rel=1e-10)


@pytest.mark.parametrize(("coupling", "support"), [(1e9, 1.0), (1e9, 1e-4)])
def test_a_spring_among_much_stiffer_ones_is_integrated(coupling: float, support: float) -> None:
    """It is not dropped, and no closed form that has lost its digits takes its place."""
    assert pack(case_of(chained(coupling, support))).system.joined.chains.size == 0


def test_vibrations_that_coincide_are_integrated() -> None:
    """Drag in the ratio of the inertias and a coupling as stiff as it damps: the drift's decay is that of a vibration."""
    document: Document = {
        "rotors": {
            "a": {"mass": 1.0, "inertia": 0.25, "load": {"drag": 0.125}, "initial": {"omega": -0.5}},
            "b": {"mass": 1.0, "inertia": 2.0, "load": {"drag": 1.0}, "initial": {"omega": 1.5}},
        },
        "couplings": [{"between": ["a", "b"], "torsional_stiffness": 0.5, "torsional_damping": 1.0, "ratio": -0.5}],
        "run": {"duration": 0.1, "sampling": 100.0, "tolerance": 1e-9},
    }  # fmt: skip
    assert gp.simulate(case_of(document)).success


def test_a_held_centre_does_not_move() -> None:
    document = disc_in_sleeve(1e8, 0.0, 0.1)
    document["rotors"]["wall"] = {"mass": 1.0, "inertia": 1e-3, "initial": {"vy": 0.01}}
    with pytest.raises(
        InputError, match=r"rotors\.wall\.initial\.vy = 0\.01: must be 0: its centre is held\."
    ):
        gp.simulate(case_of(document))


def test_rotors_that_turn_far_keep_their_momentum() -> None:
    """A coupling of ratio 3 between free discs that have turned by 1000 and 3000 rad, 1 s: no part in 1e9 is lost."""
    document: Document = {
        "rotors": {
            "a": {"mass": 1.0, "inertia": 1e-3, "initial": {"theta": 3000.9, "omega": 3.0}},
            "b": {"mass": 1.0, "inertia": 2e-3, "initial": {"theta": 1000.3, "omega": 1.0}},
        },
        "couplings": [{"between": ["a", "b"], "torsional_stiffness": 1e6, "ratio": 3.0}],
        "run": {"duration": 1.0, "sampling": 100.0, "tolerance": 1e-9},
    }
    omega = gp.simulate(case_of(document)).ds.omega
    momentum = 3.0 * 1e-3 * omega.sel(rotor="a").to_numpy() + 2e-3 * omega.sel(rotor="b").to_numpy()
    assert np.abs(momentum / momentum.ravel()[0] - 1.0).max() < 1e-9
