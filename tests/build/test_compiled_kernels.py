"""Kernels in a library: calls of each other by symbols, arguments of every kind, what is refused."""

import copy
import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import INTERPRETED, compiled
from gearplay.kernels.compiled_once import compiled_once

pytestmark = pytest.mark.skipif(INTERPRETED, reason="nothing is compiled here")
RECORD = np.dtype([("mass", "f8"), ("count", "i8")], align=True)


@dataclass(frozen=True, eq=False)
class Inner(Group):
    """A group within a group."""

    values: Floats
    empty: Rows


@dataclass(frozen=True, eq=False)
class Outer(Group):
    """One of everything."""

    table: Rows
    cube: Annotated[NDArray[np.int64], 3]
    inner: Inner
    records: tuple[NDArray[Any], ...]


Outer.declare("records", [RECORD, RECORD])


@compiled_once
def walk(group: Outer, offset: float) -> float:
    """Read every field, write where it is read again."""
    total, inner = offset, group.inner
    for i in range(group.table.shape[0]):
        row = group.table[i]
        for j in range(row.size):
            inner.values[j] += row[j]
            total += inner.values[j] * group.cube[i, j, 3]
    group.records[1][1].mass += total
    return total + group.records[0][0].count + group.records[1].size + inner.empty.size


@compiled_once
def share(inner: Inner, y: Floats, table: Rows, n: int, x: float) -> tuple[int, float]:
    """Write to an array, return a pair."""
    y[0] = 7.0
    return n + 1, inner.values[n] * x + table[1, 0]


@compiled
def double(x: float) -> float:
    """Return twice a number."""
    return 2.0 * x


@compiled_once
def caller(inner: Inner, y: Floats, table: Rows) -> float:
    """Call a kernel twice by its symbol, with a literal and with a variable, and a contained one."""
    n, half = share(inner, y, table, 1, 0.5)
    m, again = share(inner, y, table, n, 2.0)
    return 100.0 * m + double(5.0 * half) + again


@compiled_once
def everything(inner: Inner, y: Floats, table: Rows, n: int, x: float, yes: bool) -> tuple[int, float, bool]:
    """Take and return one of each kind."""
    y[1] += inner.values[1] + table[1, 2] * table.shape[0] * table.shape[1]
    return -n, x / 3.0 if yes else x, not yes


@compiled_once
def nothing(places: Ints) -> None:
    """Return nothing."""
    places[0] = 2**40


@compiled_once
def even(n: int) -> bool:
    """Return whether a number is even."""
    return n % 2 == 0


KERNELS: Any = (walk, share, caller, everything, nothing, even)


def inner_of(*values: float) -> Inner:
    return Inner(np.array(values), np.zeros((0, 2)))


def outer() -> Outer:
    """Return a group with known contents."""
    return Outer(
        table=np.arange(6.0).reshape(2, 3),
        cube=np.arange(24).reshape(2, 3, 4),
        inner=inner_of(0.0, 0.0, 0.0),
        records=(
            np.array([(0.5, 7)], RECORD).view(np.recarray),
            np.array([(1.5, 8), (2.5, 9)], RECORD).view(np.recarray),
        ),
    )


@pytest.fixture(scope="module", autouse=True)
def library(tmp_path_factory: pytest.TempPathFactory) -> None:
    from small_library import load_small

    load_small(tmp_path_factory.mktemp("small"), *KERNELS)


def test_kernel_reads_and_writes_groups_as_python_does() -> None:
    one, two = outer(), outer()
    expected = (
        sum((two.table[: i + 1, j].sum()) * two.cube[i, j, 3] for i in range(2) for j in range(3)) + 0.25
    )
    assert walk(one, 0.25) == expected + 7 + 2
    assert one.inner.values.tolist() == [3.0, 5.0, 7.0]
    assert one.records[1][1].mass == 2.5 + expected


def test_kernel_calls_another_by_its_symbol() -> None:
    y = np.zeros(2)
    # first (2, 2 * 0.5 + 2), then (3, 3 * 2 + 2)
    assert caller(inner_of(1.0, 2.0, 3.0), y, np.arange(4.0).reshape(2, 2)) == 100.0 * 3 + 10.0 * 3.0 + 8.0
    assert y[0] == 7.0


