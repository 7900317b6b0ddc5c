"""Hook of mkdocs: write the pages and draw the figures that follow from the code, before a site is built from them."""

import subprocess
import sys
from pathlib import Path
from typing import Any

SCRIPTS = (
    "figures/draw_conventions.py",
    "figures/draw_elements.py",
    "figures/draw_clearances.py",
    "figures/draw_house.py",
    "write_reference.py",
    "write_case_file.py",
    "write_commands.py",
)


def on_pre_build(config: Any) -> None:
    """Run the scripts; raises `CalledProcessError` where one fails."""
    for script in SCRIPTS:
        subprocess.run([sys.executable, str(Path(config.docs_dir) / script)], check=True)
