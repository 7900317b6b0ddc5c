"""Load sharing among the planets of a set, static or along a simulated motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import FORCE
from gearplay.linear.system import linear_system
from gearplay.model.case import Case
from gearplay.parts.mesh.law.record import BACK, DRIVE
from gearplay.parts.mesh.train import geometry
from gearplay.parts.planetary.members import PinError
from gearplay.parts.planetary.names import MEMBERS
from gearplay.parts.registry import MESH
from gearplay.results.base import Column, OfDataset
from gearplay.results.planet_loads import load_factors, mesh_of, planets_of, set_of
from gearplay.results.provenance import provenance
from gearplay.results.result import Result
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

PLACES = 72
"""Parts of the carrier's turn over which forces are averaged."""
LEAST = 1e-6
"""Force on the sun [N] that is none."""
COLUMNS = {
    "share": Column(("planet",), "1", "share of the load on the sun"),
    "load_sharing_factor": Column(("planet",), "1", "load-sharing factor: 1 where all share alike"),
    "sun_force": Column(("planet",), "N", "force along the line of action at the sun, mean"),
    "ring_force": Column(("planet",), "N", "force along the line of action at the ring, mean"),
    "beside_pin": Column(("planet", "direction"), "m", "planet beside its pin, in the carrier's frame, mean"),
    "floating": Column(("member", "axis"), "m", "displacement of a floating member, mean"),
    "factor_spread": Column(
        ("planet",), "1", "standard deviation of the load-sharing factor, weighed by the load"
    ),
    "factor_peak": Column(("planet",), "1", "largest force over the mean share"),
    "factor_history": Column(("planet", "time"), "1", "load-sharing factor"),
    "beside_pin_history": Column(
        ("planet", "direction", "time"), "m", "planet beside its pin, in the carrier's frame"
    ),
    "floating_history": Column(("member", "axis", "time"), "m", "displacement of a floating member"),
    "force_over_turn": Column(("planet", "place"), "N", "force of the sun's mesh by place of the carrier"),
}


