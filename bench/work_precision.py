"""Wall time at equal error: ours, the plain method on the same kernels, and everything a user would pick instead."""

import importlib
import time
from itertools import pairwise
from statistics import median

import numpy as np

from bench.problem import LIVELY, QUIET
from gearplay.kernels import run as kernel

PEERS = (
    ("plain 5(4), same kernels", "bench.plain"),
    ("SciPy", "bench.peers.scipy_peer"),
    ("numbalsoda", "bench.peers.numbalsoda_peer"),
    ("SUNDIALS CVODE", "bench.peers.sundials_peer"),
    ("diffrax", "bench.peers.diffrax_peer"),
    ("Boost odeint, C++", "bench.peers.odeint_peer"),
)
TOLERANCES = tuple(10.0**-k for k in np.arange(4.0, 10.5, 0.5))
WANTED = (1e-8, 1e-10)  # m
REPEATS = 15  # of quick runs; the least time counts, since this machine may be shared


def ours(problem, member, tolerance):
    """Return our final state and the seconds from given state to final state."""
    run = problem.run(member, tolerance)
    began = time.perf_counter()
    problem.finish(run)
    seconds = time.perf_counter() - began
    assert run.clock[kernel.T] == problem.span
    return run.y, seconds


def curve(problem, solve):
    """Return (median error, median seconds) over the members at each tolerance, until a method fails or is slow."""
    points = []
    for tolerance in TOLERANCES:
        errors, times = [], []
        for member in problem.members:
            runs = [solve(problem, member, tolerance)]
            runs += [solve(problem, member, tolerance) for _ in range(REPEATS if runs[0][1] < 0.01 else 2)]
            errors.append(problem.error(member, runs[0][0]))
            times.append(min(run[1] for run in runs))
        if np.all(np.isfinite(errors)):
            points.append((max(median(errors), 1e-16), median(times)))
        if sum(times) > 3.0:
            break
    return points


def time_at(points, wanted):
    """Return the least seconds that reach an error, between the measured points; NaN where none does.

    Only what more work cannot undo counts: of two points with falling error the later, dearer one.
    """
    best = float("nan")
    for (e_0, t_0), (e_1, t_1) in pairwise(points):
        if e_1 <= wanted <= e_0:
            share = np.log(e_0 / wanted) / np.log(e_0 / e_1) if e_0 > e_1 else 1.0
            best = float(np.exp((1.0 - share) * np.log(t_0) + share * np.log(t_1)))
    if points and points[0][0] <= wanted and not best > 0.0:
        best = points[0][1]
    return best


def curves(problem):
    """Return every method's curve by name, and why others are missing."""
    found, absent = {"gearplay": curve(problem, ours)}, {}
    for family, place in PEERS:
        try:
            module = importlib.import_module(place)
            reason = module.missing()
        except ImportError as error:
            absent[family] = str(error)
            continue
        if reason:
            absent[family] = reason
            continue
        for method in getattr(module, "offered", lambda names=module.NAME: names)():

            def solve(problem, member, tolerance, module=module, method=method):
                return module.solve(problem, member, method, tolerance)

            name = family if method == "5(4)" else f"{family} {method}"
            found[name] = curve(problem, solve)
    return found, absent


def report():
    """Return the tables as lines of Markdown."""
    lines = []
    for problem in (LIVELY, QUIET):
        found, absent = curves(problem)
        lines += [
            "",
            f"### {problem.name.capitalize()}: {1e3 * problem.span:g} ms, {len(problem.members)} initial states",
            "",
            "| method | " + " | ".join(f"ms at {w:.0e} m | times ours" for w in WANTED) + " |",
            "|---|" + "---:|" * (2 * len(WANTED)),
        ]
        base = [time_at(found["gearplay"], w) for w in WANTED]
        for name, points in found.items():
            cells = []
            for wanted, ground in zip(WANTED, base, strict=True):
                seconds = time_at(points, wanted)
                known = seconds > 0.0
                cells += [f"{1e3 * seconds:.3g}", f"{seconds / ground:.1f}"] if known else ["not reached", ""]
            lines.append(f"| {name} | " + " | ".join(cells) + " |")
        lines += ["", *(f"Missing: {name}: {reason}." for name, reason in absent.items())]
    return lines


if __name__ == "__main__":
    print("\n".join(report()))
