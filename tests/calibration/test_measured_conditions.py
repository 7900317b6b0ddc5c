from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calibration_problems import small_plan
from gearplay.calibration.objective import measurements_of
from gearplay.files.measurements import write_record
from gearplay.files.record import Channel, Record
from gearplay.vocabulary.errors import InputError

RATE = 5000.0  # ten times the plan's
T = np.arange(int(8.0 * RATE)) / RATE
TONES = 0.3 * np.sin(2 * np.pi * 5.0 * T) + 0.2 * np.sin(2 * np.pi * 20.0 * T)


def plan_of(record: str, **changes: Any) -> Any:
    return small_plan(
        conditions=[{"name": "slow", "set": {"rotors.pinion.drive.speed": "60 rpm"}, "record": record}],
        targets=[
            {"kind": "hump", "name": "radial", "band": [2.0, 12.0], "width": 0.03},
            {"kind": "line", "name": "mesh", "order": 1, "search": 0.1},
            {"kind": "statistic", "name": "hits", "statistic": "impacts_per_second", "contact": "ring"},
        ],
        simulation={"members": 2, "duration": "2 s", "transient": "0.1 s", "sampling": "500 Hz"},
        **changes,
    )


def saved(folder: Path, values: Any, *, rate: float = RATE, unit: str = "m/s^2") -> str:
    write_record(Record((Channel("acc", np.asarray(values), rate, unit),)), folder / "r.h5", overwrite=True)
    return "r.h5"


def test_a_record_is_read_as_the_simulation_is(tmp_path: Path) -> None:
    seen = measurements_of(plan_of(saved(tmp_path, TONES)), tmp_path)["slow"]
    assert set(seen) == {"radial", "mesh"}  # an accelerometer does not see single contacts
    assert seen["mesh"]["frequency"].value == pytest.approx(20.0, abs=0.05)
    # The mean over 1/500 s loses sinc(20 / 500) = 0.26 %.
    assert seen["mesh"]["amplitude"].value == pytest.approx(0.2 * np.sinc(20.0 / 500.0), rel=5e-3)
    assert seen["radial"]["frequency"].value == pytest.approx(5.0, abs=0.1)


def test_units_of_acceleration_are_converted(tmp_path: Path) -> None:
    si = measurements_of(plan_of(saved(tmp_path, TONES)), tmp_path)["slow"]["mesh"]["amplitude"].value
    small = measurements_of(plan_of(saved(tmp_path, 1e3 * TONES, unit="mm/s^2")), tmp_path)
    assert small["slow"]["mesh"]["amplitude"].value == pytest.approx(si)
    gravities = measurements_of(plan_of(saved(tmp_path, TONES / 9.80665, unit="g")), tmp_path)
    assert gravities["slow"]["mesh"]["amplitude"].value == pytest.approx(si)


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"unit": "V"}, "must have a unit of acceleration"),
        ({"rate": 5100.0}, "must be sampled at a multiple of simulation.sampling = 500 Hz, not at 5100 Hz"),
        ({"rate": 50_000.0}, "must be at least 2 s long"),
    ],
)
def test_records_that_do_not_fit_are_named(tmp_path: Path, how: dict[str, Any], words: str) -> None:
    plan = plan_of(saved(tmp_path, TONES, **how))
    with pytest.raises(InputError, match=words):
        measurements_of(plan, tmp_path)


def test_a_missing_record_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.csv"):
        measurements_of(plan_of("nothing.csv"), tmp_path)
