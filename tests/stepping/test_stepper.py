"""`Stepper`: exact motions, nothing lost at communication points, members of a batch like steppers of their own."""

import gc
import operator
import tracemalloc
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.integrate import implicit, members
from gearplay.integrate import run as kernel
from gearplay.model.pack import pack
from gearplay.parts.coupling import law as coupling
from gearplay.solver.flow import Flow
from gearplay.solver.integration import Course
from two_inertias import D1, D2, Exact, Pair

ANGLES = ["motor.theta", "motor.omega", "load.theta", "load.omega"]


def stepped(pair: Pair, **more: Any) -> gp.Stepper:
    """Return a stepper of a pair, at rest in the middle of its play."""
    return gp.Stepper(pair.case(1e-13), inputs=["motor.drive.torque"], outputs=ANGLES, **more)


@pytest.mark.parametrize(("pair", "count"), [(D1, 40), (D2, 100)], ids=["1 ms", "100 us"])
def test_two_inertias_with_play_follow_the_exact_motion(pair: Pair, count: int) -> None:
    """Angles to 1e-14 rad; speeds to the last bits of a touch's time, as damping sets in with a jump."""
    stepper, exact = stepped(pair), Exact(pair)
    for i in range(count):
        found, wanted = stepper.step(pair.dt, [pair.torque(i)]), exact.step(pair.torque(i))
        assert np.abs(found - wanted)[[0, 2]].max() < 1e-14, i
        assert np.abs(found - wanted)[[1, 3]].max() < 6e-12, i


PUBLISHED = {
    "1 ms": (D1, {10: (3.887365100742e-03, 4.916050557130e-01, 3.128673813193e-03, 5.825680658868e-01),
                  40: (1.342758798933e-02, -5.558004079850e-01, 1.077417067052e-02, 3.788346248352e-01)}),
    "100 us": (D2, {50: (-3.597971189992e-03, 1.342142575593e-01, 9.987634873916e-04, 2.216401786525e-02),
                    100: (-1.663341009562e-03, 4.611968729570e+00, 1.690140632896e-03, -2.395693832118e-01)}),
}  # fmt: skip


@pytest.mark.parametrize("name", PUBLISHED)
def test_two_inertias_with_play_meet_the_table_of_the_specification(name: str) -> None:
    pair, rows = PUBLISHED[name]
    stepper = stepped(pair)
    for i in range(max(rows)):
        found = stepper.step(pair.dt, [pair.torque(i)])
        if i + 1 in rows:
            wanted = np.array(rows[i + 1])
            assert np.abs(found - wanted)[[0, 2]].max() < 1e-12
            # The table's last row of speeds is 1e-11 off the matrix exponentials, too.
            assert np.abs(found - wanted)[[1, 3]].max() < (2e-11 if i == 99 else 1e-12)


@pytest.mark.parametrize("dt", [1e-3, 1e-5])
@pytest.mark.parametrize("name", ["han2021", "two-stage-reducer", "planetary-reducer"])
def test_interrupted_motion_is_that_of_one_run(name: str, dt: float) -> None:
    """To 1e-8 m after 10 ms."""
    case = gp.load_case(name)
    stepper = gp.Stepper(case)
    course = Course(case, pack(case), stepper.state)
    course.advance(0.01)
    for _ in range(round(0.01 / dt)):
        stepper.step(dt)
    n = len(case.rotors)
    apart = np.abs(stepper.state - course.state).reshape(-1)[: 3 * n].reshape(n, 3)[:, :2]
    assert apart.max() < 1e-8
    assert stepper.time == pytest.approx(0.01, abs=1e-15)


