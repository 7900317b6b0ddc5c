"""Cascades of position, speed and current loops, encoders and delays: against an independent simulation and closed forms."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Measured
from gearplay.vocabulary.errors import InputError
from two_inertias import Exact, Lagged, Pair

TIME = 0.5  # s
PAIR = Pair(J1=1e-3, J2=4e-3, k=60.0, c=0.0, play=4e-3, d1=1e-3, d2=2e-3, dt=1e-3, a=0.0, w=0.0)
MOVE = {"value": 0.4, "start": 0.02, "rise": 0.05, "hold": 0.1, "fall": 0.05}
LOOP: Document = {
    "kind": "cascade",
    "position_gain": 25.0,
    "speed_gain": 0.09,
    "integral_gain": 0.8,
    "feedforward": 0.7,
    "torque_limit": 3.0,
    "sensor": "load",
    "sample_time": 1e-3,
    "position_every": 3,
    "resolution": 2e-4,
    "speed_resolution": 1e-4,
}


def case(pair: Pair = PAIR, time: float = TIME, **drive: Any) -> gp.Case:
    """Return motor and load with play between them, the motor on a loop."""
    still = {"theta": 0.0, "omega": 0.0}
    return gp.load_case(
        {
            "rotors": {
                "motor": {"mass": 1.0, "inertia": pair.J1, "drive": drive, "load": {"drag": pair.d1}, "initial": still},
                "load": {"mass": 1.0, "inertia": pair.J2, "load": {"drag": pair.d2}, "initial": still},
            },
            "couplings": [
                {"between": ["motor", "load"], "torsional_stiffness": pair.k, "torsional_damping": pair.c, "play": pair.play}
            ],
            "run": {"duration": time, "sampling": 1.0 / pair.dt, "tolerance": 1e-12},
        }
    )  # fmt: skip


def move(t: float) -> tuple[float, float]:
    """Return angle [rad] and speed [rad/s] of the set-point, by its trapezoid of the speed."""
    top = MOVE["value"] / (0.5 * MOVE["rise"] + MOVE["hold"] + 0.5 * MOVE["fall"])
    knots = np.cumsum([MOVE["start"], MOVE["rise"], MOVE["hold"], MOVE["fall"]])
    speed = float(np.interp(t, knots, [0.0, top, top, 0.0]))
    at = [0.0, *(x for x in knots if x < t), t]
    speeds = [float(np.interp(x, knots, [0.0, top, top, 0.0])) for x in at]
    return float(np.trapezoid(speeds, at)), speed


def by_hand(loop: Document, plant: Exact) -> np.ndarray[Any, Any]:
    """Return angles of motor and load at each sample [rad] by the recursion of the control, in its own words: speed loop, PI."""
    period, delay = loop["sample_time"], loop.get("delay", 0.0)
    integral, acting, waiting, wanted_speed, before = 0.0, 0.0, 0.0, 0.0, 0.0
    rows = []
    for k in range(round(TIME / period) + 1):
        motor, omega, load = plant.state[:3]
        rows.append((motor, load))
        if k % loop["position_every"] == 0:
            angle, speed = move(k * period)
            seen = _count(load, loop["resolution"])
            wanted_speed = loop["position_gain"] * (angle - seen) + loop["feedforward"] * speed
        count = _count(motor, loop["speed_resolution"])
        measured_speed = omega if loop["speed_resolution"] == 0.0 else (count - before) / period if k else 0.0
        before = count
        error = wanted_speed - measured_speed
        demand = loop["speed_gain"] * error + loop["integral_gain"] * integral
        torque = min(max(demand, -loop["torque_limit"]), loop["torque_limit"])
        integral += period * (error + (torque - demand) / loop["speed_gain"])
        if delay in (0.0, period):
            acting, waiting = (waiting, torque) if delay else (torque, torque)
            plant.step(acting, period)
        else:
            plant.step(acting, delay)
            acting = torque
            plant.step(acting, period - delay)
    return np.array(rows)


def _count(angle: float, resolution: float) -> float:
    return resolution * math.floor(angle / resolution + 0.5) if resolution else angle


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("changes", "lag"),
    [
        pytest.param({}, 0.0, marks=pytest.mark.slow),
        pytest.param({"delay": 0.4e-3}, 0.0, marks=pytest.mark.slow),
        ({"delay": 1e-3, "torque_limit": 0.2}, 0.0),
        ({"delay": 0.4e-3, "position_every": 1}, 0.5e-3),
        pytest.param({"resolution": 0.0, "speed_resolution": 0.0}, 0.0, marks=pytest.mark.slow),
    ],
)
def test_sampled_cascade__encoder_behind_play(changes: Document, lag: float, measured: Measured) -> None:
    """Matrix exponentials between samples and contacts; the load's encoder is behind the play, the motor's before it."""
    loop = LOOP | changes
    more = {"current_time": lag} if lag else {}
    run = gp.simulate(case(angle={"trapezoid": MOVE}, **loop, **more))
    theta = run.ds["theta"].squeeze().transpose("time", "rotor").values
    exact = by_hand(loop, Lagged(PAIR, lag) if lag else Exact(PAIR))[: len(theta)]
    assert np.ptp(exact[:, 0] - exact[:, 1]) > 0.9 * PAIR.play  # both flanks
    worst = float(np.max(np.abs(theta - exact)))
    measured("sampled cascade with an encoder behind play: angles over 0.5 s [rad]", worst, "1e-8")
    assert worst < 1e-8


def test_cascade__is_the_position_loop_with_its_integral_on_the_speed_error(measured: Measured) -> None:
    """Continuous, motor alone: J omega' = kv (v - omega) + ki z, z' = v - omega, v = k e + f angle', by another integrator."""
    from scipy.integrate import solve_ivp

    J, k, kv, ki, feed, lag = 1e-3, 30.0, 0.08, 1.5, 0.6, 2e-3
    rest = {"theta": 0.0, "omega": 0.0}
    document = {
        "rotors": {
            "motor": {
                "mass": 1.0,
                "inertia": J,
                "initial": rest,
                "drive": {
                    "kind": "cascade",
                    "angle": {"sine": {"amplitude": 0.2, "frequency": "3 Hz", "phase": 0.4, "mean": 0.1}},
                    "position_gain": k,
                    "speed_gain": kv,
                    "integral_gain": ki,
                    "feedforward": feed,
                    "torque_limit": 100.0,
                    "current_time": lag,
                },
            }
        },
        "run": {"duration": 0.3, "sampling": 1e3, "tolerance": 1e-12},
    }

    def rates(t: float, y: Any) -> list[float]:
        angle = 0.1 + 0.2 * math.sin(6.0 * math.pi * t + 0.4)
        wanted = k * (angle - y[0]) + feed * 0.2 * 6.0 * math.pi * math.cos(6.0 * math.pi * t + 0.4)
        return [y[1], y[3] / J, wanted - y[1], (kv * (wanted - y[1]) + ki * y[2] - y[3]) / lag]

    run = gp.simulate(document)
    times = run.ds["time"].values
    exact = solve_ivp(rates, (0.0, 0.3), [0.0] * 4, method="DOP853", t_eval=times, rtol=1e-12, atol=1e-14).y
    worst = float(np.max(np.abs(run.ds["theta"].values.ravel() - exact[0])))
    measured("continuous cascade with a current loop: angle [rad]", worst, "1e-9")
    assert worst < 1e-9


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"delay": 2e-3}, r"drive\.delay.*at most sample_time"),
        ({"sample_time": 0.0}, r"drive\.resolution.*must be 0 for a continuous control"),
        ({"speed_sensor": "other"}, r"speed_sensor.*other"),
        ({"angle": {"trapezoid": MOVE}, "over_time": {"step": {"time": 0.1, "value": 1.0}}}, "given together with angle"),
        ({"angle": 0.3, "over_time": {"step": {"time": 0.1, "value": 1.0}}}, r"drive\.angle.*left out"),
        ({"angle": {"trapezoid": {**MOVE, "rise": 0.0, "hold": 0.0, "fall": 0.0}}}, "must be above 0 s"),
        ({"angle": {"step": {"time": 0.1, "value": 1.0}, "sine": {"amplitude": 0.1, "frequency": 1.0}}}, "one of step, sine"),
        ({"angle": {"table": [[0.0, 0.0], [0.0, 1.0]]}}, r"table\.1.*later"),
        ({"angle": "nowhere.csv"}, "nowhere.csv"),
        ({"position_gain": 0.0}, "position_gain"),
    ],
)  # fmt: skip
def test_cascade__refusals(changes: Document, words: str) -> None:
    with pytest.raises(InputError, match=words):
        gp.simulate(case(**({"angle": 0.1} | LOOP | changes)), duration=0.001)
