"""Hook of the package's build: the kernel library goes into the wheel, or into the source tree of an editable installation."""

import os
import subprocess
import sys
import sysconfig
from functools import cached_property
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

COMPILER = ["numba>=0.61", "numpy>=2.0", "pydantic>=2.12"]
"""What `gearplay.build` imports."""


class KernelLibrary(BuildHookInterface):
    """Builds the kernel library; GEARPLAY_TARGET names another platform, GEARPLAY_PURE=1 leaves it to the first use."""

    @cached_property
    def target(self) -> str:
        """The platform, by its name in `gearplay.build.targets`."""
        sys.path.insert(0, str(Path(self.root) / "src"))
        from gearplay.build.targets import host

        return os.environ.get("GEARPLAY_TARGET") or host()

    @property
    def is_wanted(self) -> bool:
        """Whether a library belongs into what is built."""
        return self.target_name == "wheel" and not os.environ.get("GEARPLAY_PURE")

    @property
    def needs_zig(self) -> bool:
        """Whether zig links: for another platform, or where there is no C compiler."""
        target = self.target
        from gearplay.build.linking import system_compiler

        return system_compiler(target) is None

    def found(self) -> Path | None:
        """Return the library of these sources where it is there."""
        target = self.target
        from gearplay.build.targets import TARGETS, host
        from gearplay.kernels.library import OWN, find

        return find(OWN if target == host() else OWN / target, TARGETS[target].suffix)

    def dependencies(self) -> list[str]:
        """Return what compiles and links, if the library has to be built."""
        if not self.is_wanted or self.found():
            return []
        return [*COMPILER, *(["ziglang"] if self.needs_zig else [])]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the library where it is not there, and add it to the wheel."""
        if not self.is_wanted:
            return
        file = self.found() or self._build()
        if version == "editable":
            return
        from gearplay.build.targets import TARGETS

        system = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        platform = TARGETS[self.target].wheel if self.needs_zig else system
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform}"
        for each in (file, Path(self.root) / "src" / "gearplay" / "_library" / "gearplay.h"):
            build_data["force_include"][str(each)] = f"gearplay/_library/{each.name}"

    def _build(self) -> Path:
        root = Path(self.root) / "src"
        command = [sys.executable, "-m", "gearplay.build", "--target", self.target]
        command += ["--folder", str(root / "gearplay" / "_library")]
        paths = [str(root), os.environ.get("PYTHONPATH", "")]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"The kernel library could not be built: {done.stdout.strip()}")
        return Path(done.stdout.splitlines()[-1])
