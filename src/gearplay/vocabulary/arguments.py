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
class Whole:
    """A whole number in a range."""

    low: int
    high: int = MOST

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        if isinstance(value, bool) or not isinstance(value, numbers.Integral):
            return f"must be a whole number from {self.low} to {self.high}"
        inside = self.low <= int(value) <= self.high
        return "" if inside else f"must be a whole number from {self.low} to {self.high}"


@dataclass(frozen=True)
class Real:
    """A finite number in a range, its ends included or, ``above``, the lower one not; text where that is read further in.

    A ``time`` may also be text with a unit, which `checked_function` converts to seconds.
    """

    low: float
    high: float = math.inf
    above: bool = False
    text: bool = False
    time: bool = False

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        if self.text and isinstance(value, str):
            return ""
        low = f"above {self.low:g}" if self.above else f"of {self.low:g} or more"
        wanted = (
            f"must be a number {low}"
            if self.high == math.inf
            else f"must be a number {low}, {self.high:g} at most"
        )
        if math.isinf(self.low):
            wanted = "must be a finite number"
        if self.text:
            wanted += ", or text"
        if isinstance(value, bool) or not isinstance(value, numbers.Real):
            return wanted
        try:
            number = float(value)
        except OverflowError:
            return wanted
        if not math.isfinite(number):
            return wanted
        inside = self.low <= number <= self.high and not (self.above and number == self.low)
        return "" if inside else wanted


@dataclass(frozen=True)
class Kind:
    """A value of one of several types, with a text for messages."""

    types: tuple[type, ...]
    words: str

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        return "" if isinstance(value, self.types) else f"must be {self.words}"


@dataclass(frozen=True)
class Texts:
    """A list of texts; one alone is taken where ``single``."""

    single: bool = False

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        if isinstance(value, str):
            return "" if self.single else "must be a list of texts, also of one"
        fits = isinstance(value, Sequence) and all(isinstance(each, str) for each in value)
        return "" if fits else "must be a list of texts" + (", or one" if self.single else "")


@dataclass(frozen=True)
class Calls:
    """A function."""

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        return "" if callable(value) else "must be a function"


@dataclass(frozen=True)
class Has:
    """An object of gearplay, recognised by its attributes, or one of the other accepted types."""

    name: str
    words: str
    types: tuple[type, ...] = ()

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        ours = hasattr(value, self.name) and not isinstance(value, type)
        return "" if ours or isinstance(value, self.types) else f"must be {self.words}"


@dataclass(frozen=True)
class Numbers:
    """A list or an array of finite numbers, of texts too where they are read further in, one alone where ``single``."""

    text: bool = False
    single: bool = False

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        wanted = "must be a list of finite numbers" + (" or of texts" if self.text else "")
        one = Real(-math.inf, text=self.text)
        if self.single and not one.fault(value):
            return ""
        listed = isinstance(value, Sequence) or hasattr(value, "__array__")
        if not listed or isinstance(value, (str, bytes)):
            return wanted
        try:
            if len(value) > LOOKED_AT:  # type: ignore[arg-type]
                value = [*value[:LOOKED_AT], *value[-LOOKED_AT:]]  # type: ignore[index]
            each = [*value]  # type: ignore[misc]
        except TypeError:  # an array without dimensions
            return wanted
        return wanted if not each or any(one.fault(number) for number in each) else ""


@dataclass(frozen=True)
class Tables:
    """A list of tables; one table alone where ``single``."""

    single: bool = False

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        if self.single and isinstance(value, Mapping):
            return ""
        fits = isinstance(value, Sequence) and not isinstance(value, (str, bytes))
        fits = fits and all(isinstance(each, Mapping) for each in value)  # type: ignore[attr-defined]
        return "" if fits else "must be a list of tables" + (", or one table" if self.single else "")


@dataclass(frozen=True)
class Axis:
    """A signal with two ends and a count: ``("wheel.theta", -1e-3, 1e-3, 60)``."""

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        wanted = "must be a signal, its lowest and highest value and how many, as (signal, low, high, count)"
        if not isinstance(value, Sequence) or isinstance(value, (str, bytes)) or len(value) != 4:
            return wanted
        rules: tuple[Any, ...] = (TEXT, Real(-math.inf), Real(-math.inf), Whole(2))
        return wanted if any(rule.fault(each) for rule, each in zip(rules, value, strict=True)) else ""


@dataclass(frozen=True)
class Window:
    """Two times [s], None for an open end: ``(0.5, None)``."""

    def fault(self, value: object) -> str:
        """Return what is required where a value is something else, else nothing."""
        wanted = "must be two times [s], None for an open end, as (0.5, None)"
        if not isinstance(value, Sequence) or isinstance(value, (str, bytes)) or len(value) != 2:
            return wanted
        rule = Real(-math.inf)
        return wanted if any(each is not None and rule.fault(each) for each in value) else ""


