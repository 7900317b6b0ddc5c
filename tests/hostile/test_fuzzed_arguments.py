"""Public functions with hostile arguments: a result or an error of gearplay within seconds."""

import inspect
import math
import random
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from calibration_problems import PLAN as SMALL
from depth import sized
from gearplay.kernels import compiled_once
from gearplay.vocabulary.errors import GearplayError
from rexs.gearbox_files import PLANETARY

pytestmark = pytest.mark.hostile

CALLS = sized(5000)
LONG = {"export_fmu": 4, "lyapunov": 4, "validate": 4}
"""Functions whose valid calls take seconds: so many times fewer calls."""
LONGEST = 3.0
"""Of one call [s]: longer work is stopped, as Ctrl-C would."""
SOON = 15.0
"""When what is stopped has to end [s], on a busy machine."""
SHORT = {"run.duration": 0.01, "run.transient": 0.0, "run.sampling": 1e4}
PLAN = SMALL | {
    "parameters": SMALL["parameters"][:1],
    "models": SMALL["models"][:1],
    "effort": SMALL["effort"] | {"evaluations": 8, "startup": 8, "polish": 0},
}


def valid(folder: Path) -> dict[str, dict[str, Any]]:
    """Return arguments of each public function that work, so small that a call is short."""
    short = gp.replace(gp.load_case("han2021"), SHORT)
    pair = gp.torsional_pair(0.8, mean_force=0.1, force=0.05)
    backlash = "meshes.0.backlash"
    record = gp.Record((gp.Channel("acc", np.sin(np.arange(256.0)), 1000.0, "m/s^2"),))
    gp.write_record(record, folder / "record.h5")
    gp.simulate(short).save(folder / "run.nc")
    force, at = "pinion-ring.transmission_error", ["ring.x"]
    pressed = gp.load_case("external-pair")
    return {
        "basins": {
            "case": pair,
            "first": ("wheel.theta", -1e-3, 1e-3, 3),
            "second": ("wheel.omega", -5.0, 5.0, 3),
            "settle": 5,
        },
        "bifurcation": {
            "case": short,
            "path": backlash,
            "values": ["90 um", "100 um"],
            "signals": ["ring.x"],
            "settle": 2,
            "keep": 2,
            "period": "mesh",
        },
        "branch": {"case": pair, "path": "run.duration", "low": 0.5, "high": 1.0, "settle": 5, "orbits": 3},
        "branches": {"case": pair, "path": "run.duration", "low": 0.5, "high": 1.0, "settle": 5, "orbits": 3},
        "calibrate": {"plan": PLAN, "folder": folder / "calibration"},
        "campbell": {"case": pressed, "speeds": [10.0, 20.0]},
        "check_case": {"case": short},
        "export_dxf": {"case": short, "path": folder / "gears.dxf", "overwrite": True},
        "export_fmu": {
            "case": short,
            "path": folder / "drive.fmu",
            "outputs": ["ring.x"],
            "tune": ["rotors.ring.mass"],
            "overwrite": True,
        },
        "diagnose": {
            "record": gp.Channel("acc", np.sin(np.arange(4096.0)), 1000.0, "m/s^2"),
            "teeth": "10:20",
            "bearings": ["8, 7.9mm, 33.5mm"],
            "speed": "600 rpm",
        },
        "frequency_response": {
            "case": pressed,
            "force": force.replace("pinion-ring", "input-output"),
            "at": ["input.x"],
            "frequencies": [10.0, 20.0],
        },
        "impacts": {"case": short, "signals": at, "contact": "ring", "duration": 0.05, "transient": 0.0},
        "import_rexs": {"path": PLANETARY, "gear_bodies": "solid", "allowance": "c25"},
        "load_case": {"source": "han2021", "overrides": ["run.seed=3"]},
        "load_plan": {"source": PLAN},
        "load_sharing": {"source": "planetary-reducer"},
        "describing_function": {"case": pressed, "at": "output", "hold": "input", "torque": 5.0},
        "lost_motion": {"case": pressed, "at": "output", "hold": "input", "torque": 5.0},
        "lyapunov": {"case": pair, "count": 1, "duration": 0.5, "transient": 0.1},
        "make_dataset": {
            "plan": {
                "case": short.resolved(),
                "rig": {"collector": {"sampling": "20 kHz"}},
                "classes": [{"label": "a"}, {"label": "b", "set": {backlash: "120 um"}}],
                "axes": [{"name": "seed", "path": "run.seed", "values": [1, 2]}],
                "split": {"train": 0.5, "validation": 0.0, "test": 0.5},
            },
            "folder": folder / "records",
        },
        "measure": {"case": short, "duration": 0.01, "transient": 0.0},
        "modes": {"case": pressed},
        "motion": {"case": pair, "periods": 100, "settle": 5, "ensemble": 4, "compare": False},
        "periodic_orbit": {"case": pair, "settle": 20},
        "planetary": {"name": "stage"},
        "portrait": {"case": short, "settle": 2, "keep": 3, "show": 2},
        "read_measurement": {"path": folder / "record.h5"},
        "read_result": {"path": folder / "run.nc"},
        "reduce": {"case": pressed, "at": "output", "hold": "input", "torque": 5.0},
        "replace": {"case": short, "changes": {backlash: "120 um"}},
        "section": {"case": short, "signals": at, "keep": 3, "settle": 1, "period": "mesh"},
        "teeth": {"source": short, "mesh": "pinion-ring"},
        "view": {"source": short, "window": (0.0, 0.005), "at": "ring", "magnify": 1.0},
        "simulate": {"case": short, "ensemble": 2},
        "sweep": {
            "case": short,
            "axes": {backlash: ["50 um", "100 um"]},
            "reduce": [{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}],
        },
        "torsional_pair": {"frequency": 0.8},
        "validate": {},
        "wear": {
            "case": gp.replace("han2021", {"sleeves.ring.wear": {"coefficient": 1e-16, "length": 0.01}}),
            "turns": 1e5,
            "blocks": 1,
        },
        "write_record": {"record": record, "path": folder / "again.h5", "overwrite": True},
    }


