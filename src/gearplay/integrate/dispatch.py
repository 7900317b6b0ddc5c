"""Dispatch of element functions to the law of each element's kind: the questions that a law answers, with their defaults.

numba has no virtual calls: `dispatched` makes each function a chain of ifs over `gearplay.parts.registry.KINDS`. Callers use
element indices e and never a kind; the law of a kind has a function of the same name and arguments, with the index n among the
elements of its kind in place of e. A law without a function that is not required has the body given here.
"""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

from gearplay.kernels.advancement import STAYS_OPEN
from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import Branch, Loads, System
from gearplay.kernels.sample_block import place_members
from gearplay.parts.registry import KINDS, SIGNAL_COUNTS

P = ParamSpec("P")
R = TypeVar("R")

ORDER = [*KINDS[1:], KINDS[0]]
"""Order of the ifs: speed servos, the rarest, last."""


def _generated(function: Callable[P, R], lines: list[str], names: dict[str, Any]) -> Callable[P, R]:
    """Return a function of the same name and signature with another body."""
    source = "\n    ".join([f"def {function.__name__}({', '.join(_arguments(function))}):", *lines])
    exec(compile(source, f"<dispatch of {function.__name__}>", "exec"), names)
    made: Any = names[function.__name__]
    made.__annotations__, made.__doc__ = function.__annotations__, function.__doc__
    made.__module__, made.__qualname__ = function.__module__, function.__qualname__
    return cast(Callable[P, R], made)


def _arguments(function: Callable[..., Any]) -> list[str]:
    return list(function.__code__.co_varnames[: function.__code__.co_argcount])


