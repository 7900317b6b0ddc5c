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
