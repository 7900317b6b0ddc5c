"""What every kind of element must hold, present and future: each test asks all kinds of `gearplay.parts.registry`.
Meshes with pairs of teeth, and with the envelope over them, are further kinds here.

The file ``test_KIND.py`` beside this one brings random mechanisms with an element of its kind, ``sample(rng)``, with
``plain=True`` without what a turn or a mirror would have to carry along; directions of its own that turn with the mechanism,
``carried(document, sign, angle)``, ``sign`` -1 for a mirror; and, where its forces have one without damping, their potential
energy, ``potential(packed, y)``.
"""

import importlib
import math
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

from building import Document, Floats, Measured, case_of, merged, simulate_one
from depth import FULL, sized
from gearplay.integrate import dispatch
from gearplay.integrate.events import first_switch
from gearplay.integrate.restart import begin
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.run import DONE, T_END, Run, T, make_run
from gearplay.integrate.runge_kutta import error_norm
from gearplay.integrate.slopes import make_slopes
from gearplay.integrate.switches import make_branch, switch_values
from gearplay.integrate.trial_step import attempt, evaluate
from gearplay.kernels.advancement import RESOLUTION, STAYS_OPEN
from gearplay.kernels.free_motion import propagate
from gearplay.kernels.layout import LOADED, OPEN, PENETRATION, RATE
from gearplay.model.pack import Packed, pack
from gearplay.parts import registry
from gearplay.solver.flow import Flow

KINDS = {kind.name: number for number, kind in enumerate(registry.KINDS) if number != registry.PAIR}
KINDS["pairs"] = registry.MESH  # which have the forces that elements of kind pair show
KINDS["envelope"] = registry.MESH
KIND_FILES = {kind.name: kind.file for kind in registry.KINDS}
every_kind = pytest.mark.parametrize("kind", KINDS)
WITHOUT_CONTACTS = ("servo", "support", "excitation", "base", "positioner")
LOOKS = np.linspace(0.0, 1.0, 42)[1:-1]  # shares of a step
MECHANISMS = {"sleeve": 1000, "bearing": 40, "pairs": 40, "envelope": 40}
"""How many a test of steps draws of a kind below the full depth; of others 100."""


def own(kind: str) -> ModuleType:
    """Return the test file of a kind."""
    return importlib.import_module(f"elements.test_{kind}")


class Scene:
    """Elements of one kind at one state, on the branch that the state chooses."""

    def __init__(self, document: Document, kind: str, rng: np.random.Generator, depth: float = 2.0) -> None:
        self.packed = pack(case_of(document))
        self.system, self.rng = self.packed.system, rng
        self.elements = [int(e) for e in np.flatnonzero(self.system.elements["kind"] == KINDS[kind])]
        n = self.system.rotors.size
        self.n, self.y = n, depth * self.packed.natural * rng.uniform(-1.0, 1.0, self.packed.state_size)
        rotors: Any = self.system.rotors
        self.held = [3 * i + c for i in range(n) for c in range(3) if _is_held(rotors[i], c)]
        self.y[self.held], self.y[[3 * n + c for c in self.held]] = 0.0, 0.0
        self.branch, self.loads = make_branch(self.system), make_loads(self.system)
        self.branch.impact_speeds[:] = rng.uniform(0.05, 0.2, self.branch.impact_speeds.size)
        self.decide(self.y)

    def decide(self, y: Floats) -> None:
        """Choose every branch by the state."""
        for e in range(self.system.elements.size):
            assert dispatch.contact_kinematics(self.system, e, 0.0, y, self.branch, self.loads) == 0
        touching = self.loads.contacts[:, PENETRATION] > 0.0
        self.branch.modes[: len(touching)] = np.where(touching, LOADED, OPEN)
        for e in range(self.system.elements.size):
            dispatch.initialise(self.system, e, 0.0, y, self.branch, self.loads)

    def forces(self, y: Floats, impact_speeds: Floats | None = None) -> tuple[Floats, Floats]:
        """Return the sums on the rotors [rotor, 3] and the rates of the elements' own states."""
        branch = self.branch if impact_speeds is None else replace(self.branch, impact_speeds=impact_speeds)
        dy = np.zeros(y.size)
        self.loads.rotors[:] = 0.0
        acting = np.array([len(self.elements), *self.elements], dtype=np.int64)
        assert dispatch.apply_forces(self.system, acting, 0.0, y, branch, self.loads, dy) == 0
        return self.loads.rotors.copy(), dy[6 * self.n :]

    def slopes(self, z: Floats) -> tuple[Floats, Floats]:
        """Return what a change z of state and stored impact speeds changes in `forces`, by the elements' own slopes."""
        rows, force, dz = make_slopes(self.system).elements, np.zeros((self.n, 3)), np.zeros(z.size)
        for e in self.elements:
            assert dispatch.linearise(self.system, e, 0.0, self.y, self.branch, self.loads, rows[e]) == 0
            dispatch.add_change(self.system, e, rows[e], z, self.branch, force, dz)
        return force, dz[6 * self.n : self.y.size]

    def run(self, tolerance: float) -> Run | None:
        """Return a run that begins at the state, None where it cannot."""
        run = make_run(
            self.system,
            self.y,
            self.packed.natural,
            self.packed.restart_step,
            self.packed.stops,
            np.arange(0),
            np.empty((0, 0)),
            99,
            tolerance,
        )
        run.clock[T_END] = 1.0
        return run if begin(self.system, run) == DONE else None

    def look(self, run: Run, h: float, x: float, s: int) -> float:
        """Return switch s at the share x of the step of h [s] just tried."""
        evaluate(self.system, run, h, x, s)
        return float(run.g_try[s])


