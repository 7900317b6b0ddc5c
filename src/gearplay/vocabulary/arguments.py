"""Rules of the arguments of public functions, by name, checked at every call."""

import inspect
import math
import numbers
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import wraps
from types import MappingProxyType
from typing import Any, Final

from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError
from gearplay.vocabulary.interrupts import raised_without_harm
from gearplay.vocabulary.memory import enough_memory

MOST: Final = 10**15
"""Largest count that is accepted; its cost is checked by the function itself."""
LOOKED_AT: Final = 100_000
"""Numbers of a list that are checked from each end; functions refuse a longer list for its length."""
LONGEST: Final = 1e9
"""Longest time [s]."""


@dataclass(frozen=True)
class Rule:
    """Requirement on an argument: a test of its value, and the requirement as text."""

    fits: Callable[[Any], bool]
    words: str

    def fault(self, value: object) -> str:
        """Return the requirement if a value does not meet it, else an empty text."""
        return "" if self.fits(value) else f"must be {self.words}"


@dataclass(frozen=True)
class Whole:
    """A whole number in a range."""

    low: int
    high: int = MOST

    def fault(self, value: object) -> str:
        """Return the requirement if a value does not meet it, else an empty text."""
        whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
        if whole and self.low <= int(value) <= self.high:  # type: ignore[call-overload]
            return ""
        limits = f", {self.low} or more" if self.high == MOST else f" from {self.low} to {self.high}"
        return f"must be a whole number{limits}"


@dataclass(frozen=True)
class Real:
    """A finite number in a range, which excludes its lower end if ``above``; or ``text``, read by the function itself.

    A ``time`` may also be text with a unit, which `checked_function` converts to seconds.
    """

    low: float
    high: float = math.inf
    above: bool = False
    text: bool = False
    time: bool = False

    def fault(self, value: object) -> str:
        """Return the requirement if a value does not meet it, else an empty text."""
        if (self.text and isinstance(value, str)) or self._fits(value):
            return ""
        if math.isinf(self.low):
            wanted = "must be a finite number"
        else:
            wanted = f"must be a number {'above ' if self.above else 'of '}{self.low:g}"
            wanted += "" if self.above else " or more"
            wanted += "" if self.high == math.inf else f", {self.high:g} at most"
        return wanted + (", or text" if self.text else "")

    def _fits(self, value: object) -> bool:
        if isinstance(value, bool) or not isinstance(value, numbers.Real):
            return False
        try:
            number = float(value)
        except OverflowError:
            return False
        inside = self.low <= number <= self.high and not (self.above and number == self.low)
        return math.isfinite(number) and inside


FINITE: Final = Real(-math.inf)


def one_of(types: type | tuple[type, ...], words: str) -> Rule:
    """Return the rule of values of some types."""
    return Rule(lambda value: isinstance(value, types), words)


def having(name: str, words: str, types: tuple[type, ...] = ()) -> Rule:
    """Return the rule of objects that have an attribute, or are of one of some types."""
    return Rule(
        lambda value: (hasattr(value, name) and not isinstance(value, type)) or isinstance(value, types),
        words,
    )


def listed(kind: type, words: str, *, single: bool = False) -> Rule:
    """Return the rule of lists of one type, or of one value of it where ``single``."""

    def fits(value: Any) -> bool:
        if isinstance(value, kind):
            return single
        return _is_list(value) and all(isinstance(each, kind) for each in value)

    return Rule(fits, f"a list of {words}s" + (", or one" if single else ", also of one"))


def numbers_listed(*, text: bool = False, single: bool = False) -> Rule:
    """Return the rule of lists or arrays of finite numbers, with ``text`` also of texts; one alone where ``single``."""
    one = Real(-math.inf, text=text)

    def fits(value: Any) -> bool:
        if single and not one.fault(value):
            return True
        if not _is_list(value) and not hasattr(value, "__array__"):
            return False
        try:
            if len(value) > LOOKED_AT:
                value = [*value[:LOOKED_AT], *value[-LOOKED_AT:]]
            each = [*value]
        except TypeError:  # an array without dimensions
            return False
        return bool(each) and not any(one.fault(number) for number in each)

    return Rule(fits, "a list of finite numbers" + (" or of texts" if text else ""))


def _is_list(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, (str, bytes))


