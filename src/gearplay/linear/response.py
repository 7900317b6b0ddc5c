"""Response of a linear system to one harmonic excitation, over its frequency."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.linear.inputs import Excitation, excitation_of
from gearplay.linear.outputs import output_of
from gearplay.linear.system import LinearSystem
from gearplay.results.base import OfDataset
from gearplay.results.provenance import provenance
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

BLOCK = 256
"""Frequencies solved at once."""
TAKEN = ("at", "frequency", "mode", "amplitude", "phase", "unit")
"""Names of a response, which a parameter cannot have alone."""


@dataclass(frozen=True, repr=False)
class FrequencyResponse(OfDataset):
    """Response of displacements, torques and forces to a harmonic excitation of amplitude 1.

    ``ds`` has ``amplitude``, in ``unit`` (at) per unit of the excitation, and ``phase`` [rad], its lead over the cosine, both
    (at, frequency); over a parameter (parameter, at, frequency), with ``natural_frequency`` (parameter, mode).
    """

    result_kind = "frequency response"

    @property
    def parameter(self) -> str | None:
        """Dimension of the parameter, None of a single case."""
        first = str(self.dataset["amplitude"].dims[0])
        return None if first == "at" else first

    @property
    def resonances(self) -> dict[str, float]:
        """Frequency [Hz] of the largest response of each output over all values of the parameter."""
        found, frequency = self.dataset["amplitude"].values, self.dataset["frequency"].values
        found = found if self.parameter is None else found.max(axis=0)
        return {
            str(name): float(frequency[int(np.argmax(row))])
            for name, row in zip(self.dataset["at"].values, found, strict=True)
        }

    @property
    def message(self) -> str:
        """Frequency of the largest response of each output as text."""
        words = ", ".join(f"{name} most at {frequency:.6g} Hz" for name, frequency in self.resonances.items())
        over = ""
        if self.parameter is not None:
            values = self.dataset[self.parameter].values
            over = f" over {values.size} values of {self.parameter}, {values[0]:.6g} to {values[-1]:.6g}"
        return f"response to {self.dataset.attrs['force']}{over}: {words}"

    def plot(self) -> Figure:
        """Draw amplitudes and phases over frequency, over a parameter the amplitudes; returns the figure."""
        from gearplay.linear.figures import family_drawing, response_drawing

        drawn: Figure = (
            response_drawing(self.dataset) if self.parameter is None else family_drawing(self.dataset)
        )
        return drawn


def solve_response(system: LinearSystem, excitation: Excitation, frequencies: Floats) -> Complex:
    """Return the complex amplitude of every coordinate, shape [frequency, coordinate]."""
    omega = 2.0 * np.pi * frequencies
    found = np.empty((len(omega), len(excitation.by_value)), dtype=np.complex128)
    mass = np.diag(system.mass)
    for start in range(0, len(omega), BLOCK):
        w = omega[start : start + BLOCK, None, None]
        dynamic = system.stiffness + 1j * w * system.damping - w * w * mass
        right = excitation.by_value + 1j * w * excitation.by_rate - w * w * excitation.by_second_rate
        try:
            found[start : start + BLOCK] = np.linalg.solve(dynamic, np.swapaxes(right, 1, 2))[:, :, 0]
        except np.linalg.LinAlgError:
            rule = "must not be that of an undamped mode, nor 0 where the train is free to turn"
            raise InputError.of("frequencies", "one of them", rule, "Leave it out, or give damping") from None
    return found


def response_of(
    system: LinearSystem, force: str, at: Sequence[str], frequencies: Floats
) -> FrequencyResponse:
    """Return the response of some outputs as a dataset with provenance."""
    import xarray as xr

    outputs = [output_of(system, name) for name in at]
    excitation = excitation_of(system, force)
    every = solve_response(system, excitation, frequencies)
    rate = 2j * np.pi * frequencies
    rows: list[Complex] = []
    for output in outputs:
        row = every @ output.by_place + rate * (every @ output.by_rate)
        if output.mesh and output.mesh == excitation.mesh:
            row = row + output.error[0] + rate * output.error[1]
        rows.append(row)
    chosen = np.array(rows)
    unit = excitation.unit
    per = f"({unit})" if " " in unit or "/" in unit else unit
    variables = {
        "amplitude": (
            ("at", "frequency"),
            np.abs(chosen),
            {"units": f"1/{per}", "long_name": f"amplitude per {unit} of {force}"},
        ),
        "phase": (
            ("at", "frequency"),
            np.angle(chosen),
            {"units": "rad", "long_name": "phase before the excitation"},
        ),
        "unit": (
            ("at",),
            np.array([output.unit for output in outputs], dtype=object),
            {"long_name": "unit of an output"},
        ),
    }
    coordinates = {
        "frequency": ("frequency", frequencies, {"units": "Hz", "long_name": "frequency"}),
        "at": list(at),
    }
    natural = [float(f) for f in system.eigen.frequency]
    attributes = provenance(system.case, force=force, natural_frequencies=natural)
    return FrequencyResponse(xr.Dataset(variables, coords=coordinates, attrs=attributes))


def responses_of(
    systems: Iterable[LinearSystem],
    force: str,
    at: Sequence[str],
    frequencies: Floats,
    *,
    path: str,
    values: Floats,
    units: str,
) -> FrequencyResponse:
    """Return the responses of systems over the ``values`` of a field or parameter, as one dataset."""
    import xarray as xr

    name = path.rpartition(".")[2]
    name = path if name in TAKEN else name
    found, natural = [], []
    for system in systems:
        found.append(response_of(system, force, at, frequencies).ds)
        natural.append(system.eigen.frequency)
    modes = max(map(len, natural))
    padded = [np.pad(row, (0, modes - len(row)), constant_values=np.nan) for row in natural]
    ds = xr.concat(
        [each[["amplitude", "phase"]] for each in found], dim=name, combine_attrs="override", join="exact"
    )
    ds = ds.assign(unit=found[0]["unit"])
    words = {"units": "Hz", "long_name": "natural frequency, undamped"}
    ds["natural_frequency"] = ((name, "mode"), np.array(padded), words)
    ds = ds.assign_coords({name: (name, values, {"units": units, "long_name": path})})
    attributes = {key: value for key, value in found[0].attrs.items() if key != "natural_frequencies"}
    return FrequencyResponse(ds.drop_attrs(deep=False).assign_attrs(attributes))
