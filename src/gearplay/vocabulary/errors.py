"""Exception classes, one per exit code of the command line.

Every message follows one grammar, ``path = value: what is required. What to do.``, so that the
public functions and the command line print it as it is and never need a traceback.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from typing import ClassVar, Final, NamedTuple, Self

from gearplay.vocabulary import exit_codes

VALUE_LENGTH: Final = 60
"""Longest piece of a user's value that a message repeats [characters]."""

KEY_LENGTH: Final = 40
"""Longest piece of a user's key that a message repeats [characters]."""

FAULTS_SHOWN: Final = 40
"""Faults a message lists before it only counts the rest."""


class _NoValue:
    """Type of `NO_VALUE`."""

    def __repr__(self) -> str:
        return "NO_VALUE"

    def __reduce__(self) -> str:
        return "NO_VALUE"


NO_VALUE: Final = _NoValue()
"""Stands for "no value to show", since ``None`` is a value."""


def escape_controls(text: str) -> str:
    r"""Write control, format and surrogate characters as escapes.

    Examples
    --------
    >>> print(escape_controls("a\x1b[31m\nb"))
    a\x1b[31m\nb

    """
    if text.isprintable():
        return text
    return "".join(
        character.encode("unicode_escape").decode("ascii")
        if unicodedata.category(character) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")
        else character
        for character in text
    )


def shorten(text: str, length: int = VALUE_LENGTH) -> str:
    """Escape `text` and cut it to about `length` characters, marking the cut with ``...``.

    Examples
    --------
    >>> shorten("x" * 100, 10)
    'xxxxxxx...'

    """
    escaped = escape_controls(text[: length + 1])
    return escaped if len(escaped) <= length else escaped[: length - 3] + "..."


def show_value(value: object) -> str:
    """Show a user's value on one short line, as a case file would write it.

    Containers are named, not listed, since they can be of any size.

    Examples
    --------
    >>> show_value("20 deg"), show_value(True), show_value([1, 2, 3]), show_value({"a": 1})
    ('"20 deg"', 'true', 'a list of 3', 'a table of 1')

    """
    if isinstance(value, str):
        return f'"{shorten(value)}"'
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple, set, frozenset)):
        return f"a list of {len(value)}"
    if isinstance(value, dict):
        return f"a table of {len(value)}"
    if value is None:
        return "none"
    if isinstance(value, int) and value.bit_length() > 200:
        return "an integer of more than 60 digits"
    if isinstance(value, (bytes, bytearray)):
        return f"{len(value)} bytes"
    try:
        return shorten(repr(value))
    except Exception:  # a foreign object may fail even at this; the message must not
        return f"a value of type {shorten(type(value).__name__)}"


def join_path(parts: Iterable[object]) -> str:
    """Write the parts of a field's path with dots; a key that is no plain name is quoted and shortened.

    Examples
    --------
    >>> join_path(["meshes", 0, "backlash"]), join_path(["rotors", "a b"])
    ('meshes.0.backlash', 'rotors."a b"')

    """
    shown = []
    for part in parts:
        text = str(part)
        plain = text.isascii() and text.replace("_", "").replace("-", "").isalnum()
        shown.append(shorten(text, KEY_LENGTH) if plain else f'"{shorten(text, KEY_LENGTH)}"')
    return ".".join(shown)


