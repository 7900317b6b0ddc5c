import pint
import pytest

from gearplay.model.variables import RESULT_VARIABLES
from gearplay.vocabulary import quantities as q

EVERY = [*q.DIMENSIONS.values(), *RESULT_VARIABLES.values()]
CONTRACT = (
    "x y theta vx vy omega ax ay drive_torque load_torque rotor_power_loss "
    "sleeve_penetration sleeve_force_x sleeve_force_y sleeve_power_loss "
    "drive_penetration back_penetration drive_force back_force backlash "
    "working_pressure_angle center_distance transmission_error_dynamic contact_state mesh_power_loss mesh_power_input "
    "coupling_twist coupling_torque coupling_power_loss coupling_force_x coupling_force_y "
    "support_force_x support_force_y support_torque support_power_loss "
    "excitation_torque base_ax base_ay position_torque position_error"
)


def test_the_result_variables_are_those_of_the_contract() -> None:
    assert list(RESULT_VARIABLES) == CONTRACT.split()


@pytest.mark.slow
@pytest.mark.parametrize("quantity", EVERY, ids=lambda quantity: quantity.name)
def test_display_factors_agree_with_the_units(quantity: q.Quantity) -> None:
    units = pint.UnitRegistry()
    shown = units.Quantity(1.0, "" if quantity.unit == "1" else quantity.unit)
    shown = shown.to("" if quantity.display_unit == "1" else quantity.display_unit)
    assert shown.magnitude == pytest.approx(quantity.display_factor + quantity.display_offset, rel=1e-12)
    assert quantity.long_name
    assert quantity.symbol.isascii()


def test_hertz_stiffness_carries_its_exponent() -> None:
    assert q.hertz_stiffness(1.5).unit == "N/m^1.5"
    assert q.hertz_stiffness(1.0).unit == q.STIFFNESS.unit
