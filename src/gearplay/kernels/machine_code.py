"""Loading of a kernel's machine code by LLVM's linker alone, without the compiler."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import llvmlite
import llvmlite.binding as llvm


@dataclass(frozen=True)
class Code:
    """What a kernel was compiled to."""

    symbol: str  # its name there
    needs: list[str]  # names of what it calls: other kernels, and the mathematics of C
    content: bytes


_linked: list[llvm.ExecutionEngine] = []
"""Of all code that is in use."""
_linking = threading.Lock()


@cache
def _machine() -> llvm.Target:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple()


def processor() -> tuple[str, ...]:
    """Return what machine code depends on: the system, the processor and what it can do, LLVM's version."""
    features = llvm.get_host_cpu_features().flatten()
    return llvm.get_process_triple(), llvm.get_host_cpu_name(), features, llvmlite.__version__


def link(code: Code, known: Callable[[str], int | None]) -> int | None:
    """Return the address of a kernel; None where something that it needs is not there.

    ``known`` returns the address of what asks for another kernel, None for a name that is not one's.
    """
    with _linking:
        # One engine for each: names within the code of two kernels may be the same. The first makes C's functions known.
        engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine().create_target_machine())
        for name in code.needs:
            if (address := known(name)) is not None:
                llvm.add_symbol(name, address)
            elif llvm.address_of_symbol(name) is None:
                return None
        engine.add_object_file(llvm.ObjectFileRef.from_data(code.content))
        engine.finalize_object()
        _linked.append(engine)
        return engine.get_function_address(code.symbol) or None
