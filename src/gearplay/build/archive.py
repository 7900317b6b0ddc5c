"""Static libraries: archives of object files, with the index of symbols that linkers look for."""

import os
import struct
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from gearplay.build.targets import host
from gearplay.kernels.library import PACKAGE, SOURCES, LibraryError, content_digest, find, folders

ARCHIVE: Final = ".a"
_MAGIC: Final = b"!<arch>\n"


def archive(objects: Sequence[Path], symbols: Sequence[str], folder: Path) -> Path:
    """Write an archive of object files, each of which defines one symbol, into a folder; return its file.

    The format is that of GNU ar, which linkers for Windows read too: a member "/" with the offset of each symbol's member.
    """
    contents = [file.read_bytes() for file in objects]
    names = b"".join(symbol.encode("ascii") + b"\0" for symbol in symbols)
    index_size = 4 + 4 * len(symbols) + len(names)
    at, offsets = len(_MAGIC) + 60 + index_size + index_size % 2, []
    for content in contents:
        offsets.append(at)
        at += 60 + len(content) + len(content) % 2
    index = struct.pack(f">I{len(offsets)}I", len(offsets), *offsets) + names
    parts = [_MAGIC, *_member("/", index)]
    for n, content in enumerate(contents):
        parts += _member(f"{n}.o/", content)
    whole = b"".join(parts)
    file = folder / f"gearplay-{SOURCES}-{content_digest(whole)}{ARCHIVE}"
    beside = file.with_suffix(".part")
    beside.write_bytes(whole)
    os.replace(beside, file)
    return file


def _member(name: str, content: bytes) -> list[bytes]:
    head = f"{name:<16}{0:<12}{0:<6}{0:<6}{'644':<8}{len(content):<10}`\n"
    return [head.encode("ascii"), content, b"\n" * (len(content) % 2)]


def static_library(target: str) -> Path:
    """Return the kernels of a platform as a static library; built in a child process if missing.

    Raises `LibraryError` where it cannot be built.
    """
    found = _find(target)
    if found is None:
        paths = [str(PACKAGE.parent), os.environ.get("PYTHONPATH", "")]
        done = subprocess.run(
            [sys.executable, "-m", "gearplay.build", "--static", "--target", target],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))},
            stdout=subprocess.PIPE,
            text=True,
            check=False,
        )
        found = _find(target)
        if done.returncode != 0 or found is None:
            said = (done.stdout.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
            raise LibraryError(f"The kernels for {target} could not be built: {said}")
    return found


def _find(target: str) -> Path | None:
    places = [folder if target == host() else folder / target for folder in folders()]
    return next(filter(None, (find(place, ARCHIVE) for place in places if place.is_dir())), None)
