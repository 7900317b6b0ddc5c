"""Reduction of a simulation to a fixed row of numbers, computed where the simulation runs."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.model.case import Case
from gearplay.model.pack import Packed, pack
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.parts.mesh.train import rolling
from gearplay.parts.protocol import without_slots
from gearplay.results.output_shaft import OutputShaft, input_of, output_of, shaft_of_runs, wanted_of
from gearplay.results.planet_loads import FACTORS, load_factors, mesh_of, planets_of, set_of
from gearplay.results.spectra import Spectrum, amplitude_spectrum
from gearplay.signals.checks import check_channel
from gearplay.signals.lines import band_level, band_levels, find_hump, find_line
from gearplay.signals.statistics import rms_of, signal_statistics
from gearplay.solver.trajectory import ACCELERATIONS, Trajectory, all_columns, choose_columns
from gearplay.sweeps.plans.kept import (
    ContactReduction,
    HistoryReduction,
    HumpReduction,
    JamReduction,
    LevelReduction,
    LineReduction,
    LoadSharingReduction,
    OutputReduction,
    SpectrumReduction,
    StatisticReduction,
)
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import OUTPUT_STATISTICS, contact_unit

Floats = NDArray[np.float64]
OfSignal = (
    StatisticReduction | LineReduction | HumpReduction | LevelReduction | SpectrumReduction | HistoryReduction
)


@dataclass(frozen=True)
class Kept:
    """One variable of the row: its name, unit and meaning, and the values along its own dimension, if it has one."""

    name: str
    unit: str
    long_name: str
    along: str = ""
    along_unit: str = ""
    grid: tuple[float, ...] = ()

    @property
    def size(self) -> int:
        """Numbers that it takes in the row."""
        return len(self.grid) if self.along else 1


class Reducer:
    """The reductions of a plan for cases of one build.

    Raises `InputError` for a signal, element or contact that the case does not have.
    """

    def __init__(self, plan: SweepPlan, case: Case, packed: Packed) -> None:
        self.reductions = plan.reduce
        self.signals = sorted({name for each in plan.reduce for name in _needed(each, case, packed)})
        run = case.run
        samples = max(1, int(run.duration * run.sampling + 0.5))
        for each in plan.reduce:
            _check_band(each, run.duration, run.sampling)
        self.shares = [_kept(each, samples, run.sampling, packed) for each in plan.reduce]
        self.layout = [kept for share in self.shares for kept in share]
        self._last: tuple[Case | None, float] = (None, math.nan)
        _check_names(plan, self.layout)

    @property
    def size(self) -> int:
        """Numbers in a row."""
        return sum(kept.size for kept in self.layout)

    def row(self, case: Case, run: Trajectory, *, slowness: float = 1.0) -> tuple[Floats, str]:
        """Return the row of one finished run, shape [number], and why some of it is NaN ("" where all was made).

        Orders count from ``slowness`` times the nominal speed.
        """
        last = self._last
        if last[0] is not case:  # members of one case come one after another
            last = self._last = (case, rolling.mesh_frequency(case) if case.meshes else math.nan)
        fundamental = slowness * last[1]
        parts, reasons, record = [], [], _Record(case, run)
        for each, kept in zip(self.reductions, self.shares, strict=True):
            size = sum(part.size for part in kept)
            try:
                made = np.concatenate([np.atleast_1d(part) for part in _values(each, fundamental, record)])
                if made.size != size:
                    rule = f"must keep the {size} numbers of the base case in every case"
                    cure = "Remove the reduction history, or keep run.duration and run.sampling constant"
                    raise InputError.of("numbers", made.size, rule, cure)
            except InputError as error:
                made = np.full(size, math.nan)
                reasons.append(f"reduce.{each.name}: {error}")
            parts.append(made.astype(np.float64))
        return np.concatenate(parts), reasons[0].splitlines()[0] if reasons else ""


def _check_names(plan: SweepPlan, layout: list[Kept]) -> None:
    """Refuse names of the product that mean two things: a reduction may make several."""
    drawn = plan.design.parameters if plan.design else ()
    taken = {each.name for each in (*plan.axes, *drawn)}
    for kept in layout:
        for name in filter(None, (kept.name, kept.along)):
            if name in taken:
                raise InputError.of("reduce", name, "must be a name of its own in the product", "Rename one")
            taken.add(name)


def _check_band(reduction: Any, duration: float, sampling: float) -> None:
    """Refuse frequencies that the record of the base case does not hold, and parts finer than its lines."""
    half, resolution, where = 0.5 * sampling, 1.0 / duration, f"reduce.{reduction.name}"
    band = getattr(reduction, "band", None)
    top, field = (band[1], "band") if band is not None else (getattr(reduction, "near", None) or 0.0, "near")
    if top > half:
        rule = f"must be at most {half:g} Hz, half of run.sampling"
        raise InputError.of(f"{where}.{field}", f"{top:g} Hz", rule, "Lower it, or raise run.sampling")
    if band is None:
        return
    if isinstance(reduction, SpectrumReduction):
        most = int((band[1] - band[0]) / resolution * (1.0 + 1e-9))
        if reduction.count > most:
            rule = f"must be at most {most}: a record of {duration:g} s has a line each {resolution:g} Hz"
            raise InputError.of(f"{where}.count", reduction.count, rule, "Lower it, or lengthen run.duration")
    elif band[1] - band[0] < 3.0 * resolution:
        rule = f"must be at least {3.0 * resolution:g} Hz wide: a record of {duration:g} s has a line each {resolution:g} Hz"
        raise InputError.of(
            f"{where}.band", f"{band[0]:g} to {band[1]:g} Hz", rule, "Widen it, or lengthen run.duration"
        )


def _needed(reduction: Any, case: Case, packed: Packed) -> list[str]:
    """Return the solver's signals for one reduction, ``element.signal``."""
    if isinstance(reduction, ContactReduction):
        known = packed.contact_labels
        if reduction.contact not in known:
            raise _unknown(reduction, "contact", reduction.contact, without_slots(known))
        return []
    if isinstance(reduction, OutputReduction):
        if reduction.at not in (None, *case.rotors):
            raise _unknown(reduction, "at", str(reduction.at), tuple(case.rotors))
        lead, at = input_of(case), reduction.at or output_of(case)
        return [f"{label}.{signal}" for signal, label in wanted_of(packed, at, lead)]
    if isinstance(reduction, JamReduction):
        names = [f"{reduction.mesh}:drive", f"{reduction.mesh}:back"]
        if names[0] not in packed.contact_labels:
            raise _unknown(reduction, "mesh", reduction.mesh, packed.labels.get("mesh", ()))
        return [f"{reduction.mesh}.contact_state"]
    if isinstance(reduction, LoadSharingReduction):
        return [f"{label}.{signal}" for label in _sun_meshes(reduction, case) for signal in FLANKS]
    wanted = f"{reduction.at}.{ACCELERATIONS.get(reduction.signal, reduction.signal)}"
    try:
        choose_columns(packed, [wanted])
    except InputError:
        if reduction.signal in RESULT_VARIABLES:
            known = tuple(c.label for c in all_columns(packed) if c.signal == reduction.signal)
            raise _unknown(reduction, "at", reduction.at, tuple(dict.fromkeys(known))) from None
        raise _unknown(reduction, "signal", reduction.signal, tuple(RESULT_VARIABLES)) from None
    if isinstance(reduction, LineReduction) and reduction.order is not None and not case.meshes:
        rule = "must not be given: the case has no mesh"
        raise InputError.of(f"reduce.{reduction.name}.order", reduction.order, rule, "Give near in Hz")
    return [wanted]


