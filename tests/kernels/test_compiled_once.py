"""Kernels that are called by address: the same numbers, compiled when first called, not contained in their callers."""

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from gearplay.kernels.compiled import INTERPRETED
from programs import run_program

pytestmark = pytest.mark.hostile

PROGRAM = """
import json, sys
import numpy as np
from dataclasses import dataclass
from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels import compiler
from gearplay.kernels.compiled import compiled
from gearplay.kernels.compiled_once import KERNELS, compiled_once

made, compile_kernel = [], compiler.compile_kernel
def note(kernel):
    made.append(kernel.name.removeprefix("__main__."))
    return compile_kernel(kernel)
compiler.compile_kernel = note

@dataclass(frozen=True, eq=False)
class Numbers(Group):
    values: Floats

@compiled_once
def share(numbers: Numbers, y: Floats, table: Rows, n: int, x: float) -> tuple[int, float]:
    y[0] = 7.0
    return n + 1, numbers.values[n] * x + table[1, 0]

@compiled_once
def never(numbers: Numbers) -> float:
    return numbers.values[0]

@compiled_once
def past(numbers: Numbers, n: int) -> float:
    return numbers.values[n]

@compiled
def double(x):
    return 2.0 * x

@compiled_once
def caller(numbers: Numbers, y: Floats, table: Rows, which: int) -> float:
    if which == 1:
        return never(numbers)
    if which == 2:
        return past(numbers, 9)
    n, half = share(numbers, y, table, 1, 0.5)
    m, again = share(numbers, y, table, n, 2.0)  # a literal and a variable make one version
    return 100.0 * m + double(5.0 * half) + again

numbers = Numbers(np.array([1.0, 2.0, 3.0]))
y, table = np.zeros(2), np.arange(4.0).reshape(2, 2)
found = {"value": caller(numbers, y, table, 0), "y": y[0]}
found["made"] = made.copy()
found["needs"] = compile_kernel(KERNELS["__main__.caller"]).needs
try:
    caller(numbers, y, table, 2)
    found["past"] = "nothing was said"
except IndexError as error:
    found["past"] = "IndexError"

@compiled_once
def wrong(numbers: Numbers, y: Floats) -> float:
    return never(y)

try:
    wrong(numbers, y)
    found["wrong"] = "compiled"
except Exception as error:
    found["wrong"] = "takes" if "__main__.never takes" in str(error) else str(error)
json.dump(found, sys.stdout)
"""


def cache_in(folder: Path) -> dict[str, str]:
    """Return the environment in which kernels are compiled, whatever this process does, into a folder."""
    return {"NUMBA_CACHE_DIR": str(folder / "cache"), "NUMBA_DISABLE_JIT": "0"}


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    folder = tmp_path_factory.mktemp("once")
    done = run_program(PROGRAM, file=folder / "program.py", **cache_in(folder), NUMBA_BOUNDSCHECK="1")
    made: dict[str, object] = json.loads(done.stdout)
    return made


@pytest.mark.slow
def test_a_call_by_address_gives_what_the_kernel_returns(found: dict[str, object]) -> None:
    # first (2, 2 * 0.5 + 2), then (3, 3 * 2 + 2)
    assert found["value"] == 100.0 * 3 + 10.0 * 3.0 + 8.0
    assert found["y"] == 7.0


def test_an_index_beyond_its_bounds_comes_through(found: dict[str, object]) -> None:
    assert found["past"] == "IndexError"


def test_a_wrong_argument_is_refused_when_the_caller_is_compiled(found: dict[str, object]) -> None:
    assert found["wrong"] == "takes"


CALLED = """
import json, sys
import numpy as np
from dataclasses import dataclass
from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled_once import compiled_once

@dataclass(frozen=True, eq=False)
class Numbers(Group):
    values: Floats

@compiled_once
def everything(numbers: Numbers, y: Floats, table: Rows, n: int, x: float, yes: bool) -> tuple[int, float, bool]:
    y[1] += numbers.values[1] + table[1, 2] * table.shape[0] * table.shape[1]
    return -n, x / 3.0 if yes else x, not yes

@compiled_once
def nothing(places: Ints) -> None:
    places[0] = 2**40

@compiled_once
def even(n: int) -> bool:
    return n % 2 == 0

numbers, y, table, places = Numbers(np.array([1.0, 0.5])), np.zeros(2), np.arange(6.0).reshape(2, 3), np.zeros(1, dtype=int)
found = {
    "everything": [everything(numbers, y, table, 2**40, 1.5, True), everything(numbers, y, table, 7, 2, False)],
    "nothing": nothing(places), "even": [even(2), even(np.int64(3))],
}
found["y"], found["places"] = y.tolist(), places.tolist()
refused, still = [], np.zeros(2)
still.flags.writeable = False
for args in (
    (y, y, table, 1, 1.0, True), (numbers, table, table, 1, 1.0, True), (numbers, y, table.T, 1, 1.0, True),
    (numbers, places, table, 1, 1.0, True), (numbers, y, table, 1.5, 1.0, True), (numbers, y, table, 1, "x", True),
    (numbers, y, table, 1, 1.0), (numbers, [1.0], table, 1, 1.0, True), (numbers, y, table, 2**70, 1.0, True),
    (numbers, still, table, 1, 1.0, True),
):
    try:
        everything(*args)
    except (TypeError, ValueError) as error:
        refused.append(str(error))
found["refused"] = refused
json.dump(found, sys.stdout)
"""


