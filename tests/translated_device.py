"""What numba-cuda makes of the kernels, run by the processor: a program that compares it with the kernels themselves.

numba-cuda writes LLVM's code before a device's own compiler takes over. Here LLVM compiles that for the processor instead, with
C's mathematics in the place of the device's, and threads one after the other: the translation, groups and the memory's layout are
those of the device. Runs in a process of its own, because LLVM's pointers must be written as LLVM of today does, not as the
device's compiler wants them. Prints, for each case, the largest difference of states and the counts of both, as JSON.
"""

import ctypes
import json
import re
import sys
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numba.cuda.codegen import CUDACodeLibrary
from tests.emulated_device import Emulated

import gearplay as gp
from gearplay.device import translate
from gearplay.device.code import unneeded
from gearplay.kernels.layout import System
from gearplay.kernels.run import Run
from gearplay.solver import on_device
from gearplay.solver.simulate import run_batch

MATHEMATICS = (
    "acos", "asin", "atan", "atan2", "copysign", "cos", "exp", "expm1", "fabs", "floor", "fmax", "fmin", "log", "log1p", "pow",
    "sin", "sqrt",
)  # fmt: skip
AROUND = """
declare double @llvm.fabs.f64(double)
define i32 @__nv_isfinited(double %x) {
  %size = call double @llvm.fabs.f64(double %x)
  %finite = fcmp olt double %size, 0x7FF0000000000000
  %whole = zext i1 %finite to i32
  ret i32 %whole
}
@thread = global i32 0
define i32 @place_tid.x() {
  %number = load i32, ptr @thread
  ret i32 %number
}
define i32 @place_ctaid.x() {
  ret i32 0
}
define i32 @place_ntid.x() {
  ret i32 1
}
"""


class _WrittenError(Exception):
    """The code has been written: the device's compiler is not asked."""


def written(systems: list[System]) -> tuple[list[str], str]:
    """Return LLVM's code of a turn, module by module, and the name of its function."""
    found: dict[str, Any] = {}

    def keep(library: CUDACodeLibrary, cc: Any = None) -> str:
        found.update(code=library.llvm_strs, name=library.name)
        raise _WrittenError

    asked, CUDACodeLibrary.get_asm_str = CUDACodeLibrary.get_asm_str, keep
    try:
        translate.compile_turn(unneeded(systems), (9, 0))
    except _WrittenError:
        pass
    finally:
        CUDACodeLibrary.get_asm_str = asked
    return found["code"], "make_turn"


class Translated(Emulated):
    """A device whose turns are the translated ones."""

    def __init__(self) -> None:
        super().__init__()
        self.turns: list[Any] = []

    def turn_for(self, systems: list[System], run: Run) -> Any:
        code, name = written(systems)
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        machine = llvm.Target.from_default_triple().create_target_machine(opt=1)
        triple, layout = llvm.get_process_triple(), str(machine.target_data)

        def here(text: str) -> str:
            text = re.sub(r"target triple = .*", f'target triple = "{triple}"', text)
            text = re.sub(r"target datalayout = .*", f'target datalayout = "{layout}"', text)
            text = text.replace("llvm.nvvm.read.ptx.sreg.", "place_").replace("addrspacecast", "bitcast")
            return re.sub(r"addrspace\(\d\)", "", text)

        whole = llvm.parse_assembly(AROUND)
        for text in code:
            whole.link_in(llvm.parse_assembly(here(text)))
        mathematics = ctypes.CDLL(None)
        for each in MATHEMATICS:
            address = ctypes.cast(getattr(mathematics, each), ctypes.c_void_p).value
            llvm.add_symbol(f"__nv_{each}", address)
        engine = llvm.create_mcjit_compiler(whole, machine)
        engine.finalize_object()
        (entry,) = [
            f.name
            for f in whole.functions
            if name in f.name and not f.is_declaration and f.linkage == llvm.Linkage.external
        ]
        word = ctypes.c_int64
        function = ctypes.CFUNCTYPE(None, word, word, word)(engine.get_function_address(entry))
        thread = ctypes.c_int32.from_address(engine.get_global_value_address("thread"))

        def turn(count: int, steps: int, plan: int) -> None:
            self.threads.append(count)
            for k in range(count + 1):  # one more than there are runs: it must do nothing
                thread.value = k
                function(count, steps, plan)

        self.turns.append((engine, turn))  # lives as long as it is called
        return turn


def main(cases: dict[str, list[str]]) -> dict[str, Any]:
    """Return what differs, case by case: by name, with changes."""
    device, known = Translated(), {}
    turn_for = device.turn_for

    def turn_once(systems: list[System], run: Run) -> Any:
        key = unneeded(systems)
        if key not in known:
            known[key] = turn_for(systems, run)
        return known[key]

    device.turn_for = turn_once  # type: ignore[method-assign]
    devices = device.devices
    on_device.cuda = lambda: devices
    found = {}
    for words, changes in cases.items():
        case = gp.load_case(words.split()[0], ["run.transient=0", *changes])
        ours, theirs = (run_batch([(case, range(40))], signals=[], device=d)[0] for d in ("cuda", "cpu"))
        pairs = list(zip(ours, theirs, strict=True))
        found[words] = {
            "state": max(float(np.abs(one.final_state - other.final_state).max()) for one, other in pairs),
            "counts": [
                [sum(getattr(run.counters, name) for run in runs) for runs in (ours, theirs)]
                for name in ("steps", "rejected_steps", "events", "calls")
            ],
            "logs": all(np.array_equal(one.log, other.log) for one, other in pairs),
        }
    return found


if __name__ == "__main__":
    sys.stdout.write(f"{json.dumps(main(json.loads(sys.argv[1])))}\n")
