"""Results of orbit analysis: an orbit, a branch, or all connected branches, each with its case."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.families import Family, along
from gearplay.model.field_units import unit_at
from gearplay.model.pack import pack
from gearplay.nonlinear.orbits.autonomous import AutonomousMap
from gearplay.nonlinear.orbits.branch_tree import signals_of
from gearplay.nonlinear.orbits.branches import CLOSED, LEFT, Branch, Special
from gearplay.nonlinear.orbits.period_map import StrobeMap
from gearplay.nonlinear.orbits.sampled import SampledMap, sample_time
from gearplay.nonlinear.orbits.shooting import Orbit
from gearplay.pictures.style import CLEARANCE, COUPLED, new_axes
from gearplay.results.base import AnalysisResult, Column, Tabled, case_in, check_kind
from gearplay.results.provenance import provenance, signal_words

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]
PERIOD = {"units": "s", "long_name": "period of a limit cycle"}


@dataclass(frozen=True, repr=False)
class PeriodicOrbit(Orbit, Tabled):
    """A periodic orbit of a case; see `Orbit`."""

    case: Case

    result_kind = "orbit"
    VARIABLES = MappingProxyType(
        {
            "states": Column(("section", "state"), "", "state at the section, SI"),
            "matrix": Column(("state", "change"), "", "derivative of the map over the orbit, SI"),
            "multipliers": Column(("multiplier",), "1", "Floquet multiplier"),
            "contacts": Column(("contact_change", "pair"), "", "contact, and 1 where it begins"),
        }
    )
    SCALARS = MappingProxyType({"parameter": float, "residual": float, "period": float})
    __repr__ = Tabled.__repr__  # not the table of numbers that an orbit is

    @property
    def message(self) -> str:
        """Order, stability and the largest multiplier as text."""
        largest = (
            f"largest multiplier {abs(self.multipliers[0]):.4g}" if self.multipliers.size else "no multiplier"
        )
        kind = "stable" if self.stable else "unstable"
        if math.isfinite(self.period):
            return f"{kind} limit cycle of period {self.period:.6g} s, {largest}"
        if (sampling := sample_time(pack(self.case))) is not None:
            locked = f"locked to {self.order} samples, period {self.order * sampling:.6g} s"
            return f"{kind} limit cycle {locked}, {largest}"
        return f"{kind} periodic orbit of order {self.order}, {largest}"

    def motion(self, signals: Sequence[str], *, samples: int = 1000) -> xr.Dataset:
        """Return signals over the orbit, ``rotor.theta`` ...: those that follow from the state, [SI].

        ``samples`` are equal steps of the whole orbit, its end included.
        """
        import xarray as xr

        from gearplay.nonlinear.orbits.tracing import trace

        times, values, names = trace(self, signals, samples)
        variables = {name: ("time", values[:, at], signal_words(name)) for at, name in enumerate(names)}
        return xr.Dataset(variables, {"time": ("time", times, {"units": "s", "long_name": "time"})})

    def amplitude(self, signal: str, *, samples: int = 2000) -> float:
        """Return half the peak-to-peak value of a signal over the orbit [SI], extremes by parabolas through three samples."""
        from gearplay.nonlinear.orbits.tracing import swing

        return 0.5 * swing(self.motion([signal], samples=samples)[signal].values)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the multipliers in the unit circle, within which small changes decay."""
        drawn = ax if ax is not None else new_axes(4.5, 4.5)
        angle = np.linspace(0.0, 2.0 * np.pi, 361)
        drawn.plot(np.cos(angle), np.sin(angle), color=CLEARANCE, linewidth=1.0)
        drawn.plot(self.multipliers.real, self.multipliers.imag, "o", color=COUPLED, markersize=4)
        drawn.set_aspect("equal")
        drawn.set_xlabel("real part of the Floquet multiplier [1]", fontsize=8)
        drawn.set_ylabel("imaginary part [1]", fontsize=8)
        return drawn


