"""Files of runs that were damaged or crafted: refused in one sentence, or the motion itself; never a crash, never a hang."""

import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import gearplay as gp
from depth import sized
from gearplay.files.atomic import LENGTH, with_checksum
from gearplay.solver import stored_motion
from gearplay.solver.checkpoints import states
from gearplay.vocabulary.errors import InputError

pytestmark = pytest.mark.hostile
DAMAGED, CRAFTED = sized(600, 60, torture=5000), sized(400, 40, torture=5000)
COUPLING = {
    "title": "stages",
    "rotors": {
        "a": {"mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": "60 rpm"}},
        "b": {"mass": 1.0, "inertia": 1e-3, "load": {"torque": 1.0}},
    },
    "couplings": [
        {"between": ["a", "b"], "torque": [[0.0, 0.0], [0.01, 1.0], [0.03, 5.0]], "torsional_damping": 0.1}
    ],
    "run": {"duration": 0.05, "transient": 0.0},
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("whole") / "run.nc"
    gp.simulate("two-stage-reducer", duration=0.05, transient=0.01).save(place)
    return place


def crafted(place: Path, to: Path, change: Callable[[h5py.File], None]) -> Path:
    """Write a file with a change and the digest that belongs to it."""
    content = io.BytesIO(place.read_bytes()[:-LENGTH])
    with h5py.File(content, "r+") as file:
        change(file)
    to.write_bytes(with_checksum(content.getvalue()))
    return to


@pytest.mark.filterwarnings("ignore")
def test_stored_motion__damage_is_refused(whole: Path, tmp_path: Path, tried: Callable[[int], None]) -> None:
    content, generator, place = whole.read_bytes(), np.random.default_rng(3), tmp_path / "run.nc"
    said: set[str] = set()
    expected = gp.read_result(whole).signal("output.omega")
    for turn in range(DAMAGED):
        damaged = bytearray(content)
        at = int(generator.integers(len(content)))
        if turn % 3 == 0:
            damaged[at] ^= 1 << int(generator.integers(8))
        elif turn % 3 == 1:
            del damaged[at:]
        else:
            damaged[at : at + 64] = bytes(64)
        place.write_bytes(damaged)
        if damaged == content:
            continue
        try:
            np.testing.assert_array_equal(gp.read_result(place).signal("output.omega"), expected)
        except InputError as error:
            said.add(str(error))
    tried(DAMAGED)
    assert not [words for words in said if "\n" in words]


def places_of(place: Path) -> dict[str, tuple[str, int]]:
    """Return table and row of the first number of each array of a checkpoint."""
    samples: Any = gp.read_result(place).runs[0].samples
    arrays = states(stored_motion._course(samples.motion).run)
    found: dict[str, tuple[str, int]] = {}
    for kind, table in (("i", "integers"), ("f", "floats")):
        row = 0
        for name in stored_motion._stored(arrays, kind):
            found[name] = (table, row)
            row += arrays[name].size
    return found


def put(name: str, row: int, value: float) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file["motion"][name][row, -1] = value

    return change


INTEGERS = {
    "active_set.body_states": (-1, 3, 1 << 40),
    "active_set.element_states": (-1, 3),
    "branch.modes": (-1, 3, 1 << 62),
    "implicit.numbers": (-1, (1 << 53) + 1),
    "counts": (-2, (1 << 53) + 1),
}
FLOATS = {
    "active_set.since": (-1.0, 1e9, np.nan),
    "active_set.due": (-1.0, np.nan),
    "active_set.origin": (1e300, np.inf),
    "clock": (-1.0, 1e9, np.nan, np.inf),
    "y": (1e300, -np.inf),
    "stages": (np.nan,),
    "implicit.positions": (np.inf,),
}


@pytest.mark.parametrize("name", [*INTEGERS, *FLOATS])
def test_a_number_that_no_run_has_is_refused(name: str, whole: Path, tmp_path: Path) -> None:
    table, row = places_of(whole)[name]
    for value in {**INTEGERS, **FLOATS}[name]:
        place = crafted(whole, tmp_path / "run.nc", put(table, row, value))
        with pytest.raises(
            InputError, match=r"must be a readable result file \(a (number|time|state) of "
        ) as caught:
            gp.read_result(place)
        assert "\n" not in str(caught.value)


def test_the_stage_of_a_coupling_is_a_row_of_its_table(tmp_path: Path) -> None:
    gp.simulate(COUPLING).save(tmp_path / "whole.nc")
    samples: Any = gp.read_result(tmp_path / "whole.nc").runs[0].samples
    record = samples.motion.packed.system.records[stored_motion.COUPLING][0]
    assert record.stages > 0
    table, row = places_of(tmp_path / "whole.nc")["branch.modes"]
    for stage in (int(record.stages), -1, 10**6):
        change = put(table, row + int(record.mode), stage)
        with pytest.raises(InputError, match=r"branch\.modes"):
            gp.read_result(crafted(tmp_path / "whole.nc", tmp_path / "run.nc", change))


def without(name: str) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file["motion"][name]

    return change


def replaced(name: str, make: Callable[[np.ndarray], np.ndarray]) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        values = make(file["motion"][name][...])
        del file["motion"][name]
        file["motion"][name] = values

    return change


def member(column: int, value: int) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file["motion"]["run_integers"][0, column] = value

    return change


def other_contact(file: h5py.File) -> None:
    member(2, 1)(file)
    replaced("log", lambda _: np.array([[0.02], [99.0], [1.0], [0.1]]))(file)


