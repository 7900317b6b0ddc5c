"""Wall time at equal error: ours, the plain method on the same kernels, and everything a user would pick instead."""

import importlib
import time
from itertools import pairwise
from statistics import median

import numpy as np

from bench.problem import LIVELY, QUIET, spread
from gearplay.integrate import run as kernel

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
ROUNDS = 5  # of all methods in turn, since this machine may be shared
REPEATS = 3  # of quick runs within a round, of which the least time counts


def ours(problem, member, tolerance):
    """Return our final state and the seconds from given state to final state."""
    run = problem.run(member, tolerance)
    began = time.perf_counter()
    problem.finish(run)
    seconds = time.perf_counter() - began
    assert run.clock[kernel.T] == problem.span
    return run.y, seconds


def curve(problem, solve, known=None):
    """Return (median error, median seconds) over the members at each tolerance, until a method fails or is slow.

    ``known``, an earlier curve, says how far to go.
    """
    points = []
    for tolerance in TOLERANCES if known is None else TOLERANCES[: len(known)]:
        errors, times = [], []
        for member in problem.members:
            runs = [solve(problem, member, tolerance)]
            runs += [solve(problem, member, tolerance) for _ in range(REPEATS if runs[0][1] < 0.01 else 0)]
            errors.append(problem.error(member, runs[0][0]))
            times.append(min(run[1] for run in runs))
        points.append((max(median(errors), 1e-16) if np.all(np.isfinite(errors)) else np.inf, median(times)))
        if known is None and sum(times) > 3.0:
            break
    return points


def time_at(points, wanted):
    """Return the least seconds that reach an error, between the measured points; NaN where none does.

    Only what more work cannot undo counts: of two points with falling error the later, dearer one.
    """
    best = float("nan")
    points = [point for point in points if np.isfinite(point[0])]
    for (e_0, t_0), (e_1, t_1) in pairwise(points):
        if e_1 <= wanted <= e_0:
            share = np.log(e_0 / wanted) / np.log(e_0 / e_1) if e_0 > e_1 else 1.0
            best = float(np.exp((1.0 - share) * np.log(t_0) + share * np.log(t_1)))
    if points and points[0][0] <= wanted and not best > 0.0:
        best = points[0][1]
    return best


def curves(problem):
    """Return every method's curves by name, one a round, and why others are missing."""
    methods, absent = {"gearplay": ours}, {}
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

            methods[family if method == "5(4)" else f"{family} {method}"] = solve
    found = {name: [curve(problem, solve)] for name, solve in methods.items()}
    for _ in range(ROUNDS - 1):
        for name, solve in methods.items():
            found[name].append(curve(problem, solve, found[name][0]))
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
            f"Least time of {ROUNDS} rounds of all methods in turn; how many times ours, least to largest of the rounds.",
            "",
            "| method | " + " | ".join(f"ms at {w:.0e} m | times ours" for w in WANTED) + " |",
            "|---|" + "---:|" * (2 * len(WANTED)),
        ]
        seconds = {
            name: np.array([[time_at(points, w) for points in rounds] for w in WANTED])
            for name, rounds in found.items()
        }
        for name, table in seconds.items():
            cells = []
            for times, base in zip(table, seconds["gearplay"], strict=True):
                known = np.all(times > 0.0)
                cells += [f"{1e3 * min(times):.3g}", spread(times / base)] if known else ["not reached", ""]
            lines.append(f"| {name} | " + " | ".join(cells) + " |")
        lines += ["", *(f"Missing: {name}: {reason}." for name, reason in absent.items())]
    return lines


if __name__ == "__main__":
    print("\n".join(report()))