def _is_held(rotor: Any, c: int) -> bool:
    return bool((rotor.inv_inertia if c == 2 else rotor.inv_mass) == 0.0)


def scenes(kind: str, count: int, **policy: float) -> list[Scene]:
    """Return random scenes of a kind."""
    found = []
    for seed in range(count):
        rng = np.random.default_rng([KINDS[kind], seed])
        found.append(Scene(own(kind).sample(rng), kind, rng, **policy))
    return found


@pytest.mark.slow
@every_kind
def test_slopes_are_those_of_differences(kind: str, measured: Measured) -> None:
    """Central differences of the forces along random changes of the state and of stored impact speeds."""
    worst = 0.0
    for scene in scenes(kind, 40):
        sizes = np.concatenate([scene.packed.natural, np.full(scene.branch.impact_speeds.size, 0.1)])
        z = sizes * scene.rng.uniform(-1.0, 1.0, sizes.size)
        z[scene.held], z[[3 * scene.n + c for c in scene.held]] = 0.0, 0.0
        size, h = scene.y.size, 1e-5
        ends = [
            scene.forces(scene.y + s * h * z[:size], scene.branch.impact_speeds + s * h * z[size:])
            for s in (1, -1)
        ]
        for exact, plus, minus in zip(scene.slopes(z), *ends, strict=True):
            if exact.size:
                scale = float(np.max(np.abs(plus))) + float(np.max(np.abs(exact))) + 1e-12
                worst = max(worst, float(np.max(np.abs((plus - minus) / (2.0 * h) - exact))) / scale)
    measured(f"{kind}: slope against differences", worst, "1e-6")
    assert worst < 1e-6


