"""Registry of the kinds of elements, and the dispatch of each function to the module of the kind.

numba has no virtual calls, so each dispatch is a chain of ifs, and the busiest one a loop per kind. Callers use element
indices e and never a kind; the module of a kind uses indices n of its own records. `KINDS` raises where a module lacks a
function; `tests/elements` tests all of them.
"""

from dataclasses import dataclass
from types import ModuleType

from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elements import coupling, excitation, housing, mesh, positioner, servo, sleeve, support
from gearplay.kernels.layout import Branch, Loads, System
from gearplay.kernels.mesh_geometry import follow_orbit, know_angles
from gearplay.kernels.sample_block import place_members

SERVO, SLEEVE, MESH, COUPLING = servo.KIND, sleeve.KIND, mesh.KIND, coupling.KIND
SUPPORT, EXCITATION, HOUSING, POSITIONER = support.KIND, excitation.KIND, housing.KIND, positioner.KIND

# Required of the module of every kind: its record, the sizes of its entries, and these functions.
FACTS = ("KIND", "RECORD", "SIGNALS", "MEMORY", "MODES", "PER_CONTACT", "SLOPES")
QUESTIONS = (
    "contact_kinematics",  # gaps, rates, margins and forces of its contacts
    "apply_forces",  # forces on its rotors
    "stay_open",  # a time without a touch, in free motion
    "may_return",  # what a switch function may hide between the ends of a step
    "linearise",  # slopes of `apply_forces`
    "add_change",  # what a change of the state changes in the forces
    "crossing",  # and in a switch function
    "observe",  # signals
)
DERIVATIVE = ("linearise", "add_change", "crossing", "jump", "carry_sample")
"""Functions that only the exact derivative needs: dispatched in `derivative`."""


@dataclass(frozen=True)
class Kind:
    """A kind of element, by the name of its dimension in results, and its module."""

    name: str
    file: ModuleType

    def __post_init__(self) -> None:
        lacking = [word for word in FACTS + QUESTIONS if not hasattr(self.file, word)]
        if lacking:
            raise TypeError(f"{self.file.__name__} says nothing of {', '.join(lacking)}")


KINDS = (
    Kind("servo", servo),
    Kind("sleeve", sleeve),
    Kind("mesh", mesh),
    Kind("coupling", coupling),
    Kind("support", support),
    Kind("excitation", excitation),
    Kind("base", housing),
    Kind("positioner", positioner),
)
SHOWN = tuple(len(kind.file.SIGNALS) for kind in KINDS)
"""How many signals an element has, by its kind."""


