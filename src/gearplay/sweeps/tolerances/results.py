"""Tolerance results of a sweep, as requested by ``[tolerance]`` in its plan."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.folder import gather, run_in
from gearplay.sweeps.tolerances.allowable import Floats, largest_scale, search_plan
from gearplay.sweeps.tolerances.page import values_of, write_tolerance
from gearplay.vocabulary.progress import Progress
from gearplay.work.engine import Engine
from gearplay.work.folder import locked

if TYPE_CHECKING:
    import xarray as xr

FOLDER = "tolerance"


def limit_of(made: Sweep) -> float:
    """Return the limit of a plan's tolerance in the measure's unit; `InputError` where its unit does not fit."""
    tolerance = made.plan.tolerance
    assert tolerance is not None
    unit = next(kept.unit for kept in made.reducer.layout if kept.name == tolerance.measure)
    return tolerance.limit_in(unit)


def write_tolerances(
    made: Sweep,
    product: "xr.Dataset",
    folder: Path,
    engine: Engine,
    *,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> dict[str, Any]:
    """Write the tolerance page of a finished sweep into its folder and return its document.

    The search for the largest factor simulates; its sweeps are kept in ``tolerance/`` and resumed after an interruption.
    """
    plan, tolerance, search = made.plan, made.plan.tolerance, None
    assert tolerance is not None

    def at(*, fresh: bool) -> Callable[[float], Floats]:
        def evaluate(factor: float) -> Floats:
            part = Sweep(search_plan(plan, tolerance, factor, fresh=fresh))
            part.check_size()
            place = folder / FOLDER / f"{'fresh' if fresh else 'factor'}-{factor!r}"
            with locked(place):
                run_in(part, place, engine, progress=progress, stop=stop)
                return values_of(gather(part, place), tolerance.measure)

        return evaluate

    if tolerance.scale:
        search = largest_scale(
            at(fresh=False),
            limit_of(made),
            probability=tolerance.probability,
            confidence=tolerance.confidence,
            factors=tolerance.factors,
            steps=tolerance.steps,
            check=at(fresh=True),
        )
    return write_tolerance(plan, tolerance, product, folder, search=search)