@pytest.mark.slow
@every_kind
def test_no_touch_is_missed_in_flight(kind: str, measured: Measured) -> None:
    """Dense looks into up to 10 000 flights for the time that an element says it stays open."""
    flights, deepest, seed = 0, 0.0, 0
    wanted = sized(10_000)
    while flights < wanted:
        rng = np.random.default_rng([7, KINDS[kind], seed])
        seed += 1
        scene = Scene(own(kind).sample(rng), kind, rng, depth=0.0)
        elements = [e for e in scene.elements if scene.system.elements[e]["contacts"] > 0]
        if not elements:
            assert kind in WITHOUT_CONTACTS or seed < 1000
            if kind in WITHOUT_CONTACTS:
                return
            continue
        natural, n = scene.packed.natural, scene.n
        contacts = scene.system.contacts
        for _ in range(100):
            flights += 1
            y = 0.7 * natural * rng.uniform(-1.0, 1.0, natural.size)
            y[scene.held], y[[3 * n + c for c in scene.held]] = 0.0, 0.0
            now = np.array(y)
            for e in elements:
                doing, span = dispatch.stay_open(scene.system, e, 0.0, y, scene.branch, 1.0, scene.loads.out)
                if doing != STAYS_OPEN:
                    continue
                for share in (0.3, 0.7, 0.95, 1.0):
                    t = share * span
                    for i in range(n):
                        propagate(scene.system, i, 0.0, t, y, now)
                    dispatch.contact_kinematics(scene.system, e, t, now, scene.branch, scene.loads)
                    first = scene.system.elements[e]["contact"]
                    for k in range(first, first + scene.system.elements[e]["contacts"]):
                        started_open = _gap_at_start(scene, e, k, y) <= 0.0
                        over = scene.loads.contacts[k, PENETRATION] / contacts[k]["natural"]
                        if started_open:
                            deepest = max(deepest, float(over))
    measured(f"{kind}: deepest touch missed, natural sizes", deepest, "1e-10")
    assert deepest < 10.0 * RESOLUTION


def _gap_at_start(scene: Scene, e: int, k: int, y: Floats) -> float:
    loads = make_loads(scene.system)
    dispatch.contact_kinematics(scene.system, e, 0.0, y, scene.branch, loads)
    return float(loads.contacts[k, PENETRATION])


@pytest.mark.slow
@pytest.mark.compiled
@every_kind
def test_no_switch_is_missed_within_a_step(kind: str, measured: Measured) -> None:
    """Dense looks into steps that the error estimate accepts: what turns positive there, and back, ends the step there.

    Touches that graze are the many; of what else may return `test_stiffness_edges` makes sure.
    """
    humps, missed = 0, 0
    for seed in range(3000 if FULL else MECHANISMS.get(kind, 100)):
        rng = np.random.default_rng([11, KINDS[kind], seed])
        scene = Scene(own(kind).sample(rng), kind, rng, depth=float(rng.choice([0.02, 0.2, 2.0])))
        run = scene.run(1e-6)
        if run is None:
            continue
        system, active_set = scene.system, run.active_set
        for h in scene.packed.restart_step * 10.0 ** rng.uniform(-1.0, 1.0, 20):
            if attempt(system, run, h) != 0 or error_norm(active_set, h, run.stages, run.scale) > 1.0:
                continue
            switch_values(system, active_set, run.clock[T] + h, run.y_new, run.branch, run.loads, run.g_1)
            _, place = first_switch(system, run, h, True)
            for s in active_set.switches[1 : active_set.switches[0] + 1]:
                if run.g_0[s] > 0.0 or run.g_1[s] > 0.0:
                    continue
                few = [scene.look(run, h, x, s) for x in LOOKS[::5]]
                few += [run.g_0[s], run.g_1[s]]
                if max(few) + 3.0 * (max(few) - min(few)) < 0.0:
                    continue  # far below 0 throughout
                values = [scene.look(run, h, x, s) for x in LOOKS]
                lowest = min(*values, run.g_0[s], run.g_1[s])
                if max(values) > 1e-3 * (max(values) - lowest):
                    humps += 1
                    missed += bool(place > LOOKS[int(np.argmax(values))])
    measured(f"{kind}: switches missed of {humps} that come back within a step", missed, "0")
    assert missed == 0
    assert humps >= sized(10, 3) or kind != "sleeve"


@every_kind
def test_forces_are_the_gradient_of_their_energy(kind: str, measured: Measured) -> None:
    """Without damping the generalised forces are -dV/dq, V written apart from them."""
    potential = getattr(own(kind), "potential", None)
    if potential is None:
        assert kind in ("servo", "excitation", "base", "positioner", "pairs", "envelope"), (
            "an element without a potential must say so here"
        )
        return
    worst = 0.0
    for seed in range(20):
        rng = np.random.default_rng([11, seed])
        scene = Scene(own(kind).sample(rng, damped=False, plain=True), kind, rng)
        force, _ = scene.forces(scene.y)
        for c in range(3 * scene.n):
            if c in scene.held:
                continue
            h = 1e-4 * scene.packed.natural[c]
            values = []
            for s in (1.0, -1.0):
                moved = scene.y.copy()
                moved[c] += s * h
                values.append(potential(scene.packed, moved))
            slope = -(values[0] - values[1]) / (2.0 * h)
            worst = max(
                worst, abs(slope - force.ravel()[c]) * scene.packed.natural[c] / (abs(values[0]) + 1e-12)
            )
    measured(f"{kind}: force against energy", worst, "1e-5")
    assert worst < 1e-5


