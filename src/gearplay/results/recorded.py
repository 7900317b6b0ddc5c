"""A run as a record of channels, for signal analysis."""

from gearplay.files.record import Channel, Record
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.results.choice import choose
from gearplay.results.result import Result
from gearplay.results.titles import case_words

FORMAT = "gearplay run"


def record_of(result: Result, member: int = 0) -> Record:
    """Return the signals of one member as channels, ``ring.ax`` by name, with their units.

    >>> import gearplay as gp
    >>> record_of(gp.simulate("han2021", duration=0.01, transient=0.0)).channel("ring.ax").unit
    'm/s^2'
    """
    time = result.time(member)
    start = float(time[0]) if time.size else 0.0
    channels = tuple(
        Channel(
            f"{label}.{signal}",
            result.signal(signal, label, member),
            result.sampling,
            RESULT_VARIABLES[signal].unit,
            start,
            {"long_name": RESULT_VARIABLES[signal].long_name},
        )
        for signal, label in result.held()
    )
    return Record(channels, case_words(result.case), FORMAT)


def usual_channel(result: Result) -> str:
    """Return the name of the most informative channel: an acceleration where a centre moves, else a force or a speed."""
    signal, label = choose(result, [], None, kind="spectrum")[0]
    return f"{label}.{signal}"
