"""Pass orders, stiffness, clearance classes, the catalogue and input of rolling bearings."""

import math

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

import gearplay as gp
from building import Document, Measured, case_of, merged
from gearplay.model.check import check_case
from gearplay.parts.bearing.geometry import CATALOGUE, ball_stiffness, elliptic_integrals, pass_orders
from gearplay.parts.bearing.schema import Bearing
from gearplay.vocabulary.errors import InputError
from parts.bearing.shafts import BALLS, shaft

INCH = 25.4e-3


@pytest.mark.parametrize(
    ("elements", "ratio", "printed"),
    [
        (8, 0.3125 / 1.319, (0.381539045, 3.052312358, 4.947687642, 1.991939045)),
        (9, 0.3126 / 1.537, (0.398308393, 3.584775537, 5.415224463, 2.356721701)),
        (8, 0.2656 / 1.122, (0.381639929, 3.053119430, 4.946880570, 1.993838724)),
        (8, 0.235 / 1.245, (0.405622490, 3.244979920, 4.755020080, 2.554558660)),
    ],
)
def test_pass_orders(elements: int, ratio: float, printed: tuple[float, ...], measured: Measured) -> None:
    """Cage, outer ring, inner ring, spin per turn, as printed."""
    worst = float(np.max(np.abs(np.array(pass_orders(elements, ratio)) - printed)))
    measured("bearing: pass orders", worst, "1e-9")
    assert worst < 1e-9


def test_the_catalogue_has_the_printed_orders() -> None:
    for name, order in (("6205", 5.415224463), ("ER-10K", 4.947687642)):
        bearing = Bearing(catalogue=name, groove_ratio=0.52)
        assert bearing.orders.inner == pytest.approx(order, abs=1e-9)
    assert 1797.0 / 60.0 * Bearing(catalogue="6205", groove_ratio=0.52).orders.inner == pytest.approx(
        162.19, abs=5e-3
    )
    assert len(CATALOGUE) <= 10
    assert all(each.source for each in CATALOGUE.values())
    given = Bearing(catalogue="6205", rolling_elements=7, groove_ratio=0.52)
    assert (given.elements, given.element_size) == (7, 0.3126 * INCH), "a number given wins"


def test_elliptic_integrals() -> None:
    for m in np.linspace(0.0, 0.999999, 60):
        assert elliptic_integrals(float(m)) == pytest.approx((ellipk(m), ellipe(m)), rel=1e-14)


@pytest.mark.parametrize(("groove", "printed"), [(0.515, 1.01914e10), (0.52, 9.21459e9), (0.53, 8.03341e9)])
def test_stiffness_of_a_ball_in_grooves(groove: float, printed: float) -> None:
    found = ball_stiffness(7.94e-3, 39.04e-3, 7.94 / 39.04, (groove, groove), 206e9, 0.3)
    assert found == pytest.approx(printed, rel=6e-6)
    bearing = Bearing(
        rolling_elements=9, element_diameter=7.94e-3, pitch_diameter=39.04e-3, groove_ratio=groove
    )
    assert bearing.element_stiffness() == pytest.approx(found, rel=1e-12)


@pytest.mark.parametrize(
    ("grade", "bore", "middle"),
    [
        ("CN", 25e-3, 12.5e-6),
        ("C3", 25e-3, 20.5e-6),
        ("C2", 10e-3, 3.5e-6),
        ("C4", 10.1e-3, 25.5e-6),
        ("C5", 100e-3, 97.5e-6),
    ],
)
def test_clearance_of_a_class(grade: str, bore: float, middle: float) -> None:
    """ISO 5753: the middle of the range for the bore; diametral, so that the shaft moves freely by half of it."""
    bearing = Bearing(**BALLS, bore=bore, internal_clearance=grade)
    assert bearing.internal_clearance == pytest.approx(middle, abs=1e-15)
    assert bearing.clearance() == 0.5 * bearing.internal_clearance
    assert Bearing(
        catalogue="6205", groove_ratio=0.52, internal_clearance="C3"
    ).internal_clearance == pytest.approx(20.5e-6)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"internal_clearance": "C3"}, r"internal_clearance.*C3.*needs the bore"),
        ({"internal_clearance": "C3", "bore": 0.5}, r"internal_clearance.*bore of 500 mm"),
        ({"internal_clearance": "C7"}, r"internal_clearance"),
        ({"rolling_elements": None}, r"rolling_elements.*is required, or catalogue"),
        ({"rolling_elements": 20}, r"element_diameter.*distance of neighbours"),
        ({"stiffness": None}, r"stiffness.*is required, or groove_ratio"),
        ({"groove_ratio": 0.52}, r"stiffness.*must not be given together with groove_ratio"),
        ({"stiffness": None, "groove_ratio": 0.52, "exponent": 1.2}, r"exponent.*must be 1.5"),
        ({"stiffness": "1e10 N/m"}, r"stiffness"),
        ({"catalogue": "9999"}, r"catalogue.*must be one of 6205"),
        ({"restitution": 0.9, "damping": {"value": 0.5}}, r"restitution.*together with damping"),
        ({"damping": {"value": "0.5 kg"}}, r"damping.value"),
        ({"damping": {"value": -1.0}}, r"damping.value.*0 s/m or more"),
    ],
)
def test_bad_input_gets_one_sentence(changes: Document, text: str) -> None:
    with pytest.raises(InputError, match=text):
        gp.load_case(shaft(merged(BALLS, changes)))


