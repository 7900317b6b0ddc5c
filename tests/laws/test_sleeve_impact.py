"""One journal against its bush: closed forms of the elastic impact, restitution laws, the conformal bed."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from building import Document, case_of, merged, pair_document, simulate_one, single_rotor_document
from gearplay.model.pack import pack
from gearplay.parts.registry import SLEEVE
from gearplay.parts.sleeve.conformal import bed_half_angle, bed_integrals, bed_penetration
from gearplay.parts.sleeve.contact_laws import bed_stiffness, literal_dissipation
from gearplay.parts.sleeve.law import sleeve_force
from gearplay.solver.trajectory import Trajectory

MASS, SPEED, CLEARANCE, STIFFNESS = 0.5, 0.05, 50e-6, 1e10
LAWS = ("lankarani-nikravesh", "hunt-crossley", "flores", "gonthier", "conformal")


def impact(direction: float = 0.7, **sleeve: Any) -> Document:
    """Return a disc that flies from the middle of its bush against the wall at ``SPEED``."""
    given = {
        "radial_clearance": CLEARANCE,
        "law": "hunt-crossley",
        "stiffness": STIFFNESS,
        "exponent": 1.5,
        "restitution": 1.0,
    }
    start = {"vx": SPEED * math.cos(direction), "vy": SPEED * math.sin(direction)}
    document = single_rotor_document(merged(given, sleeve), mass=MASS, initial=start)
    return merged(document, {"run": {"duration": 2.2e-3, "sampling": 1e7}})


def first_contact(run: Trajectory) -> tuple[float, float, float, float]:
    """Return times [s] and rates [m/s] of the first onset and release."""
    (t_on, _, on, v_on), (t_off, _, off, v_off) = run.log[:2]
    assert (on, off) == (1.0, 0.0)
    return t_on, t_off, v_on, v_off


@pytest.mark.parametrize(("exponent", "stiffness", "periods"), [(1.5, 1e10, 2.94328), (1.0, 5e7, math.pi)])
def test_elastic_impact_has_its_closed_form(exponent: float, stiffness: float, periods: float) -> None:
    """delta_max = ((n+1) m v^2 / 2K)^(1/(n+1)), duration 2.94328 or pi times delta_max / v."""
    run = simulate_one(impact(exponent=exponent, stiffness=stiffness), signals=["sleeve_penetration"])
    deepest = (0.5 * (exponent + 1.0) * MASS * SPEED**2 / stiffness) ** (1.0 / (exponent + 1.0))
    t_on, t_off, v_on, v_off = first_contact(run)
    assert t_on == pytest.approx(CLEARANCE / SPEED, rel=1e-12)
    assert (v_on, v_off) == (pytest.approx(SPEED, rel=1e-12), pytest.approx(-SPEED, rel=1e-7))
    assert float(np.max(run.values)) == pytest.approx(deepest, rel=1e-5)
    assert t_off - t_on == pytest.approx(periods * deepest / SPEED, rel=2e-6)


def test_hertz_closed_form_of_five_halves() -> None:
    """delta_max = (5 m v^2 / 4K)^(2/5), and the largest force is K delta_max^1.5."""
    run = simulate_one(impact(), signals=["sleeve_penetration", "sleeve_force_x", "sleeve_force_y"])
    deepest = (5.0 * MASS * SPEED**2 / (4.0 * STIFFNESS)) ** 0.4
    assert float(np.max(run.values[:, 0])) == pytest.approx(deepest, rel=1e-4)
    assert float(np.max(np.hypot(run.values[:, 1], run.values[:, 2]))) == pytest.approx(
        STIFFNESS * deepest**1.5, rel=1e-4
    )


def test_statistics_hold_the_peak_between_steps() -> None:
    """The tallied peak penetration and force are those of the closed form, not of the nearest step end."""
    run = simulate_one(impact(), signals=["sleeve_penetration"])
    deepest = (5.0 * MASS * SPEED**2 / (4.0 * STIFFNESS)) ** 0.4
    assert run.statistics.max_penetration[0] == pytest.approx(deepest, rel=1e-3)
    assert run.statistics.peak_force[0] == pytest.approx(STIFFNESS * deepest**1.5, rel=1e-3)
    assert run.statistics.max_impact_speed[0] == pytest.approx(SPEED, rel=1e-12)


def expected_restitution(d: float) -> float:
    """Return e of d - ln(1 + d) = -d e - ln(1 - d e), the phase-plane integral of the impact."""
    if d == 0.0:
        return 1.0
    low, high = 0.0, min(1.0, 1.0 / d) * (1.0 - 1e-15)
    return float(brentq(lambda e: d - math.log1p(d) + d * e + math.log1p(-d * e), low, high, xtol=1e-14))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("given", [0.9, 0.5])
def test_literal_law__restitution_equals_that_of_the_phase_plane(law: str, given: float) -> None:
    """Rebound speed of each published law: 0.91318 for Lankarani-Nikravesh at 0.9, not 0.9."""
    run = simulate_one(impact(law=law, restitution=given, shaft_radius=0.01), signals=["sleeve_penetration"])
    _, _, v_on, v_off = first_contact(run)
    assert -v_off / v_on == pytest.approx(expected_restitution(literal_dissipation(law, given)), abs=1e-6)


@pytest.mark.parametrize(
    ("law", "given", "delivered"),
    [
        ("lankarani-nikravesh", 0.9, 0.91318),
        ("lankarani-nikravesh", 0.5, 0.72524),
        ("flores", 0.9, 0.89392),
        ("hunt-crossley", 0.9, 0.90902),
    ],
)
def test_known_rebounds(law: str, given: float, delivered: float) -> None:
    """The tabulated rebounds of the published laws."""
    _, _, v_on, v_off = first_contact(
        simulate_one(impact(law=law, restitution=given), signals=["sleeve_penetration"])
    )
    assert -v_off / v_on == pytest.approx(delivered, abs=1e-5)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("wanted", [1.0, 0.95, 0.3])
@pytest.mark.parametrize("exponent", [1.5, 1.0])
def test_delivered_law__has_the_given_restitution(law: str, wanted: float, exponent: float) -> None:
    """restitution_reading = delivered: the rebound is the given one, whatever law and exponent."""
    stiffness = 1e10 if exponent == 1.5 else 5e7
    sleeve = {"law": law, "restitution": wanted, "restitution_reading": "delivered", "shaft_radius": 0.01}
    run = simulate_one(
        impact(**sleeve, exponent=exponent, stiffness=stiffness), signals=["sleeve_penetration"]
    )
    _, _, v_on, v_off = first_contact(run)
    assert -v_off / v_on == pytest.approx(wanted, abs=1e-6)


def test_peak_of_a_damped_impact() -> None:
    """(delta_max / delta_Hertz)^(5/2) = 2 (a - ln(1 + a)) / a^2: 0.96472 for Lankarani-Nikravesh at 0.9."""
    law = {"law": "lankarani-nikravesh", "restitution": 0.9}
    peaks = [
        float(np.max(simulate_one(impact(**s), signals=["sleeve_penetration"]).values)) for s in (law, {})
    ]
    a = 0.75 * (1.0 - 0.81)
    assert (2.0 * (a - math.log1p(a)) / a**2) ** 0.4 == pytest.approx(0.96472, abs=5e-6)
    assert peaks[0] / peaks[1] == pytest.approx(0.96472, abs=1e-5)


def test_impact_on_a_free_carrier_has_the_reduced_mass() -> None:
    """A journal in the bush of another floating body: m_1 m_2 / (m_1 + m_2) sets the duration."""
    document = impact(direction=0.0, on="carrier", exponent=1.0, stiffness=5e7)
    document["rotors"]["carrier"] = {"mass": 0.3, "inertia": 1e-3, "floating": True}
    run = simulate_one(document, signals=["vx"])
    t_on, t_off, v_on, v_off = first_contact(run)
    reduced = MASS * 0.3 / (MASS + 0.3)
    assert t_off - t_on == pytest.approx(math.pi * math.sqrt(reduced / 5e7), rel=1e-6)
    assert v_off == pytest.approx(-v_on, rel=1e-6)
    momentum = MASS * run.signal("vx", "disc") + 0.3 * run.signal("vx", "carrier")
    np.testing.assert_allclose(momentum, MASS * SPEED, rtol=1e-12)


# -- conformal bed -----------------------------------------------------------------------------------------


def test_bed_geometry_is_two_circles() -> None:
    """At theta0 the shaft's circle crosses the bush's: local penetration 0 there, delta_m in the middle."""
    c, R = 100e-6, 0.01
    for depth in (1e-8, 1e-6, 1e-4):
        theta0 = bed_half_angle(depth, c, R)
        assert bed_penetration(0.0, depth, c, R) == pytest.approx(depth, rel=1e-9)
        assert abs(bed_penetration(theta0, depth, c, R)) < 1e-16 + 1e-9 * depth
        # the bush's point at theta0 lies on the shaft's circle, whose centre is c + depth off
        x, y = (R + c) * math.cos(theta0) - (c + depth), (R + c) * math.sin(theta0)
        assert math.hypot(x, y) == pytest.approx(R, rel=1e-12)


@pytest.mark.parametrize("k", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("depth", [1e-8, 1e-6, 1e-5, 1e-4])
def test_bed_integral_agrees_with_adaptive_quadrature(k: float, depth: float) -> None:
    """2 * integral of delta(theta)^k cos theta over 0..theta0, eq. (14), against QUADPACK."""
    c, R = 100e-6, 0.01
    theta0 = bed_half_angle(depth, c, R)
    expected = (
        2.0
        * quad(
            lambda u: max(bed_penetration(theta0 * u, depth, c, R), 0.0) ** k * math.cos(theta0 * u) * theta0,
            0.0,
            1.0,
            epsabs=0.0,
            epsrel=1e-11,
            limit=200,
        )[0]
    )
    elastic, opening = bed_integrals(depth, c, R, k)
    assert elastic == pytest.approx(expected, rel=1e-9)
    assert opening == pytest.approx(2.0 * math.sin(theta0), rel=1e-14)


def test_linear_bed_has_the_hertz_exponent_and_meets_the_point_law() -> None:
    """A bed of exponent 1 gives delta^1.5 as delta -> 0, and the point law's force at its reference."""
    c, R, reference = 100e-6, 0.01, 1e-6
    force = [bed_integrals(d, c, R, 1.0)[0] for d in (1e-9, 1.01e-9)]
    assert math.log(force[1] / force[0]) / math.log(1.01) == pytest.approx(1.5, abs=1e-4)
    k = bed_stiffness(STIFFNESS, 1.5, c, R, 1.0, reference)
    assert k * bed_integrals(reference, c, R, 1.0)[0] == pytest.approx(STIFFNESS * reference**1.5, rel=1e-13)
    document = impact(
        law="conformal", shaft_radius=R, radial_clearance=c, bed_reference_penetration=reference
    )
    sleeve = pack(case_of(document)).system.records[SLEEVE][0]
    assert sleeve_force(sleeve, reference, 0.0, 1.0)[0] == pytest.approx(
        STIFFNESS * reference**1.5, rel=1e-13
    )


