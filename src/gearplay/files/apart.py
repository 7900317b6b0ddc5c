"""Reading in a process of its own, which is ended where it does not answer.

On some damaged files the HDF5 library never returns (seen with 1 in 1000, HDF5 2.0.0) and asammdf's compiled part
corrupts the memory (8.8.28, a channel outside its record). Within the process, neither an exception nor a signal helps.
"""

import atexit
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any, Final, TypeVar

from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, MeasurementError

PATIENCE: Final = 30.0
"""Time a file may take before it counts as damaged [s], beside `PACE`."""
PACE: Final = 5e6
"""Slowest reading that is waited for [bytes/s]."""
_STARTING: Final = 120.0

Read = TypeVar("Read")


class Reader:
    """A process that reads one file after another; it is started anew after it ended.

    The question is a line of JSON, the answer a line of JSON and bytes. ``child`` is the program that answers; it says first that
    it is ready.
    """

    def __init__(self, child: str) -> None:
        self.child = child
        atexit.register(self.close)
        self.lock = threading.Lock()
        self.process: subprocess.Popen[bytes] | None = None
        self.owner = 0

    def ask(
        self, question: dict[str, Any], take: Callable[[dict[str, Any], IO[bytes]], Read], patience: float
    ) -> Read | None:
        """Return what ``take`` makes of the answer, or none where the process ended or was ended for its silence.

        Raises `MeasurementError` and `InputError` that reading raised there.
        """
        with self.lock:
            process = self._running()
            assert process.stdin is not None
            assert process.stdout is not None
            watch = threading.Timer(patience, process.kill)
            try:
                watch.start()
                process.stdin.write(json.dumps(question).encode() + b"\n")
                process.stdin.flush()
                return take(_said(process.stdout), process.stdout)
            except (BrokenPipeError, EOFError):
                self._end()
                return None
            except (MeasurementError, InputError):
                raise  # an answer: the process waits for the next question
            except BaseException:
                self._end()  # half an answer is left in the pipe
                raise
            finally:
                watch.cancel()

    def _running(self) -> subprocess.Popen[bytes]:
        if self.process is not None and self.owner == os.getpid() and self.process.poll() is None:
            return self.process
        if self.owner == os.getpid():
            self._end()
        root = str(Path(__file__).resolve().parents[2])
        known = [root, *filter(None, [os.environ.get("PYTHONPATH")])]
        self.process, self.owner = None, os.getpid()
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-c", self.child],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(known)},
            )
            _hear_ready(self.process)
        except BaseException:
            self._end()  # what it says late would be taken for an answer
            raise
        return self.process

    def _end(self) -> None:
        """End the process and close its pipes."""
        process, self.process = self.process, None
        if process is None or self.owner != os.getpid():
            return
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                try:
                    pipe.close()
                except BrokenPipeError:  # what it did not read any more
                    continue

    def close(self) -> None:
        """End the process, if one runs."""
        with self.lock:
            self._end()


def _hear_ready(process: subprocess.Popen[bytes]) -> None:
    """Wait until a process says that it is ready, or ends; it is ended where it says nothing."""
    assert process.stdout is not None
    watch = threading.Timer(_STARTING, process.kill)
    try:
        watch.start()
        process.stdout.readline()
    finally:
        watch.cancel()


def _said(pipe: IO[bytes]) -> dict[str, Any]:
    """Return the line that the process answers; raise what it raises, `EOFError` where it ends."""
    line = pipe.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    said: dict[str, Any] = json.loads(line)
    if "refused" in said:
        raise MeasurementError(said["refused"])
    if "faults" in said:
        raise InputError([Fault(f[0], f[1] if f[2] else NO_VALUE, f[3], f[4]) for f in said["faults"]])
    return said


def refusal_said(error: MeasurementError | InputError) -> dict[str, Any]:
    """Return the answer that says why a file was not read."""
    if isinstance(error, MeasurementError):
        return {"refused": str(error)}
    faults = [(f.path, f.value, True, f.rule, f.cure) for f in error.faults if f.value is not NO_VALUE]
    faults += [(f.path, None, False, f.rule, f.cure) for f in error.faults if f.value is NO_VALUE]
    return {"faults": faults}


def serve(answer: Callable[[bytes, IO[bytes]], None]) -> None:
    """Answer questions until there are no more; in the other process."""
    with os.fdopen(os.dup(1), "wb") as pipe:
        os.dup2(2, 1)  # what a library prints must not reach the answers
        pipe.write(b"ready\n")
        pipe.flush()
        for line in sys.stdin.buffer:
            answer(line, pipe)
