"""`load_sharing` of planetary sets."""

from __future__ import annotations

from gearplay.model.reading import Source
from gearplay.planets.sharing import LoadSharing, moving_sharing, static_sharing
from gearplay.results.result import Result
from gearplay.results.simulate import case_of


def load_sharing(source: Source | Result, *, name: str | None = None, member: int = 0) -> LoadSharing:
    """Return how the planets of a set share its load.

    Of a case: at rest under its load, contacts as the load closes them, mean stiffness. Of a result of `simulate`: along the
    recorded motion.

    Parameters
    ----------
    source
        A `Case`, a bundled name, a path or a mapping; or a `Result` that kept positions and forces of the set.
    name
        Of the planetary set; may be left out where there is one.
    member
        Of an ensemble, its place.

    Returns
    -------
    LoadSharing
        ``.ds`` with ``share``, ``load_sharing_factor``, forces, planets relative to their pins and floating members; ``.plot()``.

    Raises
    ------
    InputError
        For a case without that set, without a load, or a result that lacks the signals.
    SimulationError
        Where no equilibrium is found.

    Examples
    --------
    >>> import gearplay as gp
    >>> sharing = gp.load_sharing("planetary-reducer")
    >>> [round(float(share), 4) for share in sharing.ds["share"]]
    [0.3333, 0.3333, 0.3333]

    """
    if isinstance(source, Result):
        return moving_sharing(source, name, member)
    return static_sharing(case_of(source), name)
