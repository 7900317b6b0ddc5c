"""Units as people write them, against their definitions: inch 25.4 mm, pound 0.45359237 kg, standard gravity 9.80665 m/s^2."""

import math

import pytest

from gearplay.schema.units import UnitError, parse_quantity
from gearplay.vocabulary import quantities as q

INCH, POUND, GRAVITY = 0.0254, 0.45359237, 9.80665
POUND_FORCE = POUND * GRAVITY
SLUG = POUND_FORCE / (12 * INCH)

LENGTHS = {
    "0.004 in": 0.004 * INCH, "4 mil": 0.004 * INCH, "4 mils": 0.004 * INCH, "4 thou": 0.004 * INCH, '0.004"': 0.004 * INCH,
    "0.004 inch": 0.004 * INCH, "100 microns": 1e-4, "100 µm": 1e-4, "100 μm": 1e-4, "100um": 1e-4,
}  # fmt: skip
MASSES = {
    "2 lb": 2 * POUND,
    "2 lbm": 2 * POUND,
    "2 lbs": 2 * POUND,
    "0.1 slug": 0.1 * SLUG,
    "32 oz": 2 * POUND,
    "2 Kg": 2.0,
}
INERTIAS = {
    "0.01 kg*m^2": 0.01, "0.01 kg·m²": 0.01, "0.01 kg.m2": 0.01, "0.01 kgm^2": 0.01, "0.01 kgm²": 0.01, "100 kg cm²": 0.01,
    "100 kgcm2": 0.01, "1e4 kg·mm²": 0.01, "3 lb in^2": 3 * POUND * INCH**2, "3 lbm-in²": 3 * POUND * INCH**2,
    "0.1 lbf in s^2": 0.1 * POUND_FORCE * INCH, "0.1 lb-in-s²": 0.1 * POUND_FORCE * INCH,
    "1 oz in s^2": POUND_FORCE / 16 * INCH, "0.01 slug ft^2": 0.01 * SLUG * (12 * INCH) ** 2,
}  # fmt: skip
TORQUES = {
    "10 Nm": 10.0, "10Nm": 10.0, "10 N*m": 10.0, "10 N·m": 10.0, "10 N-m": 10.0, "10 N⋅m": 10.0, "10 kNm": 1e4, "10 mNm": 0.01,
    "10 Nmm": 0.01, "10 Ncm": 0.1, "88 lbf in": 88 * POUND_FORCE * INCH, "88 in-lb": 88 * POUND_FORCE * INCH,
    "88 in-lbf": 88 * POUND_FORCE * INCH, "7 ft-lb": 7 * POUND_FORCE * 12 * INCH, "7 lb ft": 7 * POUND_FORCE * 12 * INCH,
    "100 oz-in": 100 * POUND_FORCE / 16 * INCH, "50 kgf cm": 0.5 * GRAVITY, "50 kg-cm": 0.5 * GRAVITY,
}  # fmt: skip
SPEEDS = dict.fromkeys(
    (
        "1750 RPM",
        "1750 rpm",
        "1750 r/min",
        "1750 rev/min",
        "1750 tr/min",
        "1750 U/min",
        "1750 1/min",
        "1750 min^-1",
        "1750 min⁻¹",
    ),
    1750 * math.pi / 30,
)
STIFFNESSES = {
    "200 N/µm": 2e8, "2e5 N/mm": 2e8, "0.2 GN/m": 2e8, "1e6 lbf/in": 1e6 * POUND_FORCE / INCH,
    "1e6 lb/in": 1e6 * POUND_FORCE / INCH,
}  # fmt: skip
OTHERS = [
    (q.ACCELERATION, "2 m/s²", 2.0), (q.ACCELERATION, "2 m/s2", 2.0), (q.FORCE, "3 lb", 3 * POUND_FORCE),
    (q.ANGLE, "20 degrees", math.radians(20.0)), (q.TEMPERATURE, "-60 °C", 213.15), (q.TIME, "2 sec", 2.0),
]  # fmt: skip
CASES = [
    (quantity, text, value)
    for quantity, table in (
        (q.LENGTH, LENGTHS), (q.MASS, MASSES), (q.INERTIA, INERTIAS), (q.TORQUE, TORQUES), (q.ANGULAR_SPEED, SPEEDS),
        (q.STIFFNESS, STIFFNESSES),
    )
    for text, value in table.items()
] + OTHERS  # fmt: skip


@pytest.mark.parametrize(("quantity", "text", "value"), CASES, ids=[text for _, text, _ in CASES])
def test_a_unit_has_its_size_however_it_is_spelled(quantity: q.Quantity, text: str, value: float) -> None:
    assert parse_quantity(text, quantity) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("quantity", "text", "cure"),
    [
        (q.TEMPERATURE, "-60", 'Write "-60 degC".'),
        (q.ANGULAR_SPEED, "1490", 'Write "1490 rpm" or "1490 rad/s"'),
        (q.LENGTH, "10 DP", 'Write the module: "2.54 mm"'),
        (q.LENGTH, "10 kg", "is not a length"),
        (q.MASS, "10 lbf", "is not a mass"),
        (q.ANGULAR_SPEED, "29 Hz", "is not an angular speed"),
        (q.FORCE, "10 kg", "is not a force"),
        (q.TORQUE, "10 N²m", "is not a torque"),
    ],
)
def test_unit_spelling__a_wrong_one_is_refused_with_its_cure(
    quantity: q.Quantity, text: str, cure: str
) -> None:
    with pytest.raises(UnitError) as caught:
        parse_quantity(text, quantity)
    assert cure in str(caught.value)
