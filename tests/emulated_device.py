"""A device in the processor's memory: it takes turns on the words that a fleet lays out, by the processor's kernels."""

import copy
import ctypes
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.device.fleet import LAST
from gearplay.device.turns import make_turn
from gearplay.device.words import LANES, WORD, Words
from gearplay.kernels import stepper
from gearplay.kernels.layout import System
from gearplay.kernels.run import Run
from gearplay.solver.on_device import Devices


def _at(address: int, count: int) -> NDArray[np.int64]:
    return np.ctypeslib.as_array((ctypes.c_int64 * count).from_address(address))


class Emulated:
    """Memory that counts what it holds, and turns."""

    def __init__(self) -> None:
        self.size = 10**9
        self.held: dict[int, NDArray[Any]] = {}
        self.threads: list[int] = []
        """Of each turn."""

    def allocate(self, size: int) -> int:
        step = LANES * WORD
        numbers = np.full(max(1, size) + step, 255, dtype=np.uint8)  # whoever reads what nobody wrote sees it
        address = -(-numbers.ctypes.data // step) * step
        self.held[address] = numbers
        return address

    def release(self, address: int) -> None:
        del self.held[address]

    def put(self, address: int, numbers: NDArray[Any]) -> None:
        assert numbers.flags.c_contiguous
        ctypes.memmove(address, numbers.ctypes.data, numbers.nbytes)

    def get(self, address: int, numbers: NDArray[Any]) -> None:
        assert numbers.flags.c_contiguous
        ctypes.memmove(numbers.ctypes.data, address, numbers.nbytes)

    @property
    def devices(self) -> Devices:
        """As the solver takes it, with a memory of 1 GB."""
        return Devices(self, lambda: self.size, self.turn_for)

    def turn_for(self, systems: Sequence[System], run: Run) -> Any:
        """Return a turn for runs of the form of one."""
        system, run = copy.deepcopy(systems[0]), copy.deepcopy(run)
        words = Words(run, LANES, LAST)

        class At:
            """A run whose words stand in a tile: taken out, advanced, put back."""

            def __init__(self, base: int) -> None:
                self.lane = base % (LANES * WORD) // WORD
                self.tile = _at(base - WORD * self.lane, LANES * words.size).reshape(-1, LANES)
                self.heads = np.empty((LANES, words.head), dtype=np.int64)
                words.from_tile(self.tile[: words.head], self.heads)
                words.put(self.heads[self.lane], run)
                for array, kept in self.last():
                    array[:] = kept

            def last(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
                for name in LAST:
                    array = getattr(run, name)
                    yield array.reshape(-1).view(np.int64), self.tile[words.place(array), self.lane]

            def back(self) -> None:
                self.heads[self.lane] = words.take(run)
                self.tile[: words.head] = words.to_tile(self.heads)
                for array, kept in self.last():
                    kept[:] = array

            def __getattr__(self, name: str) -> Any:
                return getattr(run, name)

        mechanism = Words(system)

        def mechanism_at(table: int, base: int) -> System:
            assert np.array_equal(_at(table, mechanism.table.size), mechanism.table)
            mechanism.put(_at(base, mechanism.head), system)
            return system

        def run_at(table: int, base: int) -> At:
            assert np.array_equal(_at(table, words.table.size), words.table)
            return At(base)

        def advance(system: System, at: At, steps: int) -> int:
            status = stepper.advance(system, run, steps)
            at.back()
            return int(status)

        numbers = iter(())

        def thread(_: int) -> int:
            return next(numbers)

        def word(address: int, place: int) -> int:
            return int(_at(address + WORD * place, 1)[0])

        def set_word(address: int, place: int, value: int) -> None:
            _at(address + WORD * place, 1)[0] = value

        def set_number(address: int, place: int, value: float) -> None:
            _at(address + WORD * place, 1).view(np.float64)[0] = value

        turn = make_turn(advance, run_at, mechanism_at, thread, word, set_word, set_number)

        def all_threads(count: int, steps: int, plan: int) -> None:
            nonlocal numbers
            self.threads.append(count)
            numbers = iter(range(LANES * (-(-count // LANES))))  # more threads than runs, as on a device
            for _ in range(LANES * (-(-count // LANES))):
                turn(count, steps, plan)

        return all_threads
