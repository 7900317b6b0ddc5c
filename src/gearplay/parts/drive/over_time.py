"""Set-points over time of drives: imported where a case has one, and the constants that they stand for."""

from typing import TYPE_CHECKING, Annotated, Any, Final

from gearplay.parts.protocol import Actuator
from gearplay.schema.fields import Later, Part, Problem

if TYPE_CHECKING:
    from gearplay.parts.drive.set_points import SetPoint as SetPoint
else:

    class SetPoint:
        """Set-points of few cases: ``SetPoint[Speed]`` imports them, when the first is read."""

        def __class_getitem__(cls, value: Any) -> Any:
            def find() -> type[Part]:
                from gearplay.parts.drive import set_points

                return set_points.SetPoint[value]

            return Annotated[Any, Later(find)]


OVER_TIME: Final = "set-point over time, in place of the constant"


def nominal_problems(drive: Actuator, name: str) -> list[Problem]:
    """Set the constant of a drive to the nominal value of its set-point over time; return a contradiction of both."""
    over_time: Any = getattr(drive, "over_time", None)
    if over_time is None:
        return []
    given, nominal = getattr(drive, name), over_time.nominal
    if given not in (0.0, nominal):
        rule = "must be left out where over_time gives it"
        return [Problem((name,), rule, "Remove it, or over_time")]
    drive.__dict__[name] = nominal
    return []
