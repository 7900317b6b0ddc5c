"""The commands of README and docs: found, and run as they stand, page by page, in a folder with the files that they name.

What would take minutes is shortened, and only so: a plan is replaced by a copy with less of everything (`SHORT_PLANS`), and other
commands get the options of `SHORTER` behind their own, less those of `LEFT_OUT`, and the numbers of `LESS`. In full depth those
that take seconds run as they stand.
"""

import re
import shlex
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from depth import FULL
from gearplay.cli.copy import names
from gearplay.cli.main import WORDS, run
from gearplay.model.toml_files import parse_toml, write_toml

ROOT = Path(__file__).resolve().parents[1]
MADE = {"case-file.md", "commands.md", "reference.md", "variables.md"}
"""Pages that `make docs` writes from the code."""
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *(page for page in sorted((ROOT / "docs").rglob("*.md")) if page.name not in MADE),
]
FENCE = re.compile(r"^(?P<fence>```+)(?P<kind>[a-z]*)\n(?P<text>.*?)^(?P=fence)$", re.DOTALL | re.MULTILINE)
SHELL = {"", "sh", "console"}
PROGRAMS = ("gearplay", "make", "python", "pip")
LONG = {"study", "calibrate", "sweep", "dataset", "resume", "motion", "modes"}
"""Verbs that are left to the full depth, unless a command only asks how long it would take."""
NEVER = {"serve"}
"""Ends by Ctrl-C only: the tests of the page start it."""
SHORTER: dict[str, tuple[str, ...]] = {
    "study": ("--members", "2", "--duration", "1"),
    "motion": ("--periods", "200", "--settle", "100", "--members", "4"),
    "run": ("--set", "run.sampling=10kHz"),
    "bifurcation": ("--count", "8", "--settle", "50", "--keep", "20", "--orbits", "12"),
    "measure": ("--duration", "2"),
    "dataset": ("--set", "run.duration=20ms", "--set", "run.transient=0s"),
    "wear": ("--blocks", "1"),
    "portrait": ("--settle", "50", "--keep", "100"),
}
LESS = {"--positions": "4", "--members": "8", "--frames": "8"}
"""Options that get smaller numbers where a command has them."""
LEFT_OUT = {"--claims"}
"""Options that make minutes of work whatever else is said: tests/cli/test_study.py runs them."""
EVALUATIONS = "40"
RUN: dict[str, Any] = {"run.duration": "0.1 s", "run.transient": "0 s", "run.tolerance": 1e-6}


def shorter_sweep(plan: dict[str, Any]) -> dict[str, Any]:
    """Return a sweep plan with as many axes, parameters and kept numbers, but few places, short runs and no bands in them."""
    kept = [each for each in plan["reduce"] if each["kind"] in ("statistic", "contact", "jam")]
    short: dict[str, Any] = {
        **plan,
        "members": 2,
        "set": {**plan.get("set", {}), **RUN, "run.sampling": "2 kHz"},
        "reduce": kept,
    }
    if "axes" in plan:
        short["axes"] = [{**axis, "count": 2} if "count" in axis else axis for axis in plan["axes"]]
    if "design" in plan:
        short["design"] = {**plan["design"], "count": 8}
    if "tolerance" in plan:
        short["tolerance"] = {**plan["tolerance"], "count": 10, "steps": 5}
    return short


def shorter_calibration(plan: dict[str, Any]) -> dict[str, Any]:
    """Return a calibration plan with all its parameters, targets and conditions, but few trials of few, short members."""
    effort = {
        "evaluations": int(EVALUATIONS),
        "startup": 32,
        "polish": 2,
        "polish_members": 2,
        "check_members": 2,
    }
    return {
        **plan,
        "set": {**plan.get("set", {}), "run.tolerance": 1e-5},
        "models": plan["models"][:2],
        "simulation": {**plan["simulation"], "members": 2, "transient": "0.1 s"},
        "effort": {**plan["effort"], **effort},
    }


