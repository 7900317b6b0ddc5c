"""Platforms that a kernel library is built for."""

import platform
import sys
from dataclasses import dataclass
from typing import Final

from gearplay.vocabulary.errors import NO_VALUE, InputError


@dataclass(frozen=True)
class Target:
    """A platform: its names in LLVM, zig and wheels.

    ``triple`` and ``processor`` are LLVM's, ``zig`` is that of zig's linker, ``suffix`` of its libraries, ``wheel`` the tag of
    its wheels. Processors are the oldest that are supported: every later one runs the same code, to the same bits.
    """

    triple: str
    processor: str
    zig: str
    suffix: str
    wheel: str


TARGETS: Final = {
    "linux-x86_64": Target(
        "x86_64-unknown-linux-gnu", "x86-64-v2", "x86_64-linux-gnu.2.17", ".so", "manylinux_2_17_x86_64"
    ),
    "linux-aarch64": Target(
        "aarch64-unknown-linux-gnu", "generic", "aarch64-linux-gnu.2.17", ".so", "manylinux_2_17_aarch64"
    ),
    "windows-x86_64": Target(
        "x86_64-w64-windows-gnu", "x86-64-v2", "x86_64-windows-gnu", ".dll", "win_amd64"
    ),
    "macos-arm64": Target(
        "arm64-apple-macosx11.0.0", "apple-m1", "aarch64-macos", ".dylib", "macosx_11_0_arm64"
    ),
    "macos-x86_64": Target(
        "x86_64-apple-macosx10.13.0", "x86-64-v2", "x86_64-macos", ".dylib", "macosx_10_13_x86_64"
    ),
}
_SYSTEMS = {"linux": "linux", "win32": "windows", "darwin": "macos"}
_MACHINES = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "arm64", "aarch64": "aarch64"}


def host() -> str:
    """Return the name of the platform that this runs on; `InputError` where it is none of `TARGETS`."""
    system = _SYSTEMS.get(sys.platform, sys.platform)
    name = f"{system}-{_MACHINES.get(platform.machine().lower(), platform.machine())}"
    if name not in TARGETS:
        rule = f"must be one of {', '.join(TARGETS)}"
        raise InputError.of(
            "platform", name, rule, "Kernels can run in plain Python: set GEARPLAY_INTERPRETED=1"
        )
    return name


def target(name: str) -> Target:
    """Return a platform by its name; `InputError` for another."""
    if name not in TARGETS:
        raise InputError.of(
            "--target", name or NO_VALUE, f"must be one of {', '.join(TARGETS)}", "Choose one"
        )
    return TARGETS[name]
