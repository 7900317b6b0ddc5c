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
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, Final

import numpy as np

from gearplay.files.measurements.building import Request
from gearplay.files.measurements.refusing import check_samples, damaged
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, MeasurementError

PATIENCE: Final = 30.0
"""Time a file may take before it counts as damaged [s], beside `PACE`."""

PACE: Final = 5e6
"""Slowest reading that is waited for [bytes/s]."""

_STARTING: Final = 120.0
_CHILD: Final = "from gearplay.files.measurements.apart_child import serve; serve()"


class Reader:
    """A process that reads one file after another; it is started anew after it ended.

    The question is a line of JSON, the answer a line of JSON and the samples of all channels as float64.
    """

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.process: subprocess.Popen[bytes] | None = None
        self.owner = 0

    def ask(self, request: Request, reader: str, patience: float) -> Record | None:
        """Return the record, or none where the process ended or was ended for its silence."""
        with self.lock:
            process = self._running()
            assert process.stdin is not None
            assert process.stdout is not None
            watch = threading.Timer(patience, process.kill)
            watch.start()
            try:
                question = asdict(request) | {"path": str(request.path.absolute()), "reader": reader}
                process.stdin.write(json.dumps(question).encode() + b"\n")
                process.stdin.flush()
                return _answer(request, process.stdout)
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
        root = str(Path(__file__).resolve().parents[3])
        known = [root, *filter(None, [os.environ.get("PYTHONPATH")])]
        self.process = subprocess.Popen(
            [sys.executable, "-c", _CHILD],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(known)},
        )
        self.owner = os.getpid()
        watch = threading.Timer(_STARTING, self.process.kill)
        watch.start()
        try:
            assert self.process.stdout is not None
            self.process.stdout.readline()  # it says when it is ready
        finally:
            watch.cancel()
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


_READER: Final = Reader()
atexit.register(_READER.close)


def _answer(request: Request, pipe: IO[bytes]) -> Record:
    """Return the record that the process answers; raise what it raises, `EOFError` where it ends."""
    line = pipe.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    said = json.loads(line)
    if "refused" in said:
        raise MeasurementError(said["refused"])
    if "faults" in said:
        raise InputError([Fault(f[0], f[1] if f[2] else NO_VALUE, f[3], f[4]) for f in said["faults"]])
    check_samples(request.path, sum(channel["size"] for channel in said["channels"]))
    channels = [_channel(channel, pipe) for channel in said["channels"]]
    return Record(tuple(channels), said["source"], said["format"], MappingProxyType(said["attributes"]))


def _channel(said: dict[str, Any], pipe: IO[bytes]) -> Channel:
    values = np.empty(said.pop("size"))
    attributes = MappingProxyType(said.pop("attributes"))
    view = values.data.cast("B")
    while len(view):
        count = pipe.readinto(view)  # type: ignore[attr-defined]
        if not count:
            raise EOFError
        view = view[count:]
    return Channel(values=values, attributes=attributes, **said)


def read_apart(request: Request, reader: str, library: str) -> Record:
    """Read a file in the other process.

    Parameters
    ----------
    request
        What the caller asked for.
    reader
        ``hdf5``, ``mat`` or ``mdf4``.
    library
        What reads there, for the sentence.

    Raises
    ------
    MeasurementError, InputError
        What reading raises; or where the process crashes, or takes longer than `PATIENCE` and `PACE` allow.

    """
    record = _READER.ask(request, reader, PATIENCE + request.size / PACE)
    if record is None:
        raise damaged(request.path, f"{library} crashes on it or does not return")
    return record
