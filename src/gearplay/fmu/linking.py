"""Shared libraries of an FMU: the C sources of the package and the data of a case, linked with the kernels of a platform."""

import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Final, NamedTuple

from gearplay.build.archive import static_library
from gearplay.build.linking import linker
from gearplay.kernels.library import LibraryError
from gearplay.vocabulary.errors import InputError

SOURCES: Final = Path(__file__).with_name("c")


class Platform(NamedTuple):
    """A platform: its name in `gearplay.build.targets`, its folders in an FMU of version 2 and 3, the suffix of libraries."""

    target: str
    folder_2: str
    folder_3: str
    suffix: str


PLATFORMS: Final = {
    "linux64": Platform("linux-x86_64", "linux64", "x86_64-linux", ".so"),
    "win64": Platform("windows-x86_64", "win64", "x86_64-windows", ".dll"),
    "aarch64-linux": Platform("linux-aarch64", "aarch64-linux", "aarch64-linux", ".so"),
}


def platform(name: str) -> Platform:
    """Return a platform by its name; `InputError` for another."""
    if name not in PLATFORMS:
        raise InputError.of("platforms", name, f"must be of {', '.join(PLATFORMS)}", "Choose some of these")
    return PLATFORMS[name]


def link_fmu(target: str, version: int, texts: Mapping[str, str], name: str, suffix: str) -> bytes:
    """Return the shared library of an FMU for a platform; ``texts`` are the written sources by their file names.

    Raises `LibraryError` where nothing can link it.
    """
    kernels, compiler = static_library(target), linker(target)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for file, text in texts.items():
            (folder / file).write_text(text, encoding="ascii")
        made = folder / f"library{suffix}"
        flags = ["-std=gnu11", "-O2", "-shared", "-fvisibility=hidden", "-Wall", "-s"]
        if suffix == ".so":
            exported = folder / "exported"
            exported.write_text(f"{{ global: fmi{version}*; local: *; }};\n", encoding="ascii")
            flags += ["-fPIC", f"-Wl,--version-script={exported}", "-Wl,-z,now", "-Wl,-z,noexecstack"]
        units = [SOURCES / "model.c", SOURCES / f"fmi{version}.c", folder / "data.c"]
        words = [*compiler, *flags, f"-I{folder}", f"-I{SOURCES}", *map(str, units), str(kernels)]
        words += ["-o", str(made), *(["-lm"] if suffix == ".so" else [])]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode != 0 or not made.exists():
            lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
            raise LibraryError(f"The FMU {name} cannot be linked for {target}: {lines[-1]}")
        return made.read_bytes()
