"""Simulation of the six conditions: parameter sets, ensembles of both backlash models, spectra and their lines."""

import math
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

import numpy as np

import gearplay as gp
from gearplay.studies.han2021.article import LINES, MODELS, Condition, Floats, conditions

HUMP_BAND = (0.6, 6.0)  # Hz, band of f_r
HUMP_WIDTH = 0.08  # relative width of its smoothing
LINE_SEARCH = 0.01  # relative: the sidebands of f_m and 2 f_m are f_r away
HIGHEST = 200.0  # Hz, end of the spectra that are kept
LATER, LATER_SHARE = 16.0, 6
"""One run of so many is repeated with a record this long [s] after the first one, to compare the amplitudes of f_r."""
MESH = "pinion-ring"
SIGNALS = ["ring.x", "ring.y", "ring.vx", "ring.vy", f"{MESH}.backlash"]
STATISTICS = ("share_of_time", "impacts_per_second", "mean_impact_speed", "max_impact_speed", "peak_force")

SWITCHED = "switched"
"""The uncoupled model with the coupled one's parameters: the effect of the choice of the model alone."""
FRESH_SEED = 30_000_001
"""Seed of the study's initial states: no calibration used it."""


class Variant(NamedTuple):
    """One run of all conditions: its name, the backlash model, and the bundled case that gives the parameters."""

    name: str
    model: str
    case: str


CALIBRATED, ASSUMED = "calibrated", "assumed"
PARAMETERS: dict[str, tuple[Variant, ...]] = {
    CALIBRATED: (
        Variant("coupled", "coupled", "han2021-calibrated"),
        Variant("uncoupled", "uncoupled", "han2021-calibrated-uncoupled"),
        Variant(SWITCHED, "uncoupled", "han2021-calibrated"),
    ),
    ASSUMED: tuple(Variant(model, model, "han2021") for model in MODELS),
    "geometric-inertia": tuple(Variant(model, model, "han2021-geometric-inertia") for model in MODELS),
}
"""Parameter sets by name: fitted to the test, assumed with the printed inertias, assumed with those of discs."""


@dataclass(frozen=True)
class Settings:
    """Settings of the study. Record, transient and sampling are those of the calibration."""

    parameters: str = CALIBRATED
    members: int = 24
    duration: float = 4.0  # s, per member
    transient: float = 8.0  # s
    sampling: float = 1000.0  # Hz, of the recorded mean acceleration
    history: float = 1.0  # s, of the recorded orbit
    seed: int = FRESH_SEED
    drag: float | None = None  # N m s/rad, replaces the case's

    @property
    def variants(self) -> tuple[Variant, ...]:
        """Variants of the parameter set."""
        return PARAMETERS[self.parameters]


@dataclass(frozen=True)
class Work:
    """Progress callback, cancellation, and store of finished parts.

    ``keep(identity, make)`` returns the JSON-able part ``make()``, or the stored one of the same JSON-able identity.
    """

    progress: Callable[[str, float, float], None] = lambda label, done, total: None
    stop: threading.Event = field(default_factory=threading.Event)
    keep: Callable[[Any, Callable[[], dict[str, Any]]], dict[str, Any]] = lambda identity, make: make()

    def simulate(
        self, cases: Sequence[gp.Case], members: Sequence[int], settings: Any, **changes: Any
    ) -> list[gp.Result]:
        """Simulate members of cases for the settings' transient and record.

        Raises `KeyboardInterrupt` once ``stop`` is set.
        """
        times = {name: getattr(settings, name) for name in ("duration", "transient", "sampling")}
        arguments: dict[str, Any] = {
            "members": members,
            "signals": SIGNALS,
            "stop": self.stop,
            **times,
            **changes,
        }
        results = gp.simulate(list(cases), **arguments)
        if self.stop.is_set():
            raise KeyboardInterrupt
        return results


def condition_case(base: gp.Case, condition: Condition, model: str) -> gp.Case:
    """Return the base case at one condition with one backlash model."""
    return gp.replace(
        base,
        {
            "title": f"Han 2021, {condition.label}, {model}",
            "backlash_model": model,
            "rotors.pinion.drive.speed": f"{condition.speed_rpm:g} rpm",
            "sleeves.ring.radial_clearance": f"{condition.radial_clearance_um:g} um",
            "meshes.0.backlash": f"{condition.backlash_um:g} um",
        },
    )


def base_case(variant: Variant, settings: Settings) -> gp.Case:
    """Return a variant's base case with the settings' seed and drag."""
    changes: dict[str, Any] = {"run.seed": settings.seed}
    if settings.drag is not None:
        changes["rotors.ring.load.drag"] = settings.drag
    return gp.replace(gp.load_case(variant.case), changes)


