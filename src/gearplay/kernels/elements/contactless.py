"""Defaults of an element without contacts: no force margin, no touch, no crossing, no return."""

from gearplay.kernels.advancement import STAYS_OPEN
from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import Branch, Loads, System


@compiled_once
def contact_kinematics(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Return 0: there is no contact."""
    return 0


@compiled_once
def stay_open(
    system: System, n: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return that nothing can touch."""
    return STAYS_OPEN, longest


@compiled_once
def crossing(system: System, n: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return zeros: no switch of it lets a force jump."""
    return 0.0, 0.0, 0.0


@compiled_once
def may_return(
    system: System, n: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return that no switch returns: there is none."""
    return False
