"""`describing_function`: first harmonic of a train's torque over a sinusoidal twist, and the limit cycles that it predicts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.hysteresis.balance_path import Train
from gearplay.hysteresis.cycle import limit_at_zero
from gearplay.hysteresis.held import held
from gearplay.hysteresis.loop_prediction import Prediction, predicted
from gearplay.model.reading import Source
from gearplay.results.base import OfDataset
from gearplay.results.provenance import provenance
from gearplay.results.simulate import case_of
from gearplay.schema.units import quantity_of
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearplay.nonlinear.orbits.results import PeriodicOrbit

Floats = NDArray[np.float64]

POINTS = 80
"""Points of the elastic curve, closer to each other near zero torque."""
AMPLITUDES = 300
LEAST = 1.001
"""Least amplitude of the twist, in half widths of the play."""


@dataclass(frozen=True, repr=False)
class DescribingFunction(OfDataset):
    """First harmonic of a train's torque over its twist, and limit cycles of its position loop.

    ``ds``: over ``amplitude`` (of the twist [rad]) ``stiffness`` and ``loss`` [N m/rad], real and imaginary part; of a case with
    a position loop also ``growth_rate`` [1/s] and ``frequency`` [Hz] of the loop with that stiffness, and over ``cycle`` the
    predicted limit cycles: ``cycle_period`` [s], ``cycle_twist`` and ``cycle_amplitude`` of the output [rad], ``cycle_stable``.
    """

    result_kind = "describing function"

    @property
    def message(self) -> str:
        """The predicted stable limit cycles as text."""
        ds = self.dataset
        if "cycle" not in ds.sizes:
            return f"describing function over {ds.sizes['amplitude']} amplitudes, no position loop"
        stable = np.flatnonzero(ds["cycle_stable"].values)
        if not stable.size:
            return "no stable limit cycle predicted"
        found = [
            f"period {float(ds['cycle_period'][k]):.4g} s, amplitude {float(ds['cycle_amplitude'][k]):.4g} rad at the output"
            for k in stable
        ]
        return "stable limit cycle predicted: " + "; ".join(found)

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return the effects that the prediction omits."""
        return [
            (
                "left out",
                "higher harmonics, contact damping, sampling, delay, encoders, limits of the torque",
            ),
            ("so", "compare with gp.periodic_orbit(..., autonomous=True) before relying on it"),
        ]

    def errors(self, orbit: PeriodicOrbit) -> dict[str, float]:
        """Return the relative errors of the predicted period and amplitude of the output against a computed limit cycle.

        Of several predictions that of the nearest period. Raises `InputError` where none is predicted or the orbit is forced.
        """
        ds = self.dataset
        if not math.isfinite(orbit.period):
            rule = "must be a limit cycle"
            raise InputError.of("orbit", "forced", rule, "Compute it with autonomous = True")
        if not ds.sizes.get("cycle", 0):
            raise InputError.of("orbit", "given", "nothing is predicted to compare it with", "Leave it out")
        at = int(np.argmin(np.abs(np.log(ds["cycle_period"].values / orbit.period))))
        swing = orbit.amplitude(f"{ds.attrs['at']}.theta")
        return {
            "period": float(ds["cycle_period"][at]) / orbit.period - 1.0,
            "amplitude": float(ds["cycle_amplitude"][at]) / swing - 1.0,
        }

    def plot(self) -> Figure:
        """Draw stiffness over amplitude, and growth rate with the predicted limit cycles; return the figure."""
        from gearplay.hysteresis.figures import describing_drawing

        drawn: Figure = describing_drawing(self.dataset)
        return drawn


