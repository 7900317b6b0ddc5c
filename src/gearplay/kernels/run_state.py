"""A run in progress as plain arrays: slots, status codes, buffers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import (
    CONTACT_COLUMNS,
    MESH_SIGNALS,
    OUT_SIZE,
    ROTOR_SIGNALS,
    SLEEVE_SIGNALS,
    System,
    contact_count,
    mode_count,
    switch_count,
)
from gearplay.kernels.roster import Roster, make_roster
from gearplay.kernels.runge_kutta import STAGES

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Status of a run; the solver turns it into words.
DONE, PAUSED = 0, 1
NOT_FINITE, STEP_TOO_SMALL, CHATTER, CANNOT_MESH, BLOW_UP = 10, 11, 12, 13, 14

# Slots of Motion.clock [s] and Motion.counts.
T, H, T_END, SAMPLE_START, SAMPLE_INTERVAL, H_RESTART, BURST_START, FIXED = range(8)
STEPS, REJECTED, EVENTS, CALLS, NEXT_SAMPLE, LAST_SAMPLE, ROWS, LOGGED, BURST, FORCES, BEGUN = range(11)

PER_ROTOR, PER_SLEEVE, PER_MESH = len(ROTOR_SIGNALS), len(SLEEVE_SIGNALS), len(MESH_SIGNALS)
ROTOR_STATES = 6  # of a rotor's signals: the accelerations need the forces

# Columns of Motion.tallies, one row per contact.
TIME, ONSETS, SPEED_SUM, SPEED_SQUARES, SPEED_MAX, FORCE_MAX, DEPTH_MAX = 0, 1, 2, 3, 4, 5, 6


class Motion(NamedTuple):
    """A run in progress, as plain arrays; made by `make_motion`."""

    roster: Roster
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
    wanted_rotors: Ints  # lists (first entry: length) of what those signals are computed from
    wanted_sleeves: Ints
    wanted_meshes: Ints
    row: Floats
    times: Floats  # [s] of a block of samples
    rows: Floats  # [columns, sample] sampled signals
    log: Floats  # [capacity, 4] contact changes: time, contact, 1 onset / 0 release, rate [m/s]


def signal_count(system: System) -> int:
    """Return the length of a full row: 8 signals a rotor, 3 a sleeve, 9 a mesh (names in `layout`)."""
    return int(
        PER_ROTOR * system.rotors.size + PER_SLEEVE * system.sleeves.size + PER_MESH * system.meshes.size
    )


def _wanted(system: System, columns: Ints) -> tuple[Ints, Ints, Ints, bool]:
    """Return what the kept columns are computed from: rotors, sleeves, meshes, and whether forces are needed."""
    n, n_s = system.rotors.size, system.sleeves.size
    first_sleeve, first_mesh = PER_ROTOR * n, PER_ROTOR * n + PER_SLEEVE * n_s
    of_rotors = columns[columns < first_sleeve]
    rotors = set(of_rotors // PER_ROTOR)
    sleeves = set((columns[(columns >= first_sleeve) & (columns < first_mesh)] - first_sleeve) // PER_SLEEVE)
    meshes = set((columns[columns >= first_mesh] - first_mesh) // PER_MESH)
    for k in sleeves:
        rotors |= {system.sleeves[k]["journal"], system.sleeves[k]["bush"]}
    for j in meshes:
        rotors |= {system.meshes[j][key] for key in ("a", "b", "frame")}

    def listed(items: set[int]) -> Ints:
        return np.array([len(items), *sorted(items)], dtype=np.int64)

    forces = bool(sleeves or meshes or np.any(of_rotors % PER_ROTOR >= ROTOR_STATES))
    return listed(rotors - {-1}), listed(sleeves), listed(meshes), forces


def make_motion(
    system: System,
    y_0: Floats,
    natural: Floats,
    restart_step: float,
    stops: Floats,
    columns: Ints,
    rows: Floats,
    log_capacity: int,
    tolerance: float,
    fixed_step: float | None = None,
) -> Motion:
    """Allocate a run at t = 0 from initial state ``y_0``; ``natural`` are the states' natural sizes.

    ``rows``, shape [column, sample], receives the samples of the signals ``columns``. With ``fixed_step`` [s] all steps have
    that length (`fixed_steps`).
    """
    columns = np.array(columns, dtype=np.int64)
    rotors, sleeves, meshes, forces = _wanted(system, columns)
    n, n_c, n_g = y_0.size, contact_count(system), switch_count(system)
    n_r = system.rotors.size

    def table() -> Floats:
        return np.zeros((n_c, CONTACT_COLUMNS))

    clock = np.zeros(8)
    clock[H_RESTART] = restart_step
    clock[SAMPLE_INTERVAL] = np.inf
    counts = np.zeros(11, dtype=np.int64)
    counts[LAST_SAMPLE] = -1
    counts[FORCES] = 1 if forces else 0
    roster = make_roster(system, n)
    if fixed_step is not None:
        clock[FIXED] = fixed_step
        roster.grounded[0] = 1
    return Motion(
        roster=roster,
        clock=clock,
        counts=counts,
        y=np.array(y_0, dtype=np.float64),
        y_new=np.array(y_0, dtype=np.float64),
        y_try=np.array(y_0, dtype=np.float64),
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
        columns=columns,
        wanted_rotors=rotors,
        wanted_sleeves=sleeves,
        wanted_meshes=meshes,
        row=np.zeros(signal_count(system)),
        times=np.zeros(256),
        rows=rows,
        log=np.zeros((log_capacity, 4)),
    )
