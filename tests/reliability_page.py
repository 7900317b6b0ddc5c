"""Write docs/reliability.md from the records of a run of the hostile tests: ``make torture``."""

import ast
import datetime
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

Key = tuple[str, str]
Row = tuple[int, int, str]
ROOT = Path(__file__).resolve().parents[1]
HEAD = """# Reliability

What is promised, what was tried, how often, and what failed. The table is written by `make torture` from its
run, which takes some hours; `make torture OF=tests/web` tries some files only and leaves the other rows as
they are. Do not edit.

## Promises

* Bad input, in a file, on the command line, in Python or on the page, gets a sentence that names the field,
  the value, the rule and the cure; never a traceback, a hang or a silent change.
* What would take for ever or more memory than a machine of ordinary size has is refused before it starts,
  with an estimate.
* A file that gearplay writes is whole or absent: written beside, synced, renamed. Only a plain file of one's
  own is replaced, and only where `--overwrite` says so; of two that write the same new name one wins; a
  complete result is never replaced by a partial one.
* A result that was changed, cut or grown after it was written is refused: its last bytes are a digest of all
  others. Finished parts, rows of a sweep, trials of a calibration and its `calibration.json` have theirs:
  what was changed is computed again, or named.
* A result without a digest, of another program, is read by a process of its own, which may crash, hang or run
  out of memory.
* A disk on which a write, a sync or a rename fails, once or from then on, ends a command with a sentence;
  what was stored stays, and the same command goes on. An old whole result is there until the new one is.
* Ctrl-C at any time ends a command with exit code 130 and one sentence that names the kept results; the same
  command continues there. A second Ctrl-C within three seconds destroys nothing. `gearplay run --out` keeps
  what was computed until then.
* Within a function of gearplay that Python calls, Ctrl-C is raised where it harms nothing: compiled code of some
  libraries would lose it, and keep a table half filled.
* The kernel library is loaded whole and from a trusted owner, or not at all; builds at the same time end with one.
* `run.max_wall_time` holds while signals are sampled too; a result that would take longer to compress is
  written as it is.
* A request to the page that does not become whole in 10 s (its body: 30 s more) is dropped; none leaves a traceback.
* A process that is killed loses the piece it was working on and nothing else; what is computed again is the same to the
  last byte.

Not promised: that two machines with other processors or compilers give the same last digits; that a disk
which lies about syncing keeps anything; that Ctrl-C in the first tenth of a second, while Python itself
starts, is answered by gearplay.

## Tried
"""


def purposes() -> dict[str, str]:
    """Return the first line of each test's docstring, or its name in words, by name."""
    found = {}
    for file in sorted((ROOT / "tests").rglob("test_*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                words = node.name.removeprefix("test_").replace("_", " ").replace("ctrl c", "Ctrl-C")
                found[node.name] = (
                    (ast.get_docstring(node) or words[0].upper() + words[1:]).split("\n")[0].rstrip(".")
                )
    return found


def rows_of(reports: Iterable[Path], words: dict[str, str]) -> dict[Key, Row]:
    """Return what JUnit reports say of each test: trials, failures, the day."""
    tries: dict[Key, int] = defaultdict(int)
    failed: dict[Key, int] = defaultdict(int)
    for case in (case for report in reports for case in ElementTree.parse(report).iter("testcase")):
        name = str(case.get("name")).partition("[")[0]
        if name not in words or list(case.iter("skipped")):
            continue
        key = str(case.get("classname")).split(".")[-1] + ".py", words[name]
        counts = [
            int(str(each.get("value"))) for each in case.iter("property") if each.get("name") == "tried"
        ]
        tries[key] += sum(counts) or 1
        failed[key] += bool(list(case.iter("failure")) or list(case.iter("error")))
    today = datetime.date.today().isoformat()
    return {key: (count, failed[key], today) for key, count in tries.items()}


def rows_before(page: str, known: Iterable[str]) -> dict[Key, Row]:
    """Return the rows of a page whose tests are still there."""
    lines = [line.strip("| ").split(" | ") for line in page.partition("## Tried")[2].splitlines()]
    cells = [line for line in lines if len(line) == 5 and line[0] in known]
    return {(test.strip("`"), what): (int(count), int(bad), day) for what, count, bad, test, day in cells}


def main(reports: Sequence[Path]) -> None:
    """Turn JUnit reports into the page; rows of tests that are in none of them stay."""
    page, words = ROOT / "docs" / "reliability.md", purposes()
    rows = rows_before(page.read_text(encoding="utf-8"), set(words.values())) | rows_of(reports, words)
    tries, failures = sum(row[0] for row in rows.values()), sum(row[1] for row in rows.values())
    lines = [HEAD, f"{tries} trials, {failures} failures.", ""]
    lines += ["| what | trials | failed | test | tried on |", "|---|---:|---:|---|---|"]
    for (module, what), (count, bad, day) in sorted(rows.items()):
        lines.append(f"| {what} | {count} | {bad} | `{module}` | {day} |")
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main([Path(each) for each in sys.argv[1:]])
