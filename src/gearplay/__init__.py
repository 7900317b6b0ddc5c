"""gearplay: dynamics of gear mechanisms whose small clearances are coupled.

The public names below are the interface; everything else may move. Heavy parts load on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gearplay.vocabulary.version import VERSION

__version__ = VERSION

__all__ = [
    "Case",
    "Channel",
    "Engine",
    "GearplayError",
    "InputError",
    "MeasurementError",
    "Policy",
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
    "campbell",
    "check_case",
    "frequency_response",
    "impacts",
    "load_case",
    "load_plan",
    "load_sharing",
    "lyapunov",
    "measure",
    "modes",
    "motion",
    "periodic_orbit",
    "planetary",
    "portrait",
    "read_measurement",
    "read_result",
    "replace",
    "section",
    "signals",
    "simulate",
    "sweep",
    "torsional_pair",
    "write_record",
]

if TYPE_CHECKING:
    from gearplay import signals
    from gearplay.calibration.door import calibrate
    from gearplay.calibration.reading import load_plan
    from gearplay.files.measurements import read_measurement, write_record
    from gearplay.files.record import Channel, Record
    from gearplay.linear.door import campbell, frequency_response, modes
    from gearplay.model.case import Case
    from gearplay.model.check import check_case
    from gearplay.model.planetary_door import planetary
    from gearplay.model.policy import Policy
    from gearplay.model.reading import load_case, replace
    from gearplay.nonlinear.door import basins, bifurcation, lyapunov, motion
    from gearplay.nonlinear.orbits.door import branch, branches, periodic_orbit
    from gearplay.nonlinear.section_door import impacts, portrait, section
    from gearplay.nonlinear.torsional import torsional_pair
    from gearplay.planets.door import load_sharing
    from gearplay.python_door import read_result
    from gearplay.results.door import simulate
    from gearplay.results.result import Result
    from gearplay.rig.door import measure
    from gearplay.sweeps.door import sweep
    from gearplay.sweeps.running.engines import Engine
    from gearplay.vocabulary.errors import (
        GearplayError,
        InputError,
        MeasurementError,
        ResourceError,
        SimulationError,
    )


def __getattr__(name: str) -> Any:
    if name == "signals":
        return import_module("gearplay.signals")
    if name not in __all__:
        raise AttributeError(f"module 'gearplay' has no attribute {name!r}")
    from gearplay.python_door import public

    return public(name)


def __dir__() -> list[str]:
    return sorted(__all__)