def test_conformal_impact_conserves_energy() -> None:
    """With restitution 1 the bed gives the speed back and turns at the depth of its energy integral."""
    run = simulate_one(impact(law="conformal", shaft_radius=0.01), signals=["sleeve_penetration"])
    _, _, v_on, v_off = first_contact(run)
    assert -v_off / v_on == pytest.approx(1.0, abs=1e-8)
    sleeve = pack(case_of(impact(law="conformal", shaft_radius=0.01))).system.records[SLEEVE][0]
    deepest = float(np.max(run.values))
    stored = quad(lambda d: sleeve_force(sleeve, d, 0.0, 1.0)[0], 0.0, deepest, epsrel=1e-11)[0]
    assert stored == pytest.approx(0.5 * MASS * SPEED**2, rel=1e-5)


def test_bed_as_printed_adds_the_same_damping_at_every_angle() -> None:
    """(14) as printed: 2 * integral of (K delta^1.5 + C ddelta/dt) cos theta, C = a K delta_m^1.5 / v_in."""
    document = merged(
        impact(law="conformal", shaft_radius=0.01, restitution=0.9), {"formulation": "as_published"}
    )
    sleeve = pack(case_of(document)).system.records[SLEEVE][0]
    depth, rate, v_in = 3e-6, 0.02, 0.05
    theta0 = bed_half_angle(depth, CLEARANCE, 0.01)
    C = 0.75 * (1.0 - 0.81) * STIFFNESS * depth**1.5 / v_in
    expected = (
        2.0
        * quad(
            lambda th: (
                (STIFFNESS * max(bed_penetration(th, depth, CLEARANCE, 0.01), 0.0) ** 1.5 + C * rate)
                * math.cos(th)
            ),
            0.0,
            theta0,
            epsrel=1e-12,
        )[0]
    )
    assert sleeve_force(sleeve, depth, rate, v_in)[0] == pytest.approx(expected, rel=1e-9)