def _unknown(reduction: Any, field: str, value: str, known: tuple[str, ...]) -> InputError:
    has_signal = field == "at" and hasattr(reduction, "signal")
    rule = f"must have the signal {reduction.signal}" if has_signal else "must be of this case"
    return InputError.of(f"reduce.{reduction.name}.{field}", value, rule, f"Choose from: {', '.join(known)}")


def _kept(reduction: Any, samples: int, sampling: float, packed: Packed) -> list[Kept]:
    """Return the variables that one reduction contributes to the row."""
    name = reduction.name
    if isinstance(reduction, ContactReduction):
        words = f"{reduction.statistic.replace('_', ' ')} of {reduction.contact}"
        angular = bool(packed.angular[packed.contact_labels.index(reduction.contact)])
        return [Kept(name, contact_unit(reduction.statistic, angular=angular), words)]
    if isinstance(reduction, OutputReduction):
        quantity = OUTPUT_STATISTICS[reduction.statistic]
        at = f"of {reduction.at}" if reduction.at else "of the output shaft"
        return [Kept(name, quantity.unit, f"{quantity.long_name}, {at}")]
    if isinstance(reduction, JamReduction):
        return [Kept(name, "1", f"share of time with both flanks of {reduction.mesh} pressed")]
    if isinstance(reduction, LoadSharingReduction):
        at = f"of {reduction.planetary}" if reduction.planetary else "of the planets"
        return [Kept(name, "1", f"{FACTORS[reduction.statistic]}, {at}")]
    quantity = RESULT_VARIABLES[reduction.signal]
    of = f"{quantity.long_name}, {reduction.at}"
    if isinstance(reduction, StatisticReduction):
        unit = "1" if reduction.statistic in ("kurtosis", "crest_factor") else quantity.unit
        return [Kept(name, unit, f"{reduction.statistic.replace('_', ' ')} of {of}")]
    if isinstance(reduction, LineReduction):
        near = f"order {reduction.order}" if reduction.order else f"{reduction.near:g} Hz"
        return _pair(name, quantity.unit, f"line near {near}, {of}")
    if isinstance(reduction, HumpReduction):
        return _pair(
            name, quantity.unit, f"highest hump of {reduction.band[0]:g} to {reduction.band[1]:g} Hz, {of}"
        )
    if isinstance(reduction, LevelReduction):
        return [
            Kept(name, quantity.unit, f"rms within {reduction.band[0]:g} to {reduction.band[1]:g} Hz, {of}")
        ]
    if isinstance(reduction, HistoryReduction):
        times = tuple((np.arange(_length(reduction, samples)) / sampling).tolist())
        return [Kept(name, quantity.unit, of, f"{name}_time", "s", times)]
    edges = _edges(reduction)
    centres = tuple((0.5 * (edges[1:] + edges[:-1])).tolist())
    words = f"rms within {edges[1] - edges[0]:g} Hz around each frequency, {of}"
    return [Kept(name, quantity.unit, words, f"{name}_frequency", "Hz", centres)]


