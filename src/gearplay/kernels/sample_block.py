"""A block of samples in free motion: the body states from which signals are computed."""

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import VX, System, members, vx_of, x_of

BLOCK = 120  # samples of a block; rows whose length is a power of two would share few lines of the cache
STATES_OF_ROTOR = 6  # rows of a block: x, y, theta and their rates, relative to the nominal turning


@compiled_inline
def place_rotor(system: System, i: int, free_states: Rows, s: int, y: Floats) -> None:
    """Copy rotor i's states at the s-th time of a block to ``y``."""
    at, x, v = STATES_OF_ROTOR * i, x_of(i), vx_of(system, i)
    y[x], y[x + 1], y[x + 2] = free_states[at, s], free_states[at + 1, s], free_states[at + 2, s]
    y[v], y[v + 1], y[v + 2] = (
        free_states[at + VX, s],
        free_states[at + VX + 1, s],
        free_states[at + VX + 2, s],
    )


@compiled_inline
def place_members(system: System, e: int, free_states: Rows, s: int, y: Floats) -> None:
    """Apply `place_rotor` to every rotor of element e."""
    a, b, c = members(system, e)
    place_rotor(system, a, free_states, s, y)
    if b >= 0:
        place_rotor(system, b, free_states, s, y)
    if c >= 0:
        place_rotor(system, c, free_states, s, y)
