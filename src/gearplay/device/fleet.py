"""Many runs on a device at a time: laid out there, advanced turn by turn, their logs emptied, brought back."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gearplay.device.turns import (
    CLOCKS,
    EMPTY,
    LOG,
    MECHANISM_OF,
    MECHANISM_TABLE,
    MECHANISMS,
    ORDER,
    PLAN,
    REPORT,
    REPORTS,
    RUN_TABLE,
    RUNS,
    STATUS,
    TAKEN,
    TILE,
)
from gearplay.device.words import LANES, WORD, Words
from gearplay.kernels.arrays import Floats, Ints
from gearplay.kernels.layout import System
from gearplay.kernels.run import LOG_COLUMNS, PAUSED, Run

LAST = ("rows", "log")
"""Fields of a run that only come back."""


class DeviceError(RuntimeError):
    """What a device's driver says went wrong."""


class Memory(Protocol):
    """What a fleet asks of a device (`driver.Device`)."""

    def allocate(self, size: int) -> int:
        """Return the address of that many bytes, a multiple of ``LANES * WORD``."""

    def release(self, address: int) -> None:
        """Give memory back."""

    def put(self, address: int, numbers: NDArray[Any]) -> None:
        """Copy an array, C-contiguous, to the device."""

    def get(self, address: int, numbers: NDArray[Any]) -> None:
        """Fill an array, C-contiguous, from the device."""


Turn = Callable[[int, int, int], None]
"""Lets threads take a turn: how many, steps at most, the address of the plan."""


def words_of(run: Run) -> Words:
    """Return how a run lies on a device; runs and mechanisms of one fleet lie alike."""
    return Words(run, LANES, LAST)


class Fleet:
    """Runs on a device, from when they are put there until `close`.

    Parameters
    ----------
    device, turn
        Where they run, and what a turn there is.
    systems
        The mechanism of each; they may share some.
    words, run
        How they lie there, and the run that this was made of.
    heads
        Their numbers as words, shape [run, word]: `get` and `put` bring all of them here and back.

    """

    def __init__(
        self, device: Memory, turn: Turn, systems: Sequence[System], words: Words, run: Run, heads: Ints
    ) -> None:
        self.device, self.turn, self.words, self.heads = device, turn, words, heads
        self.count = len(systems)
        self.tiles = -(-self.count // LANES)
        self.capacity = run.log.shape[0]
        self._rows, self._row_shape = words.place(run.rows).start, run.rows.shape
        self._log = words.place(run.log).start
        apart = {id(system): system for system in systems}
        places = {key: number for number, key in enumerate(apart)}
        mechanism = Words(systems[0])
        self._held: list[int] = []
        self.status: Ints = np.full(self.count, PAUSED, dtype=np.int64)
        self.steps: Ints = np.zeros(self.count, dtype=np.int64)
        self.times: Floats = np.zeros(self.count)
        self._logged: Ints = np.zeros(self.count, dtype=np.int64)
        self._taken: Ints = np.zeros(self.count, dtype=np.int64)
        """1 where the log was taken and is to be emptied."""
        try:
            plan: Ints = np.zeros(PLAN, dtype=np.int64)
            plan[TILE] = LANES * WORD * words.size
            plan[RUNS] = self._allocate(self.tiles * int(plan[TILE]))
            plan[MECHANISMS] = self._hold(np.concatenate([mechanism.take(each) for each in apart.values()]))
            size = WORD * mechanism.head
            plan[MECHANISM_OF] = self._hold(np.array([size * places[id(s)] for s in systems], dtype=np.int64))
            plan[ORDER], plan[EMPTY] = self._hold(self.status), self._hold(self._taken)
            plan[REPORT] = self._hold(np.zeros((self.count, REPORTS), dtype=np.int64))
            plan[CLOCKS] = self._hold(self.times)
            plan[RUN_TABLE], plan[MECHANISM_TABLE] = self._hold(words.table), self._hold(mechanism.table)
            self._plan, self._at = plan, self._hold(plan)
            self.put()
        except BaseException:
            self.close()
            raise

    def _allocate(self, size: int) -> int:
        address = self.device.allocate(size)
        self._held.append(address)
        return address

    def _hold(self, numbers: NDArray[Any]) -> int:
        address = self._allocate(numbers.nbytes)
        self.device.put(address, numbers)
        return address

    def close(self) -> None:
        """Give the device's memory back."""
        while self._held:
            self.device.release(self._held.pop())

    def _tile(self, tile: int) -> int:
        return int(self._plan[RUNS] + tile * self._plan[TILE])

    def put(self) -> None:
        """Bring all runs to the device as `heads` has them; all of them go on."""
        for tile in range(self.tiles):
            here = self.heads[tile * LANES : (tile + 1) * LANES]
            self.device.put(self._tile(tile), self.words.to_tile(here))
        self.status[:] = PAUSED

    def take_turn(self, steps: int, going: Ints) -> None:
        """Let runs of these numbers go on by at most so many steps; their status, times and steps follow."""
        device, plan = self.device, self._plan
        device.put(int(plan[ORDER]), going)
        device.put(int(plan[EMPTY]), self._taken)
        self.turn(going.size, steps, self._at)
        self._taken[going] = 0
        report: Ints = np.empty((self.count, REPORTS), dtype=np.int64)
        device.get(int(plan[REPORT]), report)
        device.get(int(plan[CLOCKS]), self.times)
        self.status[going] = report[going, STATUS]
        self.steps[going], self._logged[going] = report[going, TAKEN], report[going, LOG]

    def drop_logs(self, least: int) -> None:
        """Let logs be emptied where they have that many rows."""
        full = self._logged >= max(1, least)
        self._taken[full], self._logged[full] = 1, 0

    def take_logs(self, least: int) -> list[tuple[int, Floats]]:
        """Return, by number, what runs have logged, rows (t, contact, 1 onset / 0 release, rate), where it is that many."""
        full = np.flatnonzero(self._logged >= max(1, least))
        found: list[tuple[int, Floats]] = []
        most = int(self._logged[full].max(initial=0))
        for tile in np.unique(full // LANES).tolist():
            lanes = np.empty((most, LOG_COLUMNS, LANES))
            self.device.get(self._tile(tile) + WORD * LANES * self._log, lanes)
            for i in full[full // LANES == tile].tolist():
                found.append((i, lanes[: self._logged[i], :, i % LANES].copy()))
        self._taken[full], self._logged[full] = 1, 0
        return found

    def get(self) -> None:
        """Bring all runs back to `heads`."""
        lanes: Ints = np.empty((self.words.head, LANES), dtype=np.int64)
        for tile in range(self.tiles):
            self.device.get(self._tile(tile), lanes)
            self.words.from_tile(lanes, self.heads[tile * LANES : (tile + 1) * LANES])

    def samples(self) -> Iterator[Floats]:
        """Yield the samples of each run, shape [column, sample]."""
        rows = np.empty((*self._row_shape, LANES))
        for tile in range(self.tiles):
            self.device.get(self._tile(tile) + WORD * LANES * self._rows, rows)
            for lane in range(min(LANES, self.count - tile * LANES)):
                yield rows[:, :, lane]
