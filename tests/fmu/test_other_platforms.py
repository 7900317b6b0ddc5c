"""FMUs of other platforms, by their emulators: the motion of this one."""

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import gearplay as gp
from fmu_products import DOCUMENTED, INPUTS, OUTPUTS, stepped, token
from gearplay.build.archive import static_library
from gearplay.fmu.linking import PLATFORMS, SOURCES
from gearplay.kernels.compiled import INTERPRETED

pytestmark = pytest.mark.skipif(INTERPRETED or sys.platform != "linux", reason="nothing is compiled here")


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.deep
def test_windows_fmu_has_the_same_motion(fmi: int, tmp_path: Path) -> None:
    """Under wine, from the program of the docs: its C library has other sines, and the last bits differ."""
    pytest.importorskip("ziglang")
    wine = shutil.which("wine64") or shutil.which("wine64", path="/usr/lib/wine")
    if wine is None:
        pytest.skip("no wine64")
    file = gp.export_fmu(
        "two-stage-reducer",
        tmp_path / "two.fmu",
        inputs=INPUTS,
        outputs=OUTPUTS,
        fmi=fmi,
        platforms=list(PLATFORMS),
    )
    zipfile.ZipFile(file).extractall(tmp_path)
    (dll,) = (tmp_path / "binaries").glob("*/*.dll")
    assert dll.parent.name == {2: "win64", 3: "x86_64-windows"}[fmi]
    if fmi == 2:
        return
    host = tmp_path / "host.exe"
    subprocess.run(
        [
            sys.executable,
            "-m",
            "ziglang",
            "cc",
            "-target",
            "x86_64-windows-gnu",
            "-O1",
            str(DOCUMENTED),
            "-o",
            str(host),
        ],
        check=True,
    )
    words = ["10", "1e-3", "1=55", "2", "3", "4", "5"]
    done = subprocess.run(
        [wine, host, dll, token(tmp_path), *words], capture_output=True, text=True, check=True, timeout=600
    )
    native = stepped("two-stage-reducer", INPUTS, OUTPUTS, [55.0], 10, 1e-3)
    assert [float(line) for line in done.stdout.split()] == pytest.approx(native, abs=1e-9)


@pytest.mark.deep
def test_arm_fmu_has_the_same_motion(tmp_path: Path) -> None:
    """Under qemu, linked with a program into one: the emulator has no C library of that processor to load it with."""
    pytest.importorskip("ziglang")
    qemu = shutil.which("qemu-aarch64")
    if qemu is None:
        pytest.skip("no qemu-aarch64")
    file = gp.export_fmu(
        "two-stage-reducer", tmp_path / "two.fmu", inputs=INPUTS, outputs=OUTPUTS, platforms=["aarch64-linux"]
    )
    zipfile.ZipFile(file).extractall(tmp_path)
    written = tmp_path / "extra" / "gearplay"
    program = tmp_path / "program.c"
    text = DOCUMENTED.read_text(encoding="utf-8")
    names = sorted(set(re.findall(r'"(fmi3\w+)"\)', text)))
    table = "".join(f'if (strcmp(name, "{name}") == 0) return (void *){name};\n' for name in names)
    declared = "".join(f"void {name}(void);\n" for name in names)
    text = text.replace(
        "#include <dlfcn.h>", f"{declared}static void *own(const char *name) {{ {table} return 0; }}"
    )
    text = text.replace("dlopen(file, RTLD_NOW | RTLD_LOCAL)", "(void *)file").replace(
        "dlsym(library, name)", "own(name)"
    )
    program.write_text(text, encoding="utf-8")
    units = [
        program,
        SOURCES / "model.c",
        SOURCES / "fmi3.c",
        written / "data.c",
        static_library("linux-aarch64"),
    ]
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", "aarch64-linux-musl", "-static", "-O1"]
    subprocess.run(
        [*zig, f"-I{written}", f"-I{SOURCES}", *map(str, units), "-lm", "-o", str(tmp_path / "host")],
        check=True,
    )
    words = ["10", "1e-3", "1=55", "2", "3", "4", "5"]
    done = subprocess.run(
        [qemu, tmp_path / "host", "x", token(tmp_path), *words],
        capture_output=True,
        text=True,
        check=True,
        timeout=600,
    )
    native = stepped("two-stage-reducer", INPUTS, OUTPUTS, [55.0], 10, 1e-3)
    assert [float(line) for line in done.stdout.split()] == pytest.approx(native, abs=1e-9)
