"""Families of cases: along a field of a case, or over the parameter of a function."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from gearplay.model.case import Case
from gearplay.model.plan_values import number_in_si
from gearplay.model.reading import Source, load_case, replace
from gearplay.parts.drive.schema import TorqueDrive
from gearplay.parts.mesh.train import rolling
from gearplay.vocabulary.arguments import Real
from gearplay.vocabulary.errors import InputError

Family = Callable[[float], Case]


@dataclass(frozen=True)
class Varied:
    """A case as a function of one of its fields, or a function that returns cases; numbers in SI.

    ``path`` is the field's, or the name of the parameter.
    """

    given: Source | Family
    path: str

    @property
    def is_function(self) -> bool:
        """Whether the cases come from a function."""
        return callable(self.given) and not isinstance(self.given, Case)

    def case(self, value: float) -> Case:
        """Return the case from which the family begins; of a function that at a value."""
        if not self.is_function:
            return load_case(self.given)  # type: ignore[arg-type]
        made = self.given(value)  # type: ignore[operator]
        if not isinstance(made, Case):
            rule = "must return a Case"
            raise InputError.of("case", type(made).__name__, rule, "Return gearplay.replace(...) or the like")
        return made

    def number(self, value: Any, where: str) -> float:
        """Return a value of the field in SI, from a number or text with a unit; of a parameter a plain number."""
        if not self.is_function:
            base = self.case(0.0)
            try:
                return number_in_si(base, (self.path,), value, where)
            except InputError as error:
                raise self._of_path(error) from None
        fault = Real(-math.inf).fault(value)
        if fault:
            raise InputError.of(where, value, fault, "Give plain numbers for the parameter of a function")
        return float(value)

    def _of_path(self, error: InputError) -> InputError:
        """Return the error of a path that leads to no field as one of the path, any other error as it is."""
        fault = error.faults[0]
        if not fault.rule.startswith(("unknown field", "no such", "is not a path")):
            return error
        why = "" if fault.rule == "unknown field" else f"; {fault.path}: {fault.rule}"
        return InputError.of("path", self.path, f"must be a field of the case{why}", fault.cure)

    def family(self, base: Case, *, keep_load: bool = False) -> Family:
        """Return the family: along the field of a case, or the function."""
        return self.case if self.is_function else along(base, self.path, keep_load=keep_load)


def along(case: Case, path: str, *, keep_load: bool = False) -> Family:
    """Return the family of a case along one of its fields, values in SI.

    With ``keep_load`` the loads stay what they are at the case's own speeds, whatever the field does to these: a torque takes
    away what drag adds, so that drag damps and loads no more.
    """
    before = rolling.nominal_speeds(case)
    pair = case.torsional_pair

    def family(value: float) -> Case:
        nonlocal case, pair
        changed = replace(case, {path: value})
        if pair is not None and changed.torsional_pair is None:
            case, pair = changed, None  # written out in parts once, not for every value
        if not keep_load:
            return changed
        changes = {}
        for name, old, new in zip(changed.rotors, before, rolling.nominal_speeds(changed), strict=True):
            rotor = changed.rotors[name]
            extra = rotor.load.drag * float(new - old)
            free = rotor.drive is None or isinstance(rotor.drive, TorqueDrive)
            if extra != 0.0 and free:
                torque = extra + (rotor.drive.torque if isinstance(rotor.drive, TorqueDrive) else 0.0)
                drive = rotor.drive or TorqueDrive(torque=0.0)
                changes[_drive_of(name)] = drive.model_copy(update={"torque": torque}).model_dump()
        return replace(changed, changes) if changes else changed

    return family


def _drive_of(name: str) -> str:
    """Return the path of a rotor's drive, of a planetary set's member too."""
    table, _, member = name.partition(".")
    return f"planetary.{table}.{member}.drive" if member else f"rotors.{name}.drive"
