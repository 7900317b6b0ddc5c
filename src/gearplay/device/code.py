"""A turn's code for a device: from its file, or compiled, which takes minutes, and kept."""

import hashlib
from collections.abc import Callable, Iterable
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from gearplay.device.fleet import Turn
from gearplay.kernels import compiled_files, joined
from gearplay.kernels.elements.table import KINDS
from gearplay.kernels.layout import System
from gearplay.kernels.machine_code import Code
from gearplay.kernels.run import Run
from gearplay.kernels.signed import form_of

if TYPE_CHECKING:
    from gearplay.device.driver import Device


def unneeded(systems: Iterable[System]) -> frozenset[str]:
    """Return the modules of kernels that none of some mechanisms needs."""
    present: set[int] = set()
    springs = False
    for system in systems:
        present.update(system.elements["kind"].tolist())
        springs = springs or system.joined.chains.size > 0
    absent = {each.file.__name__ for number, each in enumerate(KINDS) if number not in present}
    return frozenset(absent if springs else absent | {joined.__name__})


def code_for(
    without: frozenset[str], capability: tuple[int, int], compiling: Callable[[], None] = lambda: None
) -> Code:
    """Return the code of a turn; groups of all classes have been made. ``compiling`` is called where that must be done."""
    sources = compiled_files.kernel_digest(Path(__file__).parent)
    form = repr((form_of(System), form_of(Run), version("numba-cuda"), sources))
    form = hashlib.sha256(form.encode()).hexdigest()[:16]
    which = hashlib.sha256(repr(sorted(without)).encode()).hexdigest()[:8]
    file = compiled_files.file_of(f"turn.sm{capability[0]}{capability[1]}.{which}")
    code = None if file is None else compiled_files.load(file, form)
    if code is None:
        compiling()
        from gearplay.device.translate import compile_turn

        code = compile_turn(without, capability)
        if file is not None:
            compiled_files.save(file, code, form)
    return code


def turn_of(device: "Device", without: frozenset[str], compiling: Callable[[], None] = lambda: None) -> Turn:
    """Return what lets runs take a turn on a device (`code_for`)."""
    function = device.load(code_for(without, device.capability, compiling))

    def turn(count: int, steps: int, plan: int) -> None:
        device.launch(function, count, count, steps, plan)

    return turn
