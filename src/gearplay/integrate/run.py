"""State of an integration run as plain arrays: slots, status codes, buffers."""

from dataclasses import dataclass

import numpy as np

from gearplay.integrate.active_set import ActiveSet, make_active_set
from gearplay.integrate.implicit import Implicit, make_implicit
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.runge_kutta import STAGES
from gearplay.integrate.slopes import Slopes, make_slopes
from gearplay.integrate.switches import make_branch
from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.housing_motion import KIND, NONE
from gearplay.kernels.layout import AX, AY, PER_ROTOR, VX, Branch, Loads, System
from gearplay.kernels.sample_block import BLOCK, STATES_OF_ROTOR
from gearplay.parts.registry import SIGNAL_COUNTS

# Status of a run; the solver turns it into words.
DONE, PAUSED = 0, 1
NOT_FINITE, STEP_TOO_SMALL, CHATTER, CANNOT_MESH, BLOW_UP, MISSED_SWITCH = 10, 11, 12, 13, 14, 15

# Slots of Run.clock [s, 1] and Run.counts.
T, H, T_END, SAMPLE_START, SAMPLE_INTERVAL, BURST_START, FIXED, TOLERANCE, ERROR_SHARE = range(9)
# Lengths of the first step after a switch: the shortest, and what has been learnt.
H_RESTART, H_BEGIN = range(9, 11)
INSIDE = 11  # where in the step [1] the loads inside it belong; 0 where there are none
AHEAD = 12  # s beyond T_END up to which touches of free bodies are predicted
STEPS, REJECTED, EVENTS, CALLS, NEXT_SAMPLE, LAST_SAMPLE, ROWS, LOGGED, BURST, FORCES, BEGUN = range(11)

# Columns of Run.tallies, one row per contact, and of Run.log.
TIME, ONSETS, SPEED_SUM, SPEED_SQUARES, SPEED_MAX, FORCE_MAX, DEPTH_MAX, WEDGED = range(8)
# Behind them what bounds a peak inside a step: length [s] and initial force of the step before, 0 where there is none.
LAST_STEP, LAST_FORCE = range(8, 10)
TALLIES = 10
LOG_COLUMNS = 4


@dataclass(frozen=True, eq=False)
class Run(Group):
    """A run in progress, as plain arrays; made by `make_run`."""

    active_set: ActiveSet
    branch: Branch
    modes_0: Ints  # at the start of a step whose stages judge
    clock: Floats  # [s], slots above
    counts: Ints
    y: Floats
    y_new: Floats
    y_try: Floats
    stages: Rows  # [7, state]
    dy_try: Floats
    implicit: Implicit
    slopes: Slopes  # of elements, for its Jacobian
    change: Floats  # [state, then impact speed] scratch, zero between uses
    loads_0: Loads  # at the start of the step last tried
    loads_inside: Loads  # at a stage inside it
    loads: Loads  # at its end
    loads_try: Loads  # scratch
    g_0: Floats  # switch functions at the same three states
    g_1: Floats
    g_try: Floats
    scale: Floats  # allowed local error per state
    natural: Floats  # natural size per state
    stops: Floats  # [s], sorted times where the right-hand side jumps
    tallies: Rows  # [contact, TALLIES], without rows where there are no statistics
    columns: Ints  # which signals to keep
    wanted_rotors: Ints  # lists (first entry: length) of what those signals are computed from
    wanted_elements: Ints
    row: Floats
    needed: Ints  # whether the wanted signals are computed from a state, 6 of each rotor
    times: Floats  # [s] of a block of samples
    free_states: Rows  # [6 of each rotor, sample] states of a block of samples in free motion
    scratch_memory: Rows  # memory of elements for evaluations in free motion
    shown: Rows  # [signal, sample] what an element shows in a block
    rows: Rows  # [columns, sample] sampled signals
    log: Rows  # [capacity, 4] contact changes: time, contact, 1 onset / 0 release, rate [m/s]


def signal_count(system: System) -> int:
    """Return the length of a full row: the signals of every rotor, then of every element (names in their tables)."""
    kinds = system.elements["kind"].tolist()
    return int(PER_ROTOR * system.rotors.size + sum(SIGNAL_COUNTS[kind] for kind in kinds))


def _listed(items: set[int]) -> Ints:
    return np.array([len(items), *sorted(items)], dtype=np.int64)


