"""Simulation of the article's study: six conditions, both backlash models, seeded ensembles."""

import math
import threading
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol

import numpy as np

from gearplay.files.parts import part_key
from gearplay.model import geometry, rolling
from gearplay.model.case import Case
from gearplay.published.article import Condition, conditions
from gearplay.published.settings import SWITCHED, Settings, Variant, base_case, condition_case
from gearplay.results.spectra import Spectrum, ensemble_spectrum
from gearplay.signals.lines import Line, find_hump, find_line
from gearplay.solver.simulate import run_members
from gearplay.solver.trajectory import Trajectory, acceleration_signals, work_of
from gearplay.vocabulary.errors import SimulationError
from gearplay.vocabulary.progress import Progress, Tick

HUMP_BAND = (0.6, 6.0)  # Hz, where the swing of the driven gear is looked for
HUMP_WIDTH = 0.08  # relative width of its smoothing
LINE_SEARCH = 0.01  # relative: beside f_m and 2 f_m stand sidebands, a swing's frequency away
HIGHEST = 200.0  # Hz, end of the spectra that are kept
LATER, LATER_SHARE = 16.0, 6
"""So long after the records [s] it is looked whether the swing lasts, in one run of so many."""
MESH = "pinion-ring"


class Store(Protocol):
    """Keeps finished parts of a study, so that a stopped one goes on where it was."""

    def get(self, key: str) -> dict[str, Any] | None:
        """Return the part stored under a key, or None."""

    def put(self, key: str, part: dict[str, Any]) -> None:
        """Store a part under a key."""


@dataclass(frozen=True)
class SimulatedLine:
    """A line of an ensemble: frequency [Hz], amplitude [m/s^2], prominence, and each member's level [m/s^2]."""

    frequency: float
    amplitude: float
    prominence: float
    levels: tuple[float, ...]

    @property
    def spread(self) -> float:
        """Standard deviation of log10(level) over the members [decades]."""
        return (
            float(np.std(np.log10(np.maximum(self.levels, 1e-300)), ddof=1))
            if len(self.levels) > 1
            else math.nan
        )

    @property
    def displacement(self) -> float:
        """Amplitude of the same line as displacement [m]."""
        return self.amplitude / (2.0 * math.pi * self.frequency) ** 2

    def log_level(self) -> tuple[float, float]:
        """Return log10 of the level and its standard error [decades].

        The level of a line is its amplitude in the rms spectrum of all members; the error is that of the members' mean square.
        """
        squares = np.square(self.levels)
        n, mean = squares.size, float(squares.mean()) if squares.size else 0.0
        error = (
            0.5 * float(squares.std(ddof=1)) / (math.sqrt(n) * mean * math.log(10.0))
            if n > 1 and mean
            else math.inf
        )
        return math.log10(max(self.amplitude, 1e-300)), error


@dataclass(frozen=True)
class ConditionResult:
    """One condition simulated with one model: ensemble spectrum of the ring's acceleration along the centre line."""

    case: str
    condition: Condition
    model: str  # name of the variant
    members: int
    failed: tuple[str, ...]  # messages of members that did not finish
    frequency: tuple[float, ...]  # Hz
    amplitude: tuple[float, ...]  # m/s^2, rms average over the members
    spread: tuple[float, ...]  # decades
    record: float  # s, length of one record
    lines: dict[str, SimulatedLine]
    statistics: dict[str, dict[str, float]]  # by contact, mean over the members
    jam_ratio: float
    swing_frequency: float  # Hz, of small swings of the ring under the drag's mesh force
    orbit: dict[str, tuple[float, ...]]  # time [s], x, y [m], backlash [m] of one member
    steps: int
    events: int
    wall_time: float
    lasting: float | None = None
    """Share of f_r's amplitude that is left `LATER` s later; None where nobody looked."""
    floor: float = 0.0
    """Rms acceleration of the floor [m/s^2]."""