@pytest.mark.slow
@pytest.mark.compiled
@every_kind
def test_energy_is_accounted_for(kind: str, measured: Measured) -> None:
    """The energy of random mechanisms in motion, losses included, changes by the power of its signals, to the quadrature's error.

    That of meshes is larger, whose damping of the constant law jumps at touches.
    """
    if not hasattr(own(kind), "potential"):
        return
    worst = 0.0
    for seed in range(sized(20)):
        rng = np.random.default_rng([23, KINDS[kind], seed])
        run_of = {"duration": 2e-3, "sampling": 1e6, "tolerance": 1e-11}
        plain = kind == "mesh"  # whose potential is that of its mean stiffness
        document = own(kind).sample(rng, plain=plain) | {"gravity": [0.0, -9.81], "run": run_of}
        for name, free in zip(
            document["rotors"], pack(case_of(document)).system.rotors["inv_mass"], strict=True
        ):
            if free > 0.0:
                moving = {word: float(rng.normal(0.0, 0.05)) for word in ("vx", "vy")}
                document["rotors"][name]["initial"] = document["rotors"][name].get("initial", {}) | moving
        energy, brought = energies(document)
        change = energy - energy[0]
        assert np.ptp(change) > 0.0
        worst = max(worst, float(np.max(np.abs(change - brought)) / np.ptp(change)))
    bar = 1e-2 if kind == "mesh" else 1e-4
    measured(f"{kind}: energy against the power of its signals, of its range", worst, f"{bar:g}")
    assert worst < bar


def energies(document: Document) -> tuple[Floats, Floats]:
    """Return kinetic and potential energy [J] of a run, and what the power of its signals has brought since its start [J]."""
    run, case = simulate_one(document), case_of(document)
    packed, rotors = pack(case), list(case.rotors)
    x, y, theta, vx, vy, omega = (
        np.array([run.signal(word, name) for name in rotors])
        for word in ("x", "y", "theta", "vx", "vy", "omega")
    )
    mass, inertia = (
        np.array([getattr(each, word) for each in case.rotors.values()]) for word in ("mass", "inertia")
    )
    energy = 0.5 * (mass @ (vx**2 + vy**2) + inertia @ omega**2) - case.gravity[1] * mass @ y
    state = np.zeros(packed.state_size)
    places = np.stack([x, y, theta], axis=1).reshape(3 * len(rotors), -1)
    stored = [
        own(kind).potential
        for kind, at in KINDS.items()
        if packed.system.records[at].size and hasattr(own(kind), "potential")
    ]
    for k in range(run.time.size):
        state[: 3 * len(rotors)] = places[:, k]
        energy[k] += sum(each(packed, state) for each in stored)
    power = np.zeros(run.time.size)
    for signal, label in {(each.signal, each.label) for each in run.columns}:
        if signal.endswith("_power_loss"):
            power -= run.signal(signal, label)
        elif signal.endswith(("_power_input", "_cage_power")):
            power += run.signal(signal, label)
        elif signal in ("drive_torque", "load_torque"):
            power += run.signal(signal, label) * run.signal("omega", label)
    return energy, cumulative_simpson(power, dx=1.0 / run.sampling, initial=0.0)


