"""Write docs/mutation.md from what became of the mutants and how the survivors were judged."""

import math
import tomllib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
HEAD = """# Mutation

Written by `make mutation`; do not edit. How many errors of the physics do the tests detect? One sign, number,
comparison or loop of `kernels`, `integrate`, `parts` or of the computing part of `model` is changed by
[cosmic-ray](https://cosmic-ray.readthedocs.io), and the tests run at small size until one fails. Places are
drawn uniformly; type hints, messages and names of signals are excluded. An undetected mutant is judged by
hand in `tests/mutation/judged.toml`:

* *equivalent*: no visible number can differ;
* *speed only*: the same motion with more or less work;
* *rounding*: a margin of tolerances or of rounding, which no law fixes;
* *closed*: detected by the test named, which was added for it;
* *open*: not detected.

The first share below is the expected detection of a new mutant; the second includes the tests that were added.
"""


def interval(killed: int, count: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share.

    >>> [round(end, 3) for end in interval(85, 100)]
    [0.767, 0.907]
    """
    z, share = 1.959964, killed / count
    middle = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * math.sqrt(share * (1 - share) / count + (z / (2 * count)) ** 2)
    return middle - half, middle + half


def judgements() -> dict[str, dict[str, str]]:
    """Return how survivors were judged, by name."""
    judged = tomllib.loads((HERE / "judged.toml").read_text(encoding="utf-8"))
    return {each["mutant"]: each for each in judged["survivor"]}


def _package(module: str) -> str:
    return module.partition("/")[0]


def write_page(rows: Sequence[Mapping[str, Any]], counts: Mapping[str, int], seed: int) -> None:
    """Turn rows of mutants into the page."""
    if not rows:
        return
    judged = judgements()
    closed = {name for name, each in judged.items() if each["verdict"] == "closed"}
    names = [f"{row['module']}: {row['before']} -> {row['after']}" for row in rows]
    killed = sum(bool(row["by"]) for row in rows)
    first = sum(bool(row["by"]) and name not in closed for row, name in zip(rows, names, strict=True))
    lines = [HEAD, f"{len(rows)} mutants of {sum(counts.values())} places, seed {seed}.", ""]
    for words, number in (("before tests were added", first), ("now", killed)):
        low, high = interval(number, len(rows))
        share = f"{100 * number / len(rows):.0f} % (95 % interval: {100 * low:.0f} to {100 * high:.0f} %)"
        lines.append(f"* Detected {words}: {number}, {share}.")
    hours = sum(row["seconds"] for row in rows) / 3600.0
    by_fast = sum(bool(row["by"]) and row["stage"] == 0 for row in rows)
    lines += [f"* {by_fast} of them by the fast tests; {hours:.1f} h in all on one core.", ""]
    lines += ["| package | mutants | detected |", "|---|---:|---:|"]
    tally: dict[str, list[bool]] = defaultdict(list)
    for row in rows:
        tally[_package(row["module"])].append(bool(row["by"]))
    lines += [f"| `{name}` | {len(each)} | {sum(each)} |" for name, each in sorted(tally.items())]
    lines += ["", "## Judged", "", "| where | change | verdict | why |", "|---|---|---|---|"]
    for row, name in sorted(zip(rows, names, strict=True), key=lambda pair: pair[1]):
        if row["by"] and name not in closed:
            continue
        verdict = judged.get(name, {"verdict": "not judged", "why": ""})
        change = f"`{row['before']}` → `{row['after']}`".replace("|", "\\|")
        lines.append(
            f"| `{row['module']}:{row['line']}` | {change} | {verdict['verdict']} | {verdict['why']} |"
        )
    (HERE.parents[1] / "docs" / "mutation.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