def dispatched(
    decorate: Callable[[Any], Any], *, required: bool = False
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Return a decorator that dispatches a function of (system, e, ...) to the laws, and compiles it by ``decorate``.

    Raises `TypeError` where it is ``required`` and a law lacks it.
    """

    def make(function: Callable[P, R]) -> Callable[P, R]:
        name, names = function.__name__, dict[str, Any]()
        passed = ", ".join("n" if each == "e" else each for each in _arguments(function))
        lines = ["kind, n = system.elements[e].kind, system.elements[e].index"]
        for kind in ORDER:
            law = getattr(kind.file, name, None)
            if law is not None:
                names[kind.name] = law
                lines.append(f"if kind == {kind.file.KIND}: return {kind.name}({passed})")
        if len(names) == len(KINDS):
            lines[-1] = lines[-1].partition(": ")[2]
        elif required:
            missing = [kind.file.__name__ for kind in KINDS if kind.name not in names]
            raise TypeError(f"{', '.join(missing)} must have a function {name}")
        else:
            names["default"] = compiled_inline(function)
            lines.append(f"return default({', '.join(_arguments(function))})")
        made: Callable[P, R] = decorate(_generated(function, lines, names))
        return made

    return make


@dispatched(compiled_once)
def contact_kinematics(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads) -> int:
    """Fill element e's rows of the contact table at (t, y): gaps, rates, margins, forces; return 1 where its geometry fails."""
    return 0


def _apply_in_order(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a loop for each kind in place of one dispatch per element: this is the busiest function."""
    lines, names = ["elements, c, last = system.elements, 1, acting[0]"], dict[str, Any]()
    for kind in KINDS:
        names[kind.name] = kind.file.apply_forces
        lines += [
            f"while c <= last and elements[acting[c]].kind == {kind.file.KIND}:",
            f"    if {kind.name}(system, elements[acting[c]].index, t, y, branch, loads, dy) != 0:",
            "        return 1",
            "    c += 1",
        ]
    return compiled_inline(_generated(function, [*lines, "return 0"], names))


@_apply_in_order
def apply_forces(
    system: System, acting: Ints, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add the forces of all listed elements to the sums on their rotors, fill the rates of their own states.

    ``acting`` starts with its length and rises, so that it holds kind after kind. Returns 1 where a geometry fails.
    """
    raise NotImplementedError


@dispatched(compiled_inline)
def stay_open(
    system: System, e: int, t: float, y: Floats, branch: Branch, longest: float, out: Floats
) -> tuple[int, float]:
    """Return the state of element e's gaps at (t, y) between free rotors, and a time [s] for which they provably stay open."""
    return STAYS_OPEN, longest


@dispatched(compiled_inline)
def forcing_rate(system: System, e: int, t: float, y: Floats) -> float:
    """Return the highest angular frequency [rad/s] with which element e forces its rotors."""
    return 0.0


@dispatched(compiled_inline)
def start_step(system: System, e: int, t: float, y: Floats, branch: Branch) -> None:
    """Store the data for the stages of a step of element e from (t, y)."""


@dispatched(compiled_inline)
def end_step(system: System, e: int, y: Floats, branch: Branch) -> None:
    """Update the memory of element e with the state at the end of a step."""


@dispatched(compiled_inline)
def own_switch(system: System, e: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return switch function s of element e that is neither touch nor pull, its rows of the contact table filled."""
    return -1.0


@dispatched(compiled_inline)
def switch_own(system: System, e: int, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Change the mode that switch s of element e guards, its rows of the contact table filled."""


@dispatched(compiled_inline)
def may_return(
    system: System, e: int, s: int, h: float, branch: Branch, loads_0: Loads, loads: Loads, g_0: Floats, g_1: Floats,
    stages: Rows,
) -> bool:  # fmt: skip
    """Return whether pull or own switch s of element e, not positive at both ends of a step of h [s], may be so in between.

    The contact of a pull is closed. ``loads_0`` and ``g_0`` are of its start, ``loads`` and ``g_1`` of its end, ``stages`` the
    derivatives on the way.
    """
    return False


@dispatched(compiled_inline)
def initialise(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set element e's own modes from the state alone, its rows of the contact table filled."""


@dispatched(compiled_inline)
def locate_kinks(system: System, e: int, located: bool, branch: Branch, loads: Loads, g: Floats) -> None:
    """Set whether kinks of element e's forces are located as events, and the values of their switches by ``loads``."""


@dispatched(compiled_inline)
def takes_samples(system: System, e: int) -> bool:
    """Return whether `initialise` takes a sample of element e, as is due at its sampling times only."""
    return False


@dispatched(compiled_inline)
def initialise_touch(
    system: System, e: int, k: int, t: float, y: Floats, branch: Branch, loads: Loads
) -> None:
    """Set the own modes of element e with which a touch of its contact k begins, its rows of the contact table filled."""


@dispatched(compiled_inline, required=True)
def observe(
    system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill element e's signals of a full ``row``; where it acts its rows of the contact table are of (t, y)."""
    ...


@dispatched(compiled_inline)
def show_free(
    system: System, e: int, times: Floats, count: int, free_states: Rows, y: Floats, branch: Branch, scratch_memory: Rows,
    out: Floats, shown: Rows,
) -> bool:  # fmt: skip
    """Fill element e's signals, shape [signal, sample], of a block of free motion; return whether the law has done so."""
    return False


@compiled_inline
def show(
    system: System, e: int, times: Floats, count: int, free_states: Rows, y: Floats, branch: Branch, loads: Loads, acting: bool,
    scratch_memory: Rows, row: Floats, shown: Rows,
) -> None:  # fmt: skip
    """Fill element e's signals, shape [signal, sample], of a block in which all rotors are free; y and ``row`` are scratch."""
    if acting or not show_free(
        system, e, times, count, free_states, y, branch, scratch_memory, loads.out, shown
    ):
        for s in range(count):
            place_members(system, e, free_states, s, y)
            observe(system, e, times[s], y, branch, loads, acting, row)
            for k in range(SIGNAL_COUNTS[system.elements[e].kind]):
                shown[k, s] = row[system.elements[e].signal + k]


# Functions that only the exact derivative needs.


@dispatched(compiled_inline, required=True)
def linearise(system: System, e: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill element e's row of slopes at (t, y); return 1 where its geometry fails."""
    raise NotImplementedError


@dispatched(compiled_inline, required=True)
def add_change(
    system: System, e: int, row: Floats, z: Floats, branch: Branch, force: Floats, dz: Floats
) -> None:
    """Add the change of element e's forces by a change z to ``force`` [rotor, (N, N, N m)], that of its rates to ``dz``."""
    ...


@dispatched(compiled_inline)
def crossing(system: System, e: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return the change by z of switch function s of element e (of touches: the penetration), that of its rate, and the rate."""
    return 0.0, 0.0, 0.0


@dispatched(compiled_inline)
def jump(system: System, e: int, before: Ints, modes: Ints) -> int:
    """Return the switch at which element e's force has just jumped, by its modes before and now; -1 for none."""
    return -1


@dispatched(compiled_inline)
def carry_sample(system: System, e: int, before: Rows, branch: Branch, z: Floats) -> None:
    """Carry a change z of the state over a sample that element e has just taken, ``before`` the memories until then."""