def swing_frequency(case: Case) -> float:
    """Return the frequency [Hz] of small swings of the ring in its clearance circle: sqrt(F / (m c)) / (2 pi).

    F [N] is the sum of its weight, as far as the rig is tilted, and of the mesh force drag omega / r_b that its drag calls for
    at its nominal speed: they press the ring against one side of its sleeve, about which it swings like a pendulum of length c.
    """
    ring, clearance, alpha = (
        case.rotors["ring"],
        case.sleeves["ring"].radial_clearance,
        case.meshes[0].pressure_angle,
    )
    omega = float(rolling.nominal_speeds(case)[list(case.rotors).index("ring")])
    force = ring.load.drag * abs(omega) / geometry.base_radii(case, 0)[1]
    across = math.copysign(force * math.cos(alpha), omega)  # the pinion lies in the direction of x
    weight = [ring.mass * part for part in case.gravity]
    pressing = math.hypot(force * math.sin(alpha) + weight[0], across + weight[1])
    return math.sqrt(pressing / (ring.mass * clearance)) / (2.0 * math.pi)


def mean_acceleration(run: Trajectory) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the ring's acceleration along the centre line, averaged over each sampling interval [m/s^2].

    At 120 Hz and 4 kHz the averaging costs 0.15 % of amplitude.
    """
    along: np.ndarray[tuple[int], np.dtype[np.float64]] = run.mean_acceleration("ring")[0]
    return along


def _levels(spectrum: Spectrum, frequency: float, half_width: float) -> tuple[float, ...]:
    """Return each member's rms amplitude within ``frequency`` -+ ``half_width`` [Hz]."""
    assert spectrum.each is not None
    near = np.abs(spectrum.frequency - frequency) <= max(half_width, spectrum.resolution)
    return tuple(float(v) for v in np.sqrt(np.mean(spectrum.each[:, near] ** 2, axis=1)))


def find_lines(spectrum: Spectrum, condition: Condition) -> dict[str, Line]:
    """Find f_r, f_m and 2 f_m in a spectrum of the ring's acceleration."""
    return {
        "radial": find_hump(spectrum, *HUMP_BAND, width=HUMP_WIDTH),
        "mesh_1x": find_line(spectrum, condition.mesh_frequency, search=LINE_SEARCH),
        "mesh_2x": find_line(spectrum, 2.0 * condition.mesh_frequency, search=LINE_SEARCH),
    }


def simulated_lines(spectrum: Spectrum, condition: Condition) -> dict[str, SimulatedLine]:
    """Find f_r, f_m and 2 f_m in an ensemble spectrum of the ring's acceleration."""
    result = {}
    for name, line in find_lines(spectrum, condition).items():
        half = HUMP_WIDTH * line.frequency if name == "radial" else 1.5 * spectrum.resolution
        levels = _levels(spectrum, line.frequency, half)
        result[name] = SimulatedLine(line.frequency, line.amplitude, line.prominence, levels)
    return result


def _mean_statistics(runs: Sequence[Trajectory]) -> dict[str, dict[str, float]]:
    names = ("share_of_time", "impacts_per_second", "mean_impact_speed", "max_impact_speed", "peak_force")
    labels = runs[0].statistics.labels
    return {
        label: {n: float(np.mean([getattr(run.statistics, n)[i] for run in runs])) for n in names}
        for i, label in enumerate(labels)
    }


def _history(case: Case, settings: Settings) -> dict[str, tuple[float, ...]]:
    """Return one member's orbit and backlash after the transient."""
    run = run_members(
        case,
        [1],
        signals=["ring.x", "ring.y", f"{MESH}.backlash"],
        duration=settings.history,
        transient=settings.transient,
        sampling=2000.0,
    )[0]
    columns = {
        "x": run.signal("x", "ring"),
        "y": run.signal("y", "ring"),
        "backlash": run.signal("backlash", MESH),
    }
    return {"time": tuple(run.time), **{k: tuple(float(f"{v:.6g}") for v in c) for k, c in columns.items()}}


def _lasting(
    case: Case, settings: Settings, runs: Sequence[Trajectory], stop: threading.Event
) -> float | None:
    """Return the share of f_r's amplitude in a few runs that they still have `LATER` s later; None where one did not finish."""
    later = run_members(
        case,
        [run.member for run in runs],
        signals=acceleration_signals(["ring"]),
        duration=settings.duration,
        transient=settings.transient + LATER,
        sampling=settings.sampling,
        stop=stop,
    )
    if not all(run.success for run in (*runs, *later)):
        return None
    spectra = [
        ensemble_spectrum([mean_acceleration(run) for run in each], settings.sampling)
        for each in (runs, later)
    ]
    now, then = (find_hump(spectrum, *HUMP_BAND, width=HUMP_WIDTH).amplitude for spectrum in spectra)
    return then / now


