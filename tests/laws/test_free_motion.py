"""Free flight: the closed form solves its equation, and conservative advancement misses no touch."""

import itertools
import math
from collections.abc import Iterator

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from building import Document, Floats, Measured, case_of, merged, pair_document, run_of, simulate_one
from depth import sized
from free_motion import LOOKS, oversights
from gearplay.integrate import run as kernel
from gearplay.integrate import stepper
from gearplay.kernels.advancement import open_span
from gearplay.kernels.decay import decay, slow_decays
from gearplay.kernels.free_motion import NEVER, closed_form_span, propagate
from gearplay.kernels.housing_motion import AMPLITUDE, COUNT, END, START, STEP, base_acceleration
from gearplay.kernels.layout import FREE
from gearplay.model.pack import pack

FLIGHTS = sized(10_000)


@pytest.mark.parametrize("z", [0.0, 1e-12, 1e-3, 0.0999999, 0.1, 3.0, 700.0])
def test_decay_functions(z: float) -> None:
    """phi1 = (1 - exp(-z))/z and phi2 = (1 - phi1)/z to 1e-14, on both sides of the change of formula."""
    terms = [(-z) ** k / math.factorial(k + 1) for k in range(60)] if z < 1.0 else []
    phi_1 = math.fsum(terms) if terms else -math.expm1(-z) / z
    others = [(-z) ** k / math.factorial(k + 2) for k in range(60)] if z < 1.0 else []
    phi_2 = math.fsum(others) if others else (z + math.expm1(-z)) / z**2
    assert decay(z) == pytest.approx((phi_1, phi_2), rel=1e-14)


@pytest.mark.parametrize("z", [0.0, 1e-12, 1e-3, 0.0099999, 0.01, 0.5, 0.9999999, 1.0, 3.0, 700.0])
def test_slower_decay_functions(z: float) -> None:
    """phi_n, the integral of exp(-z (1 - s)) s^(n-1) / (n-1)! from 0 to 1, to 1e-13 on both sides of the changes of formula."""
    integrals = [
        quad(
            lambda s, n=n: math.exp(-z * (1.0 - s)) * s**n / math.factorial(n),
            0.0,
            1.0,
            epsabs=0.0,
            epsrel=1e-13,
            points=[1.0 - min(1.0, 10.0 / max(z, 10.0))],
        )[0]
        for n in range(5)
    ]
    assert slow_decays(z) == pytest.approx(integrals, rel=1e-13)


SHAKEN: dict[str, Document] = {
    "sine": {"kind": "harmonic", "amplitude": 30.0, "frequency": 40.0, "phase": 1.0},
    "shock that begins and ends": {"kind": "half-sine", "amplitude": 80.0, "duration": 0.02, "start": 0.02},
    "record that begins": {
        "kind": "record",
        "values": [3.0, -20.0, 14.0, 30.0, -9.0, 2.0, 40.0],
        "sampling": 180.0,
        "start": 0.021,
    },
    "random": {"kind": "spectral-density", "density": [[5.0, 2.0], [300.0, 1.0]]},
}


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0.0, 1e-6, 0.3, 400.0])
@pytest.mark.parametrize("motion", SHAKEN)
def test_flight_on_a_housing_that_shakes(motion: str, damping: float) -> None:
    """As integrated by DOP853 between the knots of the motion, to 1e-12; its acceleration stays within what bounds it."""
    rotor = {"mass": 0.7, "inertia": 2e-3, "floating": True, "radial_damping": damping}
    base = {"acceleration": {**SHAKEN[motion], "direction": 0.7}}
    document = {"rotors": {"disc": rotor}, "base": base, "gravity": [0.3, -9.81], "run": {"duration": 0.3}}
    system = pack(case_of(document)).system
    start, end = np.array([1e-5, -2e-5, 0.3, 0.02, -0.05, 4.0]), np.zeros(6)
    direction, t_0, tau = np.array([math.cos(0.7), math.sin(0.7)]), 0.013, 0.05

    def rates(t: float, y: Floats) -> Floats:
        a = np.array([0.3, -9.81]) - base_acceleration(system, t) * direction - damping / 0.7 * y[3:5]
        return np.array([*y[3:], *a, 0.0])

    knots = system.base[START] + system.base[STEP] * np.arange(system.base[COUNT] + 1)
    knots = np.array([*knots, system.base[END], t_0 + tau])
    expected, t = start, t_0
    for stop in np.unique(knots[(knots > t_0) & (knots <= t_0 + tau)]):
        solved = solve_ivp(
            rates, (t, np.nextafter(stop, 0.0)), expected, method="DOP853", rtol=1e-13, atol=1e-16
        )
        expected, t = solved.y[:, -1], stop
    propagate(system, 0, t_0, tau, start, end)
    np.testing.assert_allclose(end, expected, rtol=1e-12, atol=1e-12)
    accelerations = [abs(base_acceleration(system, t)) for t in np.linspace(0.0, 0.3, 20_000)]
    largest = max(accelerations)
    assert largest <= system.base[AMPLITUDE] * (1.0 + 1e-12) <= 1.3 * largest


