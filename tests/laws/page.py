"""Write docs/verification.md from the records of a test run: ``make verification``."""

import json
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEAD = """# Verification

Written by `make verification` from a run of the tests that record a figure (fixture `measured`); do not edit.
Each row is a deviation that a test measured and its limit; of several parameters the worst, or the range, is shown.
What each test does is in its docstring. Published numbers: [validation](validation.md).
"""


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
    (ROOT / "docs" / "verification.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