class Fault(NamedTuple):
    """A fault of an input.

    Parameters
    ----------
    path
        Where it is: the field's path as a case file has it (``meshes.0.backlash``), or the file.
    value
        What was found there, or `NO_VALUE` where there is nothing to show.
    rule
        What is required, without a full stop.
    cure
        What to do, without a full stop; may be empty.

    Examples
    --------
    >>> print(Fault("rotors.pinion.mass", -1.0, "must be greater than 0 kg", "Give a positive mass"))
    rotors.pinion.mass = -1.0: must be greater than 0 kg. Give a positive mass.
    >>> print(Fault("rotors.pinion.modul", NO_VALUE, "unknown field", "Did you mean 'module'?"))
    rotors.pinion.modul: unknown field. Did you mean 'module'?

    """

    path: str
    value: object
    rule: str
    cure: str = ""

    def __str__(self) -> str:
        place = self.path if self.value is NO_VALUE else f"{self.path} = {show_value(self.value)}"
        sentences = [_with_stop(sentence) for sentence in (self.rule, self.cure) if sentence]
        return f"{place}: {' '.join(sentences)}"

    def as_document(self) -> dict[str, str | None]:
        """Return the fault as a JSON-able table; the value as it is shown."""
        value = None if self.value is NO_VALUE else show_value(self.value)
        return {"path": self.path, "value": value, "rule": self.rule, "cure": self.cure}


def _with_stop(sentence: str) -> str:
    return sentence if sentence[-1] in ".?!" else sentence + "."


class GearplayError(Exception):
    """Base of every error that a user can cure; `exit_code` is the exit code of the command line.

    Examples
    --------
    >>> import gearplay as gp
    >>> try:
    ...     gp.load_case({})
    ... except gp.GearplayError as error:
    ...     error.exit_code
    2

    """

    exit_code: ClassVar[int] = exit_codes.BROKEN


class InputError(GearplayError):
    """Invalid or missing input; carries every `Fault` found.

    Parameters
    ----------
    faults
        One fault or several, in the order to show them.

    Examples
    --------
    >>> error = InputError.of("run.seed", -1, "must be 0 or more")
    >>> str(error), error.exit_code, len(error.faults)
    ('run.seed = -1: must be 0 or more.', 2, 1)

    """

    exit_code = exit_codes.INPUT

    def __init__(self, faults: Fault | Iterable[Fault]) -> None:
        self.faults: list[Fault] = [faults] if isinstance(faults, Fault) else list(faults)
        super().__init__(self.faults)

    @classmethod
    def of(cls, path: str, value: object, rule: str, cure: str = "") -> Self:
        """Return the error of one `Fault`."""
        return cls(Fault(path, value, rule, cure))

    def __str__(self) -> str:
        lines = [str(fault) for fault in self.faults[:FAULTS_SHOWN]]
        rest = len(self.faults) - FAULTS_SHOWN
        if rest > 0:
            lines.append(f"... and {rest} more faults.")
        return "\n".join(lines)


class TakenError(InputError):
    """An output exists already and is kept: the cure is another name, or to overwrite it.

    Examples
    --------
    >>> error = TakenError(Fault("out", "run.nc", "must not exist yet", "Choose another name, or give overwrite=True"))
    >>> isinstance(error, InputError), error.exit_code
    (True, 2)

    """


class SimulationError(GearplayError):
    """A simulation could not be completed.

    Examples
    --------
    >>> import gearplay as gp
    >>> try:
    ...     gp.periodic_orbit("han2021", settle=1)
    ... except gp.SimulationError as error:
    ...     error.exit_code
    3

    """

    exit_code = exit_codes.SIMULATION


class ResourceError(GearplayError):
    """The requested work exceeds a limit on memory, disk, steps or time.

    Examples
    --------
    >>> import gearplay as gp
    >>> try:
    ...     gp.simulate("han2021", duration=1e6, sampling=1e7)
    ... except gp.ResourceError as error:
    ...     error.exit_code
    5

    """

    exit_code = exit_codes.RESOURCE


class MeasurementError(GearplayError):
    """A measurement file cannot be read, or differs from its own declarations.

    Examples
    --------
    >>> import gearplay as gp
    >>> import pathlib, tempfile
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "run.wav"
    >>> _ = place.write_bytes(b"RIFF")
    >>> try:
    ...     gp.read_measurement(place)
    ... except gp.MeasurementError as error:
    ...     error.exit_code
    6

    """

    exit_code = exit_codes.MEASUREMENT
