"""Storage of finished trials: one optuna study per model in an SQLite file."""

from contextlib import AbstractContextManager
from pathlib import Path

from gearplay.calibration.observe import Observed
from gearplay.calibration.plan import Plan
from gearplay.calibration.trials import Trial, mapped
from gearplay.files.databases import sqlite_errors
from gearplay.vocabulary.errors import TakenError
from gearplay.vocabulary.optional import load_optional
from gearplay.work import pieces

EVEN = ", even"
"""End of the name of a study of evenly spread trials of a model."""
FILE = "trials.sqlite"
AFTER = ("evaluations", "polish", "check_members")
"""Settings of a plan's effort that affect the end of a search and the steps after it."""


class StudyStore:
    """One model's trials as an optuna study; each is added in one transaction.

    Raises `TakenError` where the file holds trials of another plan, or is damaged, and the errors of `sqlite_errors`.
    """

    def __init__(self, folder: Path, plan: Plan, model: str, digest: str) -> None:
        optuna = load_optional("optuna", "calibration")
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        path, self.folder = folder / FILE, folder
        self.names = [p.name for p in plan.parameters_of(model.removesuffix(EVEN))]
        with _sqlite_errors(
            path, foreign=True
        ):  # optuna has errors of its own for a file that is no database
            self.study = optuna.create_study(
                storage=optuna.storages.RDBStorage(f"sqlite:///{path}"), study_name=model, load_if_exists=True
            )
            known = self.study.user_attrs.get("plan")
        if known is None:
            with _sqlite_errors(path):
                self.study.set_user_attr("plan", digest)
        elif known != digest:
            raise TakenError.of("out", str(folder), f"its {FILE} must hold trials of the same plan", _CURE)

    def read(self) -> list[Trial]:
        """Return the finished trials in order."""
        trials = []
        with _sqlite_errors(self.folder / FILE):
            found = self.study.get_trials(deepcopy=False)
        for stored in found:
            held = pieces.without_digest(stored.user_attrs, in_order=False)
            if held is None:
                rule = f"its {FILE} must hold trials as they were stored; trial {stored.number} was changed"
                raise TakenError.of("out", str(self.folder), rule, _CURE)
            observed = mapped(held["seen"], lambda _, pair: Observed(*pair))
            trials.append(Trial(stored.number, tuple(held["unit"]), observed, held["reason"], held["phase"]))
        return trials

    def add(self, trial: Trial) -> None:
        """Store one finished trial."""
        import optuna
        from optuna.distributions import FloatDistribution

        held = {
            "unit": list(trial.unit),
            "seen": mapped(trial.observed, lambda _, observed: [observed.value, observed.error]),
            "reason": trial.reason,
            "phase": trial.phase,
        }
        finished = optuna.trial.create_trial(
            state=optuna.trial.TrialState.COMPLETE if trial.good else optuna.trial.TrialState.FAIL,
            value=0.0 if trial.good else None,
            params=dict(zip(self.names, trial.unit, strict=True)),
            distributions={name: FloatDistribution(0.0, 1.0) for name in self.names},
            user_attrs=pieces.with_digest(held, in_order=False),
        )
        with _sqlite_errors(self.folder / FILE):
            self.study.add_trial(finished)


_CURE = "Choose another folder, or give overwrite=True to begin anew."


def _sqlite_errors(path: Path, *, foreign: bool = False) -> AbstractContextManager[None]:
    return sqlite_errors(path, "hold the trials of this calibration", _CURE, foreign=foreign)


def digest_of(plan: Plan) -> str:
    """Return the digest of all settings that determine a plan's trials and their results.

    Not their number: a search with more of them resumes from the stored ones.
    """
    document = plan.model_dump(mode="json", exclude={"title": True, "effort": set(AFTER)})
    return pieces.digest_of(document, in_order=False)
