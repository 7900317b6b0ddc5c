"""Every published number of `gearplay validate`, within its tolerance."""

import math

import pytest

from gearplay.validation.published import COMPARISONS, Comparison


@pytest.mark.parametrize("comparison", COMPARISONS, ids=lambda each: f"{each.title}-{each.measure.__name__}")
def test_published_numbers(comparison: Comparison) -> None:
    computed = comparison.measure()
    assert len(computed) == len(comparison.numbers)
    beyond = [
        f"{number.name}: {number.value} {number.unit}, ours {value}"
        for number, value in zip(comparison.numbers, computed, strict=True)
        if not abs(value - number.value) <= number.tolerance
    ]
    assert not beyond


def test_tolerances_are_of_the_digits_of_their_numbers() -> None:
    """At most a thousandth of the number itself, so that no row can be met by chance."""
    for comparison in COMPARISONS:
        for number in comparison.numbers:
            assert number.value == 0.0 or 0.0 < number.tolerance <= 1.01e-3 * abs(number.value), number
    named = [(each.title, number.name) for each in COMPARISONS for number in each.numbers]
    assert len({*named}) == len(named)
    assert all(math.isfinite(number.value) for each in COMPARISONS for number in each.numbers)
