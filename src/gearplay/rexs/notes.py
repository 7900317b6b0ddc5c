"""Notes of an import: assumptions and omissions, each with its consequence."""

from dataclasses import dataclass
from typing import Final

SHOWN: Final = 4
"""Components that a note names before it counts the rest."""


@dataclass(frozen=True)
class Note:
    """One note: a kind (``assumed``, ``left out`` or ``not read``), and its subject with the consequence."""

    kind: str
    text: str

    def __str__(self) -> str:
        return f"{self.kind}: {self.text}"


class Notes:
    """Notes in order; notes that differ only in their subject are merged."""

    def __init__(self) -> None:
        self._about: dict[Note, list[str]] = {}

    def _add(self, kind: str, text: str, about: object) -> None:
        named = self._about.setdefault(Note(kind, text), [])
        if about is not None and str(about) not in named:
            named.append(str(about))

    def assume(self, text: str, about: object = None) -> None:
        """Note a value that is not in the file, or read in one of several ways."""
        self._add("assumed", text, about)

    def leave_out(self, text: str, about: object = None) -> None:
        """Note an item of the file that a case cannot represent."""
        self._add("left out", text, about)

    def skip(self, text: str, about: object = None) -> None:
        """Note data of the file that the import does not read."""
        self._add("not read", text, about)

    @property
    def every(self) -> list[Note]:
        """All notes; of many components the first ones are named."""
        found = []
        for note, about in self._about.items():
            named = ", ".join(about[:SHOWN]) + (
                f" and {len(about) - SHOWN} more" if len(about) > SHOWN else ""
            )
            found.append(Note(note.kind, f"{named}: {note.text}" if named else note.text))
        return found