def _is_axis(value: Any) -> bool:
    rules: tuple[Any, ...] = (TEXT, FINITE, FINITE, Whole(2))
    return (
        _is_list(value)
        and len(value) == len(rules)
        and not any(rule.fault(each) for rule, each in zip(rules, value, strict=True))
    )


def _is_window(value: Any) -> bool:
    return (
        _is_list(value)
        and len(value) == 2
        and not any(each is not None and FINITE.fault(each) for each in value)
    )


PATH: Final = one_of((str, os.PathLike), "a path")
TEXT: Final = one_of(str, "text")
FLAG: Final = one_of(bool, "True or False")
TABLE: Final = one_of(Mapping, "a table")
TEXTS: Final = listed(str, "text")
AXIS: Final = Rule(
    _is_axis, "a signal, its lowest and highest value and how many, as (signal, low, high, count)"
)
WINDOW: Final = Rule(_is_window, "two times [s], None for an open end, as (0.5, None)")
FREE: Final = one_of(object, "")
"""Arguments that the function itself checks."""
PLAN: Final = having("model_dump", "a plan, its name, a path or a table", (str, os.PathLike, Mapping))

RULES: Final[Mapping[str, Any]] = MappingProxyType(
    {
        **dict.fromkeys(("settle", "seed", "member"), Whole(0)),
        **dict.fromkeys(("keep", "show", "count", "ensemble", "positions"), Whole(1)),
        **dict.fromkeys(("cycles", "blocks"), Whole(1, 1000)),
        "periods": Whole(100),
        "order": Whole(1, 1000),
        "doublings": Whole(0, 8),
        "fmi": Whole(2, 3),
        "orbits": Whole(2, 100_000),
        "load_case": Whole(-(2**31), 2**31 - 1),
        "frames": Whole(2),
        "threads": Whole(1, 4096),
        "duration": Real(0.0, LONGEST, above=True, time=True),
        "transient": Real(0.0, LONGEST, time=True),
        "sampling": Real(0.0, LONGEST, above=True, text=True),
        "tolerance": Real(0.0, 1.0, above=True),
        **dict.fromkeys(("size", "turns"), Real(0.0, above=True)),
        "period": Real(0.0, LONGEST, above=True, text=True),
        "speed": Real(-math.inf, text=True),
        "frequency": Real(0.0, above=True),
        **dict.fromkeys(("damping_ratio", "force"), Real(0.0)),
        **dict.fromkeys(("mean_force", "force_phase", "stiffness_amplitude"), FINITE),
        "duty": Real(0.0, 1.0),
        "magnify": Real(1e-3, 1e3),
        "window": WINDOW,
        **dict.fromkeys(
            (
                "carry",
                "keep_load",
                "compare",
                "upwards",
                "overwrite",
                "report",
                "retry",
                "zarr",
                "square",
                "backlash",
                "quasi_static",
                "autonomous",
                "quick",
            ),
            FLAG,
        ),
        **dict.fromkeys(
            (
                "contact",
                "change",
                "section",
                "load",
                "name",
                "rotor",
                "format",
                "gear_bodies",
                "allowance",
                "teeth",
                "channel",
            ),
            TEXT,
        ),
        **dict.fromkeys(("signals", "directions", "inputs", "outputs", "tune", "platforms"), TEXTS),
        **dict.fromkeys(("channels", "at", "hold"), listed(str, "text", single=True)),
        "bearings": listed(str, "text", single=True),
        "columns": TEXTS,
        "tolerances": one_of((str, os.PathLike, Mapping), "the name or path of a sweep plan, or a table"),
        "torque": Real(0.0, above=True, text=True),
        **dict.fromkeys(("stages", "temperatures"), numbers_listed(text=True)),
        **dict.fromkeys(("folder", "records"), PATH),
        **dict.fromkeys(("changes", "run", "calibration", "units"), TABLE),
        "overrides": TEXTS,
        "progress": Rule(callable, "a function"),
        "stop": having("is_set", "a threading.Event"),
        "record": having("channels", "a Record, as read_measurement or measure returns it"),
        "plan": PLAN,
        **dict.fromkeys(("first", "second"), AXIS),
        "speeds": numbers_listed(text=True, single=True),
        "members": numbers_listed(),
        "frequencies": numbers_listed(single=True),
        "axes": listed(Mapping, "table", single=True),
        "reduce": listed(Mapping, "table"),
        "values": numbers_listed(text=True),
        "policy": having("changes", "a Policy"),
        "engine": having("outcomes", "an Engine"),
        **dict.fromkeys(
            (
                *("case", "rig", "source", "mesh", "healthy"),  # checked by their own functions
                *("path", "low", "high", "start", "fields", "more"),
            ),
            FREE,
        ),
    }
)
"""The rule of each parameter's name."""
OWN: Final[Mapping[tuple[str, str], Any]] = MappingProxyType(
    {
        ("basins", "settle"): Whole(1),
        **{("diagnose", name): FREE for name in ("record", "speed")},
        ("diagnose", "members"): Whole(2, 64),
        ("frequency_response", "force"): TEXT,
        ("load_plan", "source"): PLAN,
        **{(function, "members"): Whole(1) for function in ("lost_motion", "reduce")},
        **{(function, "at"): TEXT for function in ("describing_function", "lost_motion", "reduce")},
        ("motion", "ensemble"): Whole(4),
        ("planetary", "case"): TABLE,
        ("view", "at"): TEXT,
        ("read_measurement", "sampling"): Real(0.0, above=True),
        **{
            (function, "path"): TEXT
            for function in ("bifurcation", "branch", "branches", "frequency_response")
        },
        **{
            (function, "settle"): Whole(0, 10_000_000)
            for function in ("branch", "branches", "periodic_orbit")
        },
        **{
            (function, "path"): PATH
            for function in (
                "export_dxf",
                "export_fmu",
                "import_rexs",
                "read_measurement",
                "read_result",
                "write_record",
            )
        },
    }
)
"""Parameters that mean something else in one function: ``(function, parameter)``."""


