"""`python -m gearplay.build`: build the kernel library of these sources, for this platform or for others."""

import argparse
import os
import signal
import sys
import time
from collections.abc import Callable
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from gearplay.build.targets import TARGETS, host, target
from gearplay.vocabulary.errors import GearplayError

INTERVAL = 9.5
"""Least time [s] between two lines of progress."""


def _progress() -> Callable[[int, int], None]:
    """Return a function that writes progress on standard error: a line at once, then one every `INTERVAL`."""
    began = last = time.monotonic()
    kept: int | None = None

    def report(done: int, total: int) -> None:
        nonlocal kept, last
        now = time.monotonic()
        if kept is None:
            kept = done
            more = f"; {100 * kept / total:.0f} % of it is there already" if kept else ""
            sys.stderr.write(
                f"Building the kernel library, once after an installation or an edit: some minutes{more}.\n"
            )
        elif now - last >= INTERVAL and done < total:
            last = now
            time_left = (
                f"about {(now - began) * (total - done) / (done - kept):.0f} s left"
                if done > kept
                else f"{now - began:.0f} s so far"
            )
            sys.stderr.write(f"{100 * done / total:.0f} % of the kernel library, {time_left}.\n")

    return report


def _waiting(folder: Path) -> None:
    sys.stderr.write(f"Another process builds the kernel library in {folder}: waiting for it.\n")


def _ended(signum: int, frame: object) -> None:
    """End as Ctrl-C does, so that compiler processes and their semaphores go first."""
    raise KeyboardInterrupt


def main() -> int:
    """Build; return the exit code. The files, or an error in one sentence, are on standard output, progress on standard error."""
    parser = argparse.ArgumentParser(prog="python -m gearplay.build", description=__doc__)
    parser.add_argument(
        "--target", action="append", help=f"{', '.join(TARGETS)}; may be repeated (default: this platform)"
    )
    parser.add_argument(
        "--folder", type=Path, help="where the library goes (default: where it is looked for)"
    )
    parser.add_argument(
        "--bounds",
        action="store_true",
        help="compile checks of the bounds of arrays, into a folder of its own",
    )
    parser.add_argument(
        "--static", action="store_true", help="build static libraries, for linking into others"
    )
    wanted = parser.parse_args()
    signal.signal(signal.SIGTERM, _ended)
    try:
        own = TARGETS[host()]
        targets = wanted.target or [host()]
        for each in targets:
            target(each)
        # numba reads its settings from the environment: none but these.
        for name in [name for name in os.environ if name.startswith(("NUMBA_", "GEARPLAY_INTERPRETED"))]:
            del os.environ[name]
        os.environ |= {
            "NUMBA_CPU_NAME": own.processor,
            "NUMBA_CPU_FEATURES": "",
            "NUMBA_BOUNDSCHECK": str(int(wanted.bounds)),
        }
        folder = None if wanted.folder is None else wanted.folder.resolve()
        from gearplay.build.building import build

        for file in build(
            targets, _progress(), folder=folder, static=wanted.static, waiting=_waiting
        ).values():
            sys.stdout.write(f"{file}\n")
    except KeyboardInterrupt:
        return 130
    except ModuleNotFoundError as error:
        if error.name not in ("numba", "llvmlite"):
            raise
        sys.stdout.write(
            "it needs numba. Install a wheel of gearplay for this platform, or numba: pip install numba.\n"
        )
        return 1
    except BrokenProcessPool:
        sys.stdout.write(
            "a compiler process was ended, as where memory is short. Start again: what is compiled stays.\n"
        )
        return 1
    except (GearplayError, OSError) as error:
        sys.stdout.write(f"{error}\n")
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