@dataclass(frozen=True, repr=False)
class Branches(AnalysisResult):
    """Branches of periodic orbits over a field of a case: a sequence of `Branch` with the interface of a result.

    ``missed`` are the starts near which no orbit was found, and why; ``family`` is the function of the parameter, which no file
    keeps.
    """

    branches: tuple[Branch, ...]
    case: Case
    path: str
    keep_load: bool = False
    missed: tuple[str, ...] = ()
    family: Family | None = field(default=None, compare=False)

    result_kind = "branches"

    def __len__(self) -> int:
        return len(self.branches)

    def __iter__(self) -> Iterator[Branch]:
        return iter(self.branches)

    def __getitem__(self, place: int) -> Branch:
        return self.branches[place]

    @property
    def message(self) -> str:
        """Number of branches and orbits, range of the field, stable orbits, special points, and ends within the bounds."""
        orbits = sum(len(branch.orbits) for branch in self)
        places = np.concatenate([branch.parameters for branch in self])
        unit = unit_at(self.case, self.path)
        span = f"from {places.min():.6g} to {places.max():.6g}{'' if unit == '1' else f' {unit}'}"
        early = dict.fromkeys(branch.ended for branch in self if branch.ended not in (CLOSED, LEFT))
        stable = sum(int(branch.stable.sum()) for branch in self)
        kinds: dict[str, int] = {}
        for special in (each for branch in self for each in branch.special):
            kinds[special.kind] = kinds.get(special.kind, 0) + 1
        met = "".join(f", {count} × {kind}" for kind, count in kinds.items())
        several = "branches" if len(self) != 1 else "branch"
        more = "".join(f"; {each}" for each in (*(f"ends early: {each}" for each in early), *self.missed))
        count = f"{orbits} orbits {span}, {stable} of them stable"
        return f"{len(self)} {several} over {self.path}: {count}{met}{more}"

    def rows(self) -> Sequence[tuple[str, str]]:
        """Return a line for each branch."""
        unit = unit_at(self.case, self.path)
        found = []
        for branch in self:
            special = "".join(f"; {s.kind} at {s.orbit.parameter:.6g} {unit}" for s in branch.special)
            words = f"{len(branch.orbits)} orbits, {int(branch.stable.sum())} stable{special}; ends: {branch.ended}"
            found.append((f"order {branch.order}", words))
        return found

    def levels(self, signals: Sequence[str]) -> list[Floats]:
        """Return signals at the sections of each branch's orbits, shape [orbit, order, signal] each, SI."""
        first = self.branches[0].orbits[0]
        kind = AutonomousMap if self._is_free else SampledMap if self._sampling is not None else StrobeMap
        family = kind(self._family, first.parameter)
        return [signals_of(family, branch, list(signals)) for branch in self]

    def amplitudes(self, signal: str, *, samples: int = 400) -> list[Floats]:
        """Return half the peak-to-peak value of a signal over the orbits of each branch, shape [orbit] each, SI.

        ``samples`` of each orbit, extremes by parabolas.
        """
        over = self._family
        orbits = [[PeriodicOrbit(**vars(each), case=over(each.parameter)) for each in b.orbits] for b in self]
        return [np.array([each.amplitude(signal, samples=samples) for each in own]) for own in orbits]

    @property
    def _family(self) -> Family:
        return self.family or along(self.case, self.path, keep_load=self.keep_load)

    @property
    def _is_free(self) -> bool:
        """Whether the orbits are limit cycles whose period is an unknown."""
        return math.isfinite(self.branches[0].orbits[0].period)

    @property
    def _sampling(self) -> float | None:
        """Time [s] between the samples of a control that alone excites the case, None for another case."""
        return sample_time(pack(self.case))

    def table(self, signals: Sequence[str], levels: Sequence[Any] | None = None) -> xr.Dataset:
        """Return a row for each orbit, with signals at its first section, and one for each special point.

        Coordinates: ``orbit`` with ``branch`` (number), ``order``, the field, ``stable`` (1 or 0) and ``multiplier`` (the largest
        modulus); ``special`` with its kind, branch and field. ``levels`` are those of `levels`, where they are known.
        """
        import xarray as xr

        name, unit = self.path.rpartition(".")[2], unit_at(self.case, self.path)
        words = {"units": unit, "long_name": self.path}
        rows = [
            (at, branch.order, orbit.parameter, int(orbit.stable), abs(orbit.multipliers[0]))
            for at, branch in enumerate(self)
            for orbit in branch.orbits
        ]
        numbers, orders, places, stable, largest = zip(*rows, strict=True)
        points = [(s.kind, at, s.orbit.parameter) for at, branch in enumerate(self) for s in branch.special]
        variables: dict[str, Any] = {
            "branch": ("orbit", np.array(numbers), {"long_name": "number of the branch"}),
            "order": ("orbit", np.array(orders), {"long_name": "periods after which the orbit repeats"}),
            name: ("orbit", np.array(places), words),
            "stable": ("orbit", np.array(stable), {"long_name": "whether small changes decay"}),
            "period": ("orbit", np.array([each.period for b in self for each in b.orbits]), PERIOD),
            "multiplier": ("orbit", np.array(largest), {"units": "1", "long_name": "largest Floquet multiplier, modulus"}),
            "special_kind": ("special", np.array([p[0] for p in points], dtype=object), {"long_name": "what happens there"}),
            "special_branch": ("special", np.array([p[1] for p in points], dtype=np.int64), {"long_name": "its branch"}),
            f"special_{name}": ("special", np.array([p[2] for p in points]), words),
        }  # fmt: skip
        if signals:
            values = np.concatenate([each[:, 0] for each in levels or self.levels(signals)])
            for at, signal in enumerate(signals):
                variables[signal] = ("orbit", values[:, at], signal_words(signal))
        words = {"ended": json.dumps([each.ended for each in self]), "missed": json.dumps(self.missed)}
        attributes = provenance(self.case, **words, path=self.path, keep_load=int(self.keep_load))
        return xr.Dataset(variables, attrs=attributes)

    def dataset(self, signals: Sequence[str], levels: Sequence[Any] | None = None) -> xr.Dataset:
        """Return `table` with the complete orbits in addition, so that a file holds the complete branches."""
        every = [orbit for branch in self for orbit in branch.orbits]
        special = [each for branch in self for each in branch.special]
        place = np.array([each.place for each in special], dtype=np.int64)
        whole = self.table(signals, levels)
        whole = whole.assign(_packed("orbit", every) | _packed("special", [each.orbit for each in special]))
        return whole.assign(
            {"special_place": ("special", place, {"long_name": "orbit of its branch before it"})}
        )

    @property
    def ds(self) -> xr.Dataset:
        """A row for each orbit and each special point, and all of every orbit; `table` has signals at their sections."""
        return self.dataset(())

    @classmethod
    def from_dataset(cls, dataset: xr.Dataset) -> Self:
        """Return the branches whose ``ds`` it was."""
        check_kind(dataset, cls.result_kind)
        every, points = _unpacked("orbit", dataset), _unpacked("special", dataset)
        numbers, of = dataset["branch"].values, dataset["special_branch"].values
        orders, kinds = dataset["order"].values, dataset["special_kind"].values
        found = []
        for at, ended in enumerate(json.loads(dataset.attrs["ended"])):
            own = np.flatnonzero(numbers == at)
            special = tuple(
                Special(str(kinds[k]), int(dataset["special_place"].values[k]), points[k])
                for k in np.flatnonzero(of == at)
            )
            found.append(Branch(tuple(every[k] for k in own), special, ended, int(orders[own[0]])))
        kept = bool(dataset.attrs.get("keep_load", 0))
        missed = tuple(json.loads(dataset.attrs.get("missed", "[]")))
        return cls(tuple(found), case_in(dataset), str(dataset.attrs["path"]), kept, missed)

    def plot(
        self, signal: str | None = None, *, amplitude: bool | None = None, ax: Axes | None = None
    ) -> Axes:
        """Draw a signal of all orbits over the field, stable parts solid; the first that is free if not named.

        With ``amplitude`` half its peak-to-peak value, else its values at the sections: those of forced orbits, once per period,
        if not said; of limit cycles, whose sections are contact changes or samples, the amplitude.
        """
        from gearplay.nonlinear.orbits.figures import branch_marks, draw_branch
        from gearplay.pictures.words import offset_in, plain, shown_in
        from gearplay.solver.flow import Flow

        name = signal or Flow(self.case).free_names[0]
        half = (self._is_free or self._sampling is not None) if amplitude is None else amplitude
        levels = self.amplitudes(name) if half else [each[:, :, 0] for each in self.levels([name])]
        words, drawn = signal_words(name), ax if ax is not None else new_axes()
        unit_y, up = shown_in(words["units"], max(float(np.abs(each).max()) for each in levels))
        unit_x, across = shown_in(
            unit_at(self.case, self.path), max(float(np.abs(b.parameters).max()) for b in self)
        )
        for branch, each in zip(self, levels, strict=True):
            draw_branch(drawn, branch, up * each, factor=across, offset=offset_in(unit_x))
        drawn.set_xlabel(plain(f"{self.path} [{unit_x}]"), fontsize=8)
        drawn.set_ylabel(plain(f"{'amplitude of ' if half else ''}{name} [{unit_y}]"), fontsize=8)
        what = "half the peak-to-peak value over the orbit" if half else "once per period of the excitation"
        drawn.set_title(plain(f"Periodic orbits: {name}, {what}"), fontsize=9)
        marks = branch_marks(self.branches)
        drawn.legend(marks.values(), marks.keys(), fontsize=7)
        return drawn


