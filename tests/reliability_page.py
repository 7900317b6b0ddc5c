"""Write docs/reliability.md from the records of a run of the hostile tests: ``make torture``."""

import ast
import datetime
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

Row = tuple[int, int, str]
ROOT = Path(__file__).resolve().parents[1]
HEAD = """# Reliability

Promises, and the trials that test them: damaged input, kills, full disks, Ctrl-C, hostile arguments. The table is
written by `make torture`, which takes some hours; `make torture OF=tests/web` runs some files only and keeps the other
rows. Do not edit.

## Promises

* Bad input in a file, on the command line, in Python or on the page gives one sentence with the field, the value,
  the rule and the cure. No traceback, no hang, no silent change.
* A request that needs unreasonable time or memory is refused before it starts, with an estimate.
* Files are written completely or not at all: to a temporary name, synced, renamed. Only `--overwrite` replaces a file,
  only a regular file of the same user, and never a complete result by a partial one.
* A result that was changed, cut or extended after it was written is refused by its digest. Finished parts, rows of a
  sweep and trials of a calibration have digests too: a changed one is computed again, or named.
* A file without a digest, from another program, is read in a child process, which may crash, hang or run out of memory.
* A failing write, sync or rename ends a command with one sentence. Stored pieces stay, the same command resumes, and
  an earlier result is kept until the new one is complete.
* Ctrl-C at any time ends a command with exit code 130 and one sentence that names the kept results; the same command
  resumes. A second Ctrl-C within three seconds damages nothing. `gearplay run --out` keeps the motion up to then.
* Within gearplay's functions Ctrl-C is raised at a safe point, not inside library code that would lose it.
* A process that is killed loses only its current piece; a repeated piece is identical to the last byte.
* The kernel library is loaded completely and from a trusted owner, or not at all. Simultaneous builds end with one.
* `run.max_wall_time` includes the computation of signals. A result whose compression would exceed it is written
  uncompressed.
* A request to the page that is incomplete after 10 s (its body: 30 s more) is dropped without a traceback.

Not promised: the same last digits on other processors or compilers; data on a disk that reports a sync it did not do;
an answer to Ctrl-C in the first tenth of a second, while Python starts.

## Tried
"""


def purposes() -> dict[str, str]:
    """Return the first sentence of each test module, by its path below ``tests``."""
    found = {}
    for file in sorted((ROOT / "tests").rglob("test_*.py")):
        words = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or file.stem
        found[file.relative_to(ROOT / "tests").as_posix()] = words.split("\n")[0].rstrip(".")
    return found


def _module_of(case: ElementTree.Element) -> str:
    """Return the path of a test's module below ``tests``."""
    parts = str(case.get("classname")).split(".")
    last = max(k for k, part in enumerate(parts) if part.startswith("test_"))
    return "/".join(parts[1 if parts[0] == "tests" else 0 : last + 1]) + ".py"


def rows_of(reports: Iterable[Path]) -> dict[str, Row]:
    """Return what JUnit reports say of each module: trials, failures, the day."""
    tries: dict[str, int] = defaultdict(int)
    failed: dict[str, int] = defaultdict(int)
    for case in (case for report in reports for case in ElementTree.parse(report).iter("testcase")):
        if list(case.iter("skipped")):
            continue
        module = _module_of(case)
        counts = [
            int(str(each.get("value"))) for each in case.iter("property") if each.get("name") == "tried"
        ]
        tries[module] += sum(counts) or 1
        failed[module] += bool(list(case.iter("failure")) or list(case.iter("error")))
    today = datetime.date.today().isoformat()
    return {module: (count, failed[module], today) for module, count in tries.items()}


def rows_before(page: str, known: Iterable[str]) -> dict[str, Row]:
    """Return the rows of a page whose modules are still there."""
    lines = [line.strip("| ").split(" | ") for line in page.partition("## Tried")[2].splitlines()]
    cells = [line for line in lines if len(line) == 5 and line[3].strip("`") in known]
    return {module.strip("`"): (int(count), int(bad), day) for _, count, bad, module, day in cells}


def main(reports: Sequence[Path]) -> None:
    """Turn JUnit reports into the page; rows of modules that are in none of them stay."""
    page, words = ROOT / "docs" / "reliability.md", purposes()
    rows = rows_before(page.read_text(encoding="utf-8"), set(words)) | rows_of(reports)
    tries, failures = sum(row[0] for row in rows.values()), sum(row[1] for row in rows.values())
    lines = [HEAD, f"{tries} trials, {failures} failures.", ""]
    lines += ["| what | trials | failed | test | tried on |", "|---|---:|---:|---|---|"]
    for module, (count, bad, day) in sorted(rows.items()):
        lines.append(f"| {words[module]} | {count} | {bad} | `{module}` | {day} |")
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main([Path(each) for each in sys.argv[1:]])
