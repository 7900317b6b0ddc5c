"""Campbell diagram: natural frequencies over speed, and where orders of excitation meet them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.linear.kinds import kinds_of
from gearplay.linear.system import LinearSystem, linear_system
from gearplay.model.case import Case
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.results.base import OfDataset
from gearplay.results.provenance import provenance

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

HARMONICS = 2
"""Orders of each mesh that are drawn."""


@dataclass(frozen=True, repr=False)
class Campbell(OfDataset):
    """Natural frequencies over the speed of the leading rotor.

    ``ds`` has ``frequency`` (speed, mode) and ``damping_ratio``, modes followed from speed to speed by their shapes;
    ``order_frequency`` (speed, order); ``crossing_speed``, ``crossing_frequency``, ``crossing_order`` and ``crossing_mode``
    (crossing).
    """

    result_kind = "campbell"

    @property
    def message(self) -> str:
        """Number of crossings as text."""
        ds = self.dataset
        return (
            f"{ds.sizes['mode']} modes over {ds.sizes['speed']} speeds of {ds.attrs['lead']}: "
            f"{ds.sizes['crossing']} crossings with {ds.sizes['order']} orders"
        )

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return a line for each crossing."""
        ds = self.dataset
        return [
            (f"{30.0 / np.pi * speed:.6g} rpm", f"{order} meets mode {int(mode)} at {frequency:.6g} Hz")
            for speed, order, mode, frequency in zip(
                ds["crossing_speed"].values, ds["crossing_order"].values, ds["crossing_mode"].values,
                ds["crossing_frequency"].values, strict=True,
            )
        ]  # fmt: skip

    def plot(self) -> Figure:
        """Draw the diagram; returns the figure."""
        from gearplay.linear.figures import campbell_drawing

        drawn: Figure = campbell_drawing(self.dataset)
        return drawn


def orders_of(case: Case) -> dict[str, float]:
    """Return the excitation orders of a train by name, in periods per turn of its leading rotor: shafts, meshes, harmonics."""
    _, ratios = rolling.rolling_ratios(case)
    names = list(case.rotors)
    found: dict[str, float] = {}

    def add(name: str, order: float) -> None:
        if order > 1e-9 and not any(abs(order - other) < 1e-9 * order for other in found.values()):
            found[name] = order

    for j, mesh in enumerate(case.meshes):
        frame = geometry.mesh_frame(case, j)
        beside = ratios[names.index(frame)] if frame is not None else 0.0
        order = abs(float(ratios[names.index(mesh.rotors[0])] - beside)) * geometry.teeth_of(
            case, mesh.driver
        )
        for k in range(1, HARMONICS + 1):
            add(f"{k} x {mesh.label}" if k > 1 else mesh.label, k * order)
    for name, ratio in zip(names, ratios, strict=True):
        add(name, abs(float(ratio)))
    return found


def campbell_of(case: Case, speeds: Floats, *, load: str) -> Campbell:
    """Return the diagram of a case over speeds [rad/s] of its leading rotor."""
    import xarray as xr

    lead, _ = rolling.rolling_ratios(case)
    carried = any(geometry.carrier_of(case, name) is not None for name in case.rotors)
    if carried:
        systems = [linear_system(case, load=load, speed=float(s)) for s in speeds]
    else:
        systems = [linear_system(case, load=load)] * len(speeds)
    frequency, damping = _followed(systems)
    orders = orders_of(case)
    lines = np.abs(speeds)[:, None] * np.array(list(orders.values()))[None, :] / (2.0 * np.pi)
    met = _crossings(speeds, frequency, lines)

    def numbers(dims: Any, values: Any, units: str, words: str) -> Any:
        return dims, values, {"units": units, "long_name": words}

    kinds = kinds_of(systems[0], systems[0].eigen.shape)
    names = list(orders)
    variables = {
        "frequency": numbers(("speed", "mode"), frequency, "Hz", "natural frequency"),
        "damping_ratio": numbers(("speed", "mode"), damping, "1", "damping ratio"),
        "kind": ("mode", np.array(kinds, dtype=object), {"long_name": "kind of mode at the lowest speed"}),
        "order_frequency": numbers(("speed", "order"), lines, "Hz", "frequency of an order"),
        "crossing_speed": numbers("crossing", np.array([c[0] for c in met]), "rad/s", "speed of a crossing"),
        "crossing_frequency": numbers("crossing", np.array([c[1] for c in met]), "Hz", "frequency of a crossing"),
        "crossing_mode": numbers("crossing", np.array([c[2] for c in met], dtype=np.int64), "1", "mode of a crossing"),
        "crossing_order": (
            "crossing", np.array([names[c[3]] for c in met], dtype=object), {"long_name": "order of a crossing"},
        ),
    }  # fmt: skip
    coordinates = {
        "speed": ("speed", speeds, {"units": "rad/s", "long_name": f"speed of {lead}"}),
        "order": names,
    }
    attributes = provenance(case, lead=lead, turning=int(carried))
    return Campbell(xr.Dataset(variables, coords=coordinates, attrs=attributes))


def _followed(systems: list[LinearSystem]) -> tuple[Floats, Floats]:
    """Return frequencies and damping ratios, shape [speed, mode], each mode followed by its likeness to that before."""
    from scipy.optimize import linear_sum_assignment

    frequency, damping = [systems[0].eigen.frequency], [systems[0].eigen.damping_ratio]
    before = systems[0].eigen.shape
    for system in systems[1:]:
        eigen = system.eigen
        if system is systems[0]:
            frequency.append(frequency[0])
            damping.append(damping[0])
            continue
        # Shapes are of unit modal mass: their products with the mass are cosines.
        likeness = np.abs(before.conj() @ (system.mass[:, None] * eigen.shape.T)) ** 2
        size = max(float(eigen.frequency.max(initial=0.0)), 1e-9)
        apart = np.abs(frequency[-1][:, None] - eigen.frequency[None, : len(eigen.frequency)]) / size
        rows, columns = linear_sum_assignment(10.0 * apart - likeness)
        order = columns[np.argsort(rows)]
        frequency.append(eigen.frequency[order])
        damping.append(eigen.damping_ratio[order])
        before = eigen.shape[order]
    return np.array(frequency), np.array(damping)


def _crossings(speeds: Floats, frequency: Floats, lines: Floats) -> list[tuple[float, float, int, int]]:
    """Return (speed [rad/s], frequency [Hz], mode, order) where an order's line meets a mode, by rising speed."""
    found = []
    for mode in range(frequency.shape[1]):
        for order in range(lines.shape[1]):
            gap = lines[:, order] - frequency[:, mode]
            for k in np.flatnonzero(
                (gap[:-1] < 0.0) & (gap[1:] >= 0.0) | (gap[:-1] > 0.0) & (gap[1:] <= 0.0)
            ):
                part = gap[k] / (gap[k] - gap[k + 1])
                speed = speeds[k] + part * (speeds[k + 1] - speeds[k])
                level = lines[k, order] + part * (lines[k + 1, order] - lines[k, order])
                if level > 0.0:
                    found.append((float(speed), float(level), mode, order))
    return sorted(found)
