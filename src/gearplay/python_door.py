"""What `import gearplay` offers: where each public name lives, and reading any saved answer back."""

import os
from functools import cache
from importlib import import_module
from inspect import isfunction
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from gearplay.files.atomic import shown_path
from gearplay.files.netcdf import read_dataset
from gearplay.vocabulary.arguments import guarded
from gearplay.vocabulary.errors import Fault, InputError

HOMES: Final = MappingProxyType(
    {
        "Case": "model.case",
        "Policy": "model.policy",
        "load_case": "model.reading",
        "replace": "model.reading",
        "check_case": "model.check",
        "simulate": "results.door",
        "Result": "results.result",
        "read_result": "python_door",
        "measure": "rig.door",
        "Record": "files.record",
        "Channel": "files.record",
        "read_measurement": "files.measurements",
        "write_record": "files.measurements",
        "calibrate": "calibration.door",
        "load_plan": "calibration.reading",
        "sweep": "sweeps.door",
        "Engine": "sweeps.running.engines",
        "basins": "nonlinear.door",
        "bifurcation": "nonlinear.door",
        "branch": "nonlinear.orbits.door",
        "branches": "nonlinear.orbits.door",
        "impacts": "nonlinear.section_door",
        "lyapunov": "nonlinear.door",
        "motion": "nonlinear.door",
        "periodic_orbit": "nonlinear.orbits.door",
        "portrait": "nonlinear.section_door",
        "section": "nonlinear.section_door",
        "torsional_pair": "nonlinear.torsional",
        "modes": "linear.door",
        "campbell": "linear.door",
        "frequency_response": "linear.door",
        "planetary": "model.planetary_door",
        "load_sharing": "planets.door",
        "GearplayError": "vocabulary.errors",
        "InputError": "vocabulary.errors",
        "SimulationError": "vocabulary.errors",
        "ResourceError": "vocabulary.errors",
        "MeasurementError": "vocabulary.errors",
    }
)
"""Module of each public name, below `gearplay`; loaded when it is first used."""

ANSWERS: Final = MappingProxyType(
    {
        "run": "results.result:Result",
        "sweep": "sweeps.result:SweepResult",
        "calibration": "calibration.result:Calibration",
        "bifurcation": "nonlinear.diagrams:Diagram",
        "portrait": "nonlinear.portrait:Portrait",
        "section": "nonlinear.sections:Section",
        "exponents": "nonlinear.lyapunov:Exponents",
        "motion": "nonlinear.motion:Motion",
        "basins": "nonlinear.basins:Basins",
        "orbit": "nonlinear.orbits.answers:PeriodicOrbit",
        "branch": "nonlinear.orbits.answers:OneBranch",
        "branches": "nonlinear.orbits.answers:Branches",
        "modes": "linear.modes:Modes",
        "load sharing": "planets.sharing:LoadSharing",
        "campbell": "linear.campbell:Campbell",
        "frequency response": "linear.response:FrequencyResponse",
    }
)
"""Class of each kind of saved answer."""


@cache
def public(name: str) -> Any:
    """Return a public name's object; functions check their arguments first."""
    found = getattr(import_module(f"gearplay.{HOMES[name]}"), name)
    return guarded(found, _seconds) if isfunction(found) else found


def _seconds(name: str, text: str) -> float:
    """Return a time that an argument gives as text, such as ``"10 ms"`` [s]."""
    from gearplay.model.units import UnitError, parse_quantity
    from gearplay.vocabulary.quantities import TIME

    try:
        return parse_quantity(text, TIME)
    except UnitError as error:
        raise InputError(
            Fault(name, text, error.rule, "Write for example 10 ms, or a number of seconds")
        ) from None


def read_result(path: str | os.PathLike[str]) -> Any:
    """Read what an answer's ``save`` wrote, and return the same kind of object again.

    Parameters
    ----------
    path
        A file that ``save`` or a command wrote: ``.nc`` of any verb, ``calibration.json``, or a record in any format of
        `read_measurement`.

    Returns
    -------
    Answer
        A `Result`, a sweep, a diagram ...: what was saved.

    Raises
    ------
    InputError
        Where the file is missing, damaged or of no verb.

    Examples
    --------
    >>> import tempfile, gearplay as gp
    >>> place = tempfile.mkdtemp() + "/run.nc"
    >>> gp.simulate("han2021", duration=0.01, transient=0.0).save(place)
    >>> gp.read_result(place).success
    True

    """
    place = Path(path)
    if place.suffix.lower() == ".json":
        from gearplay.calibration.result import Calibration

        return Calibration.from_document(place)
    if place.suffix.lower() not in (".nc", ".nc4", "") and place.exists():
        return _record(place)
    dataset = read_dataset(place)
    kind = kind_of(dataset)
    if kind == "record":
        return _record(place)
    if kind not in ANSWERS:
        rule = "must be what the save of an answer wrote"
        raise InputError(Fault("file", shown_path(place), rule, "Open it with xarray.open_dataset"))
    module, _, name = ANSWERS[kind].partition(":")
    return getattr(import_module(f"gearplay.{module}"), name).from_dataset(dataset)


def _record(place: Path) -> Any:
    from gearplay.files.measurements import read_measurement

    return read_measurement(place)


def kind_of(dataset: Any) -> str:
    """Return the kind of answer that a file holds, of one that does not say it, as older versions wrote; empty for none."""
    from gearplay.results.answer import KIND

    if KIND in dataset.attrs:
        return str(dataset.attrs[KIND])
    names, attributes = set(dataset.variables), dataset.attrs
    marks = {
        "run": {"contact", "share_of_time"} <= names,
        "sweep": "plan" in attributes and "status" in names,
        "branches": "special_kind" in names and "matrix" in names,
        "portrait": "path_time" in names,
        "bifurcation": {"direction", "reason"} <= names,
        "record": any(str(key).startswith("gearplay_channels") for key in (*names, *attributes)),
    }
    return next((kind for kind, found in marks.items() if found), "")
