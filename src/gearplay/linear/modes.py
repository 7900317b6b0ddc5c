"""Modes of a case, as returned by `gp.modes`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.linear.kinds import kinds_of, multiplicities
from gearplay.linear.system import LinearSystem
from gearplay.results.base import OfDataset
from gearplay.results.provenance import provenance

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Modes(OfDataset):
    """Natural frequencies of a case about its equilibrium, with damping ratios, shapes and shares of energy.

    ``ds`` has ``frequency`` (mode) [Hz], ``damping_ratio`` (mode), ``kind`` (mode), ``multiplicity`` (mode), ``shape`` (mode,
    coordinate) of unit modal mass, ``shape_imaginary`` where carriers turn, ``strain_energy_share`` (mode, element),
    ``kinetic_energy_share`` (mode, rotor), ``static_displacement`` (coordinate) from the nominal places, ``closed`` (contact),
    ``bilateral`` (contact): drive flanks that touch without load, as their back flanks do.
    """

    result_kind = "modes"

    @property
    def message(self) -> str:
        """Number and range of the modes, contacts closed by the load, and warnings as text."""
        ds = self.dataset
        frequency = ds["frequency"].values
        free = int(np.sum(frequency == 0.0))
        moving = frequency[frequency > 0.0]
        span = f", {moving[0]:.6g} to {moving[-1]:.6g} Hz" if moving.size else ""
        words = f"{frequency.size} modes{span}"
        if free:
            words += f", {free} of them free motions (0 Hz)"
        closed = int(ds["closed"].values.sum())
        words += f"; {closed} of {ds['closed'].size} contacts closed by the load"
        both = ds["contact"].values[ds["bilateral"].values == 1]
        if both.size:
            words += (
                f"; without gap and load, so taken to act on both sides of zero: {', '.join(map(str, both))}"
            )
        if int(ds.attrs["unstable"]):
            words += f"; {int(ds.attrs['unstable'])} motions without a restoring force: the equilibrium is not stable"
        if int(ds.attrs["unbalanced"]):
            words += (
                "; drives and loads do not balance: the train accelerates as one, and its inertia holds it"
            )
        return words

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return a line for each mode: frequency, damping, kind and where its energy is."""
        ds, found = self.dataset, []
        for m, frequency in enumerate(ds["frequency"].values):
            strain = ds["strain_energy_share"].values[m]
            where = ", ".join(
                f"{ds['element'].values[k]} {100 * strain[k]:.0f} %"
                for k in np.argsort(-strain)[:3]
                if strain[k] >= min(0.05, strain.max()) > 0.0
            )
            ratio = max(100.0 * float(ds["damping_ratio"].values[m]), 0.0)
            found.append(
                (
                    f"{frequency:.2f} Hz",
                    f"{ds['kind'].values[m]}, damping {ratio:.2f} %; {where or 'no strain'}",
                )
            )
        return found

    def plot(self, *, most: int = 12) -> Figure:
        """Draw the shapes of the first modes on the mechanism; returns the figure."""
        from gearplay.linear.figures import shapes_drawing

        drawn: Figure = shapes_drawing(self.dataset, most=most)
        return drawn


def modes_of(system: LinearSystem) -> Modes:
    """Return the modes of a linear system as a dataset with provenance."""
    import xarray as xr

    eigen = system.eigen
    shapes: Any = eigen.shape
    packed = system.linear.smooth.packed
    labels = packed.contact_labels
    both = [f"{system.case.meshes[n].label}:drive" for n in system.linear.bilateral]
    static = system.equilibrium.state[system.linear.free]

    def numbers(dims: Any, values: Any, units: str, words: str) -> Any:
        return dims, values, {"units": units, "long_name": words}

    variables: dict[str, Any] = {
        "frequency": numbers("mode", eigen.frequency, "Hz", "natural frequency, undamped"),
        "damping_ratio": numbers("mode", eigen.damping_ratio, "1", "damping ratio"),
        "kind": ("mode", np.array(kinds_of(system, shapes), dtype=object), {"long_name": "kind of mode"}),
        "multiplicity": numbers(
            "mode", multiplicities(eigen.frequency), "1", "number of modes at this frequency"
        ),
        "shape": numbers(
            ("mode", "coordinate"),
            np.real(shapes).copy(),
            "kg^-0.5",
            "shape of unit modal mass: m or rad per kg^0.5 m",
        ),
        "strain_energy_share": numbers(
            ("mode", "element"), system.strain_shares, "1", "share of an element in the strain energy"
        ),
        "kinetic_energy_share": numbers(
            ("mode", "rotor"), system.kinetic_shares(shapes), "1", "share of a rotor in the kinetic energy"
        ),
        "static_displacement": numbers(
            "coordinate", static, "m", "displacement by the load, rotations in rad"
        ),
        "closed": (
            "contact",
            np.array([int(label in system.equilibrium.closed) for label in labels], dtype=np.int8),
            {"long_name": "1 where the load closes the contact"},
        ),
        "bilateral": (
            "contact",
            np.isin(labels, both).astype(np.int8),
            {"long_name": "1 where a contact without gap and load acts on both sides of zero"},
        ),
    }
    if np.iscomplexobj(shapes):
        variables["shape_imaginary"] = numbers(
            ("mode", "coordinate"),
            np.imag(shapes).copy(),
            "kg^-0.5",
            "imaginary part of the shape, in the carriers' frame",
        )
    coordinates = {
        "coordinate": list(system.coordinates),
        "element": list(system.elements),
        "rotor": list(packed.rotor_names),
        "contact": list(labels),
    }
    attributes = provenance(
        system.case,
        unstable=eigen.unstable,
        unbalanced=int(system.equilibrium.unbalanced),
        turning=int(system.linear.smooth.frames.turning),
    )
    return Modes(xr.Dataset(variables, coords=coordinates, attrs=attributes))
