"""`gp.Stepper` at 1 kHz, step by step and as a rollout, over one run, and a batch beside MuJoCo's.

``python -m bench.stepping [rounds]``
"""

import sys
import time

import numpy as np

import gearplay as gp
from bench.peers import mujoco_peer
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
    stepper.reset(seed=case.run.seed)  # a drawn start: an exactly centred shaft may stay where it is
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


THREADS = 2


def batch(rounds):
    """Return wall and CPU times [s] by method of a batch, in turn; each member has torques that change from step to step."""
    names = {"inputs": ["motor.drive.torque"], "outputs": ["load.theta"]}
    stepper = gp.Stepper(TWO_INERTIAS, **names, batch=MEMBERS, threads=THREADS)
    steps = np.arange(round(SPAN / DT))
    torque = 0.5 * np.sin(0.35 * steps) + 0.15 * np.sign(np.sin(0.735 * steps + 0.4))
    control = np.random.default_rng(0).uniform(0.5, 1.0, (MEMBERS, 1)) * torque
    methods = ["step by step", "rollout"]
    if mujoco_peer.missing() is None:
        methods += ["MuJoCo, step by step", "MuJoCo, all steps in one call"]
    found = {method: [] for method in methods}
    for _ in range(rounds):
        for method, times in found.items():
            if method.startswith("MuJoCo"):
                at_once = method.endswith("one call")
                times.append(mujoco_peer.rollout(TWO_INERTIAS, DT, control, THREADS, at_once=at_once))
                continue
            stepper.reset()
            began, worked = time.perf_counter(), time.process_time()
            if method == "rollout":
                stepper.rollout(DT, np.ascontiguousarray(control.T[:, :, None]))
            else:
                for each in control.T:
                    stepper.step(DT, each[:, None])
            times.append((time.perf_counter() - began, time.process_time() - worked))
    return {method: np.array(times) for method, times in found.items()}


def main():
    """Print the tables."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    for name in LOOPS:
        run, stepped, rolled = compare(name, rounds).T
        print(
            f"{name}: {run.min() / SPAN * 1e3:.1f} ms per simulated s, stepped over that {stepped.min() / run.min():.2f} "
            f"(least times), {np.median(stepped / run):.2f} (median), a rollout {rolled.min() / run.min():.2f}"
        )
    print(f"{MEMBERS} members, {SPAN} s at {DT} s, {THREADS} threads; wall and CPU time, least to largest:")
    for method, times in batch(max(2, rounds // 5)).items():
        (wall, cpu), (most_wall, most_cpu) = times.min(axis=0), times.max(axis=0)
        print(f"  {method}: {wall:.2f} to {most_wall:.2f} s, {cpu:.2f} to {most_cpu:.2f} s")
    if (cure := mujoco_peer.missing()) is not None:
        print(f"  without MuJoCo: {cure}")


if __name__ == "__main__":
    main()
