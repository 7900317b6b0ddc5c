"""A finding about a valid case."""

from __future__ import annotations

from typing import Literal, NamedTuple


class Finding(NamedTuple):
    """Finding of `gearplay check`.

    Parameters
    ----------
    severity
        ``warning`` for numbers that are probably unintended, ``note`` for information.
    path
        Field or part of the case it is about.
    message
        Sentences for people.

    """

    severity: Literal["warning", "note"]
    path: str
    message: str

    def __str__(self) -> str:
        return f"{self.severity}: {self.path}: {self.message}"

    def as_document(self) -> dict[str, str]:
        """Return the finding as a JSON-able table."""
        return self._asdict()


def micrometres(change: float) -> str:
    """Return a change of a length [m] as a text with its sign, 0.1 um the least.

    >>> micrometres(-2.07e-5), micrometres(-1e-12)
    ('-20.7 um', '+0.0 um')
    """
    return f"{round(1e6 * change, 1) + 0.0:+.1f} um"