class SimulatedLine(NamedTuple):
    """A line of an ensemble: frequency [Hz], amplitude [m/s^2], prominence, and each member's level [m/s^2]."""

    frequency: float
    amplitude: float
    prominence: float
    levels: tuple[float, ...]

    @property
    def spread(self) -> float:
        """Standard deviation of log10(level) over the members [decades]."""
        if len(self.levels) < 2:
            return math.nan
        return float(np.std(np.log10(np.maximum(self.levels, 1e-300)), ddof=1))

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
        error = math.inf
        if n > 1 and mean:
            error = 0.5 * float(squares.std(ddof=1)) / (math.sqrt(n) * mean * math.log(10.0))
        return math.log10(max(self.amplitude, 1e-300)), error


@dataclass(frozen=True)
class ConditionResult:
    """One condition simulated with one model: ensemble spectrum of the ring's acceleration along the centre line."""

    condition: Condition
    model: str  # name of the variant
    members: int
    failed: tuple[str, ...]  # messages of members that did not finish
    frequency: tuple[float, ...]  # Hz
    amplitude: tuple[float, ...]  # m/s^2, rms average over the members
    spread: tuple[float, ...]  # decades
    record: float  # s, length of one record
    lines: tuple[SimulatedLine, ...]
    statistics: dict[str, dict[str, float]]  # by contact, mean over the members
    jam_ratio: float  # 2 sin(alpha) clearance / backlash
    swing_frequency: float  # Hz, of small swings of the ring under the drag's mesh force
    orbit: dict[str, tuple[float, ...]]  # time [s], x, y [m], backlash [m] of one member
    steps: int
    events: int
    lasting: float | None = None
    """Share of f_r's amplitude that is left `LATER` s later; None where it was not computed."""
    floor: float = 0.0
    """Rms acceleration of the floor [m/s^2]."""

    @classmethod
    def from_part(cls, part: dict[str, Any]) -> "ConditionResult":
        """Return it from its JSON-able form."""
        lines = tuple(SimulatedLine(f, a, p, tuple(levels)) for f, a, p, levels in part["lines"])
        return cls(**{**part, "condition": Condition(*part["condition"]), "lines": lines})


def swing_frequency(case: gp.Case) -> float:
    """Return the frequency [Hz] of small swings of the ring in its clearance circle: sqrt(F / (m c)) / (2 pi).

    F [N] is the sum of its weight, as far as the rig is tilted, and of the mesh force drag omega / r_b that its drag needs at
    its nominal speed. They press the ring against one side of its sleeve, where it swings like a pendulum of length c.
    """
    ring, mesh = case.rotors["ring"], case.meshes[0]
    alpha, drive = mesh.pressure_angle, case.rotors["pinion"].drive
    omega = drive.speed * case.rotors["pinion"].teeth / ring.teeth  # type: ignore[union-attr, operator]
    base_radius = 0.5 * mesh.module * ring.teeth * math.cos(alpha)  # type: ignore[operator]
    force = ring.load.drag * abs(omega) / base_radius
    across = math.copysign(force * math.cos(alpha), omega)  # the pinion lies in the direction of x
    weight = [ring.mass * part for part in case.gravity]
    pressing = math.hypot(force * math.sin(alpha) + weight[0], across + weight[1])
    return math.sqrt(pressing / (ring.mass * case.sleeves["ring"].radial_clearance)) / (2.0 * math.pi)


def accelerations(result: gp.Result) -> list[Floats]:
    """Return the ring's acceleration along the centre line [m/s^2] of each member that finished.

    Averaged over each sampling interval, which costs 0.15 % of amplitude at 120 Hz and 4 kHz.
    """
    return [run.mean_acceleration("ring")[0] for run in result.runs if run.success]


def find_lines(spectrum: gp.signals.Spectrum, condition: Condition) -> list[Any]:
    """Find f_r, f_m and 2 f_m in a spectrum of the ring's acceleration."""
    return [
        gp.signals.find_hump(spectrum, *HUMP_BAND, width=HUMP_WIDTH),
        *(
            gp.signals.find_line(spectrum, harmonic * condition.mesh_frequency, search=LINE_SEARCH)
            for harmonic in (1.0, 2.0)
        ),
    ]


def simulated_lines(spectrum: gp.signals.Spectrum, condition: Condition) -> tuple[SimulatedLine, ...]:
    """Find f_r, f_m and 2 f_m in an ensemble spectrum, each with the members' rms amplitudes near it."""
    assert spectrum.each is not None
    found = []
    for name, line in zip(LINES, find_lines(spectrum, condition), strict=True):
        half = HUMP_WIDTH * line.frequency if name == "radial" else 1.5 * spectrum.resolution
        near = np.abs(spectrum.frequency - line.frequency) <= max(half, spectrum.resolution)
        levels = np.sqrt(np.mean(spectrum.each[:, near] ** 2, axis=1)).tolist()
        found.append(SimulatedLine(line.frequency, line.amplitude, line.prominence, tuple(levels)))
    return tuple(found)


