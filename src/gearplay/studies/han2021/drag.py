"""Fit of the ring's drag, the one fitted constant of the assumed parameters, to the six measured radial frequencies."""

import math
from dataclasses import asdict
from typing import NamedTuple

import numpy as np

from gearplay.studies.han2021.article import FREQUENCY, printed
from gearplay.studies.han2021.simulation import Settings, Work, base_case, run_study

TRIALS = 5
"""Number of steps of the fit."""


class DragTrial(NamedTuple):
    """One step of the fit: drag [N m s/rad], the six ratios f_r simulated / measured, mean of |ratio - 1|."""

    drag: float
    ratios: tuple[float, ...]
    mean_error: float


def fit_drag(settings: Settings, work: Work) -> list[DragTrial]:
    """Fit the ring's drag to the six measured radial frequencies with the coupled model; best trial first.

    The radial frequency f_r is proportional to sqrt(drag) (docs/theory), so each trial scales the drag by the squared
    geometric mean of measured over simulated.
    """
    drag = base_case(settings.variants[0], settings).rotors["ring"].load.drag
    done = []
    for trial in range(TRIALS):

        def report(label: str, part: float, total: float, trial: int = trial) -> None:
            work.progress(f"drag trial {trial + 1}: {label}", trial * total + part, TRIALS * total)

        tried = Settings(**{**asdict(settings), "drag": drag, "history": 0.01})
        results = run_study(tried, Work(report, work.stop), names=("coupled",))
        ratios = np.array([r.lines[0].frequency for r in results]) / printed("test", FREQUENCY)[:, 0]
        done.append(DragTrial(drag, tuple(ratios.tolist()), float(np.mean(np.abs(ratios - 1.0)))))
        drag *= math.exp(-2.0 * float(np.mean(np.log(ratios))))
    return sorted(done, key=lambda trial: trial.mean_error)
