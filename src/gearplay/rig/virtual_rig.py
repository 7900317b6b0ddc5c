"""`measure`: record of a case by the virtual rig."""

import os
from collections.abc import Mapping
from typing import Any

from gearplay.files.record import Record
from gearplay.model.reading import Source
from gearplay.results.simulate import case_of
from gearplay.rig import measure as record_of
from gearplay.rig.plan import Rig
from gearplay.vocabulary.progress import Progress, ticking


def measure(
    case: Source,
    rig: Rig | str | os.PathLike[str] | Mapping[str, Any] | None = None,
    *,
    duration: float | None = None,
    transient: float | None = None,
    tolerance: float | None = None,
    member: int = 0,
    seed: int = 0,
    progress: Progress | None = None,
) -> Record:
    """Simulate a case and return what sensor and collector would have recorded; see docs/rig.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    rig
        A `Rig`, a path or a mapping; that of Han et al. 2021 if not given.
    duration, transient
        Record and time before it [s]; the rig's or the case's if not given.
    tolerance
        Error tolerance on scaled states [1]; the case's if not given.
    member
        Member of the ensemble, 0 for the unperturbed start.
    seed
        Of the sensors' noise.
    progress
        Called with what is running, simulated seconds done, and of how many.

    Returns
    -------
    Record
        A channel for each stage of the chain: acceleration [m/s^2], voltage [V], counts, what is recorded.

    Raises
    ------
    InputError
        For bad input, or a rig that does not fit the case.
    SimulationError
        Where the simulation does not reach its end.

    Examples
    --------
    >>> record = measure("han2021", duration=0.01, transient=0.0)
    >>> record.names
    ('sensor.acceleration', 'sensor.voltage', 'sensor.counts', 'sensor.recorded')

    """
    chosen = case_of(case, tolerance=tolerance)
    return record_of(
        chosen,
        rig,
        duration=duration,
        transient=transient,
        member=member,
        seed=seed,
        progress=ticking(progress, chosen.title or "record"),
    )