def _orbit(result: gp.Result, settings: Settings) -> dict[str, tuple[float, ...]]:
    """Return the orbit and backlash of the first member, from the end of the transient on."""
    rate, start = 2000.0, settings.transient
    window = (start, start + min(settings.history, settings.duration))
    orbit = {}
    for name, signal in (("x", "ring.x"), ("y", "ring.y"), ("backlash", f"{MESH}.backlash")):
        values = result.signal(signal, sampling=rate, window=window)
        orbit[name] = tuple(float(f"{v:.6g}") for v in values)
    return {"time": tuple((start + np.arange(len(orbit["x"])) / rate).tolist()), **orbit}


def _lasting(case: gp.Case, first: gp.Result, settings: Settings, work: Work) -> float | None:
    """Return the share of f_r's amplitude in a few runs that is left `LATER` s later; None where one did not finish."""
    runs = first.runs[::LATER_SHARE]
    [later] = work.simulate(
        [case], [run.member for run in runs], settings, transient=settings.transient + LATER
    )
    if not all(run.success for run in (*runs, *later.runs)):
        return None
    records = [run.mean_acceleration("ring")[0] for run in runs]
    now, then = (
        gp.signals.find_hump(
            gp.signals.ensemble_spectrum(each, settings.sampling), *HUMP_BAND, width=HUMP_WIDTH
        ).amplitude
        for each in (records, accelerations(later))
    )
    return then / now


def run_condition(
    case: gp.Case,
    condition: Condition,
    name: str,
    settings: Settings,
    work: Work,
    progress: Callable[[str, float, float], None] | None = None,
) -> ConditionResult:
    """Simulate the case of a condition as the variant ``name``; members that fail are left out and named.

    Raises `KeyboardInterrupt` where the run was interrupted, `SimulationError` where no member finished.
    """
    [result] = work.simulate([case], range(1, settings.members + 1), settings, progress=progress)
    lasting = None if name == SWITCHED else _lasting(case, result, settings, work)
    good = [run for run in result.runs if run.success]
    if not good:
        raise gp.SimulationError(f"{case.title}: no member finished. {result.runs[0].message}")
    spectrum = gp.signals.ensemble_spectrum(accelerations(result), settings.sampling, unit="m/s^2")
    keep = spectrum.frequency <= HIGHEST
    spread = spectrum.spread if spectrum.spread is not None else np.zeros_like(spectrum.amplitude)
    floor = case.base.random if case.base is not None else None
    mesh, clearance = case.meshes[0], case.sleeves["ring"].radial_clearance
    assert isinstance(mesh.backlash, float)
    return ConditionResult(
        condition=condition,
        model=name,
        members=len(good),
        failed=tuple(run.message for run in result.runs if not run.success),
        frequency=tuple(spectrum.frequency[keep].tolist()),
        amplitude=tuple(float(f"{a:.6g}") for a in spectrum.amplitude[keep]),
        spread=tuple(float(f"{s:.4g}") for s in spread[keep]),
        record=len(good[0].time) / settings.sampling,
        lines=simulated_lines(spectrum, condition),
        statistics={
            contact: {n: float(np.mean([getattr(run.statistics, n)[i] for run in good])) for n in STATISTICS}
            for i, contact in enumerate(good[0].statistics.labels)
        },
        jam_ratio=2.0 * math.sin(mesh.pressure_angle) * clearance / mesh.backlash,
        swing_frequency=swing_frequency(case),
        orbit=_orbit(result, settings),
        steps=result.work.steps,
        events=result.work.events,
        lasting=lasting,
        floor=floor.rms() if floor is not None else 0.0,
    )


def run_study(
    settings: Settings, work: Work | None = None, *, names: Sequence[str] | None = None
) -> list[ConditionResult]:
    """Simulate all conditions with all variants, or those with ``names``.

    Raises `KeyboardInterrupt` soon after the work's ``stop`` is set or Ctrl-C is pressed, `SimulationError` where a condition
    has no member that finished.
    """
    work = work or Work()
    variants = [each for each in settings.variants if names is None or each.name in names]
    bases = {each.name: base_case(each, settings) for each in variants}
    tasks = [(condition, variant) for condition in conditions() for variant in variants]
    span = (settings.duration + settings.transient) * settings.members
    done, one_at_a_time = [0.0] * len(tasks), threading.Lock()

    def run(at: int) -> ConditionResult:
        if work.stop.is_set():
            raise KeyboardInterrupt
        condition, variant = tasks[at]
        case = condition_case(bases[variant.name], condition, variant.model)

        def report(_: str, now: float, total: float) -> None:
            with one_at_a_time:
                done[at] = now
                work.progress(f"{condition.label}, {variant.name}", sum(done), len(tasks) * span)

        def make() -> dict[str, Any]:
            return asdict(run_condition(case, condition, variant.name, settings, work, report))

        part = work.keep([case.sha256, variant.name, asdict(settings)], make)
        report("", span, span)
        return ConditionResult.from_part(part)

    # Two at a time: members of one use the cores on which those of the other have ended.
    with ThreadPoolExecutor(2) as pool:
        running = [pool.submit(run, at) for at in range(len(tasks))]
        try:
            return [each.result() for each in running]
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                work.stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