SHORT_PLANS: dict[str, Callable[[dict[str, Any]], dict[str, Any]]] = {
    "sweep": shorter_sweep,
    "calibrate": shorter_calibration,
}


@dataclass(frozen=True)
class Command:
    """One line of a page: its words without a comment, and the file that takes its output."""

    page: Path
    words: tuple[str, ...]
    into: str = ""

    @property
    def verb(self) -> str:
        if self.words[0] != "gearplay":
            return ""
        two = " ".join(self.words[1:3])
        return two if two in WORDS.values() else self.words[1]

    @property
    def long(self) -> bool:
        """Whether it is left to the full depth."""
        return self.verb in LONG and "--dry-run" not in self.words

    def __str__(self) -> str:
        return f"{self.page.stem}: {' '.join(self.words)}"[:90]


def commands_of(page: Path) -> list[Command]:
    """Return the commands of a page's shell blocks, and of those that say no language, in order."""
    found = []
    for block in FENCE.finditer(page.read_text(encoding="utf-8")):
        if block["kind"] not in SHELL:
            continue
        for line in block["text"].replace("\\\n", " ").splitlines():
            words = line.strip().removeprefix("$ ")
            if words.startswith(PROGRAMS):
                split = shlex.split(words, comments=True)
                cut = split.index(">") if ">" in split else len(split)
                found.append(Command(page, tuple(split[:cut]), *split[cut + 1 :]))
    return found


COMMANDS = [command for page in PAGES for command in commands_of(page)]


def given(words: tuple[str, ...], option: str) -> str | None:
    """Return what follows an option."""
    return words[words.index(option) + 1] if option in words else None


def run_commands(page: Path, folder: Path, *, long: bool) -> int:
    """Run the commands of a page in order, the long ones too if wanted; return how many ran. The folder is the working one."""
    for place in ("docs", "src"):
        if not (folder / place).exists():
            (folder / place).symlink_to(ROOT / place)  # pages name files from the root of the repository
    every = [each for each in commands_of(page) if each.verb and each.verb not in NEVER]
    if long:
        every = [each for each in every if each.long or each.verb == "copy"]
    count = 0
    for command in every:
        if command.long and not long:
            continue
        assert run(shortened(command, folder)) == 0, str(command)
        if (out := given(command.words, "--out")) is not None and "." in Path(out).name:
            assert Path(out).exists(), str(command)
        count += 1
    return count


def shortened(command: Command, folder: Path) -> list[str]:
    """Return the words to run: as they stand, but for a shorter plan, or what makes long work short."""
    words = [word for word in command.words[1:] if word not in LEFT_OUT]
    if command.verb in SHORT_PLANS and "--dry-run" not in words:
        words[1] = str(short_plan(command.verb, words[1], folder))
        if command.verb == "calibrate":
            words += ["--evaluations", EVALUATIONS]
            if "--recover" in words:
                words += ["--recover", "3"]
        if "--out" not in words:
            words += ["--out", f"out/{command.verb}-{Path(words[1]).stem}"]
    if FULL and not command.long:
        return words
    words = [LESS.get(before, word) for before, word in pairwise(["", *words])]
    return words + list(SHORTER.get(command.verb, ()))


def short_plan(verb: str, plan: str, folder: Path) -> Path:
    """Write a shorter copy of a bundled plan, or of a file, and return its place."""
    kind = "calibration" if verb == "calibrate" else verb
    short = folder / "short" / f"{Path(plan).stem}.toml"
    if not short.exists():
        short.parent.mkdir(exist_ok=True)
        if plan in names()[kind]:
            assert run(["copy", plan, "--kind", kind, "--out", str(short)]) == 0
        else:
            shutil.copy(plan, short)
            if Path("records").exists() and not (short.parent / "records").exists():
                shutil.copytree("records", short.parent / "records")
        document = parse_toml(short.read_text(encoding="utf-8"), plan)
        short.write_text(write_toml(SHORT_PLANS[verb](document)), encoding="utf-8")
    return short