def elsewhere(file: h5py.File) -> None:
    del file["motion"]["log"]
    file["motion"]["log"] = h5py.ExternalLink("/etc/passwd", "/log")


def raw_elsewhere(file: h5py.File) -> None:
    shape = file["motion"]["log"].shape
    del file["motion"]["log"]
    file["motion"].create_dataset("log", shape, "f8", external=[("/etc/passwd", 0, h5py.h5f.UNLIMITED)])


CHANGES: dict[str, tuple[Callable[[h5py.File], None], str]] = {
    "missing table": (without("floats"), "lacks the dataset floats"),
    "missing group": (lambda file: file.move("motion/log", "log"), "lacks the dataset log"),
    "other type": (replaced("integers", lambda a: a.astype("f8")), "not one of i8"),
    "32 bits": (replaced("floats", lambda a: a.astype("f4")), "not one of f8"),
    "fewer rows": (replaced("floats", lambda a: a[:-1]), "not one of f8 of shape"),
    "fewer checkpoints": (replaced("floats", lambda a: a[:, :-1]), "not one of f8 of shape"),
    "no checkpoint": (member(1, 0), "not one of i8 of shape"),
    "a billion checkpoints": (member(1, 1 << 40), "not one of i8 of shape"),
    "a billion changes": (member(2, 1 << 50), "not one of f8 of shape"),
    "no member": (replaced("run_integers", lambda a: a[:0]), "a number of its members"),
    "two members": (replaced("run_integers", lambda a: np.concatenate([a, a])), "a number of its members"),
    "status": (member(3, 77), "77 is not a valid Status"),
    "mesh": (member(4, 9), "a number of its members"),
    "counter": (member(5, -1), "a number of its members"),
    "reached": (replaced("run_floats", lambda a: a * 0.5), "did not reach what their status says"),
    "contact": (other_contact, "contact log has impossible changes"),
    "other file": (elsewhere, "lacks the dataset log"),
    "other raw file": (raw_elsewhere, "lies elsewhere"),
    "order": (replaced("floats", lambda a: a[:, ::-1]), "readable result file"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_tables_that_do_not_fit_are_refused(name: str, whole: Path, tmp_path: Path) -> None:
    change, words = CHANGES[name]
    with pytest.raises(InputError, match=words) as caught:
        gp.read_result(crafted(whole, tmp_path / "run.nc", change))
    assert "\n" not in str(caught.value)


def test_stored_motion__of_another_case_is_refused(whole: Path, tmp_path: Path) -> None:
    """A velocity off by a part in a million: the replay does not arrive at the next checkpoint."""

    def change(file: h5py.File) -> None:
        samples: Any = gp.read_result(whole).runs[0].samples
        count = len(samples.motion.marks)
        assert count > 2
        table, row = places_of(whole)["y"]
        rows = slice(row, row + samples.motion.packed.state_size)
        file["motion"][table][rows, count // 2] *= 1.0 + 1e-6

    back = gp.read_result(crafted(whole, tmp_path / "run.nc", change))
    with pytest.raises(
        InputError, match=r"must hold the motion that this machine computes.*gearplay export"
    ) as caught:
        back.signal("output.ax")
    assert "\n" not in str(caught.value)


FUZZ = """
import sys
import h5py, io, numpy as np
import gearplay as gp
from gearplay.files.atomic import LENGTH, with_checksum
from pathlib import Path

whole, place = (Path(word) for word in sys.argv[1:3])
content, random = whole.read_bytes()[:-LENGTH], np.random.default_rng(int(sys.argv[3]))
fine = refused = 0
for _ in range(int(sys.argv[4])):
    part = io.BytesIO(content)
    with h5py.File(part, "r+") as file:
        table = file["motion"][random.choice(["integers", "floats", "floats", "run_integers", "run_floats"])]
        values = table[...]
        for _ in range(random.integers(1, 4)):
            at = tuple(random.integers(size) for size in values.shape)
            own = values[at]
            choices = [0, 1, 2, 3, -1, 5, 17, 2**31, 2**53, -(2**53), own + 1, own - 1]
            if values.dtype.kind == "f":
                choices = [0.0, -1.0, 1.0, 1e300, -1e300, 1e-300, 1.5 * own, -own, 1e9, 1e5, 1e-5, own * (1 + 1e-12)]
            values[at] = random.choice(choices)
        table[...] = values
    place.write_bytes(with_checksum(part.getvalue()))
    try:
        result = gp.read_result(place)
        result.signal("omega", list(result.case.rotors)[-1], window=(0.03, 0.06))
        result.runs[0].values
        fine += 1
    except gp.GearplayError as error:
        assert len(str(error).splitlines()) == 1
        refused += 1
print(fine, refused)
"""


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_stored_motion__changed_numbers_crash_nothing(
    seed: int, whole: Path, tmp_path: Path, tried: Callable[[int], None]
) -> None:
    """In a process of its own: a crash is one there."""
    words = [str(whole), str(tmp_path / "run.nc"), str(seed), str(CRAFTED)]
    done = subprocess.run(
        [sys.executable, "-c", FUZZ, *words], capture_output=True, text=True, timeout=120 + 3 * CRAFTED
    )
    assert done.returncode == 0, done.stderr
    fine, refused = map(int, done.stdout.split())
    assert fine + refused == CRAFTED
    assert refused > 0.2 * CRAFTED
    tried(CRAFTED)
