"""A run as a record of channels, for signal analysis."""

from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel, Record
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.results.choice import choose
from gearplay.results.result import Result
from gearplay.results.titles import case_words

Floats = NDArray[np.float64]
FORMAT = "gearplay run"


class SignalChannel(Channel):
    """A signal of a member of a run as a channel, whose values are computed on first access."""

    def __init__(self, result: Result, signal: str, label: str, member: int) -> None:
        quantity, time = RESULT_VARIABLES[signal], result.time(member)
        start = float(time[0]) if time.size else 0.0
        own = (f"{label}.{signal}", result.sampling, quantity.unit, start, {"long_name": quantity.long_name})
        names = ("name", "sampling", "unit", "start", "attributes")
        vars(self).update(zip(names, own, strict=True))
        vars(self).update(_size=time.size, _load=partial(result.signal, signal, label, member))

    @cached_property
    def values(self) -> Floats:
        """Samples, shape [time]."""
        found: Floats = vars(self)["_load"]()
        return found

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(vars(self)["_size"])


def record_of(result: Result, member: int = 0) -> Record:
    """Return the signals of one member as channels, ``ring.ax`` by name, with their units, computed on access.

    >>> import gearplay as gp
    >>> record_of(gp.simulate("han2021", duration=0.01, transient=0.0)).channel("ring.ax").unit
    'm/s^2'
    """
    channels = tuple(SignalChannel(result, signal, label, member) for signal, label in result.held())
    return Record(channels, case_words(result.case), FORMAT)


def usual_channel(result: Result) -> str:
    """Return the name of the most informative channel: an acceleration where a centre moves, else a force or a speed."""
    signal, label = choose(result, [], None, kind="spectrum")[0]
    return f"{label}.{signal}"