@pytest.mark.parametrize(
    "name", ["two-stage-reducer", "torsional-train", "external-pair", "planetary-reducer"]
)
def test_communication_points_keep_step_length_and_method(name: str) -> None:
    """Each costs half a step at most: implicit steps of an interval are equally long, some half a millisecond."""
    case = gp.load_case(name)
    stepper, span = gp.Stepper(case), 0.05
    stepper.reset(seed=case.run.seed)
    course = Course(case, pack(case), stepper.state)
    course.advance(span)
    for _ in range(round(span / 1e-3)):
        stepper.step(1e-3)
    counts = counts_of(stepper)
    assert counts[kernel.STEPS] <= course.run.counts[kernel.STEPS] + 0.7 * span / 1e-3
    assert counts[kernel.CALLS] <= 1.1 * course.run.counts[kernel.CALLS]


def test_communication_points_in_free_motion_need_no_new_prediction() -> None:
    """han2021 flies for milliseconds: its next touches stay predicted across the points between."""
    case = gp.load_case("han2021")
    stepper, span = gp.Stepper(case), 0.2
    course = Course(case, pack(case), stepper.state)
    course.advance(span)
    for _ in range(round(span / 1e-3)):
        stepper.step(1e-3)
    assert counts_of(stepper)[kernel.EVENTS] > 0
    assert counts_of(stepper)[kernel.CALLS] <= 1.2 * course.run.counts[kernel.CALLS]


@pytest.mark.parametrize(("tolerance", "error"), [(1e-6, 1e-8), (1e-7, 1e-9), (1e-13, 1e-12)])
def test_errors_of_angles_follow_the_tolerance(tolerance: float, error: float) -> None:
    """The table of docs/stepping.md, over 0.2 s; a torque that changes is no reason to reject a step."""
    stepper, exact = gp.Stepper(D1.case(tolerance), inputs=["motor.drive.torque"], outputs=ANGLES), Exact(D1)
    worst = 0.0
    for i in range(200):
        apart = stepper.step(D1.dt, [D1.torque(i)]) - exact.step(D1.torque(i))
        worst = max(worst, np.abs(apart)[[0, 2]].max())
    assert worst < error
    assert counts_of(stepper)[kernel.REJECTED] < 60


def counts_of(stepper: gp.Stepper) -> Any:
    return stepper._table.column("counts")[0]


def test_free_rotor_takes_up_the_impulse_of_each_step() -> None:
    """J (omega - omega_0) = the integral of the torque, whatever is held."""
    rotor = {
        "mass": 1.0,
        "inertia": 0.02,
        "drive": {"kind": "torque", "torque": 0.0},
        "initial": {"omega": 3.0},
    }
    case = gp.load_case({"rotors": {"disc": rotor}, "run": {"duration": 1.0}})
    stepper = gp.Stepper(case, inputs=["disc.drive.torque"], outputs=["disc.omega", "disc.theta"])
    omega, theta = 3.0, stepper.step(0.0)[1]
    for i, dt in enumerate([1e-3, 1e-9, 0.0, 0.02, 1e-3, 5e-4]):
        torque = 0.3 * (-1) ** i + 0.1
        found = stepper.step(dt, [torque])
        theta += omega * dt + 0.5 * torque / 0.02 * dt**2
        omega += torque / 0.02 * dt
        assert found == pytest.approx([omega, theta], rel=1e-13)


