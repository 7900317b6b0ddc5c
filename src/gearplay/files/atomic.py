"""Atomic writing: files are complete or absent, and only plain files of the user are replaced; checksum at a file's end."""

import hashlib
import os
import secrets
import shutil
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final

from gearplay.vocabulary.errors import InputError, TakenError

MARK: Final = b"gearplay sha256:"
"""Marker at the end of a file, before the SHA-256 of all bytes before it; HDF5 reads only up to its own end."""
LENGTH: Final = len(MARK) + hashlib.sha256().digest_size
"""Of marker and digest [bytes]."""

KINDS = (
    (stat.S_ISDIR, "a folder", "Add a file name."),
    (stat.S_ISLNK, "a link", "Name the file itself, or remove the link."),
    (stat.S_ISFIFO, "a pipe", "Choose a file name."),
    (stat.S_ISSOCK, "a socket", "Choose a file name."),
    (stat.S_ISCHR, "a device", "Choose a file name."),
    (stat.S_ISBLK, "a device", "Choose a file name."),
)


def shown_path(path: Path) -> str:
    """Return a path for messages; only the end of a long one, which holds the name."""
    text = str(path)
    return text if len(text) <= 56 else f"...{text[-53:]}"


def _refusal(path: Path, rule: str, cure: str = "Choose another place.") -> InputError:
    return InputError.of("out", shown_path(path), rule, cure)


def _taken(path: Path, rule: str) -> TakenError:
    return TakenError.of("out", shown_path(path), rule, "Choose another name, or give overwrite=True.")


def check_new(path: Path, *, overwrite: bool, size: float = 0.0) -> None:
    """Refuse a file that cannot be written, or exists and may not be replaced (`TakenError`); called before the computation.

    Only a plain file of this user's own is ever replaced. ``size`` is about how large it will be [bytes], if that is known.
    """
    found = _status(path)
    if found is not None and stat.S_ISREG(found.st_mode) and not overwrite:
        raise _taken(path, "must not exist yet")
    _check_replaceable(path, found)
    folder = next((each for each in (path.parent, *path.parent.parents) if each.exists()), path.parent)
    if not folder.is_dir():
        raise _refusal(path, f"must be in a folder; {folder.name} is a file")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise _refusal(path, "must be in a folder that can be written")
    free = shutil.disk_usage(folder).free
    if size > free:
        rule = f"needs {size / 1e6:.3g} MB; its disk has {free / 1e6:.3g} MB free"
        raise _refusal(path, rule, "Free some space or choose another place.")


def _status(path: Path) -> os.stat_result | None:
    """Return the status of a file, None where there is none; `InputError` for a name that is too long or has a null character."""
    try:
        return os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        raise _refusal(path, f"must be a file name ({_words(error)})", "Choose another name.") from None


def _check_replaceable(path: Path, found: os.stat_result | None) -> None:
    if found is None:
        return
    for is_kind, words, cure in KINDS:
        if is_kind(found.st_mode):
            raise _refusal(path, f"must be a file, not {words}", cure)
    if hasattr(os, "geteuid") and found.st_uid != os.geteuid():
        raise _refusal(path, "must not be somebody else's file", "Choose another name, or remove it first.")


def _words(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error)


def make_folder(path: Path) -> None:
    """Create a folder and its parents; `InputError` where that is not possible."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise _refusal(path, f"must be a folder that can be written ({_words(error)})") from None


@contextmanager
def replacing(path: Path, *, overwrite: bool = True) -> Iterator[Path]:
    """Yield a temporary name in the folder of ``path``; on success sync the file and rename it to ``path``, else remove it.

    Without ``overwrite`` a file that is there by then is kept: of two processes that write the same name one is refused. A new
    file has the mode that the umask leaves, a replaced one keeps its own.

    Raises `InputError` where the folder is missing, read-only or full, or what is there is not a plain file of this user's own.
    """
    make_folder(path.parent)
    stem = path.name if len(os.fsencode(path.name)) < 200 else "result"  # a name has 255 bytes
    # known before it is there: whatever ends this removes it
    name = str(path.parent / f".{stem}.{secrets.token_hex(6)}.part")
    try:
        os.close(os.open(name, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o666))
        yield Path(name)
        with open(name, "rb+") as file:
            os.fsync(file.fileno())
        found = _status(path)
        _check_replaceable(path, found)
        if found is not None:
            os.chmod(name, stat.S_IMODE(found.st_mode))
        if overwrite:
            os.replace(name, path)
        else:
            _rename_once(name, path)
        _sync_folder(path.parent)
    except OSError as error:
        rule = f"must be writable ({_words(error)})"
        raise _refusal(path, rule, "Free some space or choose another place.") from None
    finally:
        with suppress(OSError):  # it has its name, or the disk is read-only by now
            os.unlink(name)


def _rename_once(name: str, path: Path) -> None:
    """Rename a file without replacing an existing one; `TakenError` where the name exists."""
    try:
        try:
            os.link(name, path)
        except FileExistsError:
            raise
        except OSError:  # a file system without links
            _create_then_replace(name, path)
    except FileExistsError:
        raise _taken(path, "must not exist yet; it has come up meanwhile") from None


def _create_then_replace(name: str, path: Path) -> None:
    """Create an empty file of that name and replace it; `FileExistsError` where the name exists."""
    if os.path.lexists(path):
        raise FileExistsError
    try:
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        os.replace(name, path)
    except FileExistsError:
        raise
    except BaseException:
        if os.path.exists(name):  # not moved: the name is that of the empty file
            with suppress(OSError):
                os.unlink(path)
        raise


def _sync_folder(folder: Path) -> None:
    if not hasattr(os, "O_DIRECTORY"):  # a system whose folders cannot be opened
        return
    handle = os.open(folder, os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_with(path: Path, write: Callable[[Path], Any], *, overwrite: bool = True) -> None:
    """Write a file through ``write(temporary path)``, atomically."""
    with replacing(path, overwrite=overwrite) as temporary:
        write(temporary)


def write_text(path: Path, text: str, *, overwrite: bool = True) -> None:
    """Write a text file atomically, UTF-8, as it is."""
    write_bytes(path, text.encode("utf-8"), overwrite=overwrite)


def write_bytes(path: Path, content: bytes, *, overwrite: bool = True) -> None:
    """Write a binary file atomically."""
    write_with(path, lambda temporary: temporary.write_bytes(content), overwrite=overwrite)


def write_figures(folder: Path, figures: Mapping[str, bytes], *, add: bool = False) -> None:
    """Write PNGs by name into ``folder/figures``, each atomically; remove all others there, or ``add`` to them."""
    for name, png in figures.items():
        write_bytes(folder / "figures" / f"{name}.png", png)
    for stale in (folder / "figures").glob("*.png"):
        if not add and stale.stem not in figures:
            stale.unlink()


def with_checksum(content: bytes) -> bytes:
    """Return content followed by the marker and its digest, so that damage is detected.

    >>> len(with_checksum(b"abc")) - LENGTH
    3
    """
    return content + MARK + hashlib.sha256(content).digest()