def rule_of(function: str, parameter: str) -> Any:
    """Return the rule of a parameter; `KeyError` where none is known."""
    return OWN.get((function, parameter)) or RULES[parameter]


def checked_function(
    function: Callable[..., Any], seconds: Callable[[str, str], float]
) -> Callable[..., Any]:
    """Return a function that checks its arguments before each call; ``seconds(name, text)`` converts a time given as text.

    It raises `InputError` for arguments that are missing, unknown (with the nearest name) or invalid. Ctrl-C interrupts it where
    an exception does no harm.
    """
    signature = inspect.signature(function)
    parameters = signature.parameters

    @wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        bound, faults = bound_arguments(function.__name__, signature, args, named), []
        for name, value in bound.arguments.items():
            if value is None and parameters[name].default is None:
                continue
            rule = rule_of(function.__name__, name)
            if isinstance(value, str) and getattr(rule, "time", False):
                value = seconds(name, value)
            wanted = rule.fault(value)
            if wanted:
                faults.append(Fault(name, value, wanted, "See help(gearplay." + function.__name__ + ")"))
            elif isinstance(rule, (Whole, Real)) and not isinstance(value, str):
                bound.arguments[name] = int(value) if isinstance(rule, Whole) else float(value)
        if faults:
            raise InputError(faults)
        with raised_without_harm(), enough_memory():
            return function(*bound.args, **bound.kwargs)

    return call


def bound_arguments(
    function: str, signature: inspect.Signature, args: Sequence[Any], named: Mapping[str, Any]
) -> inspect.BoundArguments:
    """Return the arguments of a call by name; `InputError` where some are missing or unknown."""
    try:
        return signature.bind(*args, **named)
    except TypeError as error:
        parameters = signature.parameters
        open_ended = any(each.kind is each.VAR_KEYWORD for each in parameters.values())
        raise InputError(_misfit(function, list(parameters), open_ended, named, error)) from None


def _misfit(
    function: str, known: list[str], open_ended: bool, named: Mapping[str, Any], error: TypeError
) -> list[Fault]:
    unknown = [] if open_ended else [name for name in named if name not in known]
    if not unknown:
        return [Fault(function, NO_VALUE, str(error), f"Arguments: {', '.join(known)}")]
    faults = []
    for name in unknown:
        close = get_close_matches(name, known, 1)
        cure = f"Did you mean '{close[0]}'?" if close else f"Arguments: {', '.join(known)}"
        faults.append(Fault(name, NO_VALUE, f"is no argument of {function}", cure))
    return faults
