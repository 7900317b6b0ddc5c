import pint
import pytest

from gearplay.model.variables import RESULT_VARIABLES
from gearplay.vocabulary import quantities as q

EVERY = [*q.DIMENSIONS.values(), *RESULT_VARIABLES.values()]


@pytest.fixture(scope="module")
def units() -> pint.UnitRegistry:
    return pint.UnitRegistry()


@pytest.mark.parametrize("quantity", EVERY, ids=lambda quantity: quantity.name)
def test_display_factor__agrees_with_the_unit(quantity: q.Quantity, units: pint.UnitRegistry) -> None:
    shown = units.Quantity(1.0, "" if quantity.unit == "1" else quantity.unit)
    shown = shown.to("" if quantity.display_unit == "1" else quantity.display_unit)
    assert shown.magnitude == pytest.approx(quantity.display_factor + quantity.display_offset, rel=1e-12)
    assert quantity.long_name
    assert quantity.symbol.isascii()


def test_hertz_stiffness_carries_its_exponent() -> None:
    assert q.hertz_stiffness(1.5).unit == "N/m^1.5"
    assert q.hertz_stiffness(1.0).unit == q.STIFFNESS.unit