class Anything:
    """What is read and checked further in, with its own sentence."""

    def fault(self, value: object) -> str:
        """Return nothing."""
        return ""


PATH: Final = Kind((str, os.PathLike), "a path")
TEXT: Final = Kind((str,), "text")
FLAG: Final = Kind((bool,), "True or False")
TABLE: Final = Kind((Mapping,), "a table")
FREE: Final = Anything()
PLAN: Final = Has("model_dump", "a plan, its name, a path or a table", (str, os.PathLike, Mapping))

RULES: Final[Mapping[str, Any]] = MappingProxyType(
    {
        **dict.fromkeys(("settle", "doublings", "seed", "member"), Whole(0)),
        **dict.fromkeys(("keep", "show", "periods", "count", "ensemble", "orbits", "order"), Whole(1)),
        "threads": Whole(1, 4096),
        "duration": Real(0.0, LONGEST, above=True, time=True),
        "transient": Real(0.0, LONGEST, time=True),
        "sampling": Real(0.0, LONGEST, above=True, text=True),
        "tolerance": Real(0.0, 1.0, above=True),
        "size": Real(0.0, above=True),
        "period": Real(0.0, LONGEST, above=True, text=True),
        "speed": Real(-math.inf, text=True),
        "frequency": Real(0.0, above=True),
        **dict.fromkeys(("damping_ratio", "force"), Real(0.0)),
        **dict.fromkeys(("mean_force", "force_phase", "stiffness_amplitude"), Real(-math.inf)),
        "duty": Real(0.0, 1.0),
        "magnify": Real(1e-3, 1e3),
        "window": Window(),
        **dict.fromkeys(
            ("carry", "keep_load", "compare", "upwards", "overwrite", "square", "backlash"), FLAG
        ),
        **dict.fromkeys(("contact", "change", "load", "name", "format"), TEXT),
        **dict.fromkeys(("signals", "directions"), Texts()),
        **dict.fromkeys(("channels", "at"), Texts(single=True)),
        **dict.fromkeys(("folder", "records"), PATH),
        **dict.fromkeys(("changes", "run", "calibration", "units"), TABLE),
        "overrides": Texts(),
        "progress": Calls(),
        "stop": Has("is_set", "a threading.Event"),
        "record": Has("channels", "a Record, as read_measurement or measure returns it"),
        "plan": PLAN,
        **dict.fromkeys(("first", "second"), Axis()),
        "speeds": Numbers(text=True, single=True),
        "members": Numbers(),
        "frequencies": Numbers(single=True),
        "axes": Tables(single=True),
        "reduce": Tables(),
        "values": Numbers(text=True),
        "policy": Has("changes", "a Policy"),
        "engine": Has("outcomes", "an Engine"),
        **dict.fromkeys(
            (
                *("case", "rig", "source"),  # checked by their own functions
                *("path", "low", "high", "start", "fields", "more"),
            ),
            FREE,
        ),
    }
)
"""The rule of each parameter's name."""
OWN: Final[Mapping[tuple[str, str], Any]] = MappingProxyType(
    {
        ("frequency_response", "force"): TEXT,
        ("load_plan", "source"): PLAN,
        ("planetary", "case"): TABLE,
        ("view", "at"): TEXT,
        ("read_measurement", "sampling"): Real(0.0, above=True),
        **{
            (function, "path"): TEXT
            for function in ("bifurcation", "branch", "branches", "frequency_response")
        },
        **{(function, "path"): PATH for function in ("read_measurement", "read_result", "write_record")},
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
    open_ended = any(each.kind is each.VAR_KEYWORD for each in parameters.values())

    @wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        try:
            bound = signature.bind(*args, **named)
        except TypeError as error:
            raise InputError(_misfit(function.__name__, list(parameters), open_ended, named, error)) from None
        faults = []
        for name, value in list(bound.arguments.items()):
            if value is None and parameters[name].default is None:
                continue
            rule = rule_of(function.__name__, name)
            if isinstance(value, str) and getattr(rule, "time", False):
                value = bound.arguments[name] = seconds(name, value)
            wanted = rule.fault(value)
            if not wanted and isinstance(rule, (Whole, Real)) and not isinstance(value, str):
                bound.arguments[name] = int(value) if isinstance(rule, Whole) else float(value)
            if wanted:
                faults.append(Fault(name, value, wanted, "See help(gearplay." + function.__name__ + ")"))
        if faults:
            raise InputError(faults)
        with raised_without_harm(), enough_memory():
            return function(*bound.args, **bound.kwargs)

    return call


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