@compiled_once
def contact_kinematics(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Fill element e's rows of the contact table at (t, y); return 1 where its geometry fails."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == SLEEVE:
        return sleeve.contact_kinematics(system, n, t, y, branch, loads)
    if kind == MESH:
        return mesh.contact_kinematics(system, n, t, y, branch, loads)
    if kind == COUPLING:
        return coupling.contact_kinematics(system, n, t, y, branch, loads)
    if kind == SUPPORT:
        return support.contact_kinematics(system, n, t, y, branch, loads)
    if kind == EXCITATION:
        return excitation.contact_kinematics(system, n, t, y, branch, loads)
    if kind == HOUSING:
        return housing.contact_kinematics(system, n, t, y, branch, loads)
    if kind == POSITIONER:
        return positioner.contact_kinematics(system, n, t, y, branch, loads)
    return servo.contact_kinematics(system, n, t, y, branch, loads)


@compiled_inline
def apply_forces(
    system: System, acting: Ints, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Let all listed elements act: add their forces to the sums on their rotors, fill the rates of their own states.

    ``acting`` starts with its length and rises, so that it holds kind after kind. Returns 1 where a geometry fails.
    """
    elements, c, last = system.elements, 1, acting[0]
    while c <= last and elements[acting[c]].kind == SERVO:
        if servo.apply_forces(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:
            return 1
        c += 1
    while c <= last and elements[acting[c]].kind == SLEEVE:
        if sleeve.apply_forces(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:
            return 1
        c += 1
    while c <= last and elements[acting[c]].kind == MESH:
        if mesh.apply_forces(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:
            return 1
        c += 1
    while c <= last and elements[acting[c]].kind == COUPLING:
        if coupling.apply_forces(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:
            return 1
        c += 1
    while c <= last and elements[acting[c]].kind == SUPPORT:
        if support.apply_forces(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:
            return 1
        c += 1
    while c <= last and elements[acting[c]].kind == EXCITATION:
        if excitation.apply_forces(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:
            return 1
        c += 1
    while c <= last and elements[acting[c]].kind == HOUSING:
        if housing.apply_forces(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:
            return 1
        c += 1
    while c <= last:
        if positioner.apply_forces(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:
            return 1
        c += 1
    return 0


@compiled_inline
def stay_open(
    system: System, e: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return what element e's gaps do at (t, y) between free rotors, and for how long [s] they surely stay open."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == SLEEVE:
        return sleeve.stay_open(system, n, t, y, branch, longest, out)
    if kind == MESH:
        follow_orbit(system, n, y, branch.memory)
        return mesh.stay_open(system, n, t, y, branch, longest, out)
    if kind == COUPLING:
        return coupling.stay_open(system, n, t, y, branch, longest, out)
    if kind == SUPPORT:
        return support.stay_open(system, n, t, y, branch, longest, out)
    if kind == EXCITATION:
        return excitation.stay_open(system, n, t, y, branch, longest, out)
    if kind == HOUSING:
        return housing.stay_open(system, n, t, y, branch, longest, out)
    if kind == POSITIONER:
        return positioner.stay_open(system, n, t, y, branch, longest, out)
    return servo.stay_open(system, n, t, y, branch, longest, out)


@compiled_inline
def forcing_rate(system: System, e: int, t: float, y: Floats) -> float:
    """Return the highest angular frequency [rad/s] with which element e forces its rotors."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == MESH:
        return mesh.forcing_rate(system, n, t, y)
    if kind == EXCITATION:
        return excitation.forcing_rate(system, n, t, y)
    return 0.0


@compiled_inline
def start_step(system: System, e: int, t: float, y: Floats, branch: Branch) -> None:
    """Let element e note what the stages of a step from (t, y) need."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == MESH:
        know_angles(system, n, t, y, branch.memory, False)


@compiled_inline
def end_step(system: System, e: int, y: Floats, branch: Branch) -> None:
    """Let element e follow the state that a step ended with."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == MESH:
        follow_orbit(system, n, y, branch.memory)


@compiled_inline
def own_switch(system: System, e: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return switch function s of element e that is neither touch nor pull, its rows of the contact table filled."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == MESH:
        return mesh.own_switch(system, n, s, t, y, branch, loads)
    if kind == POSITIONER:
        return positioner.own_switch(system, n, s, t, y, branch, loads)
    return servo.own_switch(system, n, s, t, y, branch, loads)


@compiled_inline
def switch_own(system: System, e: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Change the mode that switch s of element e guards, its rows of the contact table filled."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == MESH:
        mesh.switch_own(system, n, s, t, y, branch, loads)
    elif kind == POSITIONER:
        positioner.switch_own(system, n, s, t, y, branch)
    else:
        servo.switch_own(system, n, s, t, y, branch)


@compiled_inline
def may_return(
    system: System, e: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Floats,
) -> bool:  # fmt: skip
    """Return whether pull or own switch s of element e, not positive at both ends of a step of h [s], may be so in between.

    The contact of a pull is closed. ``loads_0`` and ``g_0`` are of its start, ``loads`` and ``g_1`` of its end, ``stages`` the
    derivatives on the way.
    """
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == SLEEVE:
        return sleeve.may_return(system, n, s, h, branch, loads_0, loads, g_0, g_1, stages)
    if kind == MESH:
        return mesh.may_return(system, n, s, h, branch, loads_0, loads, g_0, g_1, stages)
    if kind == COUPLING:
        return coupling.may_return(system, n, s, h, branch, loads_0, loads, g_0, g_1, stages)
    if kind == SUPPORT:
        return support.may_return(system, n, s, h, branch, loads_0, loads, g_0, g_1, stages)
    if kind == EXCITATION:
        return excitation.may_return(system, n, s, h, branch, loads_0, loads, g_0, g_1, stages)
    if kind == HOUSING:
        return housing.may_return(system, n, s, h, branch, loads_0, loads, g_0, g_1, stages)
    if kind == POSITIONER:
        return positioner.may_return(system, n, s, h, branch, loads_0, loads, g_0, g_1, stages)
    return servo.may_return(system, n, s, h, branch, loads_0, loads, g_0, g_1, stages)


@compiled_inline
def initialise(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set element e's own modes from the state alone, its rows of the contact table filled."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == MESH:
        mesh.initialise(system, n, t, y, branch, loads)
    elif kind == SERVO:
        servo.initialise(system, n, t, y, branch, loads)
    elif kind == POSITIONER:
        positioner.initialise(system, n, t, y, branch, loads)


@compiled_inline
def takes_samples(system: System, e: int) -> bool:
    """Return whether `initialise` takes a sample of element e, which only its times may do, where it would set its modes."""
    kind, n = system.elements[e].kind, system.elements[e].index
    return bool(kind == POSITIONER and positioner.takes_samples(system, n))


@compiled_inline
def initialise_touch(
    system: System, e: int, k: int, t: float, y: Floats, branch: Branch, loads: Loads
) -> None:
    """Set the own modes of element e with which a touch of its contact k begins, its rows of the contact table filled."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == MESH:
        mesh.initialise_touch(system, n, k, t, y, branch, loads)


@compiled_inline
def observe(
    system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill element e's signals of a full ``row``; where it acts its rows of the contact table are of (t, y)."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == SLEEVE:
        sleeve.observe(system, n, t, y, branch, loads, acting, row)
    elif kind == MESH:
        mesh.observe(system, n, t, y, branch, loads, acting, row)
    elif kind == COUPLING:
        coupling.observe(system, n, t, y, branch, loads, acting, row)
    elif kind == SUPPORT:
        support.observe(system, n, t, y, branch, loads, acting, row)
    elif kind == EXCITATION:
        excitation.observe(system, n, t, y, branch, loads, acting, row)
    elif kind == HOUSING:
        housing.observe(system, n, t, y, branch, loads, acting, row)
    elif kind == POSITIONER:
        positioner.observe(system, n, t, y, branch, loads, acting, row)
    else:
        servo.observe(system, n, t, y, branch, loads, acting, row)


@compiled_inline
def show(
    system: System, e: int, times: Floats, count: int, free_states: Rows, y: Floats, branch: Branch, loads: Loads, acting: bool,
    scratch_memory: Rows, row: Floats, shown: Rows,
) -> None:  # fmt: skip
    """Fill element e's signals, shape [signal, sample], in a block in which all rotors are free; y and ``row`` are scratch."""
    kind, n = system.elements[e].kind, system.elements[e].index
    if kind == SLEEVE and not acting:
        sleeve.show(system, n, times, count, free_states, y, loads.out, shown)
    elif kind == MESH and not acting:
        mesh.show(system, n, times, count, free_states, y, branch, scratch_memory, loads.out, shown)
    else:
        for s in range(count):
            place_members(system, e, free_states, s, y)
            observe(system, e, times[s], y, branch, loads, acting, row)
            for k in range(SHOWN[kind]):
                shown[k, s] = row[system.elements[e].signal + k]
