"""Efficiency of sweeps: many cases of 50 ms on two workers against the same cases one after another, and memory.

``python -m bench.sweeps [cases]``; each way in a process of its own.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PLAN = {
    "title": "bench",
    "case": "han2021",
    "set": {"run.transient": 0.0, "run.sampling": 100.0, "run.tolerance": 1e-7},
    "reduce": [
        {"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"},
        {"kind": "contact", "name": "impacts", "contact": "ring", "statistic": "impacts_per_second"},
    ],
}
CASE_TIME = 0.05  # s, wanted


def plan_of(cases, duration):
    """Return the plan as a mapping: seeds make the cases alike in cost."""
    return {
        **PLAN,
        "set": {**PLAN["set"], "run.duration": duration},
        "axes": [{"name": "seed", "path": "run.seed", "values": list(range(cases))}],
    }


def alone(duration, cases):
    """Return the mean time [s] of the simulation alone, one core, nothing beside it."""
    import gearplay as gp
    from gearplay.solver.simulate import run_one

    base = gp.replace(gp.load_case("han2021"), {**PLAN["set"], "run.duration": duration})
    run_one(base, signals=["ring.vx"])
    each = [gp.replace(base, {"run.seed": seed}) for seed in range(cases)]
    started = time.perf_counter()
    for case in each:
        run_one(case, signals=["ring.vx"])
    return (time.perf_counter() - started) / cases


def measure(cases, duration, workers):
    """Return (seconds, peak memory of the parent [MB]) of a sweep in a folder."""
    from gearplay.sweeps.plans.reading import load_sweep
    from gearplay.sweeps.sweep import sweep

    plan = load_sweep(plan_of(cases, duration))
    with tempfile.TemporaryDirectory() as folder:
        started = time.perf_counter()
        sweep(plan, folder=folder, threads=workers)
        taken = time.perf_counter() - started
    return taken, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main():
    if sys.argv[1:2] == ["one"]:
        print(json.dumps(measure(int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]))))
        return
    cases = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    duration = 10.0 * CASE_TIME / alone(10.0, 20)
    single = alone(duration, 60)
    ideal = cases * single / 2.0
    words = [sys.executable, "-m", "bench.sweeps", "one", str(cases), str(duration), "2"]
    done = subprocess.run(words, capture_output=True, text=True, check=True, cwd=Path(__file__).parents[1])
    taken, memory = json.loads(done.stdout)
    print(
        f"{cases} cases of {1e3 * single:.1f} ms ({duration:.3g} simulated s) on 2 workers: {taken:.1f} s, "
        f"{100.0 * ideal / taken:.1f} % of ideal ({ideal:.1f} s); peak memory {memory:.0f} MB"
    )


if __name__ == "__main__":
    main()
