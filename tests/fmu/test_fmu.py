"""FMUs: valid, complete, alone, with the numbers of `Stepper`; from Python's importers and from plain C on three platforms."""

import platform
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

import gearplay as gp
from fmu_products import DOCUMENTED, INPUTS, OUTPUTS, stepped, token
from gearplay.kernels.compiled import INTERPRETED
from gearplay.model.pack import pack
from gearplay.solver.integration import Course

pytestmark = pytest.mark.skipif(INTERPRETED or sys.platform != "linux", reason="nothing is compiled here")
HERE = Path(__file__).parent
CASES = {
    "han2021": (["ring.load.torque"], ["ring.x", "ring.y", "ring.theta"]),
    "two-stage-reducer": (INPUTS, OUTPUTS),
    "planetary-reducer": (["stage.carrier.load.torque"], ["stage.sun.x", "stage.sun.y", "stage.planet1.x"]),
}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Export the two-stage reducer as FMUs of both versions, and unpack them: folders ``2`` and ``3``."""
    place = tmp_path_factory.mktemp("fmu")
    tune = ["rotors.output.load.drag", "meshes.0.backlash"]
    for fmi in (2, 3):
        gp.export_fmu(
            "two-stage-reducer", place / f"two{fmi}.fmu", inputs=INPUTS, outputs=OUTPUTS, tune=tune, fmi=fmi
        )
        zipfile.ZipFile(place / f"two{fmi}.fmu").extractall(place / str(fmi))
    return place


def library(made: Path, fmi: int) -> Path:
    (found,) = (made / str(fmi) / "binaries").glob("*/*.so")
    return found


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmu_exports_every_function_and_nothing_else(made: Path, fmi: int) -> None:
    """Those of the standard's header as fmpy carries it, or as the sources have them where fmpy is not installed."""
    file = library(made, fmi)
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", file], check=True, capture_output=True, text=True
    ).stdout
    exported = {line.split()[-1] for line in listed.splitlines()}
    assert len(exported) == {2: 44, 3: 75}[fmi]
    assert all(name.startswith(f"fmi{fmi}") for name in exported)
    fmpy = pytest.importorskip("fmpy")
    header = Path(fmpy.__file__).parent / "c-code" / f"fmi{fmi}FunctionTypes.h"
    wanted = set(re.findall(rf"\b(fmi{fmi}\w+)TYPE\b", header.read_text(encoding="utf-8")))
    assert wanted - exported == set()


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmu_needs_nothing_but_the_c_library(made: Path, fmi: int) -> None:
    said = subprocess.run(["ldd", library(made, fmi)], check=True, capture_output=True, text=True).stdout
    needed = {line.split()[0].split("/")[-1].split(".")[0] for line in said.splitlines()}
    assert needed <= {"linux-vdso", "libm", "libc", "ld-linux-x86-64", "ld-linux-aarch64"}


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_finds_no_fault(made: Path, fmi: int) -> None:
    validation = pytest.importorskip("fmpy.validation")
    assert validation.validate_fmu(str(made / f"two{fmi}.fmu")) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_fmu_has_the_motion_of_a_native_run(name: str, tmp_path: Path) -> None:
    """After 10 ms at steps of 1 ms and 10 us: the numbers of `Stepper`, within 1e-8 m of one run."""
    fmpy = pytest.importorskip("fmpy")
    inputs, outputs = CASES[name]
    file = gp.export_fmu(name, tmp_path / "drive.fmu", inputs=inputs, outputs=outputs)
    start = gp.Stepper(name, inputs=inputs, outputs=outputs)
    values = [start._inputs[0].start]
    case = gp.load_case(name)
    course = Course(case, pack(case), start.state)
    course.advance(0.01)
    names, state = list(start.state_names), course.state
    for dt in (1e-3, 1e-5):
        rows = fmpy.simulate_fmu(
            str(file), stop_time=0.01, step_size=dt, output_interval=dt, start_values={inputs[0]: values[0]}
        )
        found = np.array([rows[-1][output] for output in outputs])
        native = stepped(name, inputs, outputs, values, round(0.01 / dt), dt)
        assert found == pytest.approx(native, abs=1e-9)
        for output, value in zip(outputs, found, strict=True):
            if output.endswith((".x", ".y")):
                assert abs(value - state[names.index(output)]) < 1e-8, (output, dt)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    place = tmp_path_factory.mktemp("hosts")
    for source, name in ((HERE / "host.c", "threads"), (DOCUMENTED, "host")):
        words = [
            compiler,
            "-std=gnu11",
            "-O1",
            "-Wall",
            "-Wextra",
            "-Werror",
            str(source),
            "-o",
            str(place / name),
        ]
        subprocess.run([*words, "-ldl", "-lpthread"], check=True)
    return place


