"""How groups lie in a device's memory: every number once, aliases in one place, long arrays last."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.device.fleet import LAST
from gearplay.device.words import LANES, WORD, Words
from gearplay.kernels.by_address import Group
from gearplay.model.pack import pack
from gearplay.solver.course import Course


def fields(value: Any) -> Iterator[np.ndarray]:
    """Yield the arrays of a group in the order of its fields, by another way than `Words`."""
    if isinstance(value, np.ndarray):
        yield value
    else:
        for part in value if isinstance(value, tuple) else value.__reduce__()[1]:
            yield from fields(part)


@pytest.fixture
def course() -> Course:
    case = gp.load_case("pinion-idler-ring")
    packed = pack(case)
    return Course(
        case,
        packed,
        np.arange(packed.state_size, dtype=float),
        rows=np.empty((2, 7)),
        places=np.array([1, 4]),
    )


@pytest.mark.parametrize(("of", "apart"), [("system", 1), ("run", LANES)])
def test_each_array_stands_where_the_table_says(course: Course, of: str, apart: int) -> None:
    group: Group = getattr(course, of)
    last = LAST if of == "run" else ()
    words = Words(group, apart, last)
    flat, table = words.take(group), words.table.tolist()
    assert flat.size == words.head
    for array in fields(group):
        begin, shape, table = table[0], table[1 : 1 + array.ndim], table[1 + array.ndim :]
        assert tuple(shape) == array.shape
        start = begin // (WORD * apart)
        if any(array is getattr(group, name) for name in last):
            assert words.head <= start <= words.size - array.nbytes // WORD
        else:
            assert flat[start : start + array.nbytes // WORD].tobytes() == array.tobytes()
    assert not table


def test_what_two_fields_share_lies_there_once(course: Course) -> None:
    run = course.run
    words = Words(run, LANES, LAST)
    assert run.loads.rotors is run.loads_try.rotors
    assert words.place(run.loads.rotors) == words.place(run.loads_try.rotors)
    unique = {id(array): array for array in fields(run)}
    assert words.size == sum(array.nbytes for array in unique.values()) // WORD


def test_words_come_back(course: Course) -> None:
    words = Words(course.run, LANES, LAST)
    numbers = np.arange(words.head) + 10
    words.put(numbers, course.run)
    assert np.array_equal(words.take(course.run), numbers)
    assert np.array_equal(course.run.y.view(np.int64), numbers[words.place(course.run.y)])


def test_a_tile_keeps_the_parts_of_a_complex_number_together(course: Course) -> None:
    implicit, words = course.run.implicit, Words(course.run, LANES, LAST)
    heads = np.arange(3 * words.head).reshape(3, -1)
    tile = words.to_tile(heads)
    places = {"real": words.place(implicit.right), "complex": words.place(implicit.right_complex)}
    flat = {kind: tile[place].reshape(-1) for kind, place in places.items()}
    for lane in range(3):
        real, parts = (heads[lane, place] for place in places.values())
        assert np.array_equal(flat["real"][lane::LANES], real)
        assert np.array_equal(flat["complex"].reshape(-1, 2)[lane::LANES].reshape(-1), parts)
    back = np.zeros_like(heads)
    words.from_tile(tile, back)
    assert np.array_equal(back, heads)
