"""Every public function checks its arguments by one table of rules."""

import inspect
import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.vocabulary.arguments import rule_of
from gearplay.vocabulary.errors import InputError

FUNCTIONS = [
    name for name in gp.__all__ if callable(getattr(gp, name)) and not inspect.isclass(getattr(gp, name))
]


def test_every_parameter_of_every_public_function_has_a_rule() -> None:
    assert len(FUNCTIONS) >= 24
    for name in FUNCTIONS:
        for parameter in inspect.signature(getattr(gp, name)).parameters:
            assert rule_of(name, parameter) is not None


def test_checked_function__keeps_name_and_docstring() -> None:
    assert gp.section.__name__ == "section"
    assert "once per period" in (gp.section.__doc__ or "")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: gp.section("han2021", ["ring.x"], settle=-1),
            "settle = -1: must be a whole number, 0 or more",
        ),
        (
            lambda: gp.section("han2021", ["ring.x"], keep=2.5),
            "keep = 2.5: must be a whole number, 1 or more",
        ),
        (lambda: gp.section("han2021", ["ring.x"], keep=True), "keep = true: must be a whole number"),
        (lambda: gp.section("han2021", "ring.x"), "must be a list of texts, also of one"),
        (lambda: gp.section("han2021", ["ring.x"], keeps=5), "Did you mean 'keep'?"),
        (lambda: gp.section(), "missing"),
        (lambda: gp.simulate("han2021", duration=math.nan), "duration = nan: must be a number above 0"),
        (lambda: gp.simulate("han2021", progress=3), "progress = 3: must be a function"),
        (lambda: gp.simulate("han2021", stop="now"), "must be a threading.Event"),
        (lambda: gp.motion("han2021", compare=1), "compare = 1: must be True or False"),
        (lambda: gp.read_result(3), "path = 3: must be a path"),
        (lambda: gp.lyapunov("han2021", count=0), "count = 0"),
        (lambda: gp.torsional_pair("fast"), "frequency"),
    ],
)
def test_invalid_argument__is_one_sentence(call: Any, words: str) -> None:
    with pytest.raises(InputError) as caught:
        call()
    assert words in str(caught.value)


def test_numbers_of_numpy_are_numbers() -> None:
    found = gp.simulate("han2021", duration=np.float64(0.01), transient=np.int64(0), ensemble=np.int32(1))
    assert found.success
