"""Tolerance of analyses that need accurate derivatives."""

from typing import Final

from gearplay.model.case import Case
from gearplay.model.reading import replace

LOOSEST: Final = 1e-9
"""Error tolerance [1] of orbits, exponents and kinds of motion, unless that of the case is less: orbits are closed to 1e-9."""


def sharp(case: Case) -> Case:
    """Return a case whose tolerance is no looser than `LOOSEST`.

    >>> from gearplay.model.reading import load_case
    >>> sharp(load_case("han2021")).run.tolerance
    1e-09
    """
    return case if case.run.tolerance <= LOOSEST else replace(case, {"run.tolerance": LOOSEST})
