"""Sandboxed reading in a child process with limits of time and memory.

On some damaged files the HDF5 library never returns (seen with 1 in 1000, HDF5 2.0.0), asammdf's compiled part corrupts the
memory (8.8.28, a channel outside its record), and SciPy's reader of MAT files crashes (1.17). Within the process, neither an
exception nor a signal helps.
"""

import atexit
import contextlib
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import IO, Any, Final, TypeVar

from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, MeasurementError

PATIENCE: Final = 30.0
"""Time a file may take before it counts as damaged [s], in addition to `PACE`."""
PACE: Final = 5e6
"""Slowest reading that is waited for [bytes/s]."""
MOST_MEMORY: Final = 8_000_000_000
"""Address space that reading may take [bytes], in addition to eight times the file."""
_STARTING: Final = 120.0

Read = TypeVar("Read")


class UnansweredError(Exception):
    """The process crashed, exceeded its time limit, or ran out of memory; the message is a predicate that names the cause."""


class Reader:
    """Process that reads one file after another; it is started anew after it ended.

    The request is a line of JSON, the reply a line of JSON and bytes. The program first sends a line when it is ready.
    """

    def __init__(self, program: str = "from gearplay.files.sandbox import serve; serve()") -> None:
        self.program = program
        atexit.register(self.close)
        self.lock = threading.Lock()
        self.process: subprocess.Popen[bytes] | None = None
        self.owner = 0

    def ask(
        self, module: str, question: dict[str, Any], take: Callable[[dict[str, Any], IO[bytes]], Read]
    ) -> Read:
        """Return the answer of a module.

        Parameters
        ----------
        module
            Its function ``load`` imports the libraries that the question needs, ``answer`` takes the question and returns a
            description and buffers.
        question
            At least ``path`` and ``size`` [bytes] of the file.
        take
            Makes a result of the description and the pipe with the buffers; `EOFError` where it ends early.

        Raises
        ------
        MeasurementError, InputError
            As reading raises.
        UnansweredError
            Where the process crashes, takes longer than `PATIENCE` and `PACE` allow, or more memory than `MOST_MEMORY`.

        """
        patience = PATIENCE + question["size"] / PACE
        question = question | {"module": module, "patience": patience}
        with self.lock:
            process = self._running()
            assert process.stdin is not None
            assert process.stdout is not None
            try:
                process.stdin.write(json.dumps(question).encode() + b"\n")
                process.stdin.flush()
                _hear(process)  # that the libraries are loaded, which is not the file's fault
                with _ended_after(patience, process):
                    return take(_said(process.stdout), process.stdout)
            except (BrokenPipeError, EOFError):
                self._end()
                raise UnansweredError("crashes on it or does not return") from None
            except (MeasurementError, InputError, UnansweredError):
                raise  # an answer: the process waits for the next question
            except BaseException:
                self._end()  # half an answer is left in the pipe
                raise

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
                [sys.executable, "-c", self.program],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(known), "OPENBLAS_NUM_THREADS": "1"},
            )
            _hear(self.process)
        except BaseException:
            self._end()  # a late line would be taken for a reply
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


@contextlib.contextmanager
def _ended_after(patience: float, process: subprocess.Popen[bytes]) -> Iterator[None]:
    """End a process that takes longer [s]."""
    watch = threading.Timer(patience, process.kill)
    try:
        watch.start()
        yield
    finally:
        watch.cancel()


def _hear(process: subprocess.Popen[bytes]) -> None:
    """Wait for the line that the process sends when it is ready; kill the process after `_STARTING` seconds."""
    assert process.stdout is not None
    with _ended_after(_STARTING, process):
        process.stdout.readline()


def _said(pipe: IO[bytes]) -> dict[str, Any]:
    """Return the line that the process answers; raise what it raises, `EOFError` where it ends."""
    line = pipe.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    said: dict[str, Any] = json.loads(line)
    if "refused" in said:
        raise MeasurementError(said["refused"])
    if "unanswered" in said:
        raise UnansweredError(said["unanswered"])
    if "faults" in said:
        raise InputError([Fault(f[0], f[1] if f[2] else NO_VALUE, f[3], f[4]) for f in said["faults"]])
    return said


def _refusal(error: MeasurementError | InputError) -> dict[str, Any]:
    """Return the reply with the reason why a file was not read."""
    if isinstance(error, MeasurementError):
        return {"refused": str(error)}
    faults = [(f.path, f.value, True, f.rule, f.cure) for f in error.faults if f.value is not NO_VALUE]
    faults += [(f.path, None, False, f.rule, f.cure) for f in error.faults if f.value is NO_VALUE]
    return {"faults": faults}


READER: Final = Reader()
"""The one process of this kind."""


def serve() -> None:
    """Answer questions until there are no more; in the other process."""
    with os.fdopen(os.dup(1), "wb") as pipe:
        os.dup2(2, 1)  # what a library prints must not reach the answers
        pipe.write(b"ready\n")
        pipe.flush()
        for line in sys.stdin.buffer:
            question = json.loads(line)
            module = import_module(question["module"])
            module.load(question)
            pipe.write(b"loaded\n")
            pipe.flush()
            _limit(question["size"], question["patience"])
            said: dict[str, Any] = {}
            parts: Iterable[bytes | memoryview] = ()
            try:
                said, parts = module.answer(question)
            except (MeasurementError, InputError) as error:
                said = _refusal(error)
            except MemoryError:
                said = {
                    "unanswered": f"needs more than {_most_memory(question['size']) / 1e9:.3g} GB of memory to read it"
                }
            pipe.write(json.dumps(said).encode() + b"\n")
            for part in parts:
                pipe.write(part)
            pipe.flush()
            said, parts = {}, ()  # frees what was read


def _most_memory(size: int) -> float:
    return MOST_MEMORY + 8.0 * size


def _limit(size: int, patience: float) -> None:
    """Limit address space and processor time of this process; the latter ends it after the parent process has died."""
    with contextlib.suppress(ImportError, OSError, ValueError):  # a system without such limits
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (int(_most_memory(size)), resource.RLIM_INFINITY))
        used = resource.getrusage(resource.RUSAGE_SELF)
        seconds = int(used.ru_utime + used.ru_stime + 2.0 * patience) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, resource.RLIM_INFINITY))
