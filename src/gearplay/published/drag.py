"""Drag of the ring, the one fitted constant of the assumed parameters: fit to the six measured radial frequencies."""

import math
import threading
from dataclasses import asdict, dataclass

import numpy as np

from gearplay.model.reading import load_case
from gearplay.published.article import printed
from gearplay.published.han2021 import run_study
from gearplay.published.settings import Settings
from gearplay.vocabulary.progress import Progress


@dataclass(frozen=True)
class DragTrial:
    """One step of the fit: drag [N m s/rad], the six ratios f_r simulated / measured, mean error."""

    drag: float
    ratios: tuple[float, ...]

    @property
    def mean_error(self) -> float:
        """Mean of |f_r simulated / measured - 1|."""
        return float(np.mean(np.abs(np.array(self.ratios) - 1.0)))


def fit_drag(
    settings: Settings,
    *,
    trials: int = 5,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> list[DragTrial]:
    """Fit the one constant, the ring's drag, to the six measured radial frequencies; best trial first.

    The swing of the driven gear has f_r proportional to sqrt(drag) (docs/theory), so each trial scales the drag by the squared
    geometric mean of measured over simulated. Only the coupled model is used.
    """
    first = settings.variants[0]
    drag = settings.drag if settings.drag is not None else load_case(first.case).rotors["ring"].load.drag
    done = []
    for trial in range(trials):
        tried = Settings(**{**asdict(settings), "drag": drag, "history": 0.01})

        def report(label: str, part: float, total: float, trial: int = trial) -> None:
            if progress is not None:
                progress(f"drag trial {trial + 1}: {label}", trial * total + part, trials * total)

        results = run_study(tried, names=("coupled",), progress=report, stop=stop)
        ratios = tuple(
            r.lines["radial"].frequency / printed(r.condition, "radial", "frequency_hz").test for r in results
        )
        done.append(DragTrial(drag, ratios))
        drag *= math.exp(-2.0 * float(np.mean(np.log(ratios))))
    return sorted(done, key=lambda t: t.mean_error)
