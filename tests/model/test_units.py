import contextlib
import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic_core import PydanticCustomError

from gearplay.model.reading import load_case
from gearplay.schema import units
from gearplay.schema.fields import Measure
from gearplay.schema.units import UnitError, parse_quantity
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError

QUANTITIES = list(q.DIMENSIONS.values())
COMMON = [
    "um mm m",
    "deg rad",
    "rpm rad/s",
    "kg g",
    "kg m^2",
    "N",
    "N m",
    "N/m",
    "N s/m",
    "s ms us",
    "Hz kHz",
    "m/s^2",
    "GPa MPa Pa",
    "N m s/rad",
    "m/s",
]
TABLE = [(si, unit, factor) for si, row in units.FACTORS.items() for unit, factor in row.items()]


@pytest.mark.parametrize(("si", "unit", "factor"), TABLE, ids=[f"{unit} in {si}" for si, unit, _ in TABLE])
def test_the_table_of_factors_agrees_with_pint(si: str, unit: str, factor: float) -> None:
    quantity = next(quantity for quantity in QUANTITIES if quantity.unit == si)
    spelled = units._check_unit(unit, quantity)
    if quantity.name in ("acceleration", "spectral_density"):  # where g is not the gram
        spelled = {"g": "standard_gravity", "g^2/Hz": "standard_gravity^2/Hz"}.get(unit, spelled)
    assert math.isclose(units._pint_factor(spelled, si, quantity.long_name), factor, rel_tol=4e-16)


@pytest.mark.parametrize(
    ("text", "quantity", "value"),
    [
        ("100 um", q.LENGTH, 1e-4),
        ("0.1 mm", q.LENGTH, 1e-4),
        ("1e2 um", q.LENGTH, 1e-4),
        ("3 inch", q.LENGTH, 0.0762),
        ("120 rpm", q.ANGULAR_SPEED, 4 * math.pi),
        ("2 rev/s", q.ANGULAR_SPEED, 4 * math.pi),
        ("20 deg", q.ANGLE, math.radians(20)),
        ("20°", q.ANGLE, math.radians(20)),
        ("0.5 turn", q.ANGLE, math.pi),
        ("1.52e11 N/m^1.5", q.HERTZ_STIFFNESS, 1.52e11),
        ("4.80666 kN/mm^1.5", q.HERTZ_STIFFNESS, 4.80666e3 * 1000**1.5),
        ("1e-3 N m s/rad", q.ROTATIONAL_DRAG, 1e-3),
        ("1e-3 N m s", q.ROTATIONAL_DRAG, 1e-3),
        ("1 N m/rpm", q.ROTATIONAL_DRAG, 30 / math.pi),
        ("1 mN m s", q.ROTATIONAL_DRAG, 1e-3),
        ("2 N.m/rad", q.ROTATIONAL_STIFFNESS, 2.0),
        ("100 kHz", q.FREQUENCY, 1e5),
        ("100 1/s", q.FREQUENCY, 100.0),
        ("7 %", q.RATIO, 0.07),
        ("-0.0 m", q.LENGTH, 0.0),
        ("0e9999 m", q.LENGTH, 0.0),
        ("5e-324 m", q.LENGTH, 5e-324),
    ],
)
def test_text_becomes_si(text: str, quantity: q.Quantity, value: float) -> None:
    found = parse_quantity(text, quantity)
    assert found == pytest.approx(value, rel=1e-14, abs=0.0)
    assert math.copysign(1.0, found) == 1.0


def test_rational_factors_are_rounded_once() -> None:
    assert parse_quantity("100 um", q.LENGTH) == 1e-4
    assert parse_quantity("0.3 mm", q.LENGTH) == 0.3e-3
    assert parse_quantity("207 GPa", q.PRESSURE) == 207e9


