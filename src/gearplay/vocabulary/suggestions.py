"""Suggestions for misspelt names: the nearest one, or the list of all."""

import difflib
from collections.abc import Iterable
from typing import Final

from gearplay.vocabulary.errors import KEY_LENGTH, shorten

LISTED: Final = 12
"""Names a hint lists before it counts the rest."""


def listed(names: Iterable[str], most: int = LISTED) -> str:
    """Return names as a list in words, of many the first ones and the number of the others.

    Examples
    --------
    >>> listed(["ring", "pinion"]), listed("abcd", 2), listed([])
    ('ring, pinion', 'a, b and 2 more', 'none')

    """
    known = [shorten(name, KEY_LENGTH) for name in names]
    more = f" and {len(known) - most} more" if len(known) > most else ""
    return (", ".join(known[:most]) + more) or "none"


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
    return f"{title}: {listed(sorted(known))}"
