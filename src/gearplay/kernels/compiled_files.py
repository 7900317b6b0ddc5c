"""Compiled code on disk: a folder for each version of the package, a file for each kernel, its digest before it.

numba's own files know their version by an index beside them and hold whatever bytes are in them: of two versions that compile
at the same time, one could load the code of the other, and a changed byte would be run. What is written is pickled, as in numba's
own files: whoever may write into the folder may also write the package, and no file that a user is sent comes from here.
"""

import hashlib
import os
import pickle
import shutil
import uuid
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from numba.core.serialize import dumps

VERSIONS: Final = 4
"""Folders of versions that stay, the latest: compiled code of a package that was updated is of no use."""
NAME: Final = "gearplay-"
SIZE: Final = hashlib.sha256().digest_size

not_kept: list[str] = []
"""Why compiled code could not be written, in words, once in a process; for the solver to tell."""


class CompiledFiles:
    """Where numba puts the compiled code of one kernel: stands in for its index file, ``load`` and ``save``."""

    def __init__(self, folder: Path, name: str) -> None:
        self.folder = folder
        self.name = name

    def flush(self) -> None:
        """Forget what was compiled."""
        for file in self.folder.glob(f"{self.name}.*.code"):
            file.unlink(missing_ok=True)

    def load(self, key: Any) -> Any:
        """Return what was saved for a key; None where there is nothing, or what is there is damaged or of another key."""
        try:
            whole = self._file(key).read_bytes()
        except OSError:
            return None
        digest, rest = whole[:SIZE], whole[SIZE:]
        if hashlib.sha256(rest).digest() != digest:
            return None
        saved, data = pickle.loads(rest)
        return data if saved == key else None

    def save(self, key: Any, data: Any) -> None:
        """Save what was compiled for a key; where that fails say why, once: the code runs all the same."""
        rest: bytes = dumps((key, data))  # type: ignore[no-untyped-call]
        file = self._file(key)
        beside = file.with_name(f"{file.name}.{uuid.uuid4().hex[:16]}")
        try:
            if not self.folder.is_dir():
                self.folder.mkdir(parents=True, exist_ok=True)
                forget_old(self.folder)
            beside.write_bytes(hashlib.sha256(rest).digest() + rest)
            os.replace(beside, file)
        except OSError as error:
            with suppress(OSError):
                beside.unlink(missing_ok=True)
            note(f"{self.folder.parent}: {error.strerror or error}")

    def _file(self, key: Any) -> Path:
        return self.folder / f"{self.name}.{hashlib.sha256(str(key).encode()).hexdigest()[:16]}.code"


def note(why: str) -> None:
    """Note why compiled code is not kept."""
    if not not_kept:
        not_kept.append(why)


def forget_old(newest: Path) -> None:
    """Remove folders of other versions beside one, but for the latest: another process that needs one compiles anew."""
    others = []
    with suppress(OSError):
        for folder in newest.parent.glob(f"{NAME}*"):
            if folder != newest and folder.is_dir() and not folder.is_symlink():
                others.append((folder.stat().st_mtime, folder))
    for _, folder in sorted(others)[: -(VERSIONS - 1)]:
        shutil.rmtree(folder, ignore_errors=True)
