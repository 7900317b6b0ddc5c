"""A stored result on the stage: the mechanism in motion, for pictures and animations."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from gearplay.pictures.stage import Stage
from gearplay.results.choice import cut, elements_at
from gearplay.results.mechanism import frames_of, mechanism_of
from gearplay.results.result import Result
from gearplay.results.titles import case_words
from gearplay.vocabulary.errors import Fault, InputError

NEEDED = ("x", "y", "theta")


def stage_of(
    result: Result,
    window: tuple[float, float],
    *,
    at: str | None = None,
    times: float = 1.0,
    frames: int = 900,
) -> Stage:
    """Return the drawing of a result's mechanism with its frames within a window [s].

    ``at`` names what is looked at closely, ``times`` how many times larger than usual small motions are drawn.

    Raises `InputError` for a result that does not keep places and rotations, a window or a place that is not there.
    """
    held, case = set(result.held()), result.case
    missing = [f"{rotor}.{name}" for rotor in case.rotors for name in NEEDED if (name, rotor) not in held]
    if missing:
        rule = f"must keep {', '.join(missing[:3])} to draw the mechanism"
        raise InputError(Fault("result", f"{len(held)} signals", rule, "Keep all signals of the rotors"))
    named = [] if at is None else elements_at(case, at)
    time = cut(result, "x", next(iter(case.rotors)), window)[0]

    def signal(name: str, label: str) -> Any:
        return cut(result, name, label, window)[1] if (name, label) in held else np.zeros(time.size)

    return Stage(
        mechanism_of(case),
        frames_of(case, time - time[0], signal, start=float(time[0]), most=frames),
        title=case_words(case).replace(" um", " µm"),
        times=times,
        sleeve=next((name for name in named if name in case.sleeves), None),
        mesh=next((mesh.label for mesh in case.meshes if mesh.label in named), None),
    )


def pictures_in_turn(stage: Stage, draw: Callable[[Any], Any]) -> Iterator[Any]:
    """Yield what ``draw`` makes of the figure, frame by frame."""
    for frame in range(len(stage.frames["t"])):
        stage.show(frame)
        yield draw(stage.figure)
