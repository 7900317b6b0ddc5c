"""What is published: the source archive builds a wheel that installs and works in an empty environment."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

CLONE = Path(__file__).resolve().parents[2]
PARTS = (
    "pyproject.toml",
    "README.md",
    "LICENSE",
    "constraints.txt",
    "Makefile",
    "hatch_build.py",
    "src",
    "tests",
    "docs",
)


@pytest.mark.deep
def test_archive_and_wheel_install_and_work_in_an_empty_environment(tmp_path: Path) -> None:
    tree, dist, home = tmp_path / "tree", tmp_path / "dist", tmp_path / "home"
    for folder in (tree, home):
        folder.mkdir()
    for part in PARTS:
        copy = shutil.copytree if (CLONE / part).is_dir() else shutil.copy
        copy(CLONE / part, tree / part)
    environment = {key: value for key, value in os.environ.items() if key.upper().startswith("PIP_")}
    environment |= {"HOME": str(home), "PATH": "/usr/bin:/bin"}

    def call(*words: object, where: Path = tmp_path) -> str:
        done = subprocess.run(
            list(map(str, words)), cwd=where, env=environment, capture_output=True, text=True, timeout=900
        )
        assert done.returncode == 0, done.stderr[-2000:]
        return done.stdout

    call(sys.executable, "-m", "venv", tmp_path / "made")
    python = tmp_path / "made" / "bin" / "python"
    pip = (python, "-m", "pip", "install", "--quiet", "--no-compile", "-c", tree / "constraints.txt")
    call(*pip, "hatchling")
    call(python, "-m", "hatchling", "build", "-t", "sdist", "-d", dist, where=tree)
    (archive,) = dist.glob("*.tar.gz")
    call(python, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", dist, archive)
    (wheel,) = dist.glob("*.whl")
    held = zipfile.ZipFile(wheel).namelist()
    ours = [
        str(path.relative_to(CLONE / "src"))
        for path in (CLONE / "src/gearplay").rglob("*.*")
        if path.is_file()
    ]
    lacking = [name for name in ours if "__pycache__" not in name and name not in held]
    assert [name for name in lacking if "/_library/" not in name] == []
    (library,) = [name for name in held if name.startswith("gearplay/_library/gearplay-")]
    assert "gearplay/_library/gearplay.h" in held
    assert not wheel.name.endswith("-any.whl")
    call(*pip, wheel)
    assert "numba" not in call(python, "-m", "pip", "freeze")
    gearplay = python.with_name("gearplay")
    assert "han2021" in call(gearplay, "copy")
    call(gearplay, "run", "han2021", "--duration", "0.05", "--out", "run.nc")
    assert Path(library).name in call(
        python, "-c", "import gearplay.kernels.library as it; print(it.library()._name)"
    )
    call(gearplay, "plot", "run.nc")
    call(gearplay, "animate", "run.nc")
    done = subprocess.run(
        [gearplay, "serve"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert f"Run: {python} -m pip install 'gearplay[web]'" in done.stderr