# -- no sleeve pulls ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS)
def test_neither_sleeve_nor_flank_ever_pulls(law: str) -> None:
    """Heavy damping and a rough mesh: every sampled force pushes, though the bare formulas would pull."""
    heavy = {"law": law, "restitution": 0.05, "shaft_radius": 0.01}
    mesh = {
        "damping": {"ratio": 0.8, "depth": 2e-7},
        "transmission_error": [{"order": 1, "amplitude": 3e-5}],
    }
    document = pair_document(mesh=mesh, sleeves={"pinion": heavy, "ring": heavy}, gravity=[0.0, -9.81])
    document["rotors"]["pinion"]["drive"] = {"kind": "speed", "speed": 150.0}
    document["rotors"]["ring"]["load"] = {"torque": 1.0}
    document["run"] = {"duration": 0.1, "sampling": 2e5, "tolerance": 1e-9}
    run = simulate_one(document)
    assert np.all(run.signal("drive_force", "pinion-ring") >= 0.0)
    assert np.all(run.signal("back_force", "pinion-ring") >= 0.0)
    separating = 0
    for name in ("pinion", "ring"):
        f = np.array([run.signal(f"sleeve_force_{c}", name) for c in "xy"])
        e = np.array([run.signal(c, name) for c in "xy"])
        pull = np.sum(f * e, axis=0) / np.maximum(np.hypot(*e), 1e-30)
        assert np.max(pull) <= 1e-9 * np.max(np.hypot(*f))
        separating += np.count_nonzero(
            (run.signal("sleeve_penetration", name) > 1e-9) & (np.hypot(*f) == 0.0)
        )
    assert separating > 0, "the law alone would pull somewhere: there it touches without pressing"
    assert {0.0, 2.0} <= set(run.log[run.log[:, 2] == 1.0][:, 1])