def test_findings() -> None:
    """Pass orders, a class, a preload."""
    bearing = {"catalogue": "6205", "groove_ratio": 0.52, "internal_clearance": "C3"}
    found = "\n".join(map(str, check_case(case_of(shaft(bearing)))))
    assert "3.58478 times (BPFO)" in found
    assert "class C3, 13 to 28 um" in found
    found = "\n".join(map(str, check_case(case_of(shaft(BALLS | {"internal_clearance": -1e-5})))))
    assert "the bearing has 179 N/um" in found


def test_clearance_at_temperature() -> None:
    """Steel shaft in an aluminium housing: the outer raceway widens with the housing, shaft and balls with the shaft."""
    steel = {"modulus": 206e9, "poisson": 0.3, "density": 7850.0, "expansion": 11.5e-6}
    document = merged(
        shaft(BALLS | {"internal_clearance": 10e-6}, material=steel),
        {
            "environment": {
                "temperature": 393.15,
                "reference_temperature": 293.15,
                "housing": {"expansion": 23.1e-6},
            }
        },
    )
    case = case_of(document)
    size, pitch = BALLS["element_diameter"], BALLS["pitch_diameter"]
    exact = (pitch + size + 5e-6) * 23.1e-4 - (pitch - size - 5e-6) * 11.5e-4 - 2.0 * size * 11.5e-4 + 10e-6
    assert case.operating.bearings["shaft"].internal_clearance == pytest.approx(exact, rel=1e-9)
    assert any("at temperature it is" in str(each) for each in check_case(case))
    alike = merged(document, {"environment": {"housing": {"expansion": 11.5e-6}}})
    hot = case_of(alike).operating.bearings["shaft"]
    assert hot.internal_clearance == pytest.approx(10e-6 * (1.0 + 11.5e-4), rel=1e-9)
    assert hot.ratio == pytest.approx(size / pitch, rel=1e-12)
    tight = merged(
        document,
        {"bearings": {"shaft": {"internal_clearance": -3e-5}}, "environment": {"temperature": 173.15}},
    )
    with pytest.raises(InputError, match="a preload beyond a thousandth"):
        _ = case_of(tight).operating


def test_a_restitution_is_that_of_an_impact_at_its_speed() -> None:
    """One element, once, at the reference speed and at half of it, where less is lost."""
    found = []
    for speed in (0.1, 0.05):
        bearing = BALLS | {
            "internal_clearance": 1e-4,
            "restitution": 0.8,
            "reference_speed": 0.1,
            "cage_phase": 0.0,
        }
        document = shaft(bearing, initial={"x": 4e-5, "vx": speed})
        document["run"] = {"duration": 1e-3, "sampling": 1e6, "tolerance": 1e-12}
        found.append(-float(gp.simulate(document).ds["vx"].sel(rotor="shaft").values.min()) / speed)
    assert found[0] == pytest.approx(0.8, abs=1e-7)
    assert 0.88 < found[1] < 0.9
    assert math.isclose(Bearing(**BALLS, restitution=1.0).dissipation(), 0.0)


def test_fields_change_by_path_and_read_back() -> None:
    """A class becomes its clearance, lists are reached by number, and a written case is the same case."""
    bearing = {"catalogue": "6205", "groove_ratio": 0.52, "internal_clearance": "C3"}
    case = gp.load_case(shaft(bearing | {"waviness": [{"order": 8, "amplitude": "0.5 um"}]}))
    changed = gp.replace(
        case,
        {
            "bearings.shaft.offset.1": "1 um",
            "bearings.shaft.waviness.0.order": 9,
            "bearings.shaft.internal_clearance": "C4",
            "bearings.shaft.damping": {"kind": "hunt-crossley", "value": "0.5 s/m"},
        },
    )
    found = changed.bearings["shaft"]
    assert (found.offset, found.waviness[0].order, found.dissipation()) == ((0.0, 1e-6), 9, 0.5)
    assert found.internal_clearance == pytest.approx(32e-6)
    assert gp.load_case(changed.resolved()) == changed
    assert "bearings" not in gp.load_case("han2021").resolved(), "digests of other cases stay"


def test_spin_of_an_inclined_contact() -> None:
    """Pure rolling on the outer raceway: spin over the cage's speed is (d_m / 2 + D cos(a) / 2) over D / 2, about its axis."""
    ratio, angle = 0.2, math.radians(40.0)
    orders = pass_orders(12, ratio, angle)
    assert orders.spin == pytest.approx(orders.cage * (1.0 + ratio * math.cos(angle)) / ratio, rel=1e-14)
    assert orders.outer + orders.inner == pytest.approx(12.0, rel=1e-15)
