"""Public functions with checked arguments, and `read_result` for all kinds of results."""

import os
from functools import cache
from importlib import import_module
from inspect import isfunction
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from gearplay.files.atomic import shown_path
from gearplay.files.netcdf import check_file, opened, read_dataset
from gearplay.vocabulary.arguments import checked_function
from gearplay.vocabulary.errors import InputError

RESULTS: Final = MappingProxyType(
    {
        "run": "results.result:Result",
        "sweep": "sweeps.result:SweepResult",
        "dataset": "datasets.result:DatasetResult",
        "calibration": "calibration.result:Calibration",
        "diagnosis": "diagnosis.result:Diagnosis",
        "bifurcation": "nonlinear.diagrams:Diagram",
        "portrait": "nonlinear.portrait:Portrait",
        "section": "nonlinear.sections:Section",
        "exponents": "nonlinear.lyapunov:Exponents",
        "motion": "nonlinear.motion:Motion",
        "basins": "nonlinear.basins:Basins",
        "orbit": "nonlinear.orbits.results:PeriodicOrbit",
        "branch": "nonlinear.orbits.results:OneBranch",
        "branches": "nonlinear.orbits.results:Branches",
        "modes": "linear.modes:Modes",
        "lost motion": "hysteresis.result:LostMotion",
        "reduction": "hysteresis.reduction:Reduction",
        "describing function": "hysteresis.describing:DescribingFunction",
        "teeth": "gear_pairs.teeth:Teeth",
        "validation": "validation.validate:Validation",
        "load sharing": "planets.sharing:LoadSharing",
        "wear": "life.result:Wear",
        "campbell": "linear.campbell:Campbell",
        "frequency response": "linear.response:FrequencyResponse",
    }
)
"""Class of each kind of saved result."""


@cache
def public(name: str, module: str) -> Any:
    """Return the object of a public name in a module, a function with checked arguments."""
    found = getattr(import_module(module), name)
    return checked_function(found, _seconds) if isfunction(found) else found


def _seconds(name: str, text: str) -> float:
    """Return a time that an argument gives as text, such as ``"10 ms"`` [s]."""
    from gearplay.schema.units import UnitError, parse_quantity
    from gearplay.vocabulary.quantities import TIME

    try:
        return parse_quantity(text, TIME)
    except UnitError as error:
        raise InputError.of(
            name, text, error.rule, "Write for example 10 ms, or a number of seconds"
        ) from None


def read_result(path: str | os.PathLike[str]) -> Any:
    """Read a saved result and return an object of the same kind.

    Parameters
    ----------
    path
        A file that ``save`` or a command wrote: ``.nc`` of any function, ``calibration.json``, or a record in any format of
        `read_measurement`.

    Returns
    -------
    Result
        A `Result`, a sweep, a diagram ...: of the kind of the saved one.

    Raises
    ------
    InputError
        Where the file is missing, damaged or of no result.

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
    if place.suffix.lower() == ".toml" and place.exists():
        rule = "must be a result, and this is a TOML file"
        raise InputError.of("file", str(path), rule, "Read a case by gearplay.load_case")
    if place.suffix.lower() not in (".nc", ".nc4", "") and place.exists():
        return _record(place)
    from gearplay.files.measurements.hdf5 import OURS
    from gearplay.results.provenance import KIND

    checked = check_file(place)
    with opened(checked) as file:
        kind = file.attribute(KIND, str, "")
        if kind == "run" and "motion" in file:
            return _result_class(kind).from_file(file, place)
    dataset = read_dataset(checked)
    if OURS in dataset.attrs:
        return _record(place)
    kind = str(dataset.attrs.get(KIND, ""))
    if kind not in RESULTS:
        rule = "must be a file of a saved result"
        raise InputError.of("file", shown_path(place), rule, "Open it with xarray.open_dataset")
    return _result_class(kind).from_dataset(dataset)


def _result_class(kind: str) -> Any:
    module, _, name = RESULTS[kind].partition(":")
    return getattr(import_module(f"gearplay.{module}"), name)


def _record(place: Path) -> Any:
    from gearplay.files.measurements import read_measurement

    return read_measurement(place)
