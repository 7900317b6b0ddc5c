"""ROSS, a rotor-dynamics library with a backlash model of its own: the cost of one simulated second of it.

Another model (finite elements, constant steps of Newmark's method), so no common problem: speed only.
ROSS 3.1 asks for Python 3.13. GEARPLAY_BENCH_ROSS names the Python of an environment that has it; this file
is then run there by itself.
"""

import contextlib
import json
import math
import os
import subprocess
import sys
import time

NAME = ["newmark"]
PYTHON = os.environ.get("GEARPLAY_BENCH_ROSS", "")
POINTS = 6000  # per revolution, as in the library's own test of its backlash model
SPEED = 1000.0 * math.pi / 30.0  # rad/s


def missing():
    """Return what to install, None if nothing."""
    command = [PYTHON or sys.executable, "-c", "import ross"]
    hint = "pip install ross-rotordynamics in its own environment; GEARPLAY_BENCH_ROSS names its Python"
    try:
        done = subprocess.run(command, capture_output=True, timeout=300)
    except (OSError, subprocess.TimeoutExpired):
        return hint
    return None if done.returncode == 0 else hint


def seconds_per_simulated_second():
    """Return wall seconds for a simulated second, and what was simulated."""
    command = [PYTHON or sys.executable, os.path.abspath(__file__)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=True)
    answer = json.loads(done.stdout.strip().splitlines()[-1])
    return answer["value"], answer["what"]


def build():
    """Return two equal rotors with a spur gear each: 20 teeth of 10 mm, 30 mm wide, 6.57 kg, backlash."""
    import numpy as np
    import ross

    steel = ross.Material(name="steel", rho=7850, E=2e11, Poisson=0.3)
    weightless = ross.Material(name="weightless", rho=0.01, E=1e15, Poisson=0.3)
    width, mass, pitch_diameter = 0.030, 6.57, 0.2
    bore = np.sqrt(pitch_diameter**2 - 4 * mass / (np.pi * width * steel.rho))

    def rotor():
        shaft = ross.ShaftElement(n=0, L=1e-4, idl=0.0, odl=1e-4, material=weightless)
        gear = ross.GearElementTVMS(
            n=0, material=steel, width=width, bore_diameter=bore, module=0.01, n_teeth=20,
            pr_angle=math.radians(20.0), helix_angle=0, addendum_coeff=1, tip_clearance_coeff=0.25,
        )  # fmt: skip
        bearing = ross.BearingElement(n=0, kxx=1e8, kyy=1e8, cxx=512.64, cyy=512.64)
        return ross.Rotor([shaft], [gear], [bearing])

    return ross.MultiRotor(
        rotor(), rotor(), coupled_nodes=(0, 0), orientation_angle=0.0, position="above",
        mesh_damping_ratio=0.07, square_varying_stiffness={"enable": True, "amplitude_ratio": 0.275},
        backlash={
            "enable": True, "initial_value": 5e-5, "error_amp": 2e-5, "smooth_operator": False, "sigma": 1e5,
        },
    )  # fmt: skip


def run(pair, revolutions):
    """Simulate some revolutions under 300 N m with a swing of 100 N m; return wall time, span and result."""
    import numpy as np

    t = np.linspace(0.0, revolutions * 2.0 * math.pi / SPEED, int(revolutions * POINTS))
    torque = 300.0 + 100.0 * np.sin(SPEED * t)
    force = np.zeros((t.size, pair.ndof))
    for element in pair.disk_elements:
        force[:, element.n * pair.number_dof + 5] = torque
    began = time.perf_counter()
    result = pair.run_time_response(speed=SPEED, t=t, F=force, method="newmark", newmark_type="robust")
    return time.perf_counter() - began, t[-1], result


def main():
    """Print the measurement as one line of JSON."""
    import ross

    with contextlib.redirect_stdout(sys.stderr):
        run(build(), 0.1)  # compiles
        seconds, simulated, result = run(build(), 2.0)  # ROSS lets a pair with backlash run only once
    force = float(abs(result.mesh_dynamics["mesh_force"]).mean())
    what = (
        f"ROSS {ross.__version__} on Python {sys.version.split()[0]}: its spur pair with backlash, "
        f"1000 rpm, Newmark, {POINTS} steps per revolution, {simulated:.2f} s simulated, "
        f"mean mesh force {force:.0f} N"
    )
    print(json.dumps({"value": seconds / simulated, "what": what}))


if __name__ == "__main__":
    main()