def test_program_of_the_docs_steps_an_fmu(made: Path, compiled: Path) -> None:
    words = ["20", "1e-3", "1=55", "2", "3", "4", "5"]
    done = subprocess.run(
        [compiled / "host", library(made, 3), token(made / "3"), *words],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    native = stepped("two-stage-reducer", INPUTS, OUTPUTS, [55.0], 20, 1e-3)
    assert [float(line) for line in done.stdout.split()] == pytest.approx(native, abs=1e-11)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the page names the folder of this platform")
def test_commands_of_the_page_run_as_they_stand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Export, unpacking, compilation and steps of docs/fmu.md, with the output that it shows."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    page = (DOCUMENTED.parent / "fmu.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```sh\n(gearplay export fmu two-stage-reducer[^`]+)```", page)
    (shown,) = re.findall(r"```text\n([^`]+)```", page)
    (tmp_path / "docs").symlink_to(DOCUMENTED.parent)
    script = block.replace("gearplay ", f"{sys.executable} -m gearplay ").replace(
        "unzip -q -o reducer.fmu -d reducer", f"{sys.executable} -m zipfile -e reducer.fmu reducer"
    )
    done = subprocess.run(["sh", "-ec", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    numbers = [[float(word) for word in text.split()[-2:]] for text in (done.stdout, shown)]
    assert numbers[0] == pytest.approx(numbers[1], rel=1e-5)


def test_errors__are_sentences(made: Path, compiled: Path) -> None:
    def said(*words: str, key: str | None = None) -> str:
        program = [compiled / "host", library(made, 3), key or token(made / "3"), *words]
        done = subprocess.run(program, capture_output=True, text=True, check=False)
        assert done.returncode > 0
        return done.stderr

    assert "the token must be that of this binary" in said("1", "1e-3", key="{0}")
    assert "must be from 0.05 to 0.2" in said("1", "1e-3", "6=3")
    assert "must be given a finite number" in said("1", "1e-3", "1=nan")
    assert "must be that of an input or a parameter" in said("1", "1e-3", "2=1")
    assert "must be that of a variable" in said("1", "1e-3", "99")
    assert "must be a time of 0 to 1e6 s" in said("1", "-1e-3")
    blown = said("20", "0.1", "1=1e12")
    assert re.search(r"left mesh.* Stopped at t = \d\.\d+e-06 s\.", blown)


def test_instances_threads_states_and_memory(made: Path, compiled: Path) -> None:
    """Two instances in two threads like one alone; states back to the bit, damaged ones refused; no byte is left over."""
    program = [compiled / "threads", library(made, 2), token(made / "2"), "20000"]
    done = subprocess.run(program, capture_output=True, text=True, check=True)
    found, left = done.stdout.split()
    assert int(left) == 0
    stepper = gp.Stepper("two-stage-reducer", inputs=INPUTS, outputs=OUTPUTS)
    for n in range(20000):
        native = stepper.step(1e-5, [50.0 + n % 3])
    assert float(found) == pytest.approx(native[0], abs=1e-6)


@pytest.mark.parametrize("change", [(6, "rotors.output.load.drag", 0.17), (7, "meshes.0.backlash", 5e-5)])
def test_parameter_is_the_case_with_that_value(
    made: Path, compiled: Path, change: tuple[int, str, float]
) -> None:
    """Under a torque that presses the back flanks, so that the backlash counts."""
    reference, path, value = change
    words = ["10", "1e-3", "1=-50.0", f"{reference}={value!r}", "2", "3", "4", "5"]
    program = [compiled / "host", library(made, 3), token(made / "3"), *words]
    done = subprocess.run(program, capture_output=True, text=True, check=True)
    case = gp.replace(gp.load_case("two-stage-reducer"), {path: value})
    native = stepped(case, INPUTS, OUTPUTS, [-50.0], 10, 1e-3)
    plain = stepped("two-stage-reducer", INPUTS, OUTPUTS, [-50.0], 10, 1e-3)
    found = np.array([float(line) for line in done.stdout.split()])
    assert found == pytest.approx(native, rel=1e-6, abs=1e-9)
    assert np.abs(found - plain).max() > 1e-7


def test_parameter_that_changes_more_than_numbers_in_proportion_is_refused(tmp_path: Path) -> None:
    for path, words in {
        "meshes.0.module": "in proportion",
        "rotors.output.teeth": "80 is a whole number. Export one FMU for each value of it",
        "rotors.output.load.friction": "must not be 0 in the case",
        "rotors.output.drive": "must have a value in the case",
        "rotors.output.load": "must be a field with a number; the case has a table of",
        "title": 'must be a field with a number; the case has "',
        "run.duration": "must be a field whose change is one of the motion",
        "sleeves.output.radial_clearance": "Start as member 0",
        "rotors.nobody.mass": "must be the path of a field",
    }.items():
        with pytest.raises(gp.InputError, match=words):
            gp.export_fmu("two-stage-reducer", tmp_path / "a.fmu", tune=[path], member=1)
    with pytest.raises(gp.InputError, match="must not change the inertia or the torque"):
        gp.export_fmu(
            "two-stage-reducer", tmp_path / "a.fmu", inputs=INPUTS, tune=["rotors.output.load.torque"]
        )
    assert list(tmp_path.iterdir()) == []


def test_tuned_field_of_a_set__is_named_where_it_is_set(tmp_path: Path) -> None:
    with pytest.raises(gp.InputError, match=r"Give planetary\.stage\.sun\.inertia"):
        gp.export_fmu("planetary-reducer", tmp_path / "a.fmu", tune=["rotors.stage.sun.inertia"])


def test_same_case_gives_the_same_bytes(made: Path, tmp_path: Path) -> None:
    again = gp.export_fmu(
        "two-stage-reducer",
        tmp_path / "two3.fmu",
        inputs=INPUTS,
        outputs=OUTPUTS,
        tune=["rotors.output.load.drag", "meshes.0.backlash"],
    )
    assert again.read_bytes() == (made / "two3.fmu").read_bytes()


HOSTILE = ["""a"; system("true"); // $(touch owned) ??/ é %s%n */ int main a'b`c""", "x\\"]


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_titles_and_names_stay_texts(name: str, tmp_path: Path) -> None:
    """Title and file name come back as they are, and nothing of them is run."""
    case = gp.replace("han2021", {"title": name})
    file = gp.export_fmu(case, tmp_path / f"{name.replace('/', '_')}.fmu", outputs=["ring.x"])
    held = zipfile.ZipFile(file)
    root = Xml.fromstring(held.read("modelDescription.xml"))
    assert root.get("modelName") == name
    identifier = root.find("CoSimulation").get("modelIdentifier")  # type: ignore[union-attr]
    assert re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", identifier or "")
    assert f"binaries/x86_64-linux/{identifier}.so" in held.namelist() or "aarch64" in str(held.namelist())
    assert not Path("owned").exists()
    assert [each.name for each in tmp_path.iterdir()] == [file.name]


def test_command_writes_an_fmu(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from gearplay.cli.main import run

    out = tmp_path / "drive.fmu"
    words = ["export", "fmu", "han2021", "--inputs", "ring.load.torque", "--outputs", "ring.theta,ring.omega"]
    assert run([*words, "--out", str(out)]) == 0
    assert "FMI 3.0" in capsys.readouterr().out
    assert run([*words, "--out", str(out)]) == 2
    assert "must not exist yet" in capsys.readouterr().err
    refused = {
        ("--inputs", "ring.drive.speed"): "--inputs = ",
        ("--outputs", "x;y"): "--outputs = ",
        ("--platforms", "linux64,../../etc"): "--platforms = ",
        ("--tune", "meshes.9.backlash"): "--tune = ",
        ("--fmi", "1"): "--fmi = 1",
    }
    for option, sentence in refused.items():
        assert run([*words[:3], *option, "--out", str(tmp_path / "other.fmu")]) == 2, option
        assert re.match(sentence, capsys.readouterr().err), option
