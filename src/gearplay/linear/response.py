"""Response of a linear system to one harmonic excitation, over its frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.linear.system import LinearSystem, places_of
from gearplay.results.answer import OfDataset
from gearplay.results.provenance import provenance
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

FORCES = {"fx": ("x", "N"), "fy": ("y", "N"), "torque": ("theta", "N m")}
ERROR = "transmission_error"
BLOCK = 256
"""Frequencies solved at once."""


@dataclass(frozen=True, repr=False)
class FrequencyResponse(OfDataset):
    """How coordinates follow a harmonic excitation of amplitude 1.

    ``ds`` has ``amplitude`` [m or rad per unit] and ``phase`` [rad] behind the excitation's cosine, both (at, frequency).
    """

    answer = "frequency response"

    @property
    def resonances(self) -> dict[str, float]:
        """Frequency [Hz] at which each coordinate answers most."""
        found, frequency = self.dataset["amplitude"].values, self.dataset["frequency"].values
        return {
            str(name): float(frequency[int(np.argmax(row))])
            for name, row in zip(self.dataset["at"].values, found, strict=True)
        }

    @property
    def message(self) -> str:
        """Where each coordinate answers most, in words."""
        words = ", ".join(f"{name} most at {frequency:.6g} Hz" for name, frequency in self.resonances.items())
        return f"response to {self.dataset.attrs['force']}: {words}"

    def plot(self) -> Figure:
        """Draw amplitudes and phases over frequency; returns the figure."""
        from gearplay.linear.figures import response_drawing

        drawn: Figure = response_drawing(self.dataset)
        return drawn


def excitation_of(system: LinearSystem, force: str) -> tuple[Floats, Floats, str]:
    """Return the force of a unit excitation on each coordinate, what its rate adds, and its unit, shapes [coordinate]."""
    label, _, kind = force.rpartition(".")
    none = np.zeros(len(system.coordinates))
    if kind == ERROR:
        gradient, stiffness, damping = system.line_of_action(label)
        return -stiffness * gradient, -damping * gradient, "m"
    if kind not in FORCES:
        rule = "must be a force or torque on a rotor, or the error of a mesh"
        raise InputError(
            Fault(
                "force",
                force,
                rule,
                "Write rotor.fx, rotor.fy, rotor.torque or driver-driven.transmission_error",
            )
        )
    axis, unit = FORCES[kind]
    (place,) = places_of(system, [f"{label}.{axis}"])
    push = none.copy()
    push[place] = 1.0
    return push, none, unit


def solve_response(
    system: LinearSystem, force: str, frequencies: Floats
) -> tuple[NDArray[np.complex128], str]:
    """Return the complex amplitude of every coordinate, shape [frequency, coordinate], and the unit of the excitation."""
    push, by_rate, unit = excitation_of(system, force)
    omega = 2.0 * np.pi * frequencies
    found = np.empty((len(omega), len(push)), dtype=np.complex128)
    mass = np.diag(system.mass)
    for start in range(0, len(omega), BLOCK):
        w = omega[start : start + BLOCK, None, None]
        dynamic = system.stiffness + 1j * w * system.damping - w * w * mass
        right = (push + 1j * w[:, :, 0] * by_rate)[:, :, None]
        try:
            found[start : start + BLOCK] = np.linalg.solve(dynamic, right)[:, :, 0]
        except np.linalg.LinAlgError:
            rule = "must not be that of an undamped mode, nor 0 where the train is free to turn"
            raise InputError(
                Fault("frequencies", "one of them", rule, "Leave it out, or give damping")
            ) from None
    return found, unit


def response_of(
    system: LinearSystem, force: str, at: Sequence[str], frequencies: Floats
) -> FrequencyResponse:
    """Return the response of some coordinates as a dataset with provenance."""
    import xarray as xr

    places = places_of(system, at)
    complete, unit = solve_response(system, force, frequencies)
    chosen: Any = complete[:, places].T
    variables = {
        "amplitude": (
            ("at", "frequency"),
            np.abs(chosen),
            {
                "units": f"1/({unit})" if " " in unit else f"1/{unit}",
                "long_name": f"amplitude, m or rad per {unit} of {force}",
            },
        ),
        "phase": (
            ("at", "frequency"),
            np.angle(chosen),
            {"units": "rad", "long_name": "phase before the excitation"},
        ),
    }
    coordinates = {
        "frequency": ("frequency", frequencies, {"units": "Hz", "long_name": "frequency"}),
        "at": list(at),
    }
    natural = [float(f) for f in system.eigen.frequency]
    attributes = provenance(system.case, force=force, natural_frequencies=natural)
    return FrequencyResponse(xr.Dataset(variables, coords=coordinates, attrs=attributes))
