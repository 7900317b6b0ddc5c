"""A rattling ring with a flywheel behind an elastic coupling, beside one rotor of the summed inertia.

Alone: ``python -m bench.joined``.
"""

import time

import gearplay as gp
from gearplay.solver.simulate import run_one

COUPLINGS = {"0.2 kN m/rad": (2e2, 0.05), "2 kN m/rad": (2e3, 0.1), "20 kN m/rad": (2e4, 1.0)}
REPEATS = 5
MEMBERS = 4


def _case(coupling=None):
    case = gp.load_case("han2021")
    changes = {"run.duration": "20 s", "run.transient": "0.5 s", "run.sampling": "1 Hz", "run.start": "drawn"}
    if coupling is None:
        return gp.replace(case, changes)
    stiffness, damping = coupling
    document = gp.replace(case, changes).model_dump(mode="json", exclude_none=True)
    ring = document["rotors"]["ring"]
    ring["inertia"] *= 0.5
    document["rotors"]["flywheel"] = {"mass": ring["mass"], "inertia": ring["inertia"]}
    document["couplings"] = [
        {"between": ["ring", "flywheel"], "torsional_stiffness": stiffness, "torsional_damping": damping}
    ]
    return gp.load_case(document)


def _per_change(case):
    """Return processor time per contact change [s], and steps per change."""
    start, events, steps = time.thread_time(), 0, 0
    for member in range(1, 1 + MEMBERS):
        counters = run_one(case, member, signals=["ring.ax"]).counters
        events, steps = events + counters.events, steps + counters.steps
    return (time.thread_time() - start) / events, steps / events


def report():
    """Return the table of costs per contact change, measured in turn."""
    cases = {"one rotor": _case(), **{name: _case(each) for name, each in COUPLINGS.items()}}
    for case in cases.values():
        _per_change(case)
    costs = {name: [] for name in cases}
    for _ in range(REPEATS):
        for name, case in cases.items():
            costs[name].append(_per_change(case))
    lines = [
        f"`han2021` for {MEMBERS} x 20 s, its ring in two halves behind a coupling; times that of one ring, least to largest of"
        f" {REPEATS} repeats in turn.",
        "",
        "| | us per contact change | times one rotor | steps per change |",
        "|---|---:|---:|---:|",
    ]
    for name, found in costs.items():
        ratios = sorted(a / b for (a, _), (b, _) in zip(found, costs["one rotor"], strict=True))
        lines.append(
            f"| {name} | {1e6 * min(found)[0]:.1f} | {ratios[0]:.2f} to {ratios[-1]:.2f} | {found[0][1]:.1f} |"
        )
    return lines


if __name__ == "__main__":
    print("\n".join(report()))
