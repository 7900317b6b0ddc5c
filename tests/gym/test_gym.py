"""The Gymnasium environment: valid by Gymnasium's own checks, seeded, with fields drawn per episode."""

from typing import Any

import numpy as np
import pytest

import gearplay as gp
from two_inertias import D1

gymnasium = pytest.importorskip("gymnasium")
PLAY = "couplings.0.play"


def environment(**more: Any) -> Any:
    from gearplay.gym import GearEnv

    given = {"dt": 1e-3, "duration": 0.02, "draw": {PLAY: (1e-3, 8e-3)}} | more
    limits = given.pop("limits", [(-0.5, 0.5)])
    return GearEnv(
        D1.case(1e-6),
        ["motor.drive.torque"],
        ["motor.theta", "load.theta"],
        limits,
        lambda y, u: -abs(y[1]),
        **given,
    )


@pytest.mark.filterwarnings("ignore")
def test_gymnasium_finds_no_fault() -> None:
    from gymnasium.utils.env_checker import check_env

    check_env(environment(), skip_render_check=True)


def test_episode_is_that_of_a_stepper_of_the_drawn_case() -> None:
    env, u = environment(), np.random.default_rng(0).uniform(-0.5, 0.5, (20, 1))
    y, drawn = env.reset(seed=4)
    again, same = environment().reset(seed=4)
    assert np.array_equal(y, again)
    assert drawn == same
    assert 1e-3 <= drawn[PLAY] <= 8e-3
    assert env.reset()[1] != drawn
    env.reset(seed=4)
    alone = gp.Stepper(
        gp.replace(D1.case(1e-6), drawn), inputs=["motor.drive.torque"], outputs=["motor.theta", "load.theta"]
    )
    for i, torque in enumerate(u):
        y, reward, ended, truncated, _ = env.step(torque)
        assert np.array_equal(y, alone.step(1e-3, torque))
        assert reward == -abs(y[1])
        assert (ended, truncated) == (False, i == 19)


def test_motion_that_cannot_be_followed_ends_the_episode() -> None:
    env = environment(limits=[(-1e12, 1e12)], dt=1.0, duration=5.0)
    env.reset(seed=0)
    for _ in range(4):
        _, _, ended, _, info = env.step(np.array([1e12]))
        if ended:
            break
    assert ended
    assert "beyond all reason" in info["message"]


def test_limits_that_do_not_rise_are_refused() -> None:
    with pytest.raises(gp.InputError, match="limits"):
        environment(limits=[(1.0, -1.0)])
