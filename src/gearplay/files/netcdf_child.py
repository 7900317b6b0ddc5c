"""The process that reads result files without a digest for `netcdf`: it may crash, hang or run out of memory alone."""

import contextlib
import json
from pathlib import Path
from typing import IO

from gearplay.files.apart import refusal_said, serve
from gearplay.files.netcdf import read_unsealed
from gearplay.vocabulary.errors import InputError

MOST_MEMORY = 8_000_000_000
"""Address space [bytes] that a file may take to be read."""


def answer(line: bytes, pipe: IO[bytes]) -> None:
    """Answer one question: a line with a number of bytes and these, or a line that says why not."""
    asked = json.loads(line)
    content = b""
    try:
        content = read_unsealed(Path(asked["path"]), asked["size"])
        said: dict[str, object] = {"bytes": len(content)}
    except InputError as error:
        said = refusal_said(error)
    pipe.write(json.dumps(said).encode() + b"\n" + content)
    pipe.flush()


def main() -> None:
    """Answer questions until there are no more."""
    with contextlib.suppress(ImportError, OSError, ValueError):  # a system without such limits
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    serve(answer)