@pytest.mark.parametrize("damping", [0.0, 0.3])
@pytest.mark.parametrize("motion", SHAKEN)
def test_free_motion_samples__equal_those_of_steps(motion: str, damping: float) -> None:
    """Signals in flight against those of steps taken: a disc whose unbalance, far too little to matter, must be integrated."""

    def signals(unbalance: float) -> tuple[Floats, int]:
        rotor = {
            "mass": 0.7,
            "inertia": 2e-3,
            "floating": True,
            "radial_damping": damping,
            "initial": {"vx": 0.02},
        }
        if unbalance:
            rotor["unbalance"] = {"amount": unbalance}
        base = {"acceleration": {**SHAKEN[motion], "direction": 0.7}}
        run = {"duration": 0.1, "sampling": 1e4, "tolerance": 1e-11}
        motion_of = simulate_one({"rotors": {"disc": rotor}, "base": base, "run": run})
        return np.array(
            [motion_of.signal(name, "disc") for name in ("x", "y", "vx", "vy", "ax", "ay")]
        ), motion_of.counters.steps

    (flown, flights), (taken, steps) = signals(0.0), signals(1e-20)
    assert np.max(np.abs(flown[:4] - taken[:4])) < 1e-9
    assert np.max(np.abs(flown[4:] - taken[4:])) < 1e-8 < 1.0 < np.max(np.abs(flown[4:]))
    assert flights < steps / 4


def test_housing_sine__too_slow_for_the_closed_form_is_integrated() -> None:
    """10 m/s^2 at 0.05 Hz go 100 m to and fro, whose rounding would be seen by touches; at 5 Hz 1 cm."""

    def flies(frequency: float) -> bool:
        base = {"acceleration": {"kind": "harmonic", "amplitude": -10.0, "frequency": frequency}}
        case = case_of(
            {
                "rotors": {"disc": {"mass": 1.0, "inertia": 1e-3, "floating": True}},
                "base": base,
                "run": {"duration": 1.0},
            }
        )
        return bool(run_of(case, pack(case)).active_set.body_states[0] == FREE)

    assert (flies(0.05), flies(5.0)) == (False, True)


@pytest.mark.parametrize("damping", [0.0, 1e-6, 0.3, 400.0])
@pytest.mark.parametrize("friction", [0.0, 2e-3])
def test_flight_solves_the_equations_of_motion(damping: float, friction: float) -> None:
    """Gravity, torque, drag, radial damping and saturated dry friction: as integrated by DOP853, to 1e-12."""
    rotor = {
        "mass": 0.7,
        "inertia": 2e-3,
        "floating": True,
        "radial_damping": damping,
        "drive": {"kind": "torque", "torque": 0.4},
        "load": {"drag": 0.01 * damping, "friction": friction},
        "initial": {"omega": 3.0},
    }
    packed = pack(case_of({"rotors": {"disc": rotor}, "gravity": [0.3, -9.81], "run": {"duration": 1.0}}))
    start, end = np.array([1e-5, -2e-5, 0.3, 0.02, -0.05, 4.0]), np.zeros(6)
    omega_0 = float(packed.system.rotors[0].nominal_speed)

    def rates(_: float, y: Floats) -> Floats:
        spin = omega_0 + y[5]
        a = np.array([0.3, -9.81]) - damping / 0.7 * y[3:5]
        alpha = (0.4 - 0.01 * damping * spin - friction) / 2e-3
        return np.array([*y[3:], *a, alpha])

    expected = solve_ivp(rates, (0.0, 0.05), start, method="DOP853", rtol=1e-13, atol=1e-16).y[:, -1]
    propagate(packed.system, 0, 0.0, 0.05, start, end)
    np.testing.assert_allclose(end, expected, rtol=1e-12, atol=1e-16)


