"""Shares of a variance in sentences."""

from collections.abc import Sequence

from gearplay.sweeps.variance.sobol_indices import Indices

MOST_RANKED = 6
"""Most parameters whose shares are listed."""


def spoken(name: str) -> str:
    """Return a name as text for a message.

    >>> spoken("tooth_error")
    'tooth error'
    """
    return name.replace("_", " ")


def shares_words(found: Indices, names: Sequence[str] = ()) -> str:
    """Return the shares of the variance in one sentence, the same on every page: first order and total, the largest first.

    >>> shares_words(Indices("grid", ("speed", "play"), 0.95, 4, 0, (0.8, 0.1), (0.0, 0.0), (0.9, 0.2), (0.0, 0.0)))
    'Shares of its variance, first order (alone) and total (with others): speed 80 and 90 %, play 10 and 20 %.'
    """
    if found.reason:
        return f"No Sobol indices: {found.reason}."
    shown = [spoken(name) for name in names or found.names]
    ranked = ", ".join(
        f"{shown[at]} {100.0 * found.first[at]:.3g} and {100.0 * found.total[at]:.3g} %"
        for at in found.ranking[:MOST_RANKED]
    )
    more = len(shown) - MOST_RANKED
    return (
        f"Shares of its variance, first order (alone) and total (with others): {ranked}"
        + (f" and {more} more" if more > 0 else "")
        + "."
    )
