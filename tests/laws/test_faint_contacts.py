"""Contacts that hardly press: errors are small against what they could disturb, so no tolerance shakes a mesh loose."""

import math

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.integrate import run as kernel
from gearplay.kernels.layout import PENETRATION
from gearplay.solver.flow import Flow
from gearplay.solver.simulate import run_members

Floats = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

DRAG, STIFFNESS, INERTIA = 2.93e-4, 1.3e8, 0.0612  # of the ring, N m s/rad, N/m, kg m^2
SPEED = 2.0 * math.pi  # rad/s, of the pinion
BASE_RADIUS = 0.5 * 0.004 * 60 * math.cos(math.radians(20.0))
PERIODS = 40
HARDLY_LOADED = {
    "backlash_model": "uncoupled",
    "gravity.1": 0.01,
    "rotors.pinion.drive.speed": "60 rpm",
    "rotors.pinion.runout.amplitude": "3.7 um",
    "rotors.ring.runout.amplitude": "20 um",
    "rotors.ring.load.drag": 7.2e-4,
    "rotors.ring.radial_damping": 0.08,
    "sleeves.ring.restitution": 0.1,
    "meshes.0.transmission_error": [
        {"order": 1, "amplitude": "0.079 um"},
        {"order": 2, "amplitude": "0.0143 um", "phase": "234 deg"},
    ],
}


def turning_on_drag(tolerance: float) -> gp.Case:
    """Return the article's pair at 60 rpm, its ring centred, with nothing that excites it: drag presses the flanks by 5 mN."""
    return gp.replace(
        gp.load_case("han2021"),
        {
            "rotors.pinion.drive.speed": SPEED,
            "sleeves": {},
            "meshes.0.transmission_error": [],
            "meshes.0.stiffness.amplitude": 0.0,
            "rotors.pinion.runout.amplitude": 0.0,
            "rotors.ring.runout.amplitude": 0.0,
            "run.tolerance": tolerance,
        },
    )


def vibration_left(tolerance: float) -> tuple[float, int]:
    """Return the vibration of a pressed flank after `PERIODS` over its static deflection, half of it at first; and events."""
    static = DRAG * SPEED / 3.0 / BASE_RADIUS / STIFFNESS
    assert static == pytest.approx(4.2e-11, rel=0.02)  # m: the point of it
    flow = Flow(turning_on_drag(tolerance))
    state = 0.0 * flow.start()
    state[5] = -1.5 * static / BASE_RADIUS  # the ring lags
    course = flow.begin(state)
    period = 2.0 * math.pi / math.sqrt(STIFFNESS * BASE_RADIUS**2 / INERTIA)
    course.advance(PERIODS * period)
    seen = []
    for _ in range(8):
        course.advance(course.time + period / 8.0)
        seen.append(course.run.loads_0.contacts[0, PENETRATION] / static - 1.0)
    return float(np.abs(seen).max()), int(course.run.counts[kernel.EVENTS])


@pytest.mark.parametrize("tolerance", [1e-9, 1e-7, 1e-6])
def test_a_faint_vibration_is_neither_damped_nor_driven(tolerance: float, measured: Measured) -> None:
    """So shallow a flank is undamped: a vibration of half its deflection of 4e-11 m keeps its size, and it keeps in touch."""
    left, events = vibration_left(tolerance)
    measured("vibration of 2e-11 m, damped by 2 % in 40 periods: share that is left", left / 0.5, "0.95 to 1")
    assert 0.95 < left / 0.5 < 1.0
    assert events == 0


@pytest.mark.slow
def test_the_tolerance_does_not_make_a_mesh_rattle(measured: Measured) -> None:
    """Of a pair like the calibrated one, its flanks pressed by 13 mN of drag: time in touch and impacts are those at 1e-9."""
    case = gp.replace(gp.load_case("han2021"), HARDLY_LOADED)

    def seen(tolerance: float) -> Floats:
        fine = gp.replace(case, {"run.tolerance": tolerance})
        runs = run_members(fine, range(1, 17), duration=1.0, transient=5.0, sampling=100.0)
        of_flank = [(r.statistics.share_of_time[1], r.statistics.impacts_per_second[1]) for r in runs]
        return np.array(of_flank).T

    fine = seen(1e-9)
    assert np.mean(fine[0]) > 0.8
    for tolerance in (1e-7, 1e-6):
        coarse = seen(tolerance)
        spread = np.sqrt((fine.var(axis=1, ddof=1) + coarse.var(axis=1, ddof=1)) / 16.0)
        worst = float(np.max(np.abs(coarse.mean(axis=1) - fine.mean(axis=1)) / spread))
        measured(
            "mesh pressed by drag, tolerance 1e-6 against 1e-9: difference in standard errors", worst, "3"
        )
        assert worst < 3.0