def test_arguments_and_results_of_every_kind() -> None:
    inner, y, table, places = (
        inner_of(1.0, 0.5),
        np.zeros(2),
        np.arange(6.0).reshape(2, 3),
        np.zeros(1, dtype=int),
    )
    assert everything(inner, y, table, 2**40, 1.5, True) == (-(2**40), 0.5, False)
    assert everything(inner, y, table, 7, 2, False) == (-7, 2.0, True)
    assert y.tolist() == [0.0, 2 * (0.5 + 5.0 * 6.0)]
    assert (nothing(places), places.tolist()) == (None, [2**40])
    assert [even(2), even(np.int64(3))] == [True, False]


@pytest.mark.parametrize(
    ("place", "value", "reason"),
    [
        (0, np.zeros(2), "inner of .*everything must be Inner, not ndarray"),
        (1, np.zeros((2, 3)), "C-contiguous array that can be written to"),
        (1, np.zeros(1, dtype=int), "C-contiguous array that can be written to"),
        (1, [1.0], "C-contiguous array that can be written to"),
        (2, np.zeros((3, 2)).T, "C-contiguous array that can be written to"),
        (1, np.broadcast_to(1.0, 2), "C-contiguous array that can be written to"),
        (3, 1.5, "integer"),
        (3, 2**70, "64 bits"),
        (4, "x", "could not convert"),
    ],
)
def test_argument_of_another_type_is_refused(place: int, value: Any, reason: str) -> None:
    args = [inner_of(1.0, 2.0), np.zeros(2), np.zeros((2, 3)), 1, 1.0, True]
    args[place] = value
    with pytest.raises((TypeError, ValueError), match=reason):
        everything(*args)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="takes 6 arguments"):
        everything(*args[:5])  # type: ignore[arg-type,call-arg]


@pytest.mark.parametrize("twin", [copy.deepcopy, lambda group: pickle.loads(pickle.dumps(group))])
def test_group_copy_has_arrays_of_its_own(twin: Any) -> None:
    first = outer()
    second = twin(first)
    walk(second, 0.0)
    assert not first.inner.values.any()
    assert second.inner.values.any()


@pytest.mark.parametrize("wrong", [np.zeros((4, 4))[:, 1], 1.0, [1.0]])
def test_group_field_that_is_no_contiguous_array_is_refused(wrong: Any) -> None:
    with pytest.raises(TypeError, match="C-contiguous"):
        Inner(wrong, np.zeros(1))


@pytest.mark.parametrize("other", [np.zeros(3, dtype=np.int64), np.zeros((1, 3)), (np.zeros(3),)])
def test_group_field_of_another_form_is_refused(other: Any) -> None:
    """Compiled code would take integers for numbers, or a row for a column."""
    first = outer().inner
    with pytest.raises(TypeError, match="Inner must have"):
        Inner(other, first.empty)


def test_group_of_another_form_than_compiled_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A library that was compiled for other fields would read past them."""
    from gearplay.kernels import from_python

    monkeypatch.setattr(from_python, "form_of", lambda kind: {"values": ["f4", 4, 1]})
    for parameter in everything.from_python.parameters:  # type: ignore[attr-defined]
        parameter.checked = False
    with pytest.raises(TypeError, match=r"was compiled for .*, not for"):
        everything(inner_of(1.0), np.zeros(2), np.zeros((2, 3)), 1, 1.0, True)


def test_call_with_a_wrong_argument_is_refused_by_the_compiler() -> None:
    from gearplay.build.compiler import compile_kernel

    @compiled_once
    def wrong(y: Floats) -> float:
        return walk(y, 0.0)  # type: ignore[arg-type]

    with pytest.raises(Exception, match="walk takes"):
        compile_kernel(wrong)  # type: ignore[arg-type]


def test_kernel_that_allocates_is_refused_by_the_compiler() -> None:
    """No array is reference-counted: threads have nothing to fight over."""
    from gearplay.build.compiler import compile_kernel

    @compiled_once
    def allocates(n: int) -> float:
        return float(np.zeros(n).sum())

    with pytest.raises(Exception, match="No implementation of function"):
        compile_kernel(allocates)  # type: ignore[arg-type]


@pytest.mark.slow
def test_index_beyond_its_array_is_an_error_where_bounds_are_checked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import numba

    from small_library import load_small

    @compiled_once
    def past(inner: Inner, n: int) -> float:
        return float(inner.values[n])

    @compiled_once
    def through(inner: Inner, n: int) -> float:
        return past(inner, n)

    monkeypatch.setattr(numba.config, "BOUNDSCHECK", 1)
    load_small(tmp_path, past, through)
    assert through(inner_of(1.0, 2.0), 1) == 2.0
    with pytest.raises(IndexError, match="beyond the bounds"):
        through(inner_of(1.0, 2.0), 9)
