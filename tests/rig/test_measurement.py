"""`measure`: what it simulates, what it says of the record, what it refuses."""

import json
import math
import threading
from typing import Any

import numpy as np
import pytest

from gearplay.model.case import Case
from gearplay.model.reading import load_case, replace
from gearplay.rig.measurement import mean_acceleration, measure
from gearplay.rig.plan import Placement, load_rig
from gearplay.solver.simulate import run_members
from gearplay.vocabulary.errors import InputError, SimulationError

QUIET = {"noise_density": 0.0}


@pytest.fixture(scope="module")
def case() -> Case:
    moving = [
        "rotors.ring.initial.vx = 40 mm/s",
        "rotors.ring.initial.vy = 30 mm/s",
    ]  # so that contacts come soon
    return load_case("han2021", ["run.duration = 20 ms", "run.transient = 10 ms", *moving])


def test_the_mean_acceleration_is_the_increment_of_velocity(case: Case) -> None:
    run = run_members(case, [0], signals=["ring.vx", "ring.vy"], sampling=2e5)[0]
    turned = mean_acceleration(run, Placement("ring", 0.3))
    assert turned.shape == (len(run.time) - 1, 2)
    covered = np.sum(turned, axis=0) / 2e5
    gained = run.values[-1] - run.values[0]
    c, s = math.cos(0.3), math.sin(0.3)
    assert covered == pytest.approx(np.array([c * gained[0] + s * gained[1], c * gained[1] - s * gained[0]]))


def test_lengths_follow_call_then_rig_then_case(case: Case) -> None:
    rig = {"collector": {"duration": "5 ms"}}
    for arguments, samples in (({}, 2000), ({"rig": rig}, 500), ({"rig": rig, "duration": 0.003}, 300)):
        record = measure(case, **arguments)
        assert {c.values.size for c in record.channels} == {samples}
        assert {c.start for c in record.channels} == {0.01}


def test_the_sensors_run_before_the_record(case: Case) -> None:
    """The ideal channel is that of the sampled motion, from the first sample on."""
    record = measure(case, {"accelerometers": {"a": QUIET}})
    run = run_members(case, [0], signals=["ring.vx"], duration=0.02, transient=0.0, sampling=1e6)[0]
    v = run.signal("vx", "ring")
    at = 10_000  # of the record's first sample
    ideal = record.channel("a.acceleration").values
    means = np.array([(v[at + 10 * k + 5] - v[at + 10 * k - 5]) * 1e5 for k in range(1000)])
    scale = np.max(np.abs(means))
    assert scale > 0.0
    assert np.max(np.abs(ideal[:1000] - means)) < 0.1 * scale  # a mean over 10 us against a low-pass
    assert record.channel("a.voltage").values[0] != 0.0  # not at rest


def test_record__has_its_provenance(case: Case) -> None:
    rig = load_rig({"accelerometers": {"a": {}, "b": {"rotor": "pinion", "angle": "90 deg"}}})
    record = measure(case, rig, seed=7, member=2, duration=1e-3)
    about = record.attributes
    assert (about["case_title"], about["case_sha256"]) == (case.title, case.sha256)
    assert (about["seed"], about["member"]) == ("7 2", "2")
    assert (about["a_place"], about["b_place"]) == ("ring, 0 deg from +x", "pinion, 90 deg from +x")
    assert load_rig(json.loads(about["rig"])) == rig
    assert np.all(record.channel("b.acceleration").values == 0.0)  # its centre is fixed
    assert record.source == case.title
    assert all(isinstance(value, str) for value in about.values())


def test_across_is_a_quarter_turn_from_along() -> None:
    """A disc that falls freely, seen along x, y and -y."""
    disc = {"mass": 1.0, "inertia": 1.0, "floating": True}
    falling = load_case({"rotors": {"disc": disc}, "gravity": [0.0, -9.81], "run": {"duration": 5e-3}})
    axes = {"x": 0.0, "y": "90 deg", "down": "-90 deg"}
    sensors = {name: {**QUIET, "rotor": "disc", "angle": angle} for name, angle in axes.items()}
    record = measure(falling, {"accelerometers": sensors})
    x, y, down = (record.channel(f"{name}.acceleration").values[50:] for name in axes)
    assert np.allclose(x, 0.0, atol=1e-6)
    assert np.allclose(y, -9.81, rtol=1e-6)
    assert np.allclose(down, 9.81, rtol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"member": -1}, "member = -1: must be a whole number, 0 or more. Choose another."),
        ({"seed": 1.5}, "seed = 1.5: must be a whole number, 0 or more. Choose another."),
        ({"duration": 0.0}, "duration = 0.0: must be a finite time of at least 1e-05 s. Give seconds."),
        ({"duration": math.inf}, "duration = inf: must be a finite time of at least 1e-05 s. Give seconds."),
        ({"transient": -1.0}, "transient = -1.0: must be a finite time of at least 0 s. Give seconds."),
        ({"rig": {"accelerometers": {"a": {"rotor": "rng"}}}}, "Did you mean 'ring'?"),
        ({"rig": {"collector": {"bits": 0}}}, "collector.bits = 0: must be 2 or more."),
    ],
)
def test_bad_input_is_refused_in_one_sentence(case: Case, arguments: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError) as caught:
        measure(case, **arguments)
    assert says in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_a_run_that_does_not_finish_gives_no_record(case: Case) -> None:
    with pytest.raises(SimulationError, match="max_steps"):
        measure(replace(case, {"run.max_steps": 10}))
    stop = threading.Event()
    stop.set()
    with pytest.raises(KeyboardInterrupt):
        measure(replace(case, {"run.duration": 50.0}), {"collector": {"sampling": "1 kHz"}}, stop=stop)