def test_joined_rotors_take_up_the_impulse_together() -> None:
    """Two discs on a shaft without play: closed form of the kernels, whose constant is the torque."""
    disc = {"mass": 1.0, "inertia": 0.01, "drive": {"kind": "torque", "torque": 0.0}}
    case = gp.load_case(
        {
            "rotors": {"a": disc, "b": {**disc, "inertia": 0.03, "drive": {"kind": "torque", "torque": 0.0}}},
            "couplings": [{"between": ["a", "b"], "torsional_stiffness": 900.0}],
            "run": {"duration": 1.0, "tolerance": 1e-10},
        }
    )
    stepper = gp.Stepper(
        case, inputs=["a.drive.torque"], outputs=["a.omega", "b.omega", "a.theta", "b.theta"]
    )
    stepper.step(0.0)
    momentum, twist, rate = 0.0, 0.0, 0.0
    omega = np.sqrt(900.0 * (1.0 / 0.01 + 1.0 / 0.03))
    for i in range(30):
        torque = 0.5 * np.sin(0.7 * i)
        found = stepper.step(1e-3, [torque])
        momentum += torque * 1e-3
        still = torque / 0.01 / omega**2
        c, s = np.cos(omega * 1e-3), np.sin(omega * 1e-3)
        twist, rate = (
            still + (twist - still) * c + rate / omega * s,
            -(twist - still) * omega * s + rate * c,
        )
        assert 0.01 * found[0] + 0.03 * found[1] == pytest.approx(momentum, rel=1e-9, abs=1e-13)
        assert found[2] - found[3] == pytest.approx(twist, rel=1e-7, abs=1e-11)


def test_changed_load_is_that_of_a_changed_case() -> None:
    """From the same state, with contacts closed: the case with the other torque, followed from there."""
    case = gp.load_case("two-stage-reducer", ["rotors.output.load.drag=0.1 N m s/rad"])
    stepper = gp.Stepper(case, inputs=["output.load.torque"])
    stepper.step(3e-3)
    restarted = gp.Stepper(case, inputs=["output.load.torque"])
    restarted.reset(states=stepper.state)
    for each in (stepper, restarted):
        each.step(2e-3, [60.0])
    assert np.abs(stepper.state - restarted.state).max() > 1e-9  # another time, another phase of the teeth
    system = pack(gp.replace(case, {"rotors.output.load.torque": 60.0})).system
    assert stepper._table.shares[0].system.rotors["torque"] == pytest.approx(
        system.rotors["torque"], abs=1e-15
    )


def test_set_points_of_servos_move_while_it_runs() -> None:
    """A speed loop arrives at its new speed, held by its limit on the way: torque over inertia."""
    servo = {
        "kind": "servo", "speed": 10.0, "proportional_gain": 2.0, "integral_gain": 40.0, "torque_limit": 0.5,
    }  # fmt: skip
    case = gp.load_case(
        {"rotors": {"m": {"mass": 1.0, "inertia": 0.01, "drive": servo}}, "run": {"duration": 1.0}}
    )
    stepper = gp.Stepper(case, inputs=["m.drive.speed"], outputs=["m.omega"])
    before = stepper.step(0.1)[0]
    assert before == pytest.approx(10.0, abs=1e-6)
    assert stepper.step(0.05, [30.0])[0] == pytest.approx(10.0 + 0.5 / 0.01 * 0.05, rel=1e-6)
    assert stepper.step(3.0)[0] == pytest.approx(30.0, abs=1e-6)


def test_set_point_of_a_position_servo_moves_while_it_runs() -> None:
    servo = {
        "kind": "position", "angle": 0.1, "proportional_gain": 20.0, "derivative_gain": 1.0, "torque_limit": 5.0,
    }  # fmt: skip
    case = gp.load_case(
        {"rotors": {"m": {"mass": 1.0, "inertia": 0.01, "drive": servo}}, "run": {"duration": 1.0}}
    )
    stepper = gp.Stepper(case, inputs=["m.drive.angle"], outputs=["m.theta"])
    assert stepper.step(3.0)[0] == pytest.approx(0.1, abs=1e-6)
    assert stepper.step(3.0, [0.2])[0] == pytest.approx(0.2, abs=1e-6)


def test_snapshot_brings_back_every_bit() -> None:
    stepper = stepped(D1)
    for i in range(12):
        stepper.step(D1.dt, [D1.torque(i)])
    kept = stepper.snapshot()
    first = [stepper.step(D1.dt, [D1.torque(i)]) for i in range(12, 24)]
    stepper.restore(kept)
    assert np.array_equal(first, [stepper.step(D1.dt, [D1.torque(i)]) for i in range(12, 24)])
    with pytest.raises(gp.InputError, match="of this stepper"):
        stepped(D2).restore(kept)