@pytest.fixture(scope="module")
def called(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("called")
    made: dict[str, Any] = json.loads(
        run_program(CALLED, file=folder / "program.py", **cache_in(folder)).stdout
    )
    return made


@pytest.mark.slow
@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
def test_python_hands_over_and_gets_back_numbers_arrays_and_groups(called: dict[str, Any]) -> None:
    assert called["everything"] == [[-(2**40), 0.5, False], [-7, 2.0, True]]
    assert called["y"] == [0.0, 2 * (0.5 + 5.0 * 6.0)]
    assert (called["nothing"], called["places"]) == (None, [2**40])
    assert called["even"] == [True, False]


@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
def test_python_hands_over_nothing_that_compiled_code_would_misread(called: dict[str, Any]) -> None:
    refused = called["refused"]
    assert len(refused) == 10
    assert "numbers of __main__.everything must be Numbers, not ndarray" in refused
    assert sum("must be a C-contiguous array that can be written to" in words for words in refused) == 5
    assert "__main__.everything takes 6 arguments" in refused


REFRESHED = """
import signal
from numba.core import base
from numba.core.typing import context
from gearplay.kernels.compiled_once import compiled_once
from gearplay.vocabulary.interrupts import raised_without_harm

@compiled_once
def square(x: float) -> float:
    return abs(x) * x

came = []
for module in (base, context):
    def install(self, registry, wrapped=module.BaseContext.install_registry):
        if len(came) < 3:
            came.append(True)
            signal.raise_signal(signal.SIGINT)
        wrapped(self, registry)
    module.BaseContext.install_registry = install
try:
    with raised_without_harm():
        print(square(-3.0))
        signal.sigtimedwait([], 5.0)
except KeyboardInterrupt:
    print("interrupted", len(came))
print(square(-3.0))
"""


@pytest.mark.slow
@pytest.mark.skipif(
    INTERPRETED or sys.platform == "win32", reason="nothing is compiled here, or no signals there"
)
def test_ctrl_c_as_the_compiler_learns_its_types_comes_later(tmp_path: Path) -> None:
    """It would know half of them, and fail at every kernel from then on."""
    done = run_program(REFRESHED, file=tmp_path / "program.py", **cache_in(tmp_path))
    assert done.stdout.split()[-3:] == ["interrupted", "3", "-9.0"]


INTERRUPTED = """
import os, signal, sys
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled_once import Once, compiled_once

@compiled_once
def inner(x: float) -> float:
    return x + 1.0

@compiled_once
def caller(x: float) -> float:
    return inner(x)

caller.address()  # the inner one's is asked for by compiled code
signal.signal(signal.SIGINT, signal.default_int_handler)  # whatever the parent ignores

def interrupted(self):
    os.kill(os.getpid(), signal.SIGINT)
    for _ in range(1000):
        pass
    return address(self)

address, Once.address = Once.address, interrupted
try:
    print(caller(1.0))
    import time
    time.sleep(5.0)
    print("nothing came")
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no signals there")
def test_ctrl_c_while_a_kernel_is_compiled_comes_when_it_is_done(tmp_path: Path) -> None:
    done = run_program(INTERRUPTED, file=tmp_path / "program.py", check=False, **cache_in(tmp_path))
    assert done.stderr == ""
    assert done.stdout.split() in (["2.0", "interrupted"], ["interrupted"])
    assert done.returncode == 0


EDITED = """
import sys
import numpy as np
from dataclasses import dataclass
from gearplay.kernels.arrays import Floats
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled_once import compiled_once

@dataclass(frozen=True, eq=False)
class Numbers(Group):
    values: Floats

@compiled_once
def more(numbers: Numbers) -> float:
    return numbers.values[1] + {by}

print(more(Numbers(np.array([1.0, 0.25], dtype="{dtype}"))))
"""


@pytest.mark.slow
@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
def test_code_of_another_form_is_compiled_anew(tmp_path: Path) -> None:
    """Kept code was made for fields of one dtype and for a function as it then was, wherever that is written."""
    for by, dtype in (("1.0", "f8"), ("2.0", "f8"), ("2.0", "f4"), ("2.0", "f8")):
        program = EDITED.format(by=by, dtype=dtype)
        done = run_program(program, file=tmp_path / "program.py", **cache_in(tmp_path))
        assert float(done.stdout) == 0.25 + float(by), (by, dtype)


LINKED = """
import sys
import gearplay as gp
case = gp.replace(gp.load_case("han2021"), {"run.duration": 0.01, "run.transient": 0.0})
run = gp.simulate(case)
print(run.ds["ax"].sizes["time"], "numba" in sys.modules)
"""


@pytest.mark.slow
@pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
def test_what_was_compiled_before_runs_without_the_compiler() -> None:
    """Loading numba would take longer than all the rest of a short run."""
    run_program(LINKED)  # compiles what is not there yet
    assert run_program(LINKED).stdout.split() == ["1000", "False"]