def _sun_meshes(reduction: LoadSharingReduction, case: Case) -> list[str]:
    """Return the labels of the meshes of a set's planets with its sun."""
    name = set_of(case, reduction.planetary, field=f"reduce.{reduction.name}.planetary")
    return [case.meshes[mesh_of(case, name, planet, "sun")].label for planet in planets_of(case, name)]


def _pair(name: str, unit: str, words: str) -> list[Kept]:
    return [
        Kept(f"{name}_amplitude", unit, f"amplitude: {words}"),
        Kept(f"{name}_frequency", "Hz", f"frequency: {words}"),
    ]


def _length(reduction: HistoryReduction, samples: int) -> int:
    return samples - 1 if reduction.signal in ACCELERATIONS else samples


def _edges(reduction: SpectrumReduction) -> Floats:
    return np.linspace(*reduction.band, reduction.count + 1)


FLANKS = ("drive_force", "back_force")

_LEVELS: dict[str, Callable[[Floats], float]] = {
    "rms": lambda values: rms_of(values, float(np.max(np.abs(values)))),
    "peak_to_peak": lambda values: float(np.ptp(values)),
}
"""Statistics that need not all of `signal_statistics`."""


class _Record:
    """Signals of one run with their spectra and statistics, each computed once for all reductions."""

    def __init__(self, case: Case, run: Trajectory) -> None:
        self.case, self.run = case, run
        self.shafts: dict[str | None, OutputShaft] = {}
        self.made: dict[tuple[str, str, str], Any] = {}

    def _once(self, kind: str, of: OfSignal, make: Callable[[], Any]) -> Any:
        key = (kind, of.signal, of.at)
        if key not in self.made:
            self.made[key] = make()
        return self.made[key]

    def signal(self, of: OfSignal) -> Floats:
        """Return the samples of a reduction's signal, shape [time]; accelerations as increments of velocity."""

        def make() -> Floats:
            if of.signal in ACCELERATIONS:
                return self.run.relative_mean_acceleration(of.signal, of.at)
            return self.run.signal(of.signal, of.at)

        return cast(Floats, self._once("signal", of, make))

    def shaft(self, at: str | None) -> OutputShaft:
        """Return the key numbers of the output shaft, or of a rotor."""
        if at not in self.shafts:
            self.shafts[at] = shaft_of_runs(self.case, pack(self.case), at, [self.run])
        return self.shafts[at]

    def spectrum(self, of: OfSignal) -> Spectrum:
        """Return the amplitude spectrum of a reduction's signal."""
        made = self._once("spectrum", of, lambda: amplitude_spectrum(self.signal(of), self.run.sampling))
        return cast(Spectrum, made)

    def statistic(self, of: StatisticReduction) -> float:
        """Return a statistic about zero for levels, about the mean for shape; NaN where there is none."""
        channel = Channel(of.statistic, self.signal(of), self.run.sampling)
        if of.statistic in _LEVELS:
            found = _LEVELS[of.statistic](check_channel(channel))
        else:
            found = getattr(self._once("statistics", of, lambda: signal_statistics(channel)), of.statistic)
        return float(found) if math.isfinite(found) else math.nan


