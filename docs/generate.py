"""Hook of mkdocs: write the pages and draw the figures that follow from the code; complete pages for assistive technology."""

import importlib
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

SCRIPTS = (
    "figures/draw_conventions.py",
    "figures/draw_elements.py",
    "figures/draw_clearances.py",
    "figures/draw_bearing.py",
    "figures/draw_house.py",
    "write_reference.py",
    "write_case_file.py",
    "write_commands.py",
    "write_variables.py",
)

TABLES = {"<!-- published numbers -->": "write_validation", "<!-- mean stiffness -->": "write_stiffness"}
"""Places of tables on pages, and the modules whose function ``table`` computes them."""


def on_pre_build(config: Any) -> None:
    """Run the scripts, in one process of their own; raises `CalledProcessError` where one fails."""
    words = [str(Path(config.docs_dir) / script) for script in SCRIPTS]
    subprocess.run([sys.executable, __file__, *words], check=True)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the page with its tables, computed now."""
    for place, module in TABLES.items():
        if place in markdown:
            sys.path.insert(0, str(Path(__file__).parent))
            markdown = markdown.replace(place, importlib.import_module(module).table())
    return markdown


def on_post_page(output: str, **_: Any) -> str:
    """Return a page whose search has a name and whose scrolling code can be reached by keyboard, for assistive technology."""
    output = output.replace(
        'data-md-component="search" role="dialog"',
        'data-md-component="search" role="dialog" aria-label="Search"',
    )
    return output.replace('<div class="highlight-ipynb', '<div tabindex="0" class="highlight-ipynb')


if __name__ == "__main__":
    for script in sys.argv[1:]:
        sys.path[0] = str(Path(script).parent)
        runpy.run_path(script, run_name="__main__")
