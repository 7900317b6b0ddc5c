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
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, MeasurementError

TIME_LIMIT: Final = 30.0
"""Time a file may take before it counts as damaged [s], in addition to `SLOWEST`."""
SLOWEST: Final = 5e6
"""Slowest reading within the limit [bytes/s]."""
MOST_MEMORY: Final = 8_000_000_000
"""Address space that reading may take [bytes], in addition to eight times the file."""
_STARTING: Final = 120.0


@dataclass(frozen=True)
class Request:
    """Request to read a file: its path and size [bytes]."""

    path: Path
    size: int


class SandboxError(Exception):
    """The process crashed, exceeded its time limit, or ran out of memory; the message is a predicate that names the cause."""


class Reader:
    """Child process that reads one file after another; it is started anew after it ended.

    A message is a line of JSON with the sizes of the bytes that follow it; nothing in it is executed. The program
    first sends a message when it is ready.
    """

    def __init__(self, program: str = "from gearplay.files.sandbox import serve; serve()") -> None:
        self.program = program
        atexit.register(self.close)
        self.lock = threading.Lock()
        self.process: subprocess.Popen[bytes] | None = None
        self.owner = 0

    def read(self, module: str, request: Request) -> tuple[Any, list[bytearray]]:
        """Return the result of ``send(request)`` of a module in the child process, a description in JSON and buffers.

        Before it ``load(request)`` of the module imports libraries.

        Raises `MeasurementError` and `InputError` as reading does; `SandboxError` where the process crashes, takes longer than
        `TIME_LIMIT` and `SLOWEST` allow, or more memory than `MOST_MEMORY`.
        """
        seconds = TIME_LIMIT + request.size / SLOWEST
        with self.lock:
            process = self._running()
            assert process.stdin is not None
            try:
                question = {"module": module, "request": asdict(request) | {"path": str(request.path)}}
                process.stdin.write(json.dumps(question | {"seconds": seconds}).encode() + b"\n")
                process.stdin.flush()
                _receive(process, _STARTING)  # the libraries are loaded, which is not the file's fault
                reply, buffers = _receive(process, seconds)
            except BaseException as error:
                self._end()  # half a reply may be left in the pipe
                if isinstance(error, MemoryError) or not isinstance(error, Exception):
                    raise
                raise SandboxError("crashes on it or does not return") from None
        if "raises" in reply:
            raise _error_of(reply["raises"])
        return reply["content"], buffers

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
            _receive(self.process, _STARTING)
        except BaseException:
            self._end()  # a late message would be taken for a reply
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
                with contextlib.suppress(BrokenPipeError):  # bytes that it did not read any more
                    pipe.close()

    def close(self) -> None:
        """End the process, if one runs."""
        with self.lock:
            self._end()


def _receive(process: subprocess.Popen[bytes], seconds: float) -> tuple[dict[str, Any], list[bytearray]]:
    """Return the next message of a process, which is killed where it takes longer; `EOFError` where it ends."""
    assert process.stdout is not None
    watch = threading.Timer(seconds, process.kill)
    try:
        watch.start()
        head: dict[str, Any] = json.loads(process.stdout.readline())
        buffers = [bytearray(size) for size in head["sizes"]]
        for buffer in buffers:
            if process.stdout.readinto(buffer) != len(buffer):  # type: ignore[attr-defined] # buffered, thus complete
                raise EOFError
        return head, buffers
    finally:
        watch.cancel()


def _described(error: MeasurementError | InputError | SandboxError) -> list[Any]:
    """Return an error as JSON: its kind, and its message or faults."""
    if not isinstance(error, InputError):
        return [type(error).__name__, str(error)]
    values = [None if f.value is NO_VALUE else [f.value] for f in error.faults]
    return ["InputError", [[f.path, v, f.rule, f.cure] for f, v in zip(error.faults, values, strict=True)]]


def _error_of(described: list[Any]) -> Exception:
    kind, what = described
    if kind == "InputError":
        return InputError([Fault(path, NO_VALUE if v is None else v[0], *rest) for path, v, *rest in what])
    return {"MeasurementError": MeasurementError, "SandboxError": SandboxError}[kind](what)


READER: Final = Reader()
"""The one process of this kind."""


def serve() -> None:
    """Serve requests until there are no more; in the child process."""
    with os.fdopen(os.dup(1), "wb") as pipe:
        os.dup2(2, 1)  # output of a library must not reach the replies

        def send(head: dict[str, Any], buffers: Sequence[Any] = ()) -> None:
            views = [memoryview(each).cast("B") for each in buffers]
            pipe.write(json.dumps(head | {"sizes": [view.nbytes for view in views]}).encode() + b"\n")
            for view in views:
                pipe.write(view)
            pipe.flush()

        send({"ready": True})
        for line in sys.stdin.buffer:
            question = json.loads(line)
            module, fields = import_module(question["module"]), question["request"]
            request = module.Request(**fields | {"path": Path(fields["path"])})
            module.load(request)
            send({"loaded": True})
            _limit(request.size, question["seconds"])
            try:
                content, buffers = module.send(request)
                send({"content": content}, buffers)
            except (MeasurementError, InputError) as error:
                send({"raises": _described(error)})
            except MemoryError:
                most = _most_memory(request.size) / 1e9
                reason = SandboxError(f"needs more than {most:.3g} GB of memory to read it")
                send({"raises": _described(reason)})
            content, buffers = None, ()  # frees the memory


def _most_memory(size: int) -> float:
    return MOST_MEMORY + 8.0 * size


def _limit(size: int, seconds: float) -> None:
    """Limit address space and processor time of this process; the latter ends it after the parent process has died."""
    with contextlib.suppress(ImportError, OSError, ValueError):  # a system without such limits
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (int(_most_memory(size)), resource.RLIM_INFINITY))
        used = resource.getrusage(resource.RUSAGE_SELF)
        most = int(used.ru_utime + used.ru_stime + 2.0 * seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))
