"""Counts of the outcomes of cases, in one wording for files, pages, commands and messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

MISSING: Final = -1
"""Status of a case that has not been run yet; 0 is done, more than 0 a failure."""

MOST_REASONS: Final = 5
"""Number of reasons that are listed."""


@dataclass(frozen=True)
class Account:
    """Number of cases by status, and the reasons of failures with their counts, the most frequent first.

    >>> print(Account.of([0, 0, 3, -1], ["", "", "Too many steps.", ""]))
    4 cases: 2 finished, 1 failed, 1 not run yet
    """

    finished: int
    failed: int
    missing: int
    reasons: tuple[tuple[str, int], ...] = ()

    @classmethod
    def of(cls, status: ArrayLike, reasons: ArrayLike) -> Account:
        """Return the account of cases from the status and the reason of each, arrays of one shape."""
        found = np.asarray(status).ravel()
        words = np.asarray(reasons, dtype=object).ravel()[found > 0]
        counted = Counter(str(each) for each in words if each)
        return cls(int(np.sum(found == 0)), int(np.sum(found > 0)), int(np.sum(found < 0)), _ordered(counted))

    @classmethod
    def sum(cls, parts: Iterable[Account]) -> Account:
        """Return the account of cases that come in parts."""
        finished = failed = missing = 0
        counted = Counter[str]()
        for part in parts:
            finished, failed, missing = finished + part.finished, failed + part.failed, missing + part.missing
            counted.update(dict(part.reasons))
        return cls(finished, failed, missing, _ordered(counted))

    @property
    def cases(self) -> int:
        """All of them."""
        return self.finished + self.failed + self.missing

    @property
    def complete(self) -> bool:
        """Whether every case was finished."""
        return self.finished == self.cases

    def as_document(self) -> dict[str, Any]:
        """Return a JSON-able table: how many failed, how many have not been run, and the most frequent reasons."""
        return {
            "failed": self.failed,
            "missing": self.missing,
            "reasons": [reason for reason, _ in self.reasons[:MOST_REASONS]],
        }

    def __str__(self) -> str:
        parts = [f"{self.finished} finished", f"{self.failed} failed"]
        if self.missing:
            parts.append(f"{self.missing} not run yet")
        return f"{self.cases} case{'s' if self.cases != 1 else ''}: " + ", ".join(parts)


def _ordered(counted: Counter[str]) -> tuple[tuple[str, int], ...]:
    return tuple(sorted(counted.items(), key=lambda each: (-each[1], each[0])))
