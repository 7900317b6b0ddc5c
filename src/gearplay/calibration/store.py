"""Trials of a calibration on disk: one optuna study per model in an SQLite file, finished trials only."""

from pathlib import Path
from typing import Any

from gearplay.calibration.observe import Observed
from gearplay.calibration.plan import Plan
from gearplay.calibration.trials import Seen, Trial
from gearplay.files import parts
from gearplay.vocabulary.errors import Fault, TakenError
from gearplay.vocabulary.optional import load_optional

FILE = "trials.sqlite"
AFTER = ("evaluations", "polish", "check_members")
"""What a plan's effort says of the end of a search and of what comes after it."""


class StudyStore:
    """One model's trials as an optuna study; each is added whole, in one transaction.

    Raises `TakenError` where the file holds trials of another plan, or is damaged.
    """

    def __init__(self, folder: Path, plan: Plan, model: str, digest: str) -> None:
        optuna = load_optional("optuna", "calibration")
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        path, self.folder = folder / FILE, folder
        self.names = [p.name for p in plan.parameters]
        try:
            self.study = optuna.create_study(
                storage=optuna.storages.RDBStorage(f"sqlite:///{path}"), study_name=model, load_if_exists=True
            )
            known = self.study.user_attrs.get("plan")
        except Exception as error:  # SQLAlchemy and optuna each have their own for a file that is no database
            raise TakenError(
                Fault(
                    "out",
                    str(folder),
                    f"its {FILE} must hold the trials of this calibration ({type(error).__name__})",
                    _CURE,
                )
            ) from None
        if known is None:
            self.study.set_user_attr("plan", digest)
        elif known != digest:
            raise TakenError(
                Fault("out", str(folder), f"its {FILE} must hold trials of the same plan", _CURE)
            )

    def read(self) -> list[Trial]:
        """Return the finished trials in order."""
        trials = []
        for stored in self.study.get_trials(deepcopy=False):
            held = parts.without_digest(stored.user_attrs, in_order=False)  # a table of SQL has none
            if held is None:
                rule = f"its {FILE} must hold trials as they were stored; trial {stored.number} was changed"
                raise TakenError(Fault("out", str(self.folder), rule, _CURE))
            seen = {
                c: {t: {k: Observed(*v) for k, v in keys.items()} for t, keys in targets.items()}
                for c, targets in held["seen"].items()
            }
            trials.append(Trial(stored.number, tuple(held["unit"]), seen, held["reason"], held["phase"]))
        return trials

    def add(self, trial: Trial) -> None:
        """Store one finished trial."""
        import optuna
        from optuna.distributions import FloatDistribution

        held = {
            "unit": list(trial.unit),
            "seen": _plain(trial.seen),
            "reason": trial.reason,
            "phase": trial.phase,
        }
        self.study.add_trial(
            optuna.trial.create_trial(
                state=optuna.trial.TrialState.COMPLETE if trial.good else optuna.trial.TrialState.FAIL,
                value=0.0 if trial.good else None,
                params=dict(zip(self.names, trial.unit, strict=True)),
                distributions={name: FloatDistribution(0.0, 1.0) for name in self.names},
                user_attrs=parts.with_digest(held, in_order=False),
            )
        )


_CURE = "Choose another folder, or overwrite it to begin anew."


def _plain(seen: Seen) -> dict[str, Any]:
    return {
        c: {t: {k: [o.value, o.error] for k, o in keys.items()} for t, keys in targets.items()}
        for c, targets in seen.items()
    }


def digest_of(plan: Plan) -> str:
    """Return the digest of all that decides where a plan's trials are and what they show.

    Not their number: more of them go on from those that are there.
    """
    document = plan.model_dump(mode="json", exclude={"title": True, "effort": set(AFTER)})
    return parts.digest_of(document, in_order=False)
