"""Error messages for inconsistent files, limits, and translation of library errors."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Final

import numpy as np

from gearplay.vocabulary.errors import NO_VALUE, Fault, GearplayError, InputError, MeasurementError, shorten
from gearplay.vocabulary.optional import cure_for

LARGEST_FILE: Final = 4 * 2**30
"""Largest file that is read [bytes]."""

LARGEST_TEXT: Final = 512 * 2**20
"""Largest text file that is read [bytes]: its numbers need several times its size in memory."""

MOST_SAMPLES: Final = 2**29
"""Most samples of all chosen channels together: 4 GiB as they are kept in memory."""

MOST_NODES: Final = 200_000
"""Most chunks, segments or objects that a file may consist of."""

DENSEST: Final = 1100
"""Most bytes that one stored byte can unpack to; deflate reaches 1032."""

AGAIN: Final = "The file is cut or damaged: copy or export it again"
"""The cure where a file holds less than it declares."""


UNREADABLE: Final = "The file is damaged, or of a kind that is not read: export it again in another way"
"""The cure where a library refuses a file."""


def damaged(path: Path, rule: str, cure: str = AGAIN) -> MeasurementError:
    """Return the error of a damaged file: its name, the fault, the cure.

    >>> print(damaged(Path("data/run.wav"), "declares 8 samples and holds 5"))
    run.wav: declares 8 samples and holds 5. The file is cut or damaged: copy or export it again.
    """
    return MeasurementError(str(Fault(shorten(path.name), NO_VALUE, rule, cure)))


def quoted(text: str) -> str:
    r"""Return a text from the file for messages: quoted, escaped, at most 40 characters.

    >>> print(quoted("acc"), quoted("1\xa02"), quoted("a\n"))
    'acc' '1 2' 'a\n'
    """
    shown = shorten(text, 40)
    return f"'{shown if shown.isprintable() else ' '.join(shown.split())}'"  # other kinds of blanks than ours


def decoded(content: bytes) -> str:
    r"""Return text that is UTF-8, or else Latin-1, in which any byte is a letter.

    >>> print(decoded("m/s²".encode()), decoded("m/s²".encode("latin-1")))
    m/s² m/s²
    """
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def check_samples(path: Path, count: int) -> None:
    """Raise `MeasurementError` where more samples are declared than are kept in memory."""
    if count > MOST_SAMPLES:
        rule = f"declares {count} samples; at most {MOST_SAMPLES} are read at once"
        raise damaged(path, rule, "Choose fewer channels, or split the file")


def need(module: str, package: str, path: Path) -> ModuleType:
    """Import an optional package.

    Raises `InputError` with the command that installs it where it is missing.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return import_module(module)
    except ImportError:
        rule = f"needs the package {package}, which is not installed"
        raise InputError.of("file", shorten(path.name), rule, cure_for("measurements")) from None


@contextmanager
def fenced(path: Path, kind: str) -> Iterator[None]:
    """Run a library's reader; convert all its exceptions to a `MeasurementError` with the file and its kind."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            yield
        except (GearplayError, MemoryError):
            raise
        except Exception as error:  # a library fed with damaged bytes can raise anything
            words = (str(error).splitlines() or [""])[0]
            shown = shorten(f"{type(error).__name__}: {words}" if words else type(error).__name__, 120)
            raise damaged(path, f"must be a readable {kind} file ({shown})", UNREADABLE) from None


class Complaints(logging.Handler):
    """Warnings that a library logs about a file it does not refuse."""

    def __init__(self, package: str) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []
        for name in [package, *(n for n in logging.root.manager.loggerDict if n.startswith(f"{package}."))]:
            logger = logging.getLogger(name)
            logger.handlers, logger.propagate = [self], False

    def emit(self, record: logging.LogRecord) -> None:
        """Keep the text of one warning."""
        self.texts.append(record.getMessage())

    def refuse(self, path: Path, kind: str) -> None:
        """Raise `MeasurementError` with the first complaint, if there is one."""
        if self.texts:
            raise damaged(path, f"must be a readable {kind} file ({shorten(self.texts[0], 120)})", UNREADABLE)