@dataclass(frozen=True, repr=False)
class LoadSharing(OfDataset):
    """Load sharing of the planets of one set.

    ``ds``: ``share`` (planet), of the sun's mesh forces, 1/N where they share alike, and ``load_sharing_factor`` (planet), N
    times that; ``sun_force``, ``ring_force`` (planet) [N], means; ``beside_pin`` (planet, direction) [m], radial and tangential
    in the carrier's frame, means; ``floating`` (member, axis) [m]. Of a motion also ``factor_spread`` (planet), the standard
    deviation of the factor over time, ``factor_peak``; over time ``factor_history`` (planet, time), ``beside_pin_history``
    (planet, direction, time), ``floating_history`` (member, axis, time); ``force_over_turn`` (planet, place) [N], the sun's mesh
    force averaged over places of the carrier's turn.
    """

    result_kind = "load sharing"

    @property
    def message(self) -> str:
        """The factors of the planets, the largest one and its peak as text."""
        factor = self.dataset["load_sharing_factor"].values
        words = (
            f"load sharing of {self.dataset.attrs['set']}: factors "
            f"{', '.join(f'{each:.4g}' for each in factor)}; the most loaded planet carries {np.max(factor):.4g} times its share"
        )
        if "factor_peak" in self.dataset:
            words += f", at its peak {float(self.dataset['factor_peak'].max()):.4g} times"
        return words

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return a line for each planet."""
        ds, found = self.dataset, []
        for k, name in enumerate(ds["planet"].values):
            spread = f" ± {float(ds['factor_spread'].values[k]):.3g}" if "factor_spread" in ds else ""
            radial, tangential = np.round(1e6 * ds["beside_pin"].values[k], 2) + 0.0  # no -0
            found.append(
                (
                    str(name),
                    f"factor {float(ds['load_sharing_factor'].values[k]):.4g}{spread}; beside its pin {radial:.2f} um outwards, "
                    f"{tangential:.2f} um ahead",
                )
            )
        return found

    def plot(self) -> Figure:
        """Draw factors, forces over a carrier turn, planets relative to their pins and floating members; return the figure."""
        from gearplay.planets.figures import sharing_drawing

        drawn: Figure = sharing_drawing(self.dataset)
        return drawn


@dataclass(frozen=True)
class Members:
    """Names of a set's rotors and meshes in a case, and the planets' directions [rad]."""

    case: Case
    name: str

    @property
    def planets(self) -> list[str]:
        """Rotors of the planets."""
        return planets_of(self.case, self.name)

    @property
    def directions(self) -> Floats:
        """Directions of the planets [rad], carrier at rotation 0."""
        return np.array(self.case.planetary[self.name].planets.directions)

    def mesh(self, planet: str, other: str) -> int:
        """Return the place of the mesh of a planet with ``sun`` or ``ring``."""
        return mesh_of(self.case, self.name, planet, other)

    def beside(self, planet: Floats, carrier: Floats, turn: Floats, k: int) -> Floats:
        """Return the displacement of planet k from its moving pin, radial and tangential [m], shape [2, time].

        ``planet`` and ``carrier`` are displacements [m], shape [2, time], ``turn`` the carrier's rotation [rad].
        """
        table, centres = self.case.planetary[self.name], geometry.centres(self.case.operating)
        phi, A = (
            float(self.directions[k]),
            math.dist(centres[self.planets[k]], centres[f"{self.name}.carrier"]),
        )
        place = A * np.array([np.cos(phi), np.sin(phi)])
        away = planet - carrier + place[:, None]
        out = np.array([np.cos(turn + phi), np.sin(turn + phi)])
        along = np.array([-out[1], out[0]])
        off = next((each for each in table.pin_errors if each.planet == k + 1), PinError(planet=k + 1))
        radial, tangential = np.sum(away * out, axis=0) - A, np.sum(away * along, axis=0)
        return np.array([radial - off.radial, tangential - off.tangential])

    def floating(self) -> list[str]:
        """Return sun, ring and carrier as far as their centres are free."""
        return [m for m in MEMBERS if not geometry.is_held(self.case, f"{self.name}.{m}")]


def members_of(case: Case, name: str | None) -> Members:
    """Return the set of a case; `InputError` where there is none, or several and no ``name``."""
    return Members(case, set_of(case, name))


def static_sharing(case: Case, name: str | None) -> LoadSharing:
    """Return the static load sharing of the planets."""
    system = linear_system(case)
    members = members_of(case, name)
    linear, state = system.linear, system.equilibrium.state
    rotors = {rotor: i for i, rotor in enumerate(case.rotors)}
    table, records = linear.loads.contacts, linear.system.elements

    def force(planet: str, other: str) -> float:
        contact = int(
            records["contact"][np.flatnonzero(records["kind"] == MESH)[members.mesh(planet, other)]]
        )
        return float(table[contact + DRIVE, FORCE] - table[contact + BACK, FORCE])

    def at(rotor: str) -> Floats:
        return state[3 * rotors[rotor] : 3 * rotors[rotor] + 2, None].copy()

    carrier = f"{members.name}.carrier"
    turn = state[3 * rotors[carrier] + 2, None]
    beside = [members.beside(at(p), at(carrier), turn, k)[:, 0] for k, p in enumerate(members.planets)]
    floats = [at(f"{members.name}.{m}")[:, 0] for m in members.floating()]
    values = {
        "sun_force": np.array([force(planet, "sun") for planet in members.planets]),
        "ring_force": np.array([force(planet, "ring") for planet in members.planets]),
        "beside_pin": np.array(beside),
        "floating": np.array(floats).reshape(-1, 2),
    }
    return LoadSharing(_dataset(members, values, {}, kind="static"))


def moving_sharing(result: Result, name: str | None, member: int) -> LoadSharing:
    """Return the load sharing of the planets along a simulated motion."""
    case = result.case
    members = members_of(case, name)
    labels = [mesh.label for mesh in case.meshes]

    of_rotors = [(signal, rotor) for rotor in case.rotors for signal in ("x", "y", "theta")]
    forces = [(signal, label) for label in labels for signal in ("drive_force", "back_force")]
    result.runs[member].compute([*of_rotors, *forces])

    def series(signal: str, label: str) -> Floats:
        return result.signal(signal, label, member)

    def force(planet: str, other: str) -> Floats:
        label = labels[members.mesh(planet, other)]
        return series("drive_force", label) - series("back_force", label)

    def at(rotor: str) -> Floats:
        return np.stack([series("x", rotor), series("y", rotor)])

    carrier = f"{members.name}.carrier"
    turn = series("theta", carrier)
    sun = np.array([force(planet, "sun") for planet in members.planets])
    ring = np.array([force(planet, "ring") for planet in members.planets])
    place = at(carrier)
    beside = np.array([members.beside(at(p), place, turn, k) for k, p in enumerate(members.planets)])
    floats = np.array([at(f"{members.name}.{m}") for m in members.floating()]).reshape(
        len(members.floating()), 2, len(turn)
    )
    found = load_factors(sun)
    more: dict[str, Any] = {
        "factor_spread": found.spread,
        "factor_peak": found.peak,
        "factor_history": found.history,
        "beside_pin_history": beside,
        "floating_history": floats,
        "force_over_turn": _over_turn(sun, turn),
    }
    places = 2.0 * np.pi * (np.arange(PLACES) + 0.5) / PLACES
    axes = {
        "time": ("time", result.time(member), {"units": "s", "long_name": "time"}),
        "place": ("place", places, {"units": "rad", "long_name": "rotation of the carrier"}),
    }
    means = {
        "sun_force": sun.mean(axis=1),
        "ring_force": ring.mean(axis=1),
        "beside_pin": beside.mean(axis=2),
        "floating": np.mean(floats, axis=2) if floats.size else np.zeros((0, 2)),
    }
    return LoadSharing(_dataset(members, means | more, axes, kind="motion"))


def _over_turn(force: Floats, turn: Floats) -> Floats:
    """Return forces averaged over places of the carrier's turn, shape [planet, place]; NaN at those not visited."""
    at = np.floor(np.mod(turn, 2.0 * np.pi) / (2.0 * np.pi) * PLACES).astype(int) % PLACES
    counts = np.bincount(at, minlength=PLACES)
    with np.errstate(invalid="ignore"):
        return np.array(
            [
                np.bincount(at, weights=row, minlength=PLACES) / np.where(counts, counts, np.nan)
                for row in force
            ]
        )


def _dataset(members: Members, values: dict[str, Any], axes: dict[str, Any], *, kind: str) -> xr.Dataset:
    import xarray as xr

    total = float(values["sun_force"].sum())
    if abs(total) < LEAST:
        rule = "must carry a load, but no force is on the sun's meshes"
        raise InputError.of(f"planetary.{members.name}", 0.0, rule, "Give a drive torque or a load")
    share = values["sun_force"] / total
    every = {"share": share, "load_sharing_factor": len(share) * share, **values}
    for name in ("sun_force", "ring_force"):  # positive on the flanks that the load closes
        every[name] = every[name] * np.sign(every[name].sum())
    coordinates = {
        "planet": members.planets,
        "direction": ["radial", "tangential"],
        "member": members.floating(),
        "axis": ["x", "y"],
    }
    variables = {
        name: (dims, every[name], {"units": unit, "long_name": words})
        for name, (dims, unit, words) in COLUMNS.items()
        if name in every
    }
    clearance = geometry.clearance_of(members.case.operating, members.planets[0]) or 0.0
    attributes = provenance(members.case, set=members.name, of=kind, pin_clearance=clearance)
    return xr.Dataset(variables, coords={**coordinates, **axes}, attrs=attributes)