@pytest.mark.parametrize("threads", [1, 2])
def test_members_of_a_batch_move_as_steppers_of_their_own(threads: int) -> None:
    """Bit for bit, in single steps and in a rollout; inputs of one that stay are not those of its neighbour that change."""
    size, steps = 5, 20
    u = np.repeat(np.random.default_rng(3).uniform(-0.5, 0.5, (steps // 5, size, 1)), 5, axis=0)
    batch = stepped(D1, batch=size, threads=threads)
    start = batch.state
    single = np.array([batch.step(D1.dt, u[i]) for i in range(steps)])
    batch.reset()
    assert np.array_equal(batch.rollout(D1.dt, u), single)
    for m in range(size):
        alone = stepped(D1)
        alone.reset(states=start[m])
        assert np.array_equal(alone.rollout(D1.dt, u[:, m]), single[:, m]), m


def overwrite(share: Any) -> None:
    """Make numbers of everything in a share's run that no member is said to have between its steps."""
    quiet = share.run.implicit.numbers[implicit.IN_USE] == 0
    for name in sorted(members.WITHIN_STEP | (members.WHILE_IMPLICIT if quiet else set())):
        array = operator.attrgetter(name)(share.run)
        array[...] = np.nan if array.dtype.kind in "fc" else 1
    getattr(share.run, members.FIRST_ROW)[1:] = np.nan


@pytest.mark.parametrize("name", ["external-pair", "two-stage-reducer", "han2021", "pinion-idler-ring"])
def test_members_need_no_more_than_the_words_that_are_stored(name: str) -> None:
    """Bit for bit the same where everything else is overwritten between steps; implicit ones, impacts and free motion."""
    case = gp.load_case(name)
    outputs = [f"{list(case.rotors)[-1]}.{signal}" for signal in ("omega", "ax")]
    batch, other = (gp.Stepper(case, outputs=outputs, batch=2, threads=1) for _ in range(2))
    assert batch._table.states.shape[1] < 0.6 * batch._table.shares[0].words.size
    for _ in range(40):
        overwrite(other._table.shares[0])
        assert np.array_equal(batch.step(1e-3), other.step(1e-3))
    assert np.array_equal(batch.state, other.state)


@pytest.mark.parametrize("name", ["han2021", "two-stage-reducer", "planetary-reducer"])
def test_reset__starts_as_a_simulation_does(name: str) -> None:
    """The first member as the case says, the others drawn: a loop around a stepper continues what `simulate` shows."""
    case = gp.load_case(name)
    output, length = f"{list(case.rotors)[-1]}.theta", 4e-3
    stepper, batch = gp.Stepper(case, outputs=[output]), gp.Stepper(case, outputs=[output], batch=3)
    wanted = gp.simulate(case, ensemble=3, duration=length, transient=0.0)
    found = [stepper.reset(), *(stepper.step(1e-3) for _ in range(4))]
    beside = [batch.reset(), *(batch.step(1e-3) for _ in range(4))]
    for m in range(3):
        shown = wanted.signal(output, member=m, sampling=1e3)
        assert np.abs(np.array(beside)[: shown.size, m, 0] - shown).max() < 1e-10, m
        assert m > 0 or np.abs(np.array(found)[: shown.size, 0] - shown).max() < 1e-10


def test_reset__draws_all_members_by_a_seed() -> None:
    batch = gp.Stepper("han2021", outputs=["ring.x"], batch=4)
    first, flow = batch.state, Flow(gp.load_case("han2021"))
    assert np.array_equal(first, [flow.start(member) for member in range(4)])
    batch.reset(seed=gp.load_case("han2021").run.seed)
    assert np.array_equal(batch.state, [flow.start(member) for member in range(1, 5)])
    batch.reset(seed=5)
    other = batch.state
    assert not np.array_equal(first, other)
    batch.reset(seed=5)
    assert np.array_equal(batch.state, other)


def test_failing_member_ends_alone() -> None:
    """A load without end blows one member up; the other goes on, and a single stepper says why."""
    batch = stepped(D1, batch=2)
    for _ in range(3):
        y = batch.step(1.0, [[1e9], [0.0]])
    assert batch.failed.tolist() == [True, False]
    assert np.isnan(y[0]).all()
    assert np.isfinite(y[1]).all()
    assert "beyond all reason" in batch.messages[0]
    alone = stepped(D1)
    with pytest.raises(gp.SimulationError, match="beyond all reason"):
        alone.step(3.0, [1e9])


def test_steps_allocate_nothing() -> None:
    stepper, u, y = stepped(D1), np.array([0.2]), np.zeros(4)
    assert stepper.step(D1.dt, u, out=y) is y
    gc.collect()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    for _ in range(2000):
        stepper.step(1e-4, u, out=y)
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert after - before < 2000  # less than a byte a step: what tracing itself leaves


def test_jacobian_is_the_derivative_of_the_step() -> None:
    """Against central differences, over a step with contacts; nothing moves."""
    stepper = stepped(D1)
    for i in range(9):
        stepper.step(D1.dt, [D1.torque(i)])
    kept, state = stepper.snapshot(), stepper.state
    found = stepper.jacobian(8e-3, [0.4])
    assert np.array_equal(stepper.state, state)
    alone, start = stepped(D1), state
    for column in np.flatnonzero(
        np.array([name.endswith(("theta", "omega")) for name in stepper.state_names])
    ):
        ends = []
        for sign in (1.0, -1.0):
            moved = start.copy()
            moved[column] += sign * 1e-7
            alone.reset(states=moved)
            alone.step(8e-3, [0.4])
            ends.append(alone.state)
        assert (ends[0] - ends[1]) / 2e-7 == pytest.approx(found[:, column], abs=3e-5)
    stepper.restore(kept)
    after = stepper.step(8e-3, [0.4])
    stepper.restore(kept)
    stepper.jacobian(8e-3, [0.4])
    assert np.array_equal(stepper.step(8e-3, [0.4]), after)


def test_centres_at_rest_are_not_integrated_but_have_their_derivatives() -> None:
    """Of two rotors whose centres are held, two states each; d x / d v = dt, as a centre that is given a speed moves."""
    stepper = stepped(D1)
    for i in range(9):
        stepper.step(D1.dt, [D1.torque(i)])
    names, dt = list(stepper.state_names), 8e-3
    x, v = names.index("load.x"), names.index("load.vx")
    found = stepper.jacobian(dt, [0.4])
    assert found[x, v] == pytest.approx(dt, rel=1e-12)
    assert found[v, v] == 1.0
    stepper.step(1e-3, [0.6])
    while not stepper._table.shares[0].run.active_set.active[0]:
        stepper.step(1e-4)
    assert stepper._table.shares[0].run.active_set.states[0] == 4
    start = stepper.state
    start[v] = 0.25
    stepper.reset(states=start)
    stepper.step(dt, [0.4])
    assert stepper.state[x] == pytest.approx(start[x] + 0.25 * dt, rel=1e-12)


def test_pulls_are_searched_for_only_where_the_torque_turns() -> None:
    """A torque that rises or falls at all stages of a step has no maximum inside it."""
    stepper = stepped(D1)
    stepper.step(3e-3, [0.6])
    share = stepper._table.shares[0]
    system, run = share.system, share.run
    motor = 3 * len(system.rotors) + 2
    run.g_0[:], run.g_1[:] = -1e-9, -1e-9

    def returns(rates: Any) -> bool:
        run.stages[:] = 0.0
        run.stages[:, 2], run.stages[:, motor] = rates, 1e-3
        return bool(
            coupling.may_return(
                system, 0, 1, 1e-3, run.branch, run.loads_0, run.loads, run.g_0, run.g_1, run.stages
            )
        )

    assert returns(np.linspace(0.5, -0.5, 7))
    assert returns(np.linspace(0.5, 0.001, 7))
    assert not returns(np.linspace(0.5, 0.3, 7))
    assert not returns(np.linspace(-0.5, -0.3, 7))


NEAR: dict[str, tuple[str, str]] = {
    "outputs rotor": ("otput.theta", "Did you mean 'output.theta'?"),
    "outputs signal": ("output.thetta", "Did you mean 'output.theta'?"),
    "outputs far rotor": (
        "xyz.backlash",
        "Elements with backlash: input-layshaft.wheel, layshaft.pinion-output.",
    ),
    "outputs far signal": ("input-layshaft.wheel.xyz", "Signals of input-layshaft.wheel: "),
    "inputs rotor": ("otput.load.torque", "Did you mean 'output'?"),
    "inputs ending": ("output.torque", "Write output.drive.torque or output.load.torque."),
    "inputs misspelt": ("output.load.torqe", "Write output.load.torque."),
}


@pytest.mark.parametrize("kind", NEAR)
def test_misspelt_names_are_answered_with_the_nearest(kind: str) -> None:
    name, cure = NEAR[kind]
    with pytest.raises(gp.InputError) as found:
        gp.Stepper("two-stage-reducer", **{kind.split()[0]: [name]})
    assert cure in str(found.value)
    assert name in str(found.value)


def test_long_lists_of_rotors_count_the_rest() -> None:
    rotors = {f"r{k:02}": {"mass": 1.0, "inertia": 1e-3} for k in range(15)}
    ends = [("r00", f"r{k:02}") for k in range(1, 15)]
    joined = [{"between": list(each), "torsional_stiffness": 1e3} for each in ends]
    with pytest.raises(gp.InputError, match=r"Rotors: r00, r01, .*, r11 and 3 more\.$"):
        gp.Stepper(
            {"rotors": rotors, "couplings": joined, "run": {"duration": 0.1}}, inputs=["nobody.drive.torque"]
        )


REFUSED: dict[str, Callable[[], Any]] = {
    "inputs = .*must be an input of a rotor": lambda: gp.Stepper("han2021", inputs=["ring.bogus"]),
    "drive of kind speed|one of kind speed": lambda: gp.Stepper("han2021", inputs=["pinion.drive.torque"]),
    "must be given once": lambda: gp.Stepper("han2021", inputs=2 * ["ring.load.torque"]),
    "must be a list of texts": lambda: gp.Stepper("han2021", inputs="ring.load.torque"),
    "outputs = .*must be a signal": lambda: gp.Stepper("han2021", outputs=["ring.bogus"]),
    "turns one way": lambda: gp.Stepper(D1.case(1e-6), inputs=["load.load.torque"]),
    "batch = 0: must be a whole number": lambda: gp.Stepper("han2021", batch=0),
    "must be a time of 0": lambda: gp.Stepper("han2021").step(-1.0),
    "must have shape": lambda: gp.Stepper("han2021").step(1e-3, [1.0]),
    "must be finite": lambda: stepped(D1).step(1e-3, [float("nan")]),
    "u = .*must be numbers": lambda: stepped(D1).step(1e-3, ["x"]),
    "shape \\[18\\]|of shape": lambda: gp.Stepper("han2021").reset(states=np.zeros(3)),
    "seed = -1": lambda: gp.Stepper("han2021").reset(seed=-1),
    "must be 1 for a derivative": lambda: stepped(D1, batch=2).jacobian(1e-3),
}


@pytest.mark.parametrize("words", REFUSED)
def test_bad_arguments_are_refused_in_one_sentence(words: str) -> None:
    with pytest.raises(gp.InputError, match=words):
        REFUSED[words]()
