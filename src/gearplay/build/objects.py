"""Machine code of the kernels: an object file of each kernel and platform, kept by its key, compiled by several processes."""

import json
import os
import re
import signal
import threading
import uuid
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from importlib import import_module
from multiprocessing import active_children, get_context, parent_process
from pathlib import Path

import llvmlite.binding as llvm

from gearplay.build.compiler import compile_kernel
from gearplay.build.dependencies import key_of
from gearplay.build.targets import TARGETS
from gearplay.kernels.by_address import FORMS, group_forms
from gearplay.kernels.compiled_once import KERNELS
from gearplay.kernels.library import PACKAGE, LibraryError, content_digest, source_files
from gearplay.vocabulary.cores import worker_count

INTERVAL = 10.0
"""Longest time [s] between two reports of progress."""

llvm.initialize_all_targets()
llvm.initialize_all_asmprinters()


def import_kernels() -> None:
    """Import every module that defines kernels or groups of arrays."""
    for file in source_files():
        place = file.relative_to(PACKAGE.parent).with_suffix("").parts
        if place[1] != "build":
            import_module(".".join(place).removesuffix(".__init__"))


def object_files(
    folder: Path, targets: Sequence[str], progress: Callable[[int, int], None]
) -> dict[str, list[Path]]:
    """Return the object files of all kernels for each platform, kernels in the order of their names; compile missing ones.

    ``folder`` keeps them; what is complete stays there when the build ends early. ``progress`` gets what there is of all: what
    was kept at first, then more, at least every `INTERVAL`. It is not called where nothing is missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    import_kernels()
    names = sorted(KERNELS)
    keys = {name: {each: key_of(KERNELS[name], TARGETS[each]) for each in targets} for name in names}
    lacking = [name for name in names if None in [_find(folder, key) for key in keys[name].values()]]
    lacking.sort(key=_length, reverse=True)
    if lacking:
        total = sum(map(_length, names))
        done = total - sum(map(_length, lacking))
        progress(done, total)
        workers = min(worker_count(), len(lacking))
        with ProcessPoolExecutor(workers, get_context("spawn"), _begin) as pool:
            try:
                jobs = {pool.submit(_compile, folder, name, keys[name]): name for name in lacking}
                while jobs:
                    for job in wait(jobs, INTERVAL, FIRST_COMPLETED).done:
                        job.result()
                        done += _length(jobs.pop(job))
                    progress(done, total)
            except BaseException:
                for process in active_children():
                    process.terminate()
                raise
    return {each: [_kept(folder, keys[name][each]) for name in names] for each in targets}


def _kept(folder: Path, key: str) -> Path:
    """Return the object file of a key; update its time of modification, since unused files are removed."""
    file = _find(folder, key)
    if file is None:
        raise LibraryError(f"{folder / key}-*.o was removed or damaged during the build. Start again.")
    os.utime(file)
    return file


def _length(name: str) -> int:
    """Return the size of a kernel's code, a measure of its compilation time."""
    return len(KERNELS[name].py_func.__code__.co_code)


def _begin() -> None:
    """Initialise a compiler process: it ends with its parent and ignores Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def end_with_parent() -> None:
        parent = parent_process()
        if parent is not None:
            parent.join()
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
    import_kernels()


def _compile(folder: Path, name: str, keys: Mapping[str, str]) -> None:
    """Compile a kernel and write its object files."""
    text = str(compile_kernel(KERNELS[name]))
    for target, key in keys.items():
        write_object(folder, key, machine_code(text, target))


def machine_code(text: str, target: str) -> bytes:
    """Return the object file of a module's text for a platform."""
    text = re.sub(r'^target (triple|datalayout) = ".*"$', "", text, flags=re.MULTILINE)
    made = TARGETS[target]
    machine = llvm.Target.from_triple(made.triple).create_target_machine(
        cpu=made.processor, features="", opt=3, reloc="pic", codemodel="default"
    )
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = made.triple, str(machine.target_data)
    return bytes(machine.emit_object(module))


def forms_object(folder: Path, target: str) -> Path:
    """Write the object file of the forms of all groups; return the file."""
    text = json.dumps(group_forms()).encode() + b"\0"
    spelt = "".join(f"\\{byte:02x}" for byte in text)
    content = machine_code(f'@{FORMS} = constant [{len(text)} x i8] c"{spelt}"', target)
    return write_object(folder, f"forms-{target}", content)


def _find(folder: Path, key: str) -> Path | None:
    """Return the object file of a key; None if it is missing, or its content does not match its name."""
    for file in folder.glob(f"{key}-*.o"):
        if file.stem.rpartition("-")[2] == content_digest(file.read_bytes()):
            return file
    return None


def write_object(folder: Path, key: str, content: bytes) -> Path:
    """Write an object file by its key and content, complete or not at all."""
    file = folder / f"{key}-{content_digest(content)}.o"
    beside = folder / f"{uuid.uuid4().hex}.part"
    try:
        beside.write_bytes(content)
        os.replace(beside, file)
    finally:
        beside.unlink(missing_ok=True)
    return file
