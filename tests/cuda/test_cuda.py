"""On a CUDA device: the states of the processor, the same ensembles, the same maps. Without a device nothing of this runs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import ks_2samp
from tests.sweep_products import BACKLASH, PLAY, plan_of

import gearplay as gp
from gearplay.model.pack import pack
from gearplay.solver.on_device import cuda
from gearplay.solver.simulate import run_batch
from gearplay.sweeps.running.engines import Engine
from gearplay.vocabulary.errors import InputError


def device_is_missing() -> str:
    try:
        cuda()
    except InputError as error:
        return str(error)
    return ""


pytestmark = pytest.mark.skipif(bool(device_is_missing()), reason=device_is_missing())

LOADED: dict[str, list[str]] = {
    "han2021": [],
    "han2021 loaded": ["gravity.1=-9.81", "rotors.ring.load.torque=1"],
    "external-pair": [],
    "pinion-idler-ring": ["run.duration=2ms"],  # later no two computations agree
}


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
@pytest.mark.parametrize("name", list(LOADED))
def test_positions_after_ten_milliseconds_are_the_processors(name: str, tolerance: float) -> None:
    case = gp.load_case(name.split()[0], ["run.duration=10ms", "run.transient=0", *LOADED[name]])
    case = gp.replace(case, {"run.tolerance": tolerance})
    theirs, ours = (run_batch([(case, range(64))], signals=[], device=d)[0] for d in ("cpu", "cuda"))
    places = slice(3 * len(case.rotors))
    scale = pack(case).natural[places] / pack(case).natural[0]  # angles as ways
    for one, other in zip(ours, theirs, strict=True):
        assert one.status == other.status
        assert np.abs((one.final_state - other.final_state)[places] / scale).max() < 1e-9
        assert len(one.log) == len(other.log)


def test_ensembles_are_alike() -> None:
    case = gp.load_case("han2021", ["run.duration=1s", "run.transient=0.5s", "run.sampling=1kHz"])
    signals = ["ring.x", "ring.vx", "ring.vy"]
    ours = run_batch([(case, range(512))], signals=signals, device="cuda")[0]
    theirs = run_batch([(case, range(512, 1024))], signals=signals)[0]  # other members: nothing may be paired
    readings: dict[str, Any] = {
        "impacts": lambda run: run.statistics.impacts_per_second.sum(),
        "fastest": lambda run: run.statistics.max_impact_speed.max(),
        "play": lambda run: np.std(run.signal("x", "ring")),
        "along": lambda run: np.std(run.signal("vx", "ring")),
        "across": lambda run: np.std(run.signal("vy", "ring")),
    }
    for name, of in readings.items():
        p = ks_2samp([of(run) for run in ours], [of(run) for run in theirs]).pvalue
        assert p > 1e-3, name


def test_a_map_is_that_of_threads(tmp_path: Path) -> None:
    plan = plan_of(PLAY, BACKLASH, members=3)
    ours = gp.sweep(plan, folder=tmp_path / "cuda", engine=Engine("cuda"))
    theirs = gp.sweep(plan, folder=tmp_path / "threads")
    for name in ("rms", "hits"):
        np.testing.assert_allclose(ours.ds[name], theirs.ds[name], rtol=1e-6, atol=1e-9)
