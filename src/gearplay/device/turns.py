"""What a thread of the device does in a turn: advance one run by some steps, and report how it stands."""

from typing import Any

from gearplay.device.words import LANES, WORD
from gearplay.kernels.run import LOGGED, STEPS, T

RUNS, MECHANISMS, MECHANISM_OF, ORDER, EMPTY, REPORT, CLOCKS, RUN_TABLE, MECHANISM_TABLE, TILE = range(10)
"""Slots of the plan of a turn: addresses of runs, of mechanisms, of each run's mechanism [byte from the first], of the numbers of
runs that go on, of marks of those whose log was taken, of reports and of times, of both tables; bytes of a tile."""
PLAN = 10

STATUS, LOG, TAKEN = range(3)
"""Columns of a report: how the run stands, rows in its log, steps taken."""
REPORTS = 3


def make_turn(
    advance: Any, run_at: Any, mechanism_at: Any, thread: Any, word: Any, set_word: Any, set_number: Any
) -> Any:
    """Return the function of a turn, made of what the device knows: the kernel, groups at an address, words at an address."""

    def turn(count: int, steps: int, plan: int) -> None:
        k = thread(1)
        if k >= count:
            return
        i = word(word(plan, ORDER), k)
        system = mechanism_at(
            word(plan, MECHANISM_TABLE), word(plan, MECHANISMS) + word(word(plan, MECHANISM_OF), i)
        )
        tile = word(plan, RUNS) + (i // LANES) * word(plan, TILE)
        run = run_at(word(plan, RUN_TABLE), tile + WORD * (i % LANES))
        if word(word(plan, EMPTY), i) != 0:
            run.counts[LOGGED] = 0
        status = advance(system, run, steps)
        report = word(plan, REPORT)
        set_word(report, REPORTS * i + STATUS, status)
        set_word(report, REPORTS * i + LOG, run.counts[LOGGED])
        set_word(report, REPORTS * i + TAKEN, run.counts[STEPS])
        set_number(word(plan, CLOCKS), i, run.clock[T])

    return turn
