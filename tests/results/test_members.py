"""Single members of an ensemble by `simulate`."""

from pathlib import Path

import numpy as np
import pytest

import gearplay as gp

SHORT = {"duration": 0.05, "transient": 0.0, "sampling": 2e4}


def test_members__bitwise_those_of_the_ensemble(tmp_path: Path) -> None:
    """Members by number have the motion that they have in an ensemble, in memory and in a file."""
    whole = gp.simulate("han2021", ensemble=4, **SHORT)
    for numbers in ([3, 1], [2]):
        some = gp.simulate("han2021", members=numbers, **SHORT)
        assert [run.member for run in some.runs] == numbers
        for at, number in enumerate(numbers):
            expected = whole.signal("ring.x", member=number)
            np.testing.assert_array_equal(some.signal("ring.x", member=at), expected)
            path = tmp_path / f"{number}-{len(numbers)}.nc"
            some.save(path)
            read = gp.read_result(path)
            assert np.atleast_1d(read.ds["member"].values).tolist() == numbers
            np.testing.assert_array_equal(read.signal("ring.x", member=at), expected)
            assert read.runs[at].member == number
    assert np.ptp([whole.signal("ring.x", member=m)[-1] for m in range(4)]) > 0.0


@pytest.mark.parametrize("members", [[], [-1], [1, 1], [1.5]])
def test_members__refused(members: list[float]) -> None:
    with pytest.raises(gp.InputError, match="members"):
        gp.simulate("han2021", members=members, **SHORT)


def test_members__refused_beside_ensemble() -> None:
    with pytest.raises(gp.InputError, match="ensemble = 2: must be left out where members are given"):
        gp.simulate("han2021", members=[1], ensemble=2, **SHORT)
