"""Exit codes of the command line, assigned to the classes of `gearplay.vocabulary.errors`."""

from typing import Final

DONE: Final = 0
BROKEN: Final = 1
"""An error in gearplay itself."""
INPUT: Final = 2
SIMULATION: Final = 3
"""Nothing could be carried to its end."""
PARTLY: Final = 4
"""Some members or cases did not finish; what did is kept."""
RESOURCE: Final = 5
MEASUREMENT: Final = 6
INTERRUPTED: Final = 130
"""Ctrl-C."""
