"""Where along a field of a case a resonance lies."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model import rolling
from gearplay.model.case import Case
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.linear.response import FrequencyResponse


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
