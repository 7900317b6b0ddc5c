"""Linking of the object files to one shared library, by the system's C compiler or by zig's."""

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from gearplay.build.targets import TARGETS, host
from gearplay.kernels.library import SOURCES, LibraryError, content_digest


def system_compiler(target: str) -> str | None:
    """Return the system's C compiler if it can link for a platform; None where zig links."""
    if target != host() or sys.platform == "win32":
        return None
    return shutil.which("cc") or shutil.which("clang") or shutil.which("gcc")


def linker(target: str) -> list[str]:
    """Return the linker command of a platform: the system's ``cc`` if it can link for it, else zig.

    Raises `LibraryError` where there is neither.
    """
    compiler = system_compiler(target)
    if compiler is not None:
        return [compiler]
    if importlib.util.find_spec("ziglang") is None:
        what = "a C compiler (cc), or " if target == host() else ""
        raise LibraryError(
            f"Nothing links a kernel library for {target}. Install {what}zig: pip install ziglang."
        )
    return [sys.executable, "-m", "ziglang", "cc", "-target", TARGETS[target].zig]


def link(target: str, objects: Sequence[Path], folder: Path) -> Path:
    """Link object files to the library of a platform in a folder, complete or not at all; return its file.

    Raises `LibraryError` where the linker fails.
    """
    made = TARGETS[target]
    flags = {
        ".so": ["-Wl,-Bsymbolic", "-Wl,-z,now", "-Wl,-z,noexecstack", "-Wl,--build-id=none", "-lm"],
        ".dll": ["-Wl,--export-all-symbols"],
        ".dylib": [],
    }[made.suffix]
    with tempfile.TemporaryDirectory(dir=folder) as place:
        listed, linked = Path(place) / "objects", Path(place) / f"gearplay{made.suffix}"
        listed.write_text("\n".join(f'"{file.as_posix()}"' for file in objects), encoding="utf-8")
        command = [*linker(target), "-shared", "-o", str(linked), f"@{listed}", *flags]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0 or not linked.exists():
            lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
            raise LibraryError(
                f"{Path(command[0]).name} cannot link the kernel library for {target}: {lines[-1]}"
            )
        file = folder / f"gearplay-{SOURCES}-{content_digest(linked.read_bytes())}{made.suffix}"
        os.replace(linked, file)
    return file
