"""The benchmark: prints every figure of docs/benchmark.md and writes that page.

``python -m bench`` (or ``make bench``); ``--quick`` leaves the peers out.
"""

import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
from numba import njit

import gearplay as gp
from bench import joined, loaded, page, plain, trains, work_precision
from bench.jit import jitted
from bench.peers import ross_peer
from bench.problem import LIVELY, QUIET, spread
from gearplay.integrate import dispatch, stepper
from gearplay.integrate import members as member_kernel
from gearplay.integrate import run as kernel
from gearplay.integrate.right_hand_side import right_hand_side
from gearplay.kernels.layout import LOADED
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from gearplay.solver.simulate import run_members

PAGE = Path(__file__).parents[1] / "docs" / "benchmark.md"
HAN = gp.replace(gp.load_case("han2021"), {"run.tolerance": 1e-6})


def best(function, repeats=3):
    """Return the least wall time [s] of some calls."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        function()
        times.append(time.perf_counter() - began)
    return min(times)


def exponent(sizes, costs):
    """Return the slope of log cost over log size."""
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def throughput():
    """Return simulated seconds per wall second of the bundled case at 120 rpm."""
    errors = [QUIET.error(m, QUIET.ours(m, 1e-6)[0]) for m in range(1, 61)]
    span, lead = 10.0, HAN.run.transient
    lines = [
        f"`han2021` at 120 rpm, tolerance 1e-6: error at 0.1 s {median(errors):.1e} m (median of 60 initial states,"
        f" largest {max(errors):.1e} m).",
        "",
        "| kept | 100 Hz | 100 kHz | share of sampling |",
        "|---|---:|---:|---:|",
    ]
    for words, signals in (
        ("`ring.ax`, what the rig measures", ["ring.ax"]),
        ("position, velocity, acceleration of the ring", ["ring.x", "ring.vx", "ring.ax"]),
        ("all its signals", None),
    ):
        times = [
            best(
                lambda s=signals, f=f: run_members(HAN, [1], signals=s, duration=span, sampling=f, threads=1)
            )
            for f in (100.0, 1e5)
        ]
        rates = " | ".join(f"{(span + lead) / t:.0f}" for t in times)
        lines.append(f"| {words} | {rates} | {100 * (1 - times[0] / times[1]):.0f} % |")
    times = {1: [], 2: []}
    for _ in range(5):  # in turn, so that both meet the same machine
        for n in times:
            run = partial(run_members, HAN, range(1, 17), signals=["ring.ax"], duration=20.0, threads=n)
            times[n].append(best(run, 1))
    one, two = min(times[1]), min(times[2])
    lines += [
        "",
        f"Simulated seconds per wall second on one core. Two threads, 16 members: {one / two:.2f} times one.",
    ]
    return lines


def ensembles():
    """Return what a member of an ensemble costs beside the compiled code, and how two threads share an ensemble."""
    lines = [
        "`gp.simulate(case, ensemble=1000)` of `han2021` over the time in compiled code, one thread; two threads over one.",
        "",
        "| member | compiled code | all, one thread | ratio | two threads over one |",
        "|---|---:|---:|---:|---:|",
    ]
    inner, spent = member_kernel.advance_members, []

    def timed(*words):
        began = time.perf_counter()
        try:
            return inner(*words)
        finally:
            spent.append(time.perf_counter() - began)

    member_kernel.advance_members = timed
    for span in (0.05, 0.5, 2.5):
        times, count = {1: [], 2: []}, 1000
        for _ in range(7):  # in turn, so that both meet the same machine
            for n, found in times.items():
                spent.clear()
                began = time.perf_counter()
                gp.simulate(HAN, duration=span, transient=0.0, ensemble=count, threads=n)
                found.append((time.perf_counter() - began, sum(spent)))
        (one, within), (two, _) = (min(found) for found in times.values())
        each, alone = 1e6 * one / count, 1e6 * within / count
        lines.append(
            f"| {span:g} s | {alone:.0f} us | {each:.0f} us | {one / within:.2f} | {one / two:.2f} |"
        )
    member_kernel.advance_members = inner
    return lines


def signals():
    """Return what a user waits for who writes `gp.simulate(case)`, and for signals of it."""
    case, span = gp.load_case("han2021"), 5.0
    rows = {
        '`gp.simulate(gp.load_case("han2021"), duration=5.0)`': [],
        "one signal at 100 kHz": [],
        "all of them at 100 kHz": [],
    }
    gp.simulate(case, duration=0.1)
    for _ in range(5):
        began = time.perf_counter()
        result = gp.simulate(case, duration=span, threads=1)
        times = [time.perf_counter() - began]
        for ask in (lambda run=result: run.signal("ring.ax"), lambda run=result: run.runs[0].values):
            began = time.perf_counter()
            asked = ask()
            times.append((time.perf_counter() - began) / len(asked))
        for row, seconds in zip(rows.values(), times, strict=True):
            row.append(seconds)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "motion.nc"
        result.save(file)
        kept = file.stat().st_size / 1e6
    first, one, all_ = rows.values()
    words = list(rows)
    return [
        f"Least and largest of 5 repeats, in turn; a file that keeps the motion takes {kept:.2g} MB.",
        "",
        "| | |",
        "|---|---:|",
        f"| {words[0]} | {span / max(first):.0f} to {span / min(first):.0f} simulated seconds per second |",
        f"| {words[1]} | {1e9 * min(one):.1f} to {1e9 * max(one):.1f} ns a sample |",
        f"| {words[2]} | {1e9 * min(all_):.0f} to {1e9 * max(all_):.0f} ns a row of {len(result.runs[0].columns)} |",
    ]


def scaling():
    """Return cost against simulated time, rotors and cases."""
    lines = ["| against | sizes | exponent | |", "|---|---|---:|---|"]
    spans = [8.0, 16.0, 32.0, 64.0, 128.0, 256.0]
    costs = [
        median(
            best(
                lambda s=s, m=m: run_members(
                    HAN, [m], signals=["ring.ax"], duration=s, transient=0.0, threads=1
                ),
                1,
            )
            for m in range(1, 6)
        )
        for s in spans
    ]
    lines.append(f"| simulated time | 8 to 256 s | {exponent(spans, costs):.2f} | `han2021`, 100 kHz |")
    for words, make, lead, span, members in (
        ("rotors of a loaded train", trains.loaded, 0.2, 0.05, 1),
        ("rotors of a rattling train", trains.rattling, 0.0, 0.5, 15),
    ):
        costs, events, steps = [], [], []
        for size in trains.SIZES:
            times, counts, taken = [], [], []
            for seed in range(members):
                case = make(size, seed)
                packed = pack(case)
                motion = kernel.make_run(
                    packed.system, initial_state(case, packed), packed.natural, packed.restart_step, packed.stops,
                    np.arange(0), np.empty((0, 0)), 4096, 1e-6,
                )  # fmt: skip
                stepper.begin(packed.system, motion)
                for end in (lead, lead + span):
                    before = motion.counts.copy()
                    motion.clock[kernel.T_END] = end
                    began = time.perf_counter()
                    while stepper.advance(packed.system, motion, 10**9) == kernel.PAUSED:
                        motion.counts[kernel.LOGGED] = 0
                    seconds = time.perf_counter() - began
                times.append(seconds)
                counts.append(int(motion.counts[kernel.EVENTS] - before[kernel.EVENTS]))
                taken.append(int(motion.counts[kernel.STEPS] - before[kernel.STEPS]))
            costs.append(median(times))
            events.append(median(counts))
            steps.append(median(taken))
        note = f"{1e3 * costs[0] / span:.0f} to {1e3 * costs[-1] / span:.0f} ms per simulated s"
        if min(events) == 0:
            note += f"; steps grow with exponent {exponent(trains.SIZES, steps):.2f}, "
            note += f"time per step with {exponent(trains.SIZES, np.divide(costs, steps)):.2f}"
        if min(events) > 0:
            note += f"; contact events grow with exponent {exponent(trains.SIZES, events):.2f}, "
            note += f"time per event with {exponent(trains.SIZES, np.divide(costs, events)):.2f}"
        lines.append(f"| {words} | 2 to 20 | {exponent(trains.SIZES, costs):.2f} | {note} |")
    sizes = [1, 10, 100, 1000, 10_000]
    cases = [
        gp.replace(HAN, {"run.seed": i + 1, "run.duration": 0.05, "run.transient": 0.0, "run.sampling": 1e3})
        for i in range(max(sizes))
    ]
    costs = [
        best(lambda n=n: gp.simulate(cases[:n], signals=["ring.ax"]), 3 if n < 1000 else 1) for n in sizes
    ]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    lines.append(
        f"| cases | 10 to 10 000 | {exponent(sizes[1:], costs[1:]):.2f} | {1e3 * costs[-1] / sizes[-1]:.2f} ms per case "
        f"of 0.05 s, most of it packing; peak memory of the whole benchmark {peak:.0f} MiB |"
    )
    return lines


def starting():
    """Return start-up times and memory of fresh processes, those but the first in turn, and their ratio to numpy's import."""
    lines = ["| whole process | time [s] | over `import numpy` | peak memory [MiB] |", "|---|---:|---:|---:|"]
    program = (
        "import resource, subprocess, sys, time\n"
        "began = time.perf_counter()\n"
        "subprocess.run(sys.argv[1:], check=True, capture_output=True)\n"
        "print(time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "GEARPLAY_LIBRARY": folder}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)  # or each process compiles its libraries anew

        def timed(words):
            done = subprocess.run(
                [sys.executable, "-c", program, sys.executable, *words],
                env=environment,
                check=True,
                capture_output=True,
                text=True,
            )
            return tuple(map(float, done.stdout.split()))

        own = ["-m", "gearplay"]
        run = [*own, "run", "han2021", "--duration", "0.1"]
        seconds, peak = timed(run)
        lines.append(
            f"| the first `gearplay run` ever of a source tree, its kernels built | {seconds:.2f} | | {peak:.0f} |"
        )
        commands = {
            "`import numpy`": ["-c", "import numpy"],
            "`import gearplay`": ["-c", "import gearplay"],
            "`gearplay --help`": [*own, "--help"],
            "`gearplay check han2021`": [*own, "check", "han2021"],
            "`gearplay run han2021 --duration 0.1`": run,
            "the same, saved": [*run, "--out", f"{folder}/run.nc", "--overwrite"],
        }
        rounds = [[timed(words) for words in commands.values()] for _ in range(7)]
        medians = np.median(rounds, axis=0)
        for name, (seconds, peak) in zip(commands, medians, strict=True):
            lines.append(f"| {name} | {seconds:.2f} | {seconds / medians[0, 0]:.2f} | {peak:.0f} |")
    return lines


@jitted
def _evaluate(system, active_set, branch, loads, y, dy, times):
    for n in range(times):
        right_hand_side(system, active_set, 1e-9 * n, y, branch, dy, loads)


@njit
def _multiply_add(times):
    a, b, c, d, e, f, g, h = 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7
    for _ in range(times):
        a, b, c, d = a * 0.999 + 1e-3, b * 0.999 + 1e-3, c * 0.999 + 1e-3, d * 0.999 + 1e-3
        e, f, g, h = e * 0.999 + 1e-3, f * 0.999 + 1e-3, g * 0.999 + 1e-3, h * 0.999 + 1e-3
    return a + b + c + d + e + f + g + h


def hardware():
    """Return the operations of a right-hand side against the machine, and what fixed steps would need."""
    done = subprocess.run(
        [sys.executable, "-m", "bench.flops"],
        env={**os.environ, "GEARPLAY_INTERPRETED": "1"},
        check=True,
        capture_output=True,
        text=True,
    )
    counts = json.loads(done.stdout)
    operations = sum(counts.values())
    system, active_set, branch, loads = LIVELY.arguments()
    branch.modes[:2] = LOADED
    active_set.active[:2] = 1, 1
    y, dy, times = LIVELY.start(1), np.zeros(12), 200_000
    for e in range(system.elements.size):
        dispatch.start_step(system, e, 0.0, y, branch)  # knows the angles
    arguments = (system, active_set, branch, loads, y, dy)
    _evaluate(*arguments, 1)
    nanoseconds = 1e9 * best(lambda: _evaluate(*arguments, times)) / times
    _multiply_add(1)
    peak = 16e-9 * 10**7 / best(lambda: _multiply_add(10**7))
    rate = operations / nanoseconds
    lines = [
        f"A right-hand side with sleeve and flank in contact does {operations} operations ("
        + ", ".join(f"{n} {name}" for name, n in sorted(counts.items(), key=lambda item: -item[1]))
        + f") in {nanoseconds:.0f} ns: {rate:.1f} GFlop/s, {100 * rate / peak:.0f} % of what independent scalar"
        f" multiply-adds reach on this core ({peak:.1f} GFlop/s). The rest is the chain of dependences"
        " through roots and divisions.",
        "",
    ]
    for problem in (LIVELY, QUIET):
        fixed = plain.fixed_step_evaluations(problem, 1e-8)
        ours = median(int(problem.ours(m, 3e-6)[1].counts[kernel.CALLS]) for m in problem.members)
        lines.append(
            f"* {problem.name}: equal steps of the fifth-order formula need {fixed} evaluations for 1e-8 m, gearplay {ours:.0f}: "
            f"{fixed / ours:.0f} times fewer, so eight lanes in parallel would be {fixed / ours / 8:.0f} times slower."
        )
    return lines


def diagram(ross_step):
    """Return our time for a bifurcation diagram of 1000 values, 500 mesh periods each, beside ROSS's by its time per step [s]."""
    values = np.linspace(60.0, 300.0, 1000) * np.pi / 30.0
    began = time.perf_counter()
    found = gp.bifurcation(
        "han2021", "rotors.pinion.drive.speed", values.tolist(), ["ring.x"], period="mesh", settle=400, keep=100,
        directions=["up"], carry=False,
    )  # fmt: skip
    seconds = time.perf_counter() - began
    failed = int(np.sum(found.ds["reason"].values != ""))
    revolutions = 500 / 20  # of the pinion with 20 teeth
    steps = values.size * revolutions * ross_peer.POINTS
    return (
        f"A bifurcation diagram of `han2021` over speed, 1000 values of 500 mesh periods each, takes us {seconds:.1f} s on "
        f"{os.cpu_count()} cores ({failed} failed). The same count is {steps:.3g} of ROSS's steps: "
        f"{steps * ross_step / 3600.0:.0f} h on one core at its {1e3 * ross_step:.2f} ms a step, estimated, not run."
    )


def ross():
    """Return ROSS's time per simulated second on its own case beside ours on the like."""
    module = ross_peer
    reason = module.missing()
    if reason:
        return [f"Missing: ROSS: {reason}."]
    case = gp.replace(gp.load_case("external-pair"), {"run.tolerance": 1e-6})

    def own():
        run_members(case, [0], signals=["output.ax"], duration=1.0, transient=0.0, threads=1)

    theirs, ours, what = [], [], ""
    for _ in range(3):
        value, what = module.seconds_per_simulated_second()
        theirs.append(value)
        ours.append(best(own))
    ratios = [a / b for a, b in zip(theirs, ours, strict=True)]
    return [
        f"{what}: {min(theirs):.1f} s per simulated second. gearplay on the comparable `external-pair` (300 N m, 1000 rpm, both"
        f" gears in linear bearings), {min(ours):.3f} s: least of three in turn, {spread(ratios)} times less.",
        "",
        diagram(min(theirs) * 2.0 * np.pi / (ross_peer.SPEED * ross_peer.POINTS)),
    ]


SECTIONS = (  # the peers last: their libraries' threads and memory would disturb the others
    ("Throughput", throughput),
    ("Ensembles", ensembles),
    ("Loaded pairs and trains", loaded.report),
    ("Rotors behind springs", joined.report),
    ("Signals of a kept motion", signals),
    ("Scaling", scaling),
    ("Start-up", starting),
    ("The page", page.part),
    ("Hardware limit, and lanes", hardware),
    ("Work and precision", work_precision.report),
    ("Work at equal error, loaded", loaded.against_peers),
    ("ROSS", ross),
)


def main():
    """Run every section, print it, write the page."""
    lines = [
        "# Benchmark",
        "",
        "Written by `make bench`; do not edit. What it means: [performance](performance.md).",
        "",
        f"gearplay {gp.__version__}, Python {platform.python_version()}, {os.cpu_count()} cores, {platform.machine()}.",
    ]
    print("\n".join(lines))
    for title, section in SECTIONS:
        if "--quick" in sys.argv and section in (work_precision.report, loaded.against_peers, ross):
            continue
        part = ["", f"## {title}", "", *section()]
        print("\n".join(part), flush=True)
        lines += part
    if "--quick" not in sys.argv:
        PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