def run_condition(
    base: Case,
    condition: Condition,
    variant: Variant,
    settings: Settings,
    progress: Tick | None = None,
    stop: threading.Event | None = None,
) -> ConditionResult:
    """Simulate one condition with one variant; members that fail are left out and named.

    Raises `KeyboardInterrupt` where the run was interrupted, `SimulationError` where no member finished.
    """
    case = condition_case(base, condition, variant.model)
    stop = stop or threading.Event()
    runs = run_members(
        case,
        range(1, settings.members + 1),
        signals=acceleration_signals(["ring"]),
        duration=settings.duration,
        transient=settings.transient,
        sampling=settings.sampling,
        progress=progress,
        stop=stop,
    )
    if stop.is_set():
        raise KeyboardInterrupt
    lasting = None if variant.name == SWITCHED else _lasting(case, settings, runs[::LATER_SHARE], stop)
    if stop.is_set():
        raise KeyboardInterrupt
    good = [run for run in runs if run.success]
    if not good:
        raise SimulationError(f"{case.title}: no member finished. {runs[0].message}")
    spectrum = ensemble_spectrum([mean_acceleration(run) for run in good], settings.sampling, unit="m/s^2")
    keep, work = spectrum.frequency <= HIGHEST, work_of(runs)
    spread = spectrum.spread if spectrum.spread is not None else np.zeros_like(spectrum.amplitude)
    return ConditionResult(
        case=variant.case,
        condition=condition,
        model=variant.name,
        members=len(good),
        failed=tuple(run.message for run in runs if not run.success),
        frequency=tuple(float(f) for f in spectrum.frequency[keep]),
        amplitude=tuple(float(f"{a:.6g}") for a in spectrum.amplitude[keep]),
        spread=tuple(float(f"{s:.4g}") for s in spread[keep]),
        record=len(good[0].time) / settings.sampling,
        lines=simulated_lines(spectrum, condition),
        statistics=_mean_statistics(good),
        jam_ratio=geometry.jam_ratio(case, 0),
        swing_frequency=swing_frequency(case),
        orbit=_history(case, settings),
        steps=work.steps,
        events=work.events,
        wall_time=work.wall_time,
        lasting=lasting,
        floor=case.base.random.rms() if case.base is not None and case.base.random is not None else 0.0,
    )


def _from_part(part: dict[str, Any]) -> ConditionResult:
    fields = dict(part)
    fields["condition"] = Condition(**part["condition"])
    fields["lines"] = {
        k: SimulatedLine(**{**v, "levels": tuple(v["levels"])}) for k, v in part["lines"].items()
    }
    return ConditionResult(**fields)


def run_study(
    settings: Settings,
    *,
    names: Sequence[str] | None = None,
    progress: Progress | None = None,
    store: Store | None = None,
    stop: threading.Event | None = None,
) -> list[ConditionResult]:
    """Simulate all conditions with all variants, or those with ``names``; finished ones come from ``store`` where it has them.

    Raises `KeyboardInterrupt` soon after ``stop`` is set or Ctrl-C is pressed, `SimulationError` where a condition
    has no member that finished.
    """
    variants = [each for each in settings.variants if names is None or each.name in names]
    bases = {each.name: base_case(each, settings) for each in variants}
    work = [(condition, variant) for condition in conditions() for variant in variants]
    span = (settings.duration + settings.transient) * settings.members
    results = []
    stop = stop or threading.Event()
    for at, (condition, variant) in enumerate(work):
        if stop.is_set():
            raise KeyboardInterrupt
        label = f"{condition.label}, {variant.name}"
        base = bases[variant.name]
        case_digest = condition_case(base, condition, variant.model).sha256
        key = part_key([case_digest, variant.name, asdict(settings)])
        part = store.get(key) if store is not None else None
        if part is None:

            def report(done: float, total: float, at: int = at, label: str = label) -> None:
                if progress is not None:
                    progress(label, at * span + done, len(work) * span)

            result = run_condition(base, condition, variant, settings, report, stop)
            if store is not None:
                store.put(key, asdict(result))
        else:
            result = _from_part(part)
        if progress is not None:
            progress(label, (at + 1) * span, len(work) * span)
        results.append(result)
    return results
