"""A run in progress as plain arrays: slots, status codes, buffers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import CONTACT_COLUMNS, OUT_SIZE, System
from gearplay.kernels.observe import needs_only_the_state, signal_count
from gearplay.kernels.runge_kutta import STAGES
from gearplay.kernels.switches import contact_count, mode_count, switch_count

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Status of a run; the solver turns it into words.
DONE, PAUSED = 0, 1
NOT_FINITE, STEP_TOO_SMALL, CHATTER, CANNOT_MESH, BLOW_UP = 10, 11, 12, 13, 14

# Slots of Motion.clock [s] and Motion.counts.
T, H, T_END, SAMPLE_START, SAMPLE_INTERVAL, H_RESTART, BURST_START = 0, 1, 2, 3, 4, 5, 6
STEPS, REJECTED, EVENTS, CALLS, NEXT_SAMPLE, LAST_SAMPLE, ROWS, LOGGED, BURST, STATES_ONLY = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    9,
)

# Columns of Motion.tallies, one row per contact.
TIME, ONSETS, SPEED_SUM, SPEED_SQUARES, SPEED_MAX, FORCE_MAX, DEPTH_MAX = 0, 1, 2, 3, 4, 5, 6


class Motion(NamedTuple):
    """A run in progress, as plain arrays; made by `make_motion`."""

    clock: Floats  # [s], slots above
    counts: Ints
    y: Floats
    y_new: Floats
    y_try: Floats
    stages: Floats  # [7, state]
    dy_try: Floats
    modes: Ints
    latch: Floats  # [m/s], per sleeve
    contacts: Floats  # at the end of the last step tried
    contacts_0: Floats  # at its start
    contacts_try: Floats
    force: Floats
    out: Floats
    g_0: Floats
    g_1: Floats
    g_try: Floats
    scale: Floats  # allowed local error per state
    natural: Floats  # natural size per state
    stops: Floats  # [s], sorted times where the right-hand side jumps
    tallies: Floats
    columns: Ints  # which signals to keep
    row: Floats
    rows: Floats  # [capacity, columns] sampled signals
    log: Floats  # [capacity, 4] contact changes: time, contact, 1 onset / 0 release, rate [m/s]


def make_motion(
    system: System,
    y_0: Floats,
    natural: Floats,
    restart_step: float,
    stops: Floats,
    columns: Ints,
    row_capacity: int,
    log_capacity: int,
    tolerance: float,
) -> Motion:
    """Allocate a run at t = 0 from initial state ``y_0``; ``natural`` are the states' natural sizes."""
    n, n_c, n_g = y_0.size, contact_count(system), switch_count(system)
    n_r = system.rotors.size

    def table() -> Floats:
        return np.zeros((n_c, CONTACT_COLUMNS))

    clock = np.zeros(8)
    clock[H_RESTART] = restart_step
    clock[SAMPLE_INTERVAL] = np.inf
    counts = np.zeros(10, dtype=np.int64)
    counts[LAST_SAMPLE] = -1
    counts[STATES_ONLY] = 1 if needs_only_the_state(columns, n_r) else 0
    return Motion(
        clock=clock,
        counts=counts,
        y=np.array(y_0, dtype=np.float64),
        y_new=np.zeros(n),
        y_try=np.zeros(n),
        stages=np.zeros((STAGES, n)),
        dy_try=np.zeros(n),
        modes=np.zeros(mode_count(system), dtype=np.int64),
        latch=np.zeros(system.sleeves.size),
        contacts=table(),
        contacts_0=table(),
        contacts_try=table(),
        force=np.zeros((n_r, 3)),
        out=np.zeros(OUT_SIZE),
        g_0=np.zeros(n_g),
        g_1=np.zeros(n_g),
        g_try=np.zeros(n_g),
        scale=tolerance * natural,
        natural=np.array(natural, dtype=np.float64),
        stops=np.array(stops, dtype=np.float64),
        tallies=np.zeros((n_c, 7)),
        columns=np.array(columns, dtype=np.int64),
        row=np.zeros(signal_count(system)),
        rows=np.zeros((row_capacity, len(columns))),
        log=np.zeros((log_capacity, 4)),
    )