def hostile(rng: random.Random) -> Any:
    """Return a value that hardly any argument is made for."""
    makers: list[Callable[[], Any]] = [
        lambda: rng.choice(
            [None, True, False, "", "x", "ring.x", "nan", "1 furlong", "\x00", "../..", "a" * 5000]
        ),
        lambda: rng.choice([0, -1, 1, 2, 7, 10**6, 10**12, 10**40, -(10**9)]),
        lambda: rng.choice([0.0, -0.0, 0.5, -1.5, 1e-300, 1e-9, 1e9, 1e300, math.nan, math.inf, -math.inf]),
        lambda: rng.choice(
            [b"", b"bytes", 1j, Fraction(1, 3), object(), type, len, range(3), {1, 2}, slice(3)]
        ),
        lambda: rng.choice(
            [[], [None], [[]], ["ring.x", 3], {}, {"a": 1}, {1: 2}, (), ("x", 0.0, 1.0, 2), [1e300]]
        ),
        lambda: rng.choice(
            [np.nan, np.float32(1.5), np.int8(-3), np.array([]), np.zeros((2, 2)), np.array("text")]
        ),
        lambda: [hostile(rng) for _ in range(rng.randrange(3))],
    ]
    return rng.choice(makers)()


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Raise `TimeoutError` in what takes longer."""

    def late(signum: int, frame: object) -> None:
        raise TimeoutError(f"longer than {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def calls(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    return valid(tmp_path_factory.mktemp("calls"))


FUNCTIONS = [name for name in gp.__all__ if inspect.isfunction(getattr(gp, name))]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_answers_or_refuses(
    name: str,
    calls: dict[str, dict[str, Any]],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    tried: Callable[[int], None],
) -> None:
    """Arguments that hardly any function is made for: an answer, or an error of gearplay's own, within seconds."""
    monkeypatch.chdir(tmp_path)
    function, given = getattr(gp, name), calls[name]
    if name not in ("branch", "branches", "calibrate", "planetary"):
        function(**given)
    names = list(inspect.signature(function).parameters)
    rng = random.Random(name)
    calls_of_it = max(2, CALLS // len(FUNCTIONS) // LONG.get(name, 1))
    for _ in range(calls_of_it):
        these = dict(given)
        for argument in rng.sample(names, rng.choice([1, 1, 1, 2]) if len(names) > 1 else 1):
            these[argument] = (
                3 if argument == "progress" else hostile(rng)
            )  # a function that fails is its author's
        if rng.random() < 0.05:
            these[rng.choice(["setle", "x", "dur"])] = hostile(rng)
        begun = time.monotonic()
        try:
            with within(LONGEST):
                function(**these)
        except GearplayError:
            continue
        except TimeoutError:
            assert time.monotonic() - begun < SOON, these
        except Exception as error:
            changed = {key: value for key, value in these.items() if given.get(key) is not value}
            raise AssertionError(f"{name}({changed!r:.300}): {type(error).__name__}: {error}") from error
    tried(calls_of_it)


ASKING = [
    lambda: gp.section("han2021", ["ring.x"], keep=10**12),
    lambda: gp.portrait("han2021", keep=10**9),
    lambda: gp.bifurcation("han2021", "meshes.0.backlash", [1e-4] * 10**7, ["ring.x"]),
    lambda: gp.basins("han2021", ("ring.x", -1e-4, 1e-4, 10**5), ("ring.y", -1e-4, 1e-4, 10**5)),
    lambda: gp.lyapunov("han2021", duration=1e9),
    lambda: gp.simulate("han2021", duration=1e6, ensemble=1000),
    lambda: gp.impacts("han2021", ["ring.x"], "pinion-ring:drive", duration=1e6, transient=1e6),
    lambda: gp.campbell("external-pair", [0.0] * 10**7),
    lambda: gp.frequency_response(
        "external-pair", force="input.torque", at="input.theta", frequencies=np.zeros(10**8, dtype=np.int8)
    ),
    lambda: gp.motion("han2021", periods=10**12),
]


@pytest.mark.slow
@pytest.mark.parametrize("ask", ASKING, ids=range(len(ASKING)))
def test_excessive_work__is_refused_with_an_estimate(
    ask: Callable[[], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within a second, on a machine that does nothing else; no kernel is called before."""

    def looked(*_: object) -> None:
        raise AssertionError("a kernel was called")

    monkeypatch.setattr(compiled_once.Kernel, "__call__", looked)
    with within(6.0), pytest.raises(gp.ResourceError, match=r"\d"):
        ask()


def test_every_function_is_tried(calls: dict[str, dict[str, Any]]) -> None:
    assert set(FUNCTIONS) == set(calls)
