"""Worker process: runs jobs one at a time and reports progress.

Frames go over standard input and output, each after its length (4 bytes, little-endian). A job is JSON, ``{"job": ...}``;
responses are JSON, or a result frame (`frames`). ``{"stop": true}`` stops the job in hand. Memory is bounded by the system, steps
and time by the case.
"""

import contextlib
import gc
import json
import os
import struct
import sys
import threading
import time
from queue import SimpleQueue
from typing import Any, BinaryIO

from gearplay.vocabulary.errors import GearplayError
from gearplay.vocabulary.progress import Tick
from gearplay.web.pool import LONGEST_FRAME, RESULT, WORDS

MEMORY = 4 * 1024**3  # bytes of address space
PAUSE = 0.1  # s between two progress messages


class Line:
    """Connection back to the server."""

    def __init__(self, out: BinaryIO) -> None:
        self.out, self.lock = out, threading.Lock()

    def send(self, payload: bytes) -> None:
        """Write one frame."""
        with self.lock:
            try:
                self.out.write(struct.pack("<I", len(payload)) + payload)
                self.out.flush()
            except BrokenPipeError:
                os._exit(0)  # the server is gone

    def send_words(self, **words: Any) -> None:
        """Write one JSON frame."""
        self.send(WORDS + json.dumps(words).encode("utf-8"))


def main() -> None:
    """Serve jobs until standard input ends."""
    _bound_memory()
    line = Line(os.fdopen(os.dup(1), "wb"))
    os.dup2(2, 1)  # whatever prints must not come between the frames
    stop, jobs = threading.Event(), SimpleQueue[dict[str, Any] | None]()
    threading.Thread(target=_listen, args=(sys.stdin.buffer, jobs, stop), daemon=True).start()
    _warm(stop)
    gc.freeze()  # of what is loaded nothing is garbage: looking through it takes as long as a run
    line.send_words(ready=True)
    while True:
        job = jobs.get()
        if job is None:
            os._exit(0)  # the server is gone: nothing is left to tidy up
        _do(job, line, stop)


def _warm(stop: threading.Event) -> None:
    """Load everything that a run needs, so that the first run is as fast as the next."""
    from gearplay.model.reading import load_case
    from gearplay.web.tasks import run

    brief = ["run.duration=50ms", "run.transient=0s", "run.sampling=20kHz"]
    run({"case": load_case("han2021", brief).resolved()}, lambda done, total: None, stop)


def _listen(source: BinaryIO, jobs: "SimpleQueue[dict[str, Any] | None]", stop: threading.Event) -> None:
    while True:
        head = source.read(4)
        if len(head) < 4:
            stop.set()
            jobs.put(None)
            return
        words = json.loads(source.read(struct.unpack("<I", head)[0]))
        if "job" in words:
            stop.clear()  # here, where a stop that follows cannot be overtaken
            jobs.put(words["job"])
        else:
            stop.set()


def _bound_memory() -> None:
    with contextlib.suppress(ImportError, ValueError, OSError):  # not on every system
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def _do(job: dict[str, Any], line: Line, stop: threading.Event) -> None:
    """Do one job; send its result or its error."""
    from gearplay.web.tasks import TASKS

    try:
        document = TASKS[job["kind"]](job, _reporter(line), stop)
        if len(document) >= LONGEST_FRAME:
            line.send_words(
                error=f"run: its result would have more than {LONGEST_FRAME // 1024**2} MB. Shorten it."
            )
            return
        line.send(RESULT + document)
    except KeyboardInterrupt:
        line.send_words(error="Cancelled.", cancelled=True)
    except GearplayError as error:
        line.send_words(error=str(error))
    except MemoryError:
        line.send_words(
            error="run: it needs more memory than the server allows. Shorten it or lower run.sampling."
        )
    except Exception as error:
        line.send_words(
            error=f"gearplay failed: {type(error).__name__}. This is a fault of the program, not of your input."
        )


def _reporter(line: Line) -> Tick:
    last = time.monotonic()

    def report(done: float, total: float) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= PAUSE and total > 0.0:
            last = now
            line.send_words(progress=min(1.0, done / total))

    return report


if __name__ == "__main__":
    main()
