"""gearplay: dynamics of gear mechanisms whose small clearances are coupled.

The public names below are the interface; everything else may move. Heavy parts load on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gearplay.vocabulary.version import VERSION

__version__ = VERSION

_HOME = {
    "Case": "gearplay.model.case",
    "load_case": "gearplay.model.reading",
    "replace": "gearplay.model.reading",
    "check_case": "gearplay.model.check",
    "simulate": "gearplay.results.result",
    "Result": "gearplay.results.result",
    "read_result": "gearplay.results.result",
    "measure": "gearplay.rig.door",
    "Record": "gearplay.files.record",
    "Channel": "gearplay.files.record",
    "read_measurement": "gearplay.files.measurements",
    "write_record": "gearplay.files.measurements",
    "calibrate": "gearplay.calibration.door",
    "load_plan": "gearplay.calibration.reading",
    "sweep": "gearplay.sweeps.door",
    "basins": "gearplay.nonlinear.door",
    "bifurcation": "gearplay.nonlinear.door",
    "branch": "gearplay.nonlinear.orbits.door",
    "branches": "gearplay.nonlinear.orbits.door",
    "impacts": "gearplay.nonlinear.door",
    "lyapunov": "gearplay.nonlinear.door",
    "motion": "gearplay.nonlinear.door",
    "periodic_orbit": "gearplay.nonlinear.orbits.door",
    "portrait": "gearplay.nonlinear.door",
    "section": "gearplay.nonlinear.door",
    "torsional_pair": "gearplay.nonlinear.torsional",
    "GearplayError": "gearplay.vocabulary.errors",
    "InputError": "gearplay.vocabulary.errors",
    "SimulationError": "gearplay.vocabulary.errors",
    "ResourceError": "gearplay.vocabulary.errors",
    "MeasurementError": "gearplay.vocabulary.errors",
}

__all__ = [
    "Case",
    "Channel",
    "GearplayError",
    "InputError",
    "MeasurementError",
    "Record",
    "ResourceError",
    "Result",
    "SimulationError",
    "__version__",
    "basins",
    "bifurcation",
    "branch",
    "branches",
    "calibrate",
    "check_case",
    "impacts",
    "load_case",
    "load_plan",
    "lyapunov",
    "measure",
    "motion",
    "periodic_orbit",
    "portrait",
    "read_measurement",
    "read_result",
    "replace",
    "section",
    "simulate",
    "sweep",
    "torsional_pair",
    "write_record",
]

if TYPE_CHECKING:
    from gearplay.calibration.door import calibrate
    from gearplay.calibration.reading import load_plan
    from gearplay.files.measurements import read_measurement, write_record
    from gearplay.files.record import Channel, Record
    from gearplay.model.case import Case
    from gearplay.model.check import check_case
    from gearplay.model.reading import load_case, replace
    from gearplay.nonlinear.door import (
        basins,
        bifurcation,
        impacts,
        lyapunov,
        motion,
        portrait,
        section,
    )
    from gearplay.nonlinear.orbits.door import branch, branches, periodic_orbit
    from gearplay.nonlinear.torsional import torsional_pair
    from gearplay.results.result import Result, read_result, simulate
    from gearplay.rig.door import measure
    from gearplay.sweeps.door import sweep
    from gearplay.vocabulary.errors import (
        GearplayError,
        InputError,
        MeasurementError,
        ResourceError,
        SimulationError,
    )


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'gearplay' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
