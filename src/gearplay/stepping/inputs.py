"""Inputs by name: torques of drives and loads, set-points of servos, as words of the packed records that change alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.stepping import ANGLE_INPUT, DRIVE_INPUT, LOAD_INPUT, SPEED_INPUT, Held, make_held
from gearplay.kernels.layout import System
from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.parts.mesh.train import rolling
from gearplay.parts.registry import POSITIONER, SERVO
from gearplay.solver.trajectory import Column, choose_columns
from gearplay.vocabulary.errors import Fault, InputError
from gearplay.vocabulary.suggestions import did_you_mean, nearest

_ENDINGS: Final = ("drive.torque", "load.torque", "drive.speed", "drive.angle")
_WORDS: Final = {
    "drive.torque": ("N m", "torque of the drive, counter-clockwise positive"),
    "load.torque": ("N m", "load torque, against the nominal sense"),
    "drive.speed": ("rad/s", "speed that the servo is to hold, counter-clockwise positive"),
    "drive.angle": ("rad", "angle that the position servo is to hold"),
}


@dataclass(frozen=True)
class Input:
    """An input: its name, unit and description; the value of the case; kind, place and sign (`integrate.stepping.Held`)."""

    name: str
    unit: str
    description: str
    start: float
    kind: int
    place: int
    sign: float = 1.0


def find_inputs(case: Case, packed: Packed, names: Sequence[str]) -> tuple[Input, ...]:
    """Return inputs by their names, ``motor.drive.torque`` or with ``rotors.`` in front of it.

    Raises `InputError` for a name that is none, is given twice, or whose change is more than that of a word.
    """
    faults: list[Fault] = []
    found: list[Input] = []
    for given in names:
        name = given.removeprefix("rotors.")
        try:
            found.append(_find(case, packed, given, name))
        except InputError as error:
            faults += error.faults
        if name in [each.name for each in found[:-1]]:
            faults.append(Fault("inputs", given, "must be given once", "Remove one of the two"))
    if faults:
        raise InputError(faults)
    return tuple(found)


def _find(case: Case, packed: Packed, given: str, name: str) -> Input:
    ending = next((each for each in _ENDINGS if name.endswith(f".{each}")), "")
    rotor = name.removesuffix(f".{ending}")
    if not ending or rotor not in case.rotors:
        rule = "must be an input of a rotor: drive.torque, load.torque, drive.speed or drive.angle"
        raise InputError.of("inputs", given, rule, _cure(name, rotor if ending else "", case))
    unit, description = _WORDS[ending]
    i, drive = list(case.rotors).index(rotor), case.rotors[rotor].drive
    kind = None if drive is None else drive.kind
    if ending == "drive.torque":
        if drive is not None and drive.kind != "torque":
            rule = f"must be of a rotor whose drive gives a torque, and {rotor} has one of kind {kind}"
            raise InputError.of("inputs", given, rule, f"Change rotors.{rotor}.drive, or leave it out")
        start = 0.0 if drive is None else drive.torque
        return Input(name, unit, description, start, DRIVE_INPUT, i)
    if ending == "load.torque":
        sense = float(
            np.sign(rolling.moving_speeds(case.operating, rolling.nominal_speeds(case.operating))[i])
        )
        if sense == 0.0:
            rule = f"must be of a rotor that turns one way: a load opposes its nominal sense, and {rotor} has none"
            raise InputError.of("inputs", given, rule, f"Use {rotor}.drive.torque, whose sign is free")
        return Input(name, unit, description, case.rotors[rotor].load.torque, LOAD_INPUT, i, -sense)
    wanted, table, at = (
        (("servo",), SERVO, "speed")
        if ending == "drive.speed"
        else (("position", "cascade"), POSITIONER, "angle")
    )
    if drive is None or drive.kind not in wanted:
        has = "no drive" if drive is None else f"a drive of kind {kind}"
        rule = f"must be of a rotor with a drive of kind {' or '.join(wanted)}, and {rotor} has {has}"
        raise InputError.of("inputs", given, rule, f"Change rotors.{rotor}.drive, or leave it out")
    if getattr(drive, "ramp", 0.0) > 0.0:
        rule = "must be the speed of a servo without a ramp, which would continue to the case's own speed"
        raise InputError.of("inputs", given, rule, f"Remove rotors.{rotor}.drive.ramp")
    if getattr(drive, "over_time", None) is not None:
        rule = f"must be of a drive whose {at} is a constant, and that of {rotor} is given over time"
        raise InputError.of("inputs", given, rule, f"Give rotors.{rotor}.drive.{at} as a number")
    row = int(np.flatnonzero(packed.system.records[table]["rotor"] == i)[0])
    kind_of = SPEED_INPUT if ending == "drive.speed" else ANGLE_INPUT
    return Input(name, unit, description, getattr(drive, at), kind_of, row)


def _cure(name: str, rotor: str, case: Case) -> str:
    """Return what to write instead of a name, of which ``rotor`` is the part before the ending of an input."""
    if rotor:
        return did_you_mean(rotor, case.rotors, "Rotors")
    owners = [each for each in case.rotors if name == each or name.startswith(f"{each}.")]
    if not owners:
        written = f"Write for example {next(iter(case.rotors))}.drive.torque"
        return f"{written}. {did_you_mean(name.partition('.')[0], case.rotors, 'Rotors')}"
    owner = max(owners, key=len)
    wrong = name[len(owner) + 1 :]
    near = [each for each in _ENDINGS if wrong in each.split(".")]
    near = near or [each for each in (nearest(wrong, _ENDINGS),) if each] or list(_ENDINGS)
    return f"Write {' or '.join(f'{owner}.{each}' for each in near)}"


def find_outputs(packed: Packed, names: Sequence[str]) -> tuple[tuple[Column, ...], NDArray[np.int64]]:
    """Return the columns of outputs by their names, and their places in a full row; `InputError` for a name that is no signal."""
    try:
        return choose_columns(packed, list(names))
    except InputError as error:
        raise InputError([each._replace(path="outputs") for each in error.faults]) from None


def own_system(system: System) -> System:
    """Return a system whose words that inputs change are its own; all else is shared."""
    records = list(system.records)
    for kind in (SERVO, POSITIONER):
        records[kind] = records[kind].copy()
    joined = replace(system.joined, numbers=system.joined.numbers.copy())
    return replace(system, rotors=system.rotors.copy(), records=tuple(records), joined=joined)


def hold(system: System, inputs: Sequence[Input]) -> Held:
    """Return the inputs of a system, with the values of the case."""
    return make_held(
        system,
        np.array([each.kind for each in inputs], dtype=np.int64),
        np.array([each.place for each in inputs], dtype=np.int64),
        np.array([each.sign for each in inputs], dtype=np.float64),
        np.array([each.start for each in inputs], dtype=np.float64),
    )