@every_kind
def test_a_turned_mechanism_has_turned_forces(kind: str) -> None:
    """Centres and displacements turned by an angle: forces turn with them, torques stay."""
    for seed in range(20):
        rng = np.random.default_rng([13, seed])
        document = own(kind).sample(rng, plain=True) | {
            "mesh_phases": "from_zero"
        }  # teeth turn with the places
        scene, angle = Scene(document, kind, rng), float(rng.uniform(0.0, 6.0))
        turned = moved(document, scene.packed, lambda x, y, a=angle: _turn(x, y, a))
        turned = carried(kind)(turned, 1.0, angle)
        other = Scene(turned, kind, np.random.default_rng(0))
        other.branch.impact_speeds[:] = scene.branch.impact_speeds
        y = scene.y.copy()
        for i in range(scene.n):
            for at in (3 * i, 3 * (scene.n + i)):
                y[at : at + 2] = _turn(y[at], y[at + 1], angle)
        other.decide(y)
        expected, _ = scene.forces(scene.y)
        for i in range(scene.n):
            expected[i, :2] = _turn(expected[i, 0], expected[i, 1], angle)
        found, _ = other.forces(y)
        assert np.max(np.abs(found - expected)) <= 1e-6 * (np.max(np.abs(expected)) + 1e-9)


@every_kind
def test_a_mirrored_mechanism_has_mirrored_forces(kind: str) -> None:
    """y, rotations and speeds change their signs: so do forces along y and torques."""
    for seed in range(20):
        rng = np.random.default_rng([17, seed])
        document = own(kind).sample(rng, plain=True)
        scene = Scene(document, kind, rng)
        mirrored = carried(kind)(moved(document, scene.packed, lambda x, y: (x, -y)), -1.0, 0.0)
        for rotor in mirrored["rotors"].values():
            if "speed" in rotor.get("drive", {}):
                rotor["drive"]["speed"] = -rotor["drive"]["speed"]
            if rotor.get("initial"):
                rotor["initial"]["omega"] = -rotor["initial"].get("omega", 0.0)
        other = Scene(mirrored, kind, np.random.default_rng(0))
        other.branch.impact_speeds[:] = scene.branch.impact_speeds
        signs = np.array([1.0, -1.0, -1.0] * (2 * scene.n) + [-1.0] * (scene.y.size - 6 * scene.n))
        other.decide(signs * scene.y)
        expected, _ = scene.forces(scene.y)
        found, _ = other.forces(signs * scene.y)
        assert np.max(np.abs(found - expected * [1.0, -1.0, -1.0])) <= 1e-6 * (
            np.max(np.abs(expected)) + 1e-9
        )


def moved(document: Document, packed: Packed, move: Any) -> Document:
    """Return the document with every rotor's centre given and moved."""
    from gearplay.parts.mesh.train.geometry import centres

    case = case_of(document)
    return merged(
        document,
        {"rotors": {name: {"position": list(move(*centre))} for name, centre in centres(case).items()}},
    )


def carried(kind: str) -> Callable[[Document, float, float], Document]:
    """Return what turns or mirrors the directions of a kind's own in a document; most have none."""
    found: Callable[[Document, float, float], Document]
    found = getattr(own(kind), "carried", lambda document, sign, angle: document)
    return found


def _turn(x: float, y: float, angle: float) -> tuple[float, float]:
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


@pytest.mark.slow
@pytest.mark.compiled
@every_kind
def test_the_derivative_holds_through_events(kind: str, measured: Measured) -> None:
    """Latched values and saltation: the moved changes are the differences of the flow over touches and releases."""
    worst, events = 0.0, 0
    for seed in range(6):
        rng = np.random.default_rng([19, KINDS[kind], seed])
        document = own(kind).sample(rng) | {"run": {"duration": 0.01, "sampling": 1e4, "tolerance": 1e-12}}
        flow = Flow(case_of(document))
        start = flow.start() + 0.3 * flow.natural * rng.uniform(-1.0, 1.0, flow.size) * np.isin(
            np.arange(flow.size), flow.free
        )
        span, free = 2e-3, len(flow.free)
        changes = np.zeros((free, flow.size + flow.impact_count))
        changes[np.arange(free), flow.free] = 1.0
        impact_speeds = flow.go(
            start, 0.0
        ).impact_speeds  # of contacts closed at the start: held, as the derivative holds it
        found = flow.go(start, span, impact_speeds=impact_speeds, changes=changes)
        events += found.events
        sizes = flow.natural[flow.free]
        for at, c in enumerate(flow.free):
            exact = found.changes[at][flow.free] * flow.natural[c] / sizes
            off = np.inf
            for h in (1e-6, 1e-5):  # rounding limits the shorter difference, curvature the longer one
                ends = []
                for s in (1.0, -1.0):
                    y = start.copy()
                    y[c] += s * h * flow.natural[c]
                    ends.append(flow.go(y, span, impact_speeds=impact_speeds))
                if {end.events for end in ends} != {found.events}:
                    break  # another sequence of events: no derivative across it
                differences = (ends[0].state - ends[1].state)[flow.free] / (2.0 * h * sizes)
                off = min(off, float(np.max(np.abs(differences - exact)) / (1.0 + np.max(np.abs(exact)))))
                if off < 1e-5:
                    break
            worst = max(worst, off if np.isfinite(off) else 0.0)
    measured(f"{kind}: derivative through {events} events", worst, "1e-4")
    assert events > 0 or kind in WITHOUT_CONTACTS
    assert worst < 1e-4