def test_the_closed_form_ends_where_dry_friction_leaves_its_band() -> None:
    """A coasting disc with drag d and friction T is slow after J/d log((d w + T)/(d w_f + T)); one that speeds up never is."""
    friction = {"friction": 2e-3, "friction_speed": 0.5, "drag": 1e-3}
    document: Document = {
        "rotors": {
            "disc": {
                "mass": 1.0,
                "inertia": 2e-3,
                "floating": True,
                "load": friction,
                "initial": {"omega": 3.0},
            }
        },
        "run": {"duration": 1.0, "tolerance": 1e-11, "sampling": 10.0},
    }
    packed = pack(case_of(document))
    y = np.zeros(6)
    y[5] = 3.0 - packed.system.rotors[0].nominal_speed
    expected = 2.0 * math.log((3e-3 + 2e-3) / (0.5e-3 + 2e-3))
    assert closed_form_span(packed.system, 0, 0.0, y) == pytest.approx(expected, rel=1e-13)
    driven = merged(document, {"rotors": {"disc": {"drive": {"kind": "torque", "torque": 1.0}}}})
    assert closed_form_span(pack(case_of(driven)).system, 0, 0.0, y) == NEVER
    # the run goes on numerically through the band and comes to rest
    case = case_of(merged(document, {"run": {"duration": 20.0}}))
    motion = run_of(case, packed)
    motion.clock[kernel.T_END] = 0.99 * expected
    assert stepper.advance(packed.system, motion, 100_000) == kernel.DONE
    assert motion.active_set.body_states[0] == FREE
    motion.clock[kernel.T_END] = 20.0
    assert stepper.advance(packed.system, motion, 100_000) == kernel.DONE
    assert abs(packed.system.rotors[0].nominal_speed + motion.y[5]) < 1e-6


@pytest.mark.parametrize(
    ("p", "rate", "bend"), [(-1e-6, 0.1, 0.0), (-1e-6, 0.1, 5.0), (-1e-6, -0.1, 5.0), (0.0, -1e-3, 2.0)]
)
def test_open_span_is_the_first_root_of_the_majorant(p: float, rate: float, bend: float) -> None:
    """P + rate tau + bend tau^2/2 = 0 at the returned tau, and below 0 before."""
    tau = open_span(p, rate, bend)
    scale = abs(p) + abs(rate) * tau
    assert abs(p + rate * tau + 0.5 * bend * tau**2) < 1e-14 * scale
    early = np.linspace(1e-3, 1.0 - 1e-9, 500) * tau
    assert np.all(p + rate * early + 0.5 * bend * early**2 < 0.0)


def random_flyer(generator: np.random.Generator) -> Document:
    """Return a pair under random constant forces, damping, errors of the teeth, runout, drive and model."""
    kind = str(generator.choice(["internal", "external"]))
    wheel = "ring" if kind == "internal" else "wheel"
    document = pair_document(kind, backlash_model=str(generator.choice(["coupled", "uncoupled"])))
    if generator.random() < 0.2:
        document["formulation"] = "as_published"
    document["gravity"] = [float(g) for g in generator.choice([0.0, 1.0, 9.81], 2)]
    document["meshes"][0]["backlash"] = float(10.0 ** generator.uniform(-5.0, -3.7))
    document["meshes"][0]["transmission_error"] = [
        {"order": int(k), "amplitude": float(10.0 ** generator.uniform(-8.0, -5.5)), "phase": float(k)}
        for k in generator.choice([1, 2, 3, 7], 2, replace=False)
    ]
    for name, rotor in document["rotors"].items():
        rotor["runout"] = {"amplitude": float(generator.choice([0.0, 1e-6, 1e-5])), "phase": 1.0}
        rotor["radial_damping"] = float(generator.choice([0.0, 0.1, 30.0]))
        rotor["load"] = {"drag": float(generator.choice([0.0, 1e-4, 1e-2]))}
        document["sleeves"][name]["radial_clearance"] = float(10.0 ** generator.uniform(-5.0, -3.3))
    if generator.random() < 0.7:
        document["rotors"]["pinion"]["drive"] = {
            "kind": "speed",
            "speed": float(generator.uniform(-60.0, 60.0)),
        }
    else:
        document["rotors"][wheel]["drive"] = {"kind": "torque", "torque": float(generator.uniform(-0.1, 0.1))}
    document["run"] = {
        "duration": 0.1,
        "sampling": 1e3,
        "tolerance": 1e-8,
        "seed": int(generator.integers(1e9)),
    }
    return document


