"""Parameter search: a space-filling start, then optuna's TPE alternating with proposals of an emulator.

The point of trial n is a function of the plan's seed, n and the trials before it, and only finished trials are
stored: a killed search resumes to the same list of trials. No point is repeated, as its result would be the same.
"""

import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.objective import Comparison
from gearplay.calibration.trials import POLISH, SEARCH, STARTUP, Problem, Trial, TrialStore, distinct, placed
from gearplay.surrogates.polynomials import Emulator
from gearplay.vocabulary.optional import load_optional
from gearplay.vocabulary.progress import Tick

if TYPE_CHECKING:
    import optuna

Floats = NDArray[np.float64]

CANDIDATES = 64  # that TPE weighs for one trial
DRAWN = 4000  # points in each of the shrinking neighbourhoods of `refine`
BLOCK = 8  # trials between two fits of the emulator
TURN = 3  # of so many trials of the search one is TPE's, the others are the emulator's
TOP = 50  # best trials among which the emulator chooses where it begins


class Search:
    """Search of one model under a plan; the readings of the ordinate guide it in turn."""

    def __init__(self, problem: Problem, comparisons: Sequence[Comparison], trials: Sequence[Trial]) -> None:
        self.problem, self.comparisons = problem, tuple(comparisons)
        self.effort = problem.plan.effort
        self.names = [p.name for p in problem.parameters]
        self.trials: list[Trial] = []
        self._tried: set[tuple[tuple[float, ...], bool]] = set()
        self._studies = [self._new_study() for _ in self.comparisons]
        self._near: dict[
            int, tuple[int, tuple[Emulator, Floats]]
        ] = {}  # by turn: number of trials, emulator and centre
        for trial in trials:
            self.add(trial)

    def _new_study(self) -> "optuna.Study":
        optuna = load_optional("optuna", "calibration")
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        return optuna.create_study(direction="minimize")  # type: ignore[no-any-return]

    def add(self, trial: Trial) -> None:
        """Add a finished trial at its rounded point, which is the one stored, so that a resumed search is the same."""
        import optuna

        for study, comparison in zip(self._studies, self.comparisons, strict=True):
            if trial.good:
                known = optuna.trial.create_trial(
                    params=dict(zip(self.names, trial.unit, strict=True)),
                    distributions=self._space(),
                    value=float(comparison.objective(*comparison.logs_of([trial]))[0]),
                )
            else:
                known = optuna.trial.create_trial(state=optuna.trial.TrialState.FAIL)
            study.add_trial(known)
        self.trials.append(trial)
        self._tried.add(trial.same_as)

    def _space(self) -> dict[str, Any]:
        from optuna.distributions import FloatDistribution

        return {name: FloatDistribution(0.0, 1.0) for name in self.names}

    def phase(self, number: int) -> str:
        """Return the phase of trial ``number``."""
        if number < self.effort.startup:
            return STARTUP
        return POLISH if number >= self.effort.evaluations - self.effort.polish else SEARCH

    def propose(self) -> tuple[float, ...]:
        """Return the point of the next trial."""
        number = len(self.trials)
        turn = number // TURN % len(self.comparisons)
        phase = self.phase(number)
        if phase == STARTUP:
            return even_point(number, len(self.names), self.effort.seed)
        if phase == POLISH or number % TURN:
            point = self._refined(number, turn)
            if point is not None and Trial(number, placed(point), {}, phase=phase).same_as not in self._tried:
                return point
        return self._guided(number, turn)

    def _guided(self, number: int, turn: int) -> tuple[float, ...]:
        import warnings

        import optuna

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            sampler = optuna.samplers.TPESampler(
                seed=_seed(self.effort.seed, number),
                multivariate=True,
                n_startup_trials=1,
                n_ei_candidates=CANDIDATES,
            )
        study = self._studies[turn]
        study.sampler = sampler
        asked = study.ask(self._space())
        # It is added only after it has been simulated, at its rounded place (`add`).
        study.tell(asked, state=optuna.trial.TrialState.FAIL)
        return tuple(float(asked.params[name]) for name in self.names)

    def _refined(self, number: int, turn: int) -> tuple[float, ...] | None:
        """Return the best point of an emulator fitted to the trials near the best, or None where it cannot be fitted."""
        near = self._emulator(number // BLOCK * BLOCK, turn)
        if near is None:
            return None
        generator = np.random.default_rng(_seed(self.effort.seed, number))
        return refine(near[0], self.comparisons[turn], near[1], generator)

    def _emulator(self, after: int, turn: int) -> tuple[Emulator, Floats] | None:
        """Return the emulator of the first ``after`` trials, and the point of the best of them by its prediction."""
        known = self._near.get(turn)
        if known is not None and known[0] == after:
            return known[1]
        comparison = self.comparisons[turn]
        good = [trial for trial in distinct(self.trials[:after]) if trial.good]
        if len(good) < 4 * len(self.names):
            return None
        logs, errors = comparison.logs_of(good)
        units = np.array([trial.unit for trial in good])
        values = comparison.objective(logs, errors)
        emulator = Emulator.near(units, logs, values)
        top = units[np.argsort(values, kind="stable")[:TOP]]
        logs_there = emulator(top)
        centre = top[int(np.argmin(comparison.objective(logs_there, np.zeros_like(logs_there))))]
        self._near[turn] = after, (emulator, centre)
        return emulator, centre


def even_point(number: int, parameters: int, seed: int) -> tuple[float, ...]:
    """Return point ``number`` of a scrambled Sobol sequence in the unit cube."""
    from scipy.stats import qmc

    sobol = qmc.Sobol(parameters, seed=seed)
    if number:
        sobol.fast_forward(number)
    return tuple(float(u) for u in sobol.random(1)[0])


def run_even(
    problem: Problem,
    store: TrialStore,
    *,
    report: Tick | None = None,
    stop: threading.Event | None = None,
) -> list[Trial]:
    """Run, or resume, evenly spread trials, as many as the plan's evaluations; return all of them.

    Raises `KeyboardInterrupt` soon after ``stop`` is set; finished trials are in ``store``.
    """
    trials, seed = store.read(), problem.plan.effort.seed

    def propose(number: int) -> tuple[tuple[float, ...], str]:
        return even_point(number, len(problem.parameters), seed), STARTUP

    _run(problem, store, len(trials), propose, trials.append, report, stop)
    return trials


def _seed(seed: int, number: int) -> int:
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])


