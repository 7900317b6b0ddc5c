"""Hook of the package's build: the kernel library goes into the wheel, or into the source tree of an editable installation."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

LIBRARY = Path("src") / "gearplay" / "_library"


class KernelLibrary(BuildHookInterface):
    """Builds the kernel library; GEARPLAY_TARGET names another platform, GEARPLAY_PURE=1 leaves it to the first use."""

    def dependencies(self) -> list[str]:
        """Return what links, where the system has no C compiler or the library is for another platform."""
        return [] if shutil.which("cc") and "GEARPLAY_TARGET" not in os.environ else ["ziglang"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the library and add it to the wheel."""
        if self.target_name != "wheel" or os.environ.get("GEARPLAY_PURE"):
            return
        root = Path(self.root)
        target = os.environ.get("GEARPLAY_TARGET")
        command = [sys.executable, "-m", "gearplay.build", "--folder", str(root / LIBRARY)]
        paths = [str(root / "src"), os.environ.get("PYTHONPATH", "")]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
        command += ["--target", target] if target else []
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"The kernel library could not be built: {done.stdout.strip()}")
        if version == "editable":
            return
        file = Path(done.stdout.split()[-1])
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{self._platform(root, target)}"
        for each in (file, root / LIBRARY / "gearplay.h"):
            build_data["force_include"][str(each)] = f"gearplay/_library/{each.name}"

    def _platform(self, root: Path, target: str | None) -> str:
        """Return the platform in the wheel's name: that of zig's old C library, or of the system's own."""
        if target is None and shutil.which("cc"):
            return sysconfig.get_platform().replace("-", "_").replace(".", "_")
        sys.path.insert(0, str(root / "src"))
        from gearplay.build.targets import TARGETS, host

        return TARGETS[target or host()].wheel
