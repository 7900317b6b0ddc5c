"""Groups of arrays in compiled code: the same as in Python, whatever they hold, and after a copy."""

import copy
import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from gearplay.kernels.by_address import Group
from gearplay.kernels.compiler import jitted

RECORD = np.dtype([("mass", "f8"), ("count", "i8")], align=True)


@dataclass(frozen=True, eq=False)
class Inner(Group):
    """A group within a group."""

    values: Any
    empty: Any


@dataclass(frozen=True, eq=False)
class Outer(Group):
    """One of everything."""

    table: Any
    cube: Any
    inner: Inner
    records: tuple[Any, ...]


def outer() -> Outer:
    """Return a group with known contents."""
    return Outer(
        table=np.arange(6.0).reshape(2, 3),
        cube=np.arange(24).reshape(2, 3, 4),
        inner=Inner(np.zeros(3), np.zeros((0, 2))),
        records=(
            np.array([(0.5, 7)], RECORD).view(np.recarray),
            np.array([(1.5, 8), (2.5, 9)], RECORD).view(np.recarray),
        ),
    )


@jitted
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


def test_compiled_code_reads_and_writes_what_python_does() -> None:
    one, two = outer(), outer()
    expected = (
        sum((two.table[: i + 1, j].sum()) * two.cube[i, j, 3] for i in range(2) for j in range(3)) + 0.25
    )
    assert walk(one, 0.25) == expected + 7 + 2
    assert one.inner.values.tolist() == [3.0, 5.0, 7.0]
    assert one.records[1][1].mass == 2.5 + expected


@pytest.mark.parametrize("twin", [copy.deepcopy, lambda group: pickle.loads(pickle.dumps(group))])
def test_a_copy_has_arrays_of_its_own(twin: Any) -> None:
    first = outer()
    second = twin(first)
    walk(second, 0.0)
    assert not first.inner.values.any()
    assert second.inner.values.any()


@pytest.mark.parametrize("wrong", [np.zeros((4, 4))[:, 1], 1.0, [1.0]])
def test_what_cannot_be_taken_by_address_is_refused(wrong: Any) -> None:
    with pytest.raises(TypeError, match="C-contiguous"):
        Inner(wrong, np.zeros(1))


@pytest.mark.parametrize("other", [np.zeros(3, dtype=np.int64), np.zeros((1, 3)), (np.zeros(3),)])
def test_a_field_of_another_form_than_in_the_first_group_is_refused(other: Any) -> None:
    """Compiled code would take integers for numbers, or a row for a column."""
    first = outer().inner
    with pytest.raises(TypeError, match="a field of Inner is not what it was"):
        Inner(other, first.empty)