def describing_function(
    case: Source, *, at: str, hold: str | Sequence[str], torque: float | str
) -> DescribingFunction:
    """Return the describing function of a train: the first harmonic of its torque over a sinusoidal twist, input held.

    It is quasi-static: clearances, springs, contact stiffness and Coulomb friction of the train as of `lost_motion`, the mean of
    both signs of the torque. Of a case whose held rotor has a position loop it predicts limit cycles: two inertias as of `reduce`
    with the describing function between them.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    at, hold
        Output, and input or several rotors that are held.
    torque
        Largest torque of the elastic curve [N m], or with a unit: it sets the largest amplitude.

    Returns
    -------
    DescribingFunction
        ``.ds``, ``errors(orbit)`` and ``plot()``.

    Raises
    ------
    InputError
        For rotors that do not hold the train, or a torque that is too small.
    SimulationError
        Where no equilibrium is found.

    Examples
    --------
    >>> import gearplay as gp
    >>> found = gp.describing_function("external-pair", at="output", hold="input", torque="50 N m")
    >>> bool(found.ds["stiffness"][0] < found.ds["stiffness"][-1])
    True

    """
    import xarray as xr

    base = case_of(case)
    rated = quantity_of("torque", torque, q.TORQUE)
    whole = held(base, at, hold)
    twist, torques, half = _elastic_curve(Train(whole), rated)
    friction = float(np.sum(whole.friction * np.abs(whole.ratios)))
    least = LEAST * half if half > 0.0 else 1e-3 * twist[-1]
    if least >= twist[-1]:
        rule = "must twist the train well beyond its play"
        raise InputError.of("torque", f"{rated:.4g} N m", rule, "Raise it")
    amplitudes = np.geomspace(least, twist[-1], AMPLITUDES)
    stiffness = _first_harmonic(twist, torques, half)

    def harmonic(amplitude: float) -> complex:
        return complex(stiffness(amplitude), 4.0 * friction / (math.pi * amplitude))

    found = np.array([harmonic(a) for a in amplitudes.tolist()])
    variables: dict[str, Any] = {
        "stiffness": ("amplitude", found.real, {"units": "N m/rad", "long_name": "real part"}),
        "loss": ("amplitude", found.imag, {"units": "N m/rad", "long_name": "imaginary part"}),
        "half_width": ((), half, {"units": "rad", "long_name": "half of the backlash"}),
    }
    loop = predicted(base, whole, rated, amplitudes, harmonic)
    if loop is not None:
        variables |= _loop_variables(loop)
    attributes = provenance(base, at=at, hold=" ".join(whole.hold), rated_torque=rated)
    axis = {"amplitude": ("amplitude", amplitudes, {"units": "rad", "long_name": "amplitude of the twist"})}
    return DescribingFunction(xr.Dataset(variables, axis, attributes))


def _loop_variables(loop: Prediction) -> dict[str, Any]:
    cycles = np.array(loop.cycles, dtype=np.float64).reshape(-1, 4)
    words = (
        ("cycle_period", "s", "period of a predicted limit cycle"),
        ("cycle_twist", "rad", "amplitude of its twist"),
        ("cycle_amplitude", "rad", "amplitude of the output"),
        ("cycle_stable", "1", "whether it attracts"),
    )
    found: dict[str, Any] = {
        name: ("cycle", cycles[:, k], {"units": unit, "long_name": about})
        for k, (name, unit, about) in enumerate(words)
    }
    found["growth_rate"] = (
        "amplitude",
        loop.growth,
        {"units": "1/s", "long_name": "growth rate of the loop"},
    )
    found["frequency"] = ("amplitude", loop.frequency, {"units": "Hz", "long_name": "frequency of the loop"})
    return found


def _elastic_curve(train: Train, rated: float) -> tuple[Floats, Floats, float]:
    """Return twist [rad] and torque [N m] without friction, from the edge of the play on, and half the play [rad]."""
    train.friction = {}
    torques = rated * (np.arange(1, POINTS + 1) / POINTS) ** 2
    sides, edges = [], []
    for sign in (1.0, -1.0):
        train.reset()
        sides.append([sign * train.load(float(sign * each)) for each in torques[::-1]][::-1])
        edges.append(sign * limit_at_zero(train, rated, sign))
    half = max(0.5 * (edges[0] + edges[1]), 0.0)
    twist = np.concatenate([[half], np.mean(sides, axis=0)])
    return twist, np.concatenate([[0.0], torques]), half


def _first_harmonic(twist: Floats, torques: Floats, half: float) -> Callable[[float], float]:
    """Return the first harmonic [N m/rad] of the torque over ``amplitude sin x``: Gauss's rule from the edge of the play on."""
    from scipy.interpolate import PchipInterpolator

    nodes, weights = np.polynomial.legendre.leggauss(96)
    curve = PchipInterpolator(twist, torques)

    def harmonic(amplitude: float) -> float:
        start = math.asin(min(half / amplitude, 1.0))
        width = 0.5 * math.pi - start
        sine = np.sin(start + 0.5 * width * (nodes + 1.0))
        values = curve(np.clip(amplitude * sine, twist[0], twist[-1]))
        return float(2.0 * width / (math.pi * amplitude) * np.sum(weights * values * sine))

    return harmonic
