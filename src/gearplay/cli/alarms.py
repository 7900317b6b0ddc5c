"""Options of `gearplay analyze --healthy`: an alarm against the records of a folder."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any


def check_alarm(
    record: Path,
    healthy: Path | None,
    teeth: int | None,
    false_alarms: float | None,
    speed: str | None,
    held: Any,
) -> None:
    """Refuse alarm options without those that they require, and ones that cannot apply to all records."""
    from gearplay.vocabulary.errors import InputError

    if healthy is None:
        if false_alarms is not None:
            rule = "must be given with --healthy, whose records set the limit"
            raise InputError.of("--false-alarms", false_alarms, rule, "Name their folder, or leave it out")
        return
    if teeth is None:
        rule = "must be given with --teeth, whose indicators it compares"
        raise InputError.of("--healthy", str(healthy), rule, "Give the number of teeth")
    if speed is not None and speed not in held.names and Path(speed).is_file():
        rule = "must not be a file with --healthy: it would be that of all records"
        raise InputError.of("--speed", speed, rule, "Give a speed, or a channel that each record has")
    if record.resolve().parent == healthy.resolve():
        rule = "must not hold the record itself, which would be compared with itself"
        raise InputError.of("--healthy", str(healthy), rule, "Move the record elsewhere")


def alarm_against(
    found: Any, folder: Path, indicators_of: Callable[[Path], Any], false_alarms: float | None
) -> dict[str, Any]:
    """Return whether indicators raise an alarm against those of the records in a folder, with score and threshold."""
    from gearplay.signals.alarms import FALSE_ALARMS, alarm_limit
    from gearplay.vocabulary.errors import InputError

    inside = sorted(folder.iterdir()) if folder.is_dir() else []
    files = [path for path in inside if path.is_file() and not path.name.startswith(".")]
    if not files:
        rule = "must be a folder with a file for each healthy record"
        raise InputError.of("--healthy", str(folder), rule, "Name one")
    share = FALSE_ALARMS if false_alarms is None else false_alarms
    try:
        limit = alarm_limit([indicators_of(path) for path in files], false_alarms=share)
    except InputError as error:
        raise InputError([_of_file(fault, files) for fault in error.faults]) from None
    return {
        "raised": limit.raises(found),
        "score": limit.score(found),
        "threshold": limit.threshold,
        "settings": limit.message,
    }


def _of_file(fault: Any, files: Sequence[Path]) -> Any:
    """Return a fault of the k-th healthy record with the name of its file."""
    first, _, rest = fault.path.partition(".")
    number, _, name = rest.partition(".")
    return (
        fault._replace(path=f"--healthy {files[int(number)].name}: {name}")
        if first == "healthy" and number.isdigit()
        else fault
    )
