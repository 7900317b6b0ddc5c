"""Six loaded problems: bearings and flanks that stay pressed, which is what most drives do."""

import math
import time
from functools import cached_property, lru_cache

import numpy as np

import gearplay as gp
from bench.peers import numbalsoda_peer, scipy_peer
from bench.problem import Problem, spread
from gearplay.integrate import run as kernel
from gearplay.integrate.implicit import BACKOFF, FIRST_BACKOFF
from gearplay.solver.flow import Flow

DURATION = 0.1
"""Of each problem [s], after ``LEAD`` of running in."""
SHORT = {"pinion-idler-ring": 0.01, "two-stage-reducer": 0.02, "planetary-reducer": 0.05}
"""Of what is chaotic [s], where an error is asked for: later no two methods agree; and of what takes long."""
LEAD = 0.3
TOLERANCES = (1e-3, 1e-6, 1e-9)
REPEATS = 5
AT_A_TIME = 3
"""Runs of a method within a repeat, of which the least time counts: what else the machine does comes in bursts."""
WANTED = (1e-6, 1e-8, 1e-10, 1e-12)  # m


def external_pair():
    """Return the bundled pair in linear bearings under 300 N m."""
    return gp.load_case("external-pair")


def chain():
    """Return the bundled pinion, idler and ring, lightly loaded: flanks that part and meet again.

    Without losses in the sleeves, whose law would go by speeds of new impacts, which peers do not store.
    """
    return gp.load_case("pinion-idler-ring", [f"sleeves.{name}.restitution=1" for name in ("idler", "ring")])


def article_pair():
    """Return the article's internal pair under gravity and 1 N m."""
    return gp.load_case("han2021", ["gravity.1=-9.81", "rotors.ring.load.torque=1"])


def two_stage():
    """Return the bundled reducer of two stages."""
    return gp.load_case("two-stage-reducer")


def planetary_reducer():
    """Return the bundled planetary reducer."""
    return gp.load_case("planetary-reducer")


def planetary_set():
    """Return three planets between a driven sun, a ring on a torsional spring and a loaded carrier, bearings with play.

    Masses of J. Lin, R. G. Parker, J. Vib. Acoust. 121 (1999) 319.
    """
    module, alpha = 4e-3, math.radians(24.6)
    centre = 0.5 * module * 40
    base = {
        name: 0.5 * module * teeth * math.cos(alpha)
        for name, teeth in {"sun": 20, "planet": 20, "ring": 60}.items()
    }
    bearing = {"radial_clearance": 5e-6, "exponent": 1.0, "stiffness": 1e8, "restitution": 0.8}
    rotors = {
        "sun": {
            "teeth": 20,
            "mass": 0.4,
            "inertia": 0.39 * base["sun"] ** 2,
            "drive": {"kind": "speed", "speed": "1000 rpm", "ramp": "20 ms"},
        },
        "ring": {
            "teeth": 60,
            "internal": True,
            "mass": 2.35,
            "inertia": 3.0 * base["ring"] ** 2,
            "position": [0.0, 0.0],
        },
        "carrier": {
            "mass": 5.43,
            "inertia": 6.29 * centre**2,
            "position": [0.0, 0.0],
            "load": {"torque": "100 N m"},
        },
        "ground": {"mass": 1.0, "inertia": 1.0, "drive": {"kind": "speed", "speed": 0.0}},
    }
    rotors["sun"]["position"] = [0.0, 0.0]
    sleeves = {name: dict(bearing) for name in ("ring", "carrier")}
    mesh = {
        "module": module,
        "pressure_angle": alpha,
        "backlash": 1e-4,
        "stiffness": {"kind": "harmonic", "mean": 5e8, "amplitude": 5e7},
        "damping": {"ratio": 0.05},
    }
    meshes = []
    for k in range(3):
        angle, name = 2.0 * math.pi * k / 3, f"planet{k}"
        rotors[name] = {
            "teeth": 20,
            "mass": 0.66,
            "inertia": 0.61 * base["planet"] ** 2,
            "position": [centre * math.cos(angle), centre * math.sin(angle)],
        }
        sleeves[name] = {**bearing, "on": "carrier"}
        meshes += [{"driver": "sun", "driven": name, **mesh}, {"driver": name, "driven": "ring", **mesh}]
    support = {
        "between": ["ring", "ground"],
        "torsional_stiffness": 1e9 * base["ring"] ** 2,
        "torsional_damping": 65.0,
    }
    return gp.load_case(
        {
            "rotors": rotors,
            "sleeves": sleeves,
            "meshes": meshes,
            "couplings": [support],
            "run": {"duration": DURATION, "transient": LEAD, "sampling": "50 kHz"},
        }
    )


PROBLEMS = {
    "external-pair": external_pair,
    "pinion-idler-ring": chain,
    "article 1 g 1 N m": article_pair,
    "planetary": planetary_set,
    "two-stage-reducer": two_stage,
    "planetary-reducer": planetary_reducer,
}