def _values(reduction: Any, fundamental: float, record: _Record) -> list[Any]:
    run = record.run
    if isinstance(reduction, ContactReduction):
        table = getattr(run.statistics, reduction.statistic)
        return [table[run.statistics.labels.index(reduction.contact)]]
    if isinstance(reduction, OutputReduction):
        return [record.shaft(reduction.at).values[reduction.statistic]]
    if isinstance(reduction, JamReduction):
        return [float(np.mean(run.signal("contact_state", reduction.mesh) == 3.0))]
    if isinstance(reduction, LoadSharingReduction):
        labels = _sun_meshes(reduction, record.case)
        sides = [np.array([run.signal(flank, label) for label in labels]) for flank in FLANKS]
        found = load_factors(sides[0] - sides[1])
        return [float(np.max(found.mean if reduction.statistic == "factor" else found.peak))]
    if isinstance(reduction, StatisticReduction):
        return [record.statistic(reduction)]
    samples = record.signal(reduction)
    if isinstance(reduction, HistoryReduction):
        return [samples]
    spectrum = record.spectrum(reduction)
    if isinstance(reduction, LevelReduction):
        return [band_level(spectrum, samples.size, *reduction.band)]
    if isinstance(reduction, SpectrumReduction):
        return [band_levels(spectrum, samples.size, _edges(reduction))]
    if isinstance(reduction, HumpReduction):
        line = find_hump(spectrum, *reduction.band, width=reduction.width)
    else:
        near = reduction.near if reduction.near is not None else (reduction.order or 1) * fundamental
        line = find_line(spectrum, near, search=reduction.search)
    return [line.amplitude, line.frequency]