@pytest.mark.parametrize(
    ("text", "quantity"),
    [
        *(("".join(text), q.LENGTH) for text in ("9**9**9 m", "1e400 mm", "1_000 m", "nan m", "inf m", "1+1 m")),
        *((text, q.LENGTH) for text in ("", " ", "m", "5", "5 kg", "5 degC", "5 m**2", "5 m^2", "5 m^9^9", "0x10 m")),
        *((text, q.LENGTH) for text in ("5 m\n", "5\tm", "5 m;", "5 m m/m )", "(5 m)", "5 ((m", "5 m^1000", "5 m_")),
        *((text, q.LENGTH) for text in ("٣ m", "5 m" + " " * 80 + "m", "1e-400 m", "5 1", "5 2 m", "5 km^999/m^998")),
        *((text, q.LENGTH) for text in ("5 m^(9^9)", "5 m//s", "5 __import__", "5 m^1.0000", "1e99999 m", "5 meter_")),
        ("50 Hz", q.ANGULAR_SPEED),
        ("50 1/s", q.ANGULAR_SPEED),
        ("60 rpm", q.FREQUENCY),
        ("1 rad", q.RATIO),
        ("3 dB", q.RATIO),
        ("3 N m s/rad", q.TORQUE),
        ("1e8 N/m", q.HERTZ_STIFFNESS),
        ("300 K", q.ANGLE),
        (True, q.LENGTH),
        (None, q.LENGTH),
        (math.nan, q.LENGTH),
        (-math.inf, q.LENGTH),
        (10**400, q.LENGTH),
        ([1.0], q.LENGTH),
    ],
)  # fmt: skip
def test_quantity__invalid_values_are_refused_with_a_cure(text: object, quantity: q.Quantity) -> None:
    with pytest.raises(UnitError) as caught:
        parse_quantity(text, quantity)  # type: ignore[arg-type]
    assert caught.value.rule
    assert caught.value.cure


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(QUANTITIES))
def test_numbers_are_si_with_or_without_the_unit(number: float, quantity: q.Quantity) -> None:
    assert parse_quantity(number, quantity) == number
    if quantity is not q.RATIO:
        assert parse_quantity(f"{number!r} {quantity.unit}", quantity) == number


@given(st.floats(min_value=1e-6, max_value=1e6), st.sampled_from([row for row in TABLE if row[1] != "1"]))
def test_units_scale_and_never_change_order(number: float, row: tuple[str, str, float]) -> None:
    si, unit, factor = row
    quantity = next(quantity for quantity in QUANTITIES if quantity.unit == si)
    small, large = (parse_quantity(f"{size!r} {unit}", quantity) for size in (number, 2.0 * number))
    assert small == pytest.approx(number * float(factor), rel=1e-15)
    assert large == pytest.approx(2.0 * small, rel=1e-15)
    assert parse_quantity(f"{-number!r} {unit}", quantity) == -small


@pytest.mark.slow
@given(st.text(max_size=70), st.sampled_from(QUANTITIES))
def test_any_text_is_a_finite_number_or_refused(text: str, quantity: q.Quantity) -> None:
    with contextlib.suppress(UnitError):
        assert math.isfinite(parse_quantity(text, quantity))


@given(st.text(alphabet="0123456789.eE+-*/^() mkgsNradHzPu%°µ", max_size=64), st.sampled_from(QUANTITIES))
def test_text_close_to_the_grammar_is_a_finite_number_or_refused(text: str, quantity: q.Quantity) -> None:
    with contextlib.suppress(UnitError):
        assert math.isfinite(parse_quantity("1" + text, quantity))


@pytest.mark.slow
def test_common_units_need_no_pint() -> None:
    listed = [
        f"1 {unit}"
        for group in COMMON
        for unit in ([group] if "N " in group or " m^" in group else group.split())
    ]
    code = (
        "import sys\n"
        "from gearplay.schema.units import FACTORS\n"
        "from gearplay.model.reading import bundled_names, load_case\n"
        "for name in bundled_names(): load_case(name)\n"
        f"missing = [t for t in {listed!r} if not any(t[2:] in row for row in FACTORS.values())]\n"
        "print('pint' in sys.modules, missing)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False []"


def test_a_quantity_of_one_part_needs_a_bound_in_its_field() -> None:
    """Quantities that all parts share have a largest magnitude of their own."""
    own = q.Quantity("jerk", "j", "m/s^3", "m/s^3", 1.0, "jerk")
    with pytest.raises(TypeError, match="jerk needs lt or le"):
        Measure(own, "a jerk", ge=0.0)
    bounded = Measure(own, "a jerk", ge=0.0, le=10.0)
    assert bounded.read("5 mm/s^3") == pytest.approx(5e-3)
    with pytest.raises(PydanticCustomError) as refused:
        bounded.read("11 m/s^3")
    assert refused.value.context["problems"][0].rule == "must be 0 m/s^3 or more and at most 10 m/s^3"


@pytest.mark.parametrize(
    ("change", "cure"),
    [
        ("meshes.0.backlash=0,03 mm", 'Write it with a decimal point: "0.03 mm".'),
        ("run.duration=0,5s", 'Write it with a decimal point: "0.5s".'),
        ("run.duration=0,5", "Write it with a decimal point: 0.5."),
        ("sleeves.ring.restitution=0,5", "Write it with a decimal point: 0.5."),
        ("sleeves.ring.stiffness=1,5e10 N/m^1.5", 'Write it with a decimal point: "1.5e10 N/m^1.5".'),
        ("run.duration=1,000,000 s", "Write it without commas."),
    ],
)
def test_decimal_commas__are_named_not_the_unit(change: str, cure: str) -> None:
    path, _, value = change.partition("=")
    with pytest.raises(InputError) as found:
        load_case("han2021", [change])
    assert str(found.value) == f'{path} = "{value}": has a comma in its number. {cure}'
