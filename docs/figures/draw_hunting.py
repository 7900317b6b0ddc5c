"""Draw the picture of the tutorial on a loop that hunts: its motion, its limit cycles over the gain and their prediction."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import gearplay as gp
from gearplay.pictures.canvas import to_bytes
from gearplay.pictures.style import COUPLED, TEST, UNCOUPLED

CASE = Path(__file__).resolve().parents[1] / "tutorial" / "hunting.toml"
GAIN = "rotors.motor.drive.proportional_gain"
MRAD = 1e3


def draw() -> bytes:
    """Return the picture as PNG."""
    case = gp.load_case(CASE)
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    orbit = gp.periodic_orbit(case, autonomous=True, settle=40)
    motion = orbit.motion(["load.theta", "motor.theta"], samples=400)
    time = np.concatenate([motion["time"].values, motion["time"].values + orbit.period])
    for name, ratio, color in (("motor", 5.0, UNCOUPLED), ("load", 1.0, COUPLED)):
        angle = MRAD * np.tile(motion[f"{name}.theta"].values, 2) / ratio
        left.plot(time, angle, color=color, linewidth=1.4, label=name if ratio == 1.0 else f"{name} / 5")
    left.set_xlabel("time [s]", fontsize=8)
    left.set_ylabel("angle [mrad]", fontsize=8)
    branch = gp.branch(case, GAIN, 0.25, 1.3, autonomous=True, settle=40, upwards=False, orbits=60)
    up = gp.branch(case, GAIN, 0.25, 1.3, autonomous=True, settle=40, orbits=60)
    rows = []
    for each in [*branch.orbits[::-1], *up.orbits[1:]]:
        changed = gp.replace(case, {GAIN: each.parameter})
        rows.append(
            (each.parameter, replace(orbit, **vars(each), case=changed).amplitude("load.theta", samples=400))
        )
    gains, amplitudes = np.array(rows).T
    right.plot(gains, MRAD * amplitudes, color=COUPLED, linewidth=1.6, label="limit cycle")
    predicted = []
    for gain in np.linspace(0.25, 1.3, 15):
        at = gp.describing_function(
            gp.replace(case, {GAIN: float(gain)}), at="load", hold="motor", torque=0.4
        )
        predicted += [(gain, MRAD * float(a)) for a in at.ds["cycle_amplitude"].values]
    right.plot(*np.array(predicted).T, "o", color=TEST, markersize=3.5, label="describing function")
    right.set_xlabel("proportional gain [N m/rad]", fontsize=8)
    right.set_ylabel("amplitude of the load [mrad]", fontsize=8)
    right.set_ylim(bottom=0.0)
    for ax in (left, right):
        ax.legend(fontsize=8, frameon=False)
        ax.tick_params(labelsize=8)
    return to_bytes(figure, "png")


if __name__ == "__main__":
    CASE.with_name("hunting.png").write_bytes(draw())
