"""Hook of mkdocs: write the pages and draw the figures that follow from the code; complete pages for assistive technology."""

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

PUBLISHED = "<!-- published numbers -->"
"""Place of the table on docs/validation.md."""


def on_pre_build(config: Any) -> None:
    """Run the scripts; raises `CalledProcessError` where one fails."""
    for script in SCRIPTS:
        subprocess.run([sys.executable, str(Path(config.docs_dir) / script)], check=True)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the page of validation with the table of published numbers, computed now."""
    if PUBLISHED not in markdown:
        return markdown
    sys.path.insert(0, str(Path(__file__).parent))
    from write_validation import table

    return markdown.replace(PUBLISHED, table())


def on_post_page(output: str, **_: Any) -> str:
    """Return a page whose search has a name and whose scrolling code can be reached by keyboard, for assistive technology."""
    output = output.replace(
        'data-md-component="search" role="dialog"',
        'data-md-component="search" role="dialog" aria-label="Search"',
    )
    return output.replace('<div class="highlight-ipynb', '<div tabindex="0" class="highlight-ipynb')