class OneBranch(Branches):
    """One branch of periodic orbits over a field of a case: `Branches` with one entry, and the attributes of its `Branch`."""

    result_kind = "branch"

    @property
    def orbits(self) -> tuple[Orbit, ...]:
        """The orbits in the order of the branch."""
        return self.branches[0].orbits

    @property
    def special(self) -> tuple[Special, ...]:
        """Points where the kind of the orbits changes."""
        return self.branches[0].special

    @property
    def ended(self) -> str:
        """Reason for the end of the branch."""
        return self.branches[0].ended

    @property
    def order(self) -> int:
        """Periods after which its orbits repeat."""
        return self.branches[0].order

    @property
    def parameters(self) -> Floats:
        """The field at each orbit [SI], shape [orbit]."""
        return self.branches[0].parameters

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether each orbit is stable, shape [orbit]."""
        return self.branches[0].stable


def _packed(along_: str, orbits: Sequence[Orbit]) -> dict[str, Any]:
    """Return all of some orbits as variables over ``along_``, ragged ones filled up with NaN."""
    size = len(orbits[0].matrix) if orbits else 0
    most = max((orbit.order for orbit in orbits), default=1)
    states = np.full((len(orbits), most, size), np.nan)
    multipliers = np.full((len(orbits), size, 2), np.nan)
    for at, orbit in enumerate(orbits):
        states[at, : orbit.order] = orbit.states
        multipliers[at, : orbit.multipliers.size] = np.stack(
            [orbit.multipliers.real, orbit.multipliers.imag], axis=-1
        )
    matrices = np.array([orbit.matrix for orbit in orbits]).reshape(len(orbits), size, size)
    contacts = np.array([json.dumps(orbit.contacts.tolist()) for orbit in orbits], dtype=object)
    own = {"orbit": "", "special": "special_"}[along_]
    dims = (f"{own}section", f"{own}state", f"{own}change")
    return {
        f"{own}states": ((along_, *dims[:2]), states, {"long_name": "state at each section, SI"}),
        f"{own}matrix": ((along_, *dims[1:]), matrices, {"long_name": "derivative of the map over the orbit, SI"}),
        f"{own}multipliers": ((along_, f"{own}multiplier_", "part"), multipliers, {"long_name": "Floquet multipliers"}),
        f"{own}contacts": (along_, contacts, {"long_name": "contact changes, JSON"}),
        f"{own}residual": (along_, np.array([orbit.residual for orbit in orbits]), {"long_name": "residual in natural sizes"}),
        f"{own}period": (along_, np.array([orbit.period for orbit in orbits]), PERIOD),
        f"{own}parameter": (along_, np.array([orbit.parameter for orbit in orbits]), {"long_name": "the field, SI"}),
    }  # fmt: skip


def _unpacked(along_: str, dataset: xr.Dataset) -> list[Orbit]:
    own = {"orbit": "", "special": "special_"}[along_]
    names = ("states", "matrix", "multipliers", "contacts", "residual", "parameter", "period")
    columns = [dataset[f"{own}{name}"].values for name in names]
    found = []
    for states, matrix, multipliers, contacts, residual, parameter, period in zip(*columns, strict=True):
        known = multipliers[np.isfinite(multipliers[:, 0])]
        found.append(
            Orbit(
                parameter=float(parameter),
                states=states[np.isfinite(states).all(axis=1)],
                matrix=matrix,
                multipliers=known[:, 0] + 1j * known[:, 1],
                residual=float(residual),
                contacts=np.array(json.loads(str(contacts)), dtype=np.int64).reshape(-1, 2),
                period=float(period),
            )
        )
    return found