def rippling(document: Document, generator: np.random.Generator) -> Document:
    """Return a document whose pinion is driven with a ripple of one to three random orders."""
    terms = [
        {
            "order": int(generator.integers(1, 65)),
            "amplitude": float(10.0 ** generator.uniform(-4.0, -0.6)),
            "phase": float(generator.uniform(0.0, 6.0)),
        }
        for _ in range(generator.integers(1, 4))
    ]
    drive = {"kind": "speed", "speed": float(generator.uniform(-60.0, 60.0)), "ripple": terms}
    wheel = next(name for name in document["rotors"] if name != "pinion")
    return merged(document, {"rotors": {"pinion": {"drive": drive}, wheel: {"drive": None}}})


def look_for_misses(documents: Iterator[Document], flights: int, where: str, measured: Measured) -> None:
    """Demand that in every flight dense looks see no touch before the one that ends it (deeper than 1e-14 m)."""
    worst, grazing = oversights(documents, flights)
    measured(
        f"deepest missed contact of {flights} free motions{where}, {LOOKS} checks each [m]",
        worst,
        "1e-14",
    )
    assert worst < 1e-14
    assert grazing > flights // 10, "the dense looks come near to the touches"


@pytest.mark.slow
def test_no_contact_is_missed_in_ten_thousand_random_flights(measured: Measured) -> None:
    """Constant forces, damping, errors of the teeth, runouts."""
    generator = np.random.default_rng(20)
    look_for_misses((random_flyer(generator) for _ in itertools.count()), FLIGHTS, "", measured)


def test_no_contact_is_missed_beside_a_rippling_drive(measured: Measured) -> None:
    """The same with a pinion whose speed ripples: its acceleration bends the gaps, up to 64 times a revolution."""
    generator = np.random.default_rng(21)
    documents = (rippling(random_flyer(generator), generator) for _ in itertools.count())
    look_for_misses(documents, FLIGHTS // 4, " with a rippling drive", measured)


def shaking(document: Document, generator: np.random.Generator) -> Document:
    """Return a document on a housing that moves in one of four random ways, from a thousandth to twenty g."""
    size, fast = float(10.0 ** generator.uniform(-2.0, 2.3)), float(10.0 ** generator.uniform(0.5, 3.0))
    ways: list[Document] = [
        {"kind": "harmonic", "amplitude": size, "frequency": fast, "phase": 1.0},
        {"kind": "half-sine", "amplitude": -size, "duration": 0.3 / fast, "start": 0.02},
        {"kind": "record", "values": (size * generator.normal(size=20)).tolist(), "sampling": fast},
        {"kind": "spectral-density", "density": [[0.3 * fast, 0.1 * size**2 / fast], [fast, size**2 / fast]]},
    ]
    way = ways[int(generator.integers(4))]
    return merged(
        document, {"base": {"acceleration": {**way, "direction": float(generator.uniform(0.0, 6.0))}}}
    )


@pytest.mark.slow
def test_no_contact_is_missed_on_a_housing_that_shakes(measured: Measured) -> None:
    """The same where the housing's acceleration bends the gaps."""
    generator = np.random.default_rng(22)
    documents = (shaking(random_flyer(generator), generator) for _ in itertools.count())
    look_for_misses(documents, FLIGHTS // 2, " in a housing that shakes", measured)
