"""`measure`: what the virtual rig records of a case."""

import os
from collections.abc import Mapping
from typing import Any

from gearplay.files.record import Record
from gearplay.model.case import Case
from gearplay.model.reading import load_case
from gearplay.results.result import Source
from gearplay.rig import measure as record_of
from gearplay.rig.plan import Rig


def measure(
    case: Source,
    rig: Rig | str | os.PathLike[str] | Mapping[str, Any] | None = None,
    *,
    duration: float | None = None,
    transient: float | None = None,
    member: int = 0,
    seed: int = 0,
) -> Record:
    """Simulate a case and return what sensor and collector would have recorded; see docs/rig.

    ``case`` is a `Case`, a bundled name, a path or a mapping; ``rig`` a `Rig`, a path or a mapping, the article's if not given.
    ``duration`` and ``transient`` [s] override the case's; ``seed`` is that of the sensors' noise.

    Raises `InputError` for bad input and `SimulationError` where the simulation does not reach its end.

    >>> record = measure("han2021", duration=0.01, transient=0.0)
    >>> record.names
    ('sensor.acceleration', 'sensor.voltage', 'sensor.counts', 'sensor.recorded')
    """
    chosen = case if isinstance(case, Case) else load_case(case)
    return record_of(chosen, rig, duration=duration, transient=transient, member=member, seed=seed)
