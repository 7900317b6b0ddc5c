"""Ensembles on a CUDA device against two threads of the same machine's processor: same tolerance, same steps, same error."""

import sys
import time
from statistics import median

import gearplay as gp
from bench.loaded import article_pair, chain, external_pair, planetary_set
from gearplay.solver.simulate import run_batch
from gearplay.vocabulary.errors import InputError

# Simulated seconds of a member, of which the processor computes `FEW` and the device each of `MANY`.
PROBLEMS = {
    "`han2021`": (lambda: gp.load_case("han2021"), 4.0),
    "article's pair, 1 g and 1 N m": (article_pair, 0.2),
    "`external-pair`": (external_pair, 0.1),
    "`pinion-idler-ring`": (chain, 0.05),
    "planetary set": (planetary_set, 0.01),
}
FEW, MANY, REPEATS = 128, (1024, 8192, 32_768), 5


def _seconds(case, members, device):
    began = time.perf_counter()
    runs = run_batch([(case, range(members))], signals=[], device=device, threads=2)[0]
    return (time.perf_counter() - began) / members, sum(run.counters.steps for run in runs) / members


def device_name():
    """Return the device's name, or why there is none."""
    from gearplay.solver.on_device import cuda

    try:
        return cuda().memory.name, ""
    except InputError as error:
        return "", str(error)


def report(problems=tuple(PROBLEMS), many=MANY, repeats=REPEATS, tell=None):
    """Return the table: members per second of two threads and of the device, and the ratio's spread."""
    name, why = device_name()
    if why:
        return [f"None here: {why}"]
    lines = [
        f"{name}. Whole calls, starts drawn and results made included; least to largest of {repeats} repeats, in turn.",
        "",
        "| ensemble | members | steps each | members/s, two threads | members/s, device | times two threads |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for words in problems:
        make, duration = PROBLEMS[words]
        case = gp.replace(make(), {"run.duration": duration, "run.transient": 0.0, "run.sampling": 1000.0})
        for device in ("cpu", "cuda"):
            _seconds(case, 32, device)
        for members in many:
            pairs = [(_seconds(case, FEW, "cpu"), _seconds(case, members, "cuda")) for _ in range(repeats)]
            ratios = [cpu / device for (cpu, _), (device, _) in pairs]
            lines.append(
                f"| {words} | {members} | {pairs[0][1][1]:.0f} | {1 / median(p[0][0] for p in pairs):.0f}"
                f" | {1 / median(p[1][0] for p in pairs):.0f} | {min(ratios):.1f} to {max(ratios):.1f} |"
            )
            if tell is not None:
                tell(lines[-1])
    return lines


if __name__ == "__main__":
    quick = (
        {"problems": tuple(PROBLEMS)[:4], "many": (1024, 8192), "repeats": 2} if "quick" in sys.argv else {}
    )
    print("\n".join(report(tell=lambda line: print(line, file=sys.stderr, flush=True), **quick)))
