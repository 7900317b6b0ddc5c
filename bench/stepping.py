"""`gp.Stepper` at 1 kHz, step by step and as a rollout, over one run, and a batch: ``python -m bench.stepping [rounds]``."""

import sys
import time

import numpy as np

import gearplay as gp
from gearplay.model.pack import pack
from gearplay.solver.integration import Course

DT, SPAN = 1e-3, 0.2  # s
# Cases, and an input that is set to its own value in each step.
LOOPS = {
    "two-stage-reducer": ["output.load.torque"],
    "planetary-reducer": ["stage.carrier.load.torque"],
    "torsional-train": [],
    "external-pair": [],
    "han2021": ["ring.load.torque"],
}
MEMBERS = 4096
TWO_INERTIAS = {
    "rotors": {
        "motor": {
            "mass": 1.0,
            "inertia": 1e-3,
            "drive": {"kind": "torque", "torque": 0.0},
            "load": {"drag": 1e-3},
        },
        "load": {"mass": 1.0, "inertia": 4e-3},
    },
    "couplings": [
        {"between": ["motor", "load"], "torsional_stiffness": 2000.0, "torsional_damping": 0.5, "play": 4e-3}
    ],
    "run": {"duration": 1.0, "tolerance": 1e-6},
}


def compare(name, rounds):
    """Return CPU times [s] of runs, of stepped runs and of rollouts, in turn."""
    case = gp.load_case(name)
    last = list(case.rotors)[-1]
    stepper = gp.Stepper(case, inputs=LOOPS[name], outputs=[f"{last}.omega", f"{last}.theta"])
    start, packed, times = stepper.state, pack(case), []
    values = np.array([each.start for each in stepper._inputs]) if LOOPS[name] else None
    plan = np.tile([each.start for each in stepper._inputs], (round(SPAN / DT), 1))
    for _ in range(rounds):
        course = Course(case, packed, start)
        stepper.reset(states=start)
        marks = [time.process_time()]
        course.advance(SPAN)
        marks.append(time.process_time())
        for _ in range(round(SPAN / DT)):
            stepper.step(DT, values)
        marks.append(time.process_time())
        stepper.reset(states=start)
        marks.append(time.process_time())
        stepper.rollout(DT, plan)
        marks.append(time.process_time())
        times.append(np.diff(marks)[[0, 1, 3]])
    return np.array(times)


def batch(rounds):
    """Return wall and CPU times [s] of a batch whose members each have torques that change from step to step."""
    stepper = gp.Stepper(TWO_INERTIAS, inputs=["motor.drive.torque"], outputs=["load.theta"], batch=MEMBERS)
    steps = np.arange(round(SPAN / DT))
    torque = 0.5 * np.sin(0.35 * steps) + 0.15 * np.sign(np.sin(0.735 * steps + 0.4))
    scales = np.random.default_rng(0).uniform(0.5, 1.0, (MEMBERS, 1))
    times = []
    for _ in range(rounds):
        stepper.reset()
        began, worked = time.perf_counter(), time.process_time()
        for each in torque:
            stepper.step(DT, each * scales)
        times.append((time.perf_counter() - began, time.process_time() - worked))
    return np.array(times)


def main():
    """Print the tables."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    for name in LOOPS:
        run, stepped, rolled = compare(name, rounds).T
        print(
            f"{name}: {run.min() / SPAN * 1e3:.1f} ms per simulated s, stepped over that {stepped.min() / run.min():.2f} "
            f"(least times), {np.median(stepped / run):.2f} (median), a rollout {rolled.min() / run.min():.2f}"
        )
    wall, cpu = batch(max(1, rounds // 5)).min(axis=0)
    print(f"{MEMBERS} members, {SPAN} s at {DT} s: {wall:.2f} s, CPU time {cpu:.2f} s")


if __name__ == "__main__":
    main()