def _wanted(system: System, columns: Ints) -> tuple[Ints, Ints, int]:
    """Return the dependencies of the kept columns: rotors, elements, and the level of forces: 0 none, 1 forces, 2 torques too."""
    first, wanted = PER_ROTOR * system.rotors.size, columns.tolist()
    of_rotors = [c for c in wanted if c < first]
    rotors, elements = {c // PER_ROTOR for c in of_rotors}, set()
    joined = (
        system.elements[["kind", "signal", "a", "b", "c"]].tolist() if len(of_rotors) < len(wanted) else []
    )
    for e, (kind, signal, *members) in enumerate(joined):
        if any(0 <= c - signal < SIGNAL_COUNTS[kind] for c in wanted):
            elements.add(e)
            rotors.update(members)
    # Accelerations need the forces, torques of drives and loads their sums too.
    highest = max((c % PER_ROTOR for c in of_rotors), default=0)
    forces = 2 if highest > AY else 1 if elements or highest >= AX else 0
    if forces == 2:  # of springs between free rotors too, for which all joined rotors are needed
        groups = {int(system.rotors["group"][i]) for i in rotors if i >= 0} - {-1}
        rotors.update(np.flatnonzero(np.isin(system.rotors["group"], list(groups))).tolist())
    return _listed(rotors - {-1}), _listed(elements), forces


def _needed(system: System, columns: Ints, rotors: Ints, *, whole: bool) -> Ints:
    """Return which states in free motion the kept columns are computed from; where ``whole`` all of the wanted rotors."""
    needed = np.zeros((system.rotors.size, STATES_OF_ROTOR), dtype=np.int64)
    if whole:
        needed[rotors[1:]] = 1
    of_rotors = columns[columns < PER_ROTOR * system.rotors.size]
    signals = of_rotors % PER_ROTOR
    known = signals <= AY
    # An acceleration follows from velocities, both of them on a housing that shakes.
    needed[(of_rotors // PER_ROTOR)[known], np.where(signals >= AX, signals - AX + VX, signals)[known]] = 1
    turning = np.isin(np.arange(system.rotors.size), (of_rotors // PER_ROTOR)[signals >= AX])
    if system.base[KIND] != NONE:
        needed[turning, VX:] = 1
    return needed.reshape(-1)


def make_run(
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
    by_stage: bool = False,
    statistics: bool = True,
) -> Run:
    """Allocate a run at t = 0 from initial state ``y_0``; ``natural`` are the states' natural sizes.

    ``rows``, shape [column, sample], receives the samples of the signals ``columns``. With ``fixed_step`` [s] all steps have
    that length, and ``by_stage`` updates contact states at every stage (`fixed_steps`). Contacts have ``statistics`` or not.
    """
    columns = np.array(columns, dtype=np.int64)
    rotors, elements, forces = _wanted(system, columns)
    n = y_0.size
    clock = np.zeros(13)
    clock[H_RESTART] = clock[H_BEGIN] = restart_step
    clock[SAMPLE_INTERVAL], clock[AHEAD] = np.inf, 1e-9
    clock[TOLERANCE], clock[ERROR_SHARE] = tolerance, 1.0
    counts = np.zeros(11, dtype=np.int64)
    counts[LAST_SAMPLE] = -1
    counts[FORCES] = forces
    active_set = make_active_set(system, n)
    if fixed_step is not None:
        clock[FIXED] = fixed_step
        active_set.forced[0] = 2 if by_stage else 1
    loads, branch = make_loads(system), make_branch(system)
    return Run(
        active_set=active_set,
        branch=branch,
        modes_0=branch.modes.copy(),
        clock=clock,
        counts=counts,
        y=np.array(y_0, dtype=np.float64),
        y_new=np.array(y_0, dtype=np.float64),
        y_try=np.array(y_0, dtype=np.float64),
        stages=np.zeros((STAGES, n)),
        implicit=make_implicit(system.rotors.size, system.elements.size, n),
        slopes=make_slopes(system),
        change=np.zeros(n + branch.impact_speeds.size),
        dy_try=np.zeros(n),
        loads_0=Loads(loads.contacts.copy(), loads.rotors, loads.out),
        loads_inside=Loads(loads.contacts.copy(), loads.rotors, loads.out),
        loads=loads,
        loads_try=Loads(loads.contacts.copy(), loads.rotors, loads.out),
        g_0=np.zeros(system.switches.size),
        g_1=np.zeros(system.switches.size),
        g_try=np.zeros(system.switches.size),
        scale=tolerance * natural,
        natural=np.array(natural, dtype=np.float64),
        stops=np.array(stops, dtype=np.float64),
        tallies=np.zeros((system.contacts.size if statistics else 0, TALLIES)),
        columns=columns,
        wanted_rotors=rotors,
        wanted_elements=elements,
        row=np.zeros(signal_count(system)),
        needed=_needed(system, columns, rotors, whole=bool(elements[0]) or forces == 2),
        times=np.zeros(BLOCK),
        free_states=np.zeros((STATES_OF_ROTOR * system.rotors.size, BLOCK if columns.size else 0)),
        scratch_memory=branch.memory.copy(),
        shown=np.zeros((max(SIGNAL_COUNTS), BLOCK if elements[0] else 0)),
        rows=rows,
        log=np.zeros((log_capacity, LOG_COLUMNS)),
    )
