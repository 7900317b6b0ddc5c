"""Replay of a saved run for quantities that its file does not hold."""

from typing import TYPE_CHECKING, Final

import numpy as np

from gearplay.solver.simulate import run_batch
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.version import VERSION

if TYPE_CHECKING:
    from gearplay.results.result import Result

SAME: Final = 1e-9
"""Relative difference, of the largest sample, within which samples are those of the file."""
ENDED: Final = (Status.OUT_OF_TIME, Status.INTERRUPTED)
"""Ends of a run that depend on the clock."""
_CURE: Final = "Simulate the case: gearplay.simulate(result.case)"


def runs_again(result: "Result") -> list[Trajectory]:
    """Return the trajectories of a result that was read from a file: its case, integrated again.

    Raises `InputError` where a member was ended by the clock, or where the file holds other samples than the case gives
    here, and the errors of a run.
    """
    ended = [status.name for status in result.statuses if status in ENDED]
    if ended:
        raise InputError(Fault("status", ended[0], "must not be an end by the clock for a repetition", _CURE))
    kept = [
        (signal, label) for signal, label in result.held() if np.isfinite(result.signal(signal, label)).any()
    ]
    names = [f"{label}.{signal}" if label != "base" else signal for signal, label in kept]
    numbers = np.atleast_1d(result.ds["member"].values).tolist() if "member" in result.ds.coords else [0]
    runs = run_batch([(result.case, numbers)], signals=names, keep_motion=True)[0]
    for member, run in enumerate(runs):
        for signal, label in kept[:3]:
            stored, found = result.signal(signal, label, member), run.signal(signal, label)
            allowed = SAME * float(np.nanmax(np.abs(stored), initial=0.0))
            if stored.shape != found.shape or not np.allclose(
                stored, found, rtol=0.0, atol=allowed, equal_nan=True
            ):
                where = f"{label}.{signal}, member {member}"
                rule = f"must be what the case gives with gearplay {VERSION}, for a repetition of the run"
                raise InputError(Fault("result", where, rule, _CURE))
    return runs