class Loaded(Problem):
    """A loaded problem as every solver gets it: from a state at `LEAD`, over `DURATION`; impact speeds as stored there."""

    @cached_property
    def course(self):
        """Return the motion at `LEAD`, which nobody moves on."""
        return self._begun()

    def _begun(self):
        flow = Flow(gp.replace(self.case, {"run.tolerance": 1e-11}))
        course = flow.begin(flow.start())
        course.advance(LEAD)
        return course

    def start(self, member):
        """Return the state at `LEAD`."""
        return self.course.state.copy()

    def arguments(self):
        """Return the leading arguments of `derivative`."""
        system, active_set, branch, loads = super().arguments()
        for name in ("impact_speeds", "memory"):
            getattr(branch, name)[:] = getattr(self.course.run.branch, name)
        return system, active_set, branch, loads

    def timed(self, tolerance):
        """Return our final state, wall time [s] and steps per second at a tolerance."""
        course = self._begun()
        course.run.clock[kernel.TOLERANCE] = tolerance
        course.run.scale[:] = tolerance * course.run.natural
        # Whatever paid at the tolerance that led there.
        course.run.implicit.numbers[BACKOFF] = FIRST_BACKOFF
        before, began = course.steps, time.perf_counter()
        course.advance(LEAD + self.span)
        seconds = time.perf_counter() - began
        return course.state.copy(), seconds, (course.steps - before) / self.span

    def ours(self, member, tolerance):
        """Return our final state and the seconds that it took."""
        return self.timed(tolerance)[:2]

    def error(self, member, y):
        """Return the largest error [m] of positions, all on the first rotor's scale."""
        n, natural = np.asarray(y).size // 2, self.packed.natural
        differences = np.abs(np.asarray(y)[:n] - self.answer(member)[:n])
        return float(np.max(differences / natural[:n]) * natural[0])


@lru_cache
def make_problems():
    """Return the problems, their kernels compiled; the same ones each time, with the answers they have found."""
    problems = [
        Loaded(name, make(), SHORT.get(name, DURATION), (0,), begin=LEAD) for name, make in PROBLEMS.items()
    ]
    return problems


def report():
    """Return the table of the loaded problems."""
    lines = [
        f"From a state after {LEAD:g} s, over {DURATION:g} s, the chaotic chain over {SHORT['pinion-idler-ring']:g} s;"
        f" least and largest of {REPEATS} repeats, in turn.",
        "",
        "| problem | tolerance | error at its end | steps per second | simulated seconds per second |",
        "|---|---:|---:|---:|---:|",
    ]
    for problem in make_problems():
        found = {tolerance: [] for tolerance in TOLERANCES}
        for _ in range(REPEATS):
            for tolerance, runs in found.items():
                runs.append(problem.timed(tolerance))
        for tolerance, runs in found.items():
            error = problem.error(0, runs[0][0])
            speeds = [problem.span / seconds for _, seconds, _ in runs]
            lines.append(
                f"| {problem.name} | {tolerance:.0e} | {error:.1e} m | {runs[0][2]:.0f}"
                f" | {min(speeds):.3g} to {max(speeds):.3g} |"
            )
    return lines


def first_within(problem, solve):
    """Return for each error of `WANTED` the loosest tolerance at which a solver keeps it, None where none does."""
    found = dict.fromkeys(WANTED)
    for k in range(4, 27):  # from the loosest tolerance that a case may have
        tolerance = 10.0 ** (-0.5 * k)
        end = solve(problem, 0, tolerance)[0]
        error = problem.error(0, end) if np.all(np.isfinite(end)) else math.inf
        for wanted in WANTED:
            if found[wanted] is None and error <= wanted:
                found[wanted] = tolerance
        if None not in found.values():
            break
    return found


def against_peers():
    """Return tables, for each wanted error, of the seconds of ours and of peers at the loosest tolerance, and the ratios."""
    problems, solvers = (
        make_problems(),
        {"gearplay": lambda problem, member, tolerance: problem.ours(member, tolerance)},
    )
    for name, peer in (("SciPy", scipy_peer), ("numbalsoda", numbalsoda_peer)):
        if peer.missing() is None:
            methods = getattr(peer, "offered", lambda known=peer.NAME: known)()
            solvers |= {f"{name} {method}": _by(peer, method) for method in methods}
    rows = {wanted: {name: [] for name in solvers} for wanted in WANTED}
    for problem in problems:
        tolerances = {name: first_within(problem, solve) for name, solve in solvers.items()}
        for wanted in WANTED:
            cells = _timed_at(problem, solvers, {name: tolerances[name][wanted] for name in solvers})
            for name, cell in cells.items():
                rows[wanted][name].append(cell)
    lines = [
        "Least time at the loosest tolerance (by half decades) that keeps an error, over the same spans, with the common compiled"
        f" right-hand side; in turn, and how many times ours: least to largest of {REPEATS} repeats."
    ]
    for wanted in WANTED:
        lines += [
            "",
            f"| error at most {wanted:g} m |" + "".join(f" {problem.name} |" for problem in problems),
            "|---|" + "---:|" * len(problems),
            *(f"| {name} | {' | '.join(row)} |" for name, row in rows[wanted].items()),
        ]
    return lines


def _timed_at(problem, solvers, tolerances):
    """Return the cell of each solver: its least time at its tolerance, and how many times ours."""
    times = {name: [] for name in solvers}
    for _ in range(REPEATS):
        for name, solve in solvers.items():
            if tolerances[name] is not None:
                times[name].append(min(solve(problem, 0, tolerances[name])[1] for _ in range(AT_A_TIME)))
    own, cells = times["gearplay"], {}
    for name, found in times.items():
        if not found or not own:
            cells[name] = "not reached" if not found else f"{1e3 * min(found):.3g} ms"
            continue
        ratios = [theirs / ours for theirs, ours in zip(found, own, strict=True)]
        words = "" if name == "gearplay" else f", {spread(ratios)} times"
        cells[name] = f"{1e3 * min(found):.3g} ms{words}"
    return cells


def _by(peer, method):
    return lambda problem, member, tolerance: peer.solve(problem, member, method, tolerance)


if __name__ == "__main__":
    print("\n".join([*report(), "", *against_peers()]))