def test_dispatch_calls_the_law_of_the_kind_or_the_default() -> None:
    system = SimpleNamespace(
        elements=[SimpleNamespace(kind=number, index=10 + number) for number in range(len(KIND_FILES))]
    )

    def forcing_rate(system: Any, e: int, t: float, y: Any) -> float:
        return -1.0

    laws = SimpleNamespace(forcing_rate=lambda system, n, t, y: 100.0 * n)
    kinds = [registry.Kind(name, file) for name, file in KIND_FILES.items()]
    for number, kind in enumerate(kinds):
        file: Any = SimpleNamespace(**vars(kind.file))
        file.__dict__.pop("forcing_rate", None)
        if number in (0, 2):
            file.forcing_rate = laws.forcing_rate
        kinds[number] = registry.Kind(kind.name, file)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dispatch, "KINDS", tuple(kinds))
        patch.setattr(dispatch, "ORDER", [*kinds[1:], kinds[0]])
        made = dispatch.dispatched(lambda function: function)(forcing_rate)
    found = [made(system, e, 0.0, None) for e in range(len(kinds))]
    assert found == [1000.0, -1.0, 1200.0, *([-1.0] * (len(kinds) - 3))]


def test_a_law_without_a_required_function_is_refused() -> None:
    def springs(system: Any, e: int) -> float:
        return 0.0

    with pytest.raises(TypeError, match=r"parts\.sleeve\.law, .* must have a function springs"):
        dispatch.dispatched(lambda function: function, required=True)(springs)
    whole = vars(registry.KINDS[1].file)
    for word in registry.CONSTANTS:
        part: Any = SimpleNamespace(**{name: item for name, item in whole.items() if name != word})
        part.__name__ = "part"
        with pytest.raises(TypeError, match=word):
            registry.Kind("part", part)


def test_rates_are_those_of_the_penetrations() -> None:
    """Every contact's rate is the derivative of its penetration along the motion."""
    for kind in KINDS:
        for scene in scenes(kind, 10):
            h, n = 1e-7, scene.n
            rotors: Any = scene.system.rotors
            ends = []
            for s in (1.0, -1.0):
                y = scene.y.copy()
                for i in range(n):
                    y[3 * i : 3 * i + 3] += s * h * scene.y[3 * (n + i) : 3 * (n + i) + 3]
                loads = make_loads(scene.system)
                for e in scene.elements:
                    dispatch.contact_kinematics(scene.system, e, s * h, y, scene.branch, loads)
                ends.append(loads.contacts[:, PENETRATION])
            for e in scene.elements:
                dispatch.contact_kinematics(scene.system, e, 0.0, scene.y, scene.branch, scene.loads)
                first = scene.system.elements[e]["contact"]
                rows = slice(first, first + scene.system.elements[e]["contacts"])
                rates = (ends[0][rows] - ends[1][rows]) / (2.0 * h)
                assert np.allclose(rates, scene.loads.contacts[rows, RATE], rtol=1e-5, atol=1e-7), kind
            assert rotors.size == n
