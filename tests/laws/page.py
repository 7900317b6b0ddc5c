"""Write docs/verification.md from the records of a test run: ``make verification``."""

import ast
import json
import sys
import textwrap
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("laws", "cross", "nonlinear", "calibration", "rig", "signals", "sweeps")
LAWS = FOLDERS[:2]
HEAD = """# Verification

Written by `make verification` from a run of the tests that record a figure (fixture `measured`); do not edit.
Each row is what a test measured beside the limit it demands; of several parameters the worst, or the range,
is shown. See also [validation](validation.md).
"""


def purposes() -> dict[str, str]:
    """Return the first docstring line of every test function, by name."""
    found = {}
    for folder in FOLDERS:
        for file in sorted((ROOT / "tests" / folder).glob("test_*.py")):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if (
                    isinstance(node, ast.FunctionDef)
                    and node.name.startswith("test_")
                    and _measures(folder, node)
                ):
                    found[node.name] = (ast.get_docstring(node) or "").split("\n")[0]
    return found


def _measures(folder: str, test: ast.FunctionDef) -> bool:
    """Return whether a test is one of laws, or records a figure."""
    return folder in LAWS or any(each.arg == "measured" for each in test.args.args)


def filled(item: str) -> list[str]:
    """Return the lines of an item of a list."""
    return textwrap.wrap(item, 110, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)


def main(report: Path) -> None:
    """Turn a JUnit report into the page."""
    rows: dict[tuple[str, str, str], list[float]] = defaultdict(list)
    passed = 0
    for case in ElementTree.parse(report).iter("testcase"):
        passed += not list(case.iter("failure")) and not list(case.iter("error"))
        for record in case.iter("property"):
            if record.get("name") == "measured":
                quantity, value, limit = str(record.get("value")).split("|")
                module = str(case.get("classname")).split(".")[-1] + ".py"
                rows[module, quantity, limit].append(float(value))
    lines = [HEAD, f"{passed} tests passed.", "", "| what | measured | limit | test |", "|---|---:|---:|---|"]
    for (module, quantity, limit), values in rows.items():
        least, most = min(values), max(values)
        shown = f"{most:.2g}" if least == most or most < 1e-3 else f"{least:.3g} to {most:.3g}"
        lines.append(f"| {quantity} | {shown} | {limit} | `{module}` |")
    lines += [
        "",
        "## Answers",
        "",
        "Bundled cases after 5 ms at tolerance 1e-11, member 0; states in `tests/laws/answers`.",
    ]
    lines += ["", "| case | steps | rejected | events | evaluations |", "|---|---:|---:|---:|---:|"]
    for file in sorted((Path(__file__).parent / "answers").glob("*.json")):
        counts = json.loads(file.read_text(encoding="utf-8"))["counts"]
        lines.append(f"| `{file.stem}` | " + " | ".join(str(v) for v in counts.values()) + " |")
    lines += ["", "## What each test shows", ""]
    for name, purpose in purposes().items():
        lines += filled(f"* `{name}`: {purpose}") if purpose else []
    (ROOT / "docs" / "verification.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