def run_search(
    problem: Problem,
    comparisons: Sequence[Comparison],
    store: TrialStore,
    *,
    report: Tick | None = None,
    stop: threading.Event | None = None,
) -> list[Trial]:
    """Run, or resume, one model's search to the plan's number of evaluations; return all trials.

    Raises `KeyboardInterrupt` soon after ``stop`` is set; finished trials are in ``store``.
    """
    search = Search(problem, comparisons, store.read())

    def propose(number: int) -> tuple[tuple[float, ...], str]:
        return search.propose(), search.phase(number)

    _run(problem, store, len(search.trials), propose, search.add, report, stop)
    return search.trials


def _run(
    problem: Problem,
    store: TrialStore,
    first: int,
    propose: Callable[[int], tuple[tuple[float, ...], str]],
    add: Callable[[Trial], None],
    report: Tick | None,
    stop: threading.Event | None,
) -> None:
    """Simulate and store the trials from number ``first`` on, each at the point and for the phase that ``propose`` returns."""
    effort = problem.plan.effort
    for number in range(first, effort.evaluations):
        if stop is not None and stop.is_set():
            raise KeyboardInterrupt
        point, phase = propose(number)
        members = effort.polish_members if phase == POLISH else None
        trial = problem.run(number, point, phase=phase, members=members, stop=stop)
        store.add(trial)
        add(trial)
        if report is not None:
            report(number + 1.0, float(effort.evaluations))


def refine(
    emulator: Emulator,
    comparison: Comparison,
    centre: Floats,
    generator: np.random.Generator,
) -> tuple[float, ...]:
    """Return the point near ``centre`` where the emulator's objective is least, in a region of random size.

    Random points in a shrinking neighbourhood: the objective of an emulator has many shallow minima.
    """
    at, radius = centre, float(generator.choice([0.03, 0.08, 0.2]))
    for _ in range(4):
        points = np.clip(at + radius * generator.normal(size=(DRAWN, centre.size)), 0.0, 1.0)
        points[0] = at
        logs = emulator(points)
        at = points[int(np.argmin(comparison.objective(logs, np.zeros_like(logs))))]
        radius *= 0.4
    return tuple(float(u) for u in at)
