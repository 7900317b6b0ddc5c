"""Families of a case over one field, and their resonances."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model import rolling
from gearplay.model.case import Case
from gearplay.model.plan_values import number_in_si
from gearplay.model.reading import Source, load_case, replace
from gearplay.model.rotor import TorqueDrive
from gearplay.vocabulary.arguments import Real
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.linear.response import FrequencyResponse

Family = Callable[[float], Case]


@dataclass(frozen=True)
class Varied:
    """A case over one of its fields, or over the parameter of a function that returns cases; numbers in SI.

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
            raise InputError(
                Fault("case", type(made).__name__, rule, "Return gearplay.replace(...) or the like")
            )
        return made

    def number(self, value: Any, where: str) -> float:
        """Return a value of the field [SI], of text with a unit too, or of the parameter, a plain number."""
        if not self.is_function:
            return number_in_si(self.case(0.0), (self.path,), value, where)
        fault = Real(-math.inf).fault(value)
        if fault:
            raise InputError(Fault(where, value, fault, "Give plain numbers for the parameter of a function"))
        return float(value)

    def family(self, base: Case, *, keep_load: bool = False) -> Family:
        """Return the family: along the field of a case, or the function."""
        return self.case if self.is_function else along(base, self.path, keep_load=keep_load)


def along(case: Case, path: str, *, keep_load: bool = False) -> Family:
    """Return the family of a case along one of its fields, values in SI.

    With ``keep_load`` the loads stay what they are at the case's own speeds, whatever the field does to these: a torque takes
    away what drag adds, so that drag damps and loads no more.
    """
    before = rolling.nominal_speeds(case)

    def family(value: float) -> Case:
        changed = replace(case, {path: value})
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


def resonant_value(case: Case, path: str, response: "FrequencyResponse") -> float:
    """Return the speed [rad/s] that a field prescribes where a mesh meets the largest resonance of a response to its error.

    Raises `InputError` for a field that is no speed of a drive, or a response to something else than a mesh's error.
    """
    from gearplay.linear.inputs import ERROR

    label, _, kind = str(response.ds.attrs["force"]).rpartition(".")
    labels = [mesh.label for mesh in case.meshes]
    if kind != ERROR or label not in labels:
        rule = "must be a response to the error of a mesh of the case"
        raise InputError(Fault("start", str(response.ds.attrs["force"]), rule, "Give the value itself"))
    if not path.endswith(".drive.speed"):
        rule = "must be the speed of a drive for a start on a resonance"
        raise InputError(Fault("path", path, rule, "Give the value itself as start"))
    now: Any = case.resolved()
    for part in path.split("."):
        now = now[part]
    frequency = rolling.mesh_frequency(case, labels.index(label))
    if frequency == 0.0 or now == 0.0:
        raise InputError(Fault(path, now, "must not be 0 for a start on a resonance", "Choose a speed"))
    amplitude = response.ds["amplitude"].values
    at = float(response.ds["frequency"].values[int(np.argmax(amplitude.max(axis=0)))])
    return float(now) * at / frequency
