"""Records that are too short to say anything are refused, with what would do."""

import numpy as np
import pytest

import gearplay as gp
from depth import some
from gearplay.nonlinear.record_length import slow_oscillation


def test_exponents_of_an_instant_are_refused() -> None:
    """The article's mesh period at 120 rpm is 25 ms: half a second at least."""
    with pytest.raises(
        gp.InputError, match=r"at least 20 mesh periods of 0\.025 s; it covers 4e-08\. Give 0\.5 s or more"
    ):
        gp.lyapunov("han2021", duration=1e-9)
    with pytest.raises(gp.InputError, match=r"it covers 19\.6"):
        gp.lyapunov("han2021", duration=0.49)


def test_a_record_of_few_slow_swings_is_refused() -> None:
    """The article's ring crosses its backlash and bounces back in about half a second, and rattles more or less for seconds."""
    words = r"duration = 2.0: must hold 25 slow oscillations of the motion; half the power of ring\.\S+.*Give \d+ s or more"
    with pytest.raises(gp.InputError, match=words):
        gp.lyapunov("han2021", count=1, duration=2.0)


@pytest.mark.slow
def test_a_record_whose_duration_is_not_given_is_long_enough() -> None:
    """The case's own 2 s would not do; motions from different starts give one exponent, each within its uncertainty."""
    exponents = []
    for speed in some((0.0, 1e-4, 2e-4)):
        case = gp.load_case("han2021", [f"rotors.ring.initial.vx={speed}"])
        found = gp.lyapunov(case, count=1)
        assert found.time / case.run.duration in (4.0, 8.0, 16.0, 32.0)
        exponents.append(found.largest)
    values, uncertain = np.array(exponents).T
    mean = float(np.average(values, weights=1.0 / uncertain**2))
    assert np.all(np.abs(values - mean) < 2.0 * uncertain)
    assert 8.0 < mean < 20.0


def test_classification__an_unsettled_response_is_refused() -> None:
    """A disc that is dragged from its start to its speed: its own trend is its slowest swing."""
    at = np.linspace(0.0, 1.0, 300)
    assert slow_oscillation(np.exp(-at), 1.0) == 2.0
    assert slow_oscillation(np.exp(-at), 1.0, still=1.0) == 0.0
    assert slow_oscillation(np.cos(2.0 * np.pi * 20.0 * at), 1.0) == pytest.approx(0.05, rel=0.03)


def test_a_section_within_one_mesh_period_is_refused() -> None:
    with pytest.raises(
        gp.InputError, match=r"period = 1e-06: must cover at least 20 mesh periods.*Give 0\.0005 s or more"
    ):
        gp.motion("han2021", period=1e-6)


def test_record_length__an_unexcited_case_may_be_short() -> None:
    disc = {"mass": 1.0, "inertia": 1e-3, "floating": True, "initial": {"vx": 1e-3}}
    found = gp.lyapunov({"rotors": {"disc": disc}, "run": {"duration": 0.1}}, duration=0.01, transient=0.0)
    assert found.values.size == 6
