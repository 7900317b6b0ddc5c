"""Work against error for our solver and SciPy's on the same equations, throughput, and start-up times.

The peers get our compiled right-hand side behind one Python call, with every contact's branch chosen by the state alone. The
sleeve's restitution is 1, so that the impact speed, which they cannot latch, plays no part. All in one process, in turn.
"""

import os
import platform
import subprocess
import sys
import tempfile
import time
from statistics import median

import numpy as np
from scipy.integrate import solve_ivp

import gearplay as gp
from gearplay.kernels import run_state, stepper
from gearplay.kernels.layout import LOADED, MARGIN, OPEN, PENETRATION
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.switches import contact_count
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack

SPAN = 0.02  # s: short enough that errors are errors and not chaos
MEMBERS = (1, 2, 3, 4, 5)
METHODS = ("RK45", "DOP853", "LSODA")
CASE = gp.replace(
    gp.load_case("han2021"),
    {"sleeves.ring.restitution": 1.0, "rotors.ring.initial.vx": 0.05, "run.transient": 0.0},
)


def start(tolerance, member):
    """Return a packed system and a run at its start."""
    packed = pack(CASE)
    y = initial_state(CASE, packed, member=member)
    motion = run_state.make_motion(
        packed.system, y, packed.natural, packed.restart_step, packed.stops, np.arange(0), 64, 4096, tolerance
    )
    return packed, motion


def ours(tolerance, member):
    """Return the final state and the wall time [s]."""
    packed, motion = start(tolerance, member)
    began = time.perf_counter()
    stepper.begin(packed.system, motion)
    motion.clock[run_state.T_END] = SPAN
    status = stepper.advance(packed.system, motion, 10**9)
    assert status == run_state.DONE, status
    return motion.y.copy(), time.perf_counter() - began


def peer(method, tolerance, member):
    """Return the final state and the wall time [s] of one of SciPy's methods."""
    packed, motion = start(tolerance, member)
    system, contacts = packed.system, contact_count(packed.system)
    sleeves, flanks = system.sleeves.size, 2 * system.meshes.size
    depths = np.repeat(system.meshes.depth, 2)
    motion.latch[:] = 1.0
    dy = np.zeros_like(motion.y)

    def derivative(t, y):
        right_hand_side(
            system, t, y, motion.modes, motion.latch, dy, motion.contacts, motion.force, motion.out
        )
        depth, margin = motion.contacts[:, PENETRATION], motion.contacts[:, MARGIN]
        beyond = depth[sleeves:] > depths
        modes = np.where((depth > 0.0) & (margin > 0.0), LOADED, OPEN)
        now = np.concatenate([modes, beyond])
        if not np.array_equal(now, motion.modes[: contacts + flanks]):
            motion.modes[: contacts + flanks] = now
            right_hand_side(
                system, t, y, motion.modes, motion.latch, dy, motion.contacts, motion.force, motion.out
            )
        return dy.copy()

    began = time.perf_counter()
    solution = solve_ivp(
        derivative,
        (0.0, SPAN),
        motion.y.copy(),
        method=method,
        rtol=1e-12,
        atol=tolerance * packed.natural,
        max_step=1e-3,
    )
    return solution.y[:, -1], time.perf_counter() - began


def error(y, exact):
    """Return the largest error of a displacement [m]."""
    n = y.size // 6
    return max(abs(y[3 * i + c] - exact[3 * i + c]) for i in range(n) for c in (0, 1))


def at_error(points, wanted):
    """Return the wall time interpolated to an error, on logarithms; NaN outside the measured errors."""
    points = sorted(points)
    errors, times = np.log([p[0] for p in points]), np.log([p[1] for p in points])
    if not errors[0] <= np.log(wanted) <= errors[-1]:
        return float("nan")
    return float(np.exp(np.interp(np.log(wanted), errors, times)))


def work_precision():
    """Print wall time and error of every method, and the ratios at equal error."""
    print(f"\nWork and precision: {SPAN} s of han2021, medians over {len(MEMBERS)} initial states")
    exact = {m: ours(1e-13, m)[0] for m in MEMBERS}
    ours(1e-9, 1)
    tables = {}
    for name in ("gearplay", *METHODS):
        points = []
        for tolerance in (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10):
            runs = [ours(tolerance, m) if name == "gearplay" else peer(name, tolerance, m) for m in MEMBERS]
            e = median(error(y, exact[m]) for (y, _), m in zip(runs, MEMBERS, strict=True))
            t = median(t for _, t in runs)
            points.append((max(e, 1e-18), t))
            print(f"  {name:<9} tolerance {tolerance:.0e}: error {e:9.2e} m, {1e3 * t:9.3f} ms")
        tables[name] = points
    for wanted in (1e-8, 1e-10):
        base = at_error(tables["gearplay"], wanted)
        ratios = ", ".join(
            f"{n} {at_error(p, wanted) / base:.0f}x" for n, p in tables.items() if n != "gearplay"
        )
        print(f"  time over gearplay's at an error of {wanted:.0e} m: {ratios}   (nan: error not reached)")


def throughput():
    """Print simulated seconds per wall second."""
    print("\nThroughput, han2021 at 120 rpm, tolerance 1e-9, simulated seconds per wall second")
    for words, sampling, threads, members in (
        ("100 kHz, all signals, one core", 1e5, 1, 2),
        ("1 kHz, one core", 1e3, 1, 8),
        ("1 kHz, all cores", 1e3, None, 16),
    ):
        gp.simulate("han2021", duration=0.01, transient=0.0)
        began = time.perf_counter()
        gp.simulate(
            "han2021", duration=5.0, transient=0.0, sampling=sampling, ensemble=members, threads=threads
        )
        print(f"  {words:<32} {5.0 * members / (time.perf_counter() - began):8.1f}")


def starting():
    """Print start-up times of fresh processes, with a cold and a warm kernel cache."""
    print("\nStart-up, whole processes [s]")
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        run = [sys.executable, "-m", "gearplay.cli.main", "run", "han2021", "--set", "run.duration=0.1"]
        for words, command in (
            ("gearplay run, kernels compiled", run),
            ("gearplay run, kernels cached", run),
            ("gearplay --version", [sys.executable, "-m", "gearplay.cli.main", "--version"]),
            ("import gearplay", [sys.executable, "-c", "import gearplay"]),
        ):
            began = time.perf_counter()
            subprocess.run(command, env=environment, check=True, capture_output=True)
            print(f"  {words:<32} {time.perf_counter() - began:8.2f}")


if __name__ == "__main__":
    print(
        f"gearplay {gp.__version__}, Python {platform.python_version()}, {os.cpu_count()} cores, {platform.machine()}"
    )
    work_precision()
    throughput()
    starting()
