"""Trials of one piece of work on a disk that fails: a process of its own, with the shim of failing_disk.c loaded before it.

Each trial is a fork: libraries and kernels are loaded once. What came of it is printed as a line of JSON.
"""

import ctypes
import json
import os
import random
import shutil
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


def _do(work: dict[str, Any]) -> int:
    """Do a command, or a piece of Python; return the exit code."""
    from gearplay.cli.main import run
    from gearplay.vocabulary.errors import GearplayError

    if "words" in work:
        return run(work["words"])
    try:
        exec(work["program"], {})  # a program of the test's own
    except GearplayError as error:
        sys.stderr.write(f"{error}\n")
        return error.exit_code
    return 0


def _forked(do: Callable[[], int], said: Path) -> int:
    """Return the exit code of what is done in a process that is forked; its words go to a file."""
    if (child := os.fork()) == 0:
        code = 99
        try:
            to = os.open(said, os.O_CREAT | os.O_TRUNC | os.O_WRONLY)
            os.dup2(to, 1)
            os.dup2(to, 2)
            code = do()
            sys.stdout.flush()
            sys.stderr.flush()
        except BaseException:
            traceback.print_exc()
            sys.stderr.flush()
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@contextmanager
def _aside(said: Path) -> Iterator[None]:
    """Let what is printed go to a file."""
    sys.stdout.flush()
    kept, to = (os.dup(1), os.dup(2)), os.open(said, os.O_CREAT | os.O_TRUNC | os.O_WRONLY)
    os.dup2(to, 1)
    os.dup2(to, 2)
    try:
        yield
    finally:
        sys.stdout.flush()
        for handle, number in zip(kept, (1, 2), strict=True):
            os.dup2(handle, number)
            os.close(handle)
        os.close(to)


def say(words: dict[str, Any]) -> None:
    """Print a line of JSON."""
    sys.stdout.write(json.dumps(words) + "\n")
    sys.stdout.flush()


def main() -> None:
    """Count the calls of one piece of work, then let each, or some of them, fail."""
    shim, asked = ctypes.CDLL(os.environ["LD_PRELOAD"]), json.loads(sys.argv[1])
    base, work = Path(asked["base"]), Path(asked["base"]) / "work"
    rng = random.Random(asked["seed"])

    def once(at: int, error: int, on: bool) -> tuple[int, str]:
        shutil.rmtree(work, ignore_errors=True)
        shutil.copytree(base / "before", work)

        def do() -> int:
            os.chdir(work)
            os.environ |= {"FAILING_FOLDER": str(work), "FAILING_AT": str(at), "FAILING_ERROR": str(error)}
            os.environ |= {"FAILING_ON": "1"} if on else {}
            shim.failing_reset()
            return _do(asked)

        code = _forked(do, base / "said")
        return code, (base / "said").read_text(encoding="utf-8", errors="replace")

    # Done here first, all is loaded for the forks.
    shutil.copytree(base / "before", work)
    os.chdir(work)
    os.environ |= {"FAILING_FOLDER": str(work), "FAILING_AT": "0"}
    shim.failing_reset()
    with _aside(base / "said"):
        code = _do(asked)
    calls = shim.failing_calls()
    os.chdir(base)
    assert code == 0, (base / "said").read_text(encoding="utf-8")
    shutil.copytree(work, base / "whole")
    say({"calls": calls})
    every = [(at, error, on) for at in range(1, calls + 1) for error in (5, 28) for on in (False, True)]
    for at, error, on in rng.sample(every, min(len(every), asked["trials"])):
        code, said = once(at, error, on)
        shutil.rmtree(base / "held", ignore_errors=True)
        shutil.copytree(work, base / "held")
        again = None
        if code != 0 and asked["again"] and rng.random() < 0.4:
            os.environ["FAILING_AT"] = "0"
            again = _forked(lambda: (os.chdir(work), _do(asked))[1], base / "said")
        say({"at": at, "error": error, "on": on, "code": code, "said": said, "again": again})
        if sys.stdin.readline() != "next\n":  # the test looks at what is held
            return


if __name__ == "__main__":
    main()
