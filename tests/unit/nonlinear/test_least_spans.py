"""Records that are too short to say anything are refused, with what would do."""

import pytest

import gearplay as gp


def test_exponents_of_an_instant_are_refused() -> None:
    """The article's mesh period at 120 rpm is 25 ms: half a second at least."""
    with pytest.raises(
        gp.InputError, match=r"at least 20 mesh periods of 0\.025 s; it covers 4e-08\. Give 0\.5 s or more"
    ):
        gp.lyapunov("han2021", duration=1e-9)
    with pytest.raises(gp.InputError, match=r"it covers 19\.6"):
        gp.lyapunov("han2021", duration=0.49)


def test_a_section_within_one_mesh_period_is_refused() -> None:
    with pytest.raises(
        gp.InputError, match=r"period = 1e-06: must cover at least 20 mesh periods.*Give 0\.0005 s or more"
    ):
        gp.motion("han2021", period=1e-6)


def test_what_nothing_excites_periodically_may_be_short() -> None:
    disc = {"mass": 1.0, "inertia": 1e-3, "floating": True, "initial": {"vx": 1e-3}}
    found = gp.lyapunov({"rotors": {"disc": disc}, "run": {"duration": 0.1}}, duration=0.01, transient=0.0)
    assert found.values.size == 6
