"""Suggestions for misspelt names: the nearest one, or the list of all."""

import difflib
from collections.abc import Iterable
from typing import Final

from gearplay.vocabulary.errors import KEY_LENGTH, shorten

LISTED: Final = 12
"""Names a hint lists before it stops."""


def nearest(word: str, words: Iterable[str]) -> str | None:
    """Return the word that `word` was probably meant to be.

    Examples
    --------
    >>> nearest("modul", ["module", "mass"]), nearest("zzz", ["module"])
    ('module', None)

    """
    found = difflib.get_close_matches(word[:KEY_LENGTH], list(words), n=1, cutoff=0.6)
    return found[0] if found else None


def did_you_mean(word: str, words: Iterable[str], title: str = "Known") -> str:
    """Return a hint: the nearest word, or else the list of all.

    Examples
    --------
    >>> did_you_mean("rng", ["ring", "pinion"], "Rotors"), did_you_mean("zz", ["ring"], "Rotors")
    ("Did you mean 'ring'?", 'Rotors: ring')

    """
    known = list(words)
    close = nearest(word, known)
    if close is not None:
        return f"Did you mean '{shorten(close, KEY_LENGTH)}'?"
    if not known:
        return f"{title}: none"
    more = ", ..." if len(known) > LISTED else ""
    return f"{title}: {', '.join(shorten(name, KEY_LENGTH) for name in sorted(known)[:LISTED])}{more}"
