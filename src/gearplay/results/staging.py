"""A stored result prepared for drawings and animations of the mechanism."""

from typing import Any, NamedTuple

import numpy as np

from gearplay.model.pack import pack
from gearplay.pictures.stage import Stage
from gearplay.results.choice import cut, elements_at
from gearplay.results.figures import close_up
from gearplay.results.mechanism import frames_of, mechanism_of
from gearplay.results.result import Result
from gearplay.results.titles import case_words
from gearplay.solver.frames import CarrierFrames
from gearplay.vocabulary.errors import InputError

NEEDED = ("x", "y", "theta")


class Motion(NamedTuple):
    """Data of the drawings of a result in motion: see `mechanism_of`, `frames_of`; ``start`` [s] is that of the frames."""

    mechanism: dict[str, Any]
    frames: dict[str, Any]
    title: str
    look: dict[str, str]
    start: float


def motion_in(
    result: Result, window: tuple[float, float], *, at: str | None = None, frames: int = 900
) -> Motion:
    """Return the mechanism of a result and its frames within a window [s]; ``at`` names the close-up.

    Raises `InputError` for a result that does not keep places and rotations, a window or a place that is not there.
    """
    held, case = set(result.held()), result.case
    missing = [f"{rotor}.{name}" for rotor in case.rotors for name in NEEDED if (name, rotor) not in held]
    if missing:
        rule = f"must keep {', '.join(missing[:3])} to draw the mechanism"
        raise InputError.of("result", f"{len(held)} signals", rule, "Keep all signals of the rotors")
    named = [] if at is None else elements_at(case, at)
    forces = ("drive_force", "back_force", "sleeve_force_x", "sleeve_force_y")
    result.runs[0].compute([each for each in held if each[0] in (*NEEDED, *forces)])
    time = cut(result, "x", next(iter(case.rotors)), window)[0]

    def signal(name: str, label: str) -> Any:
        return cut(result, name, label, window)[1] if (name, label) in held else np.zeros(time.size)

    sleeve = next((name for name in named if name in case.sleeves), None)
    mesh = next((mesh.label for mesh in case.meshes if mesh.label in named), None)
    carriers = CarrierFrames(pack(case).system)
    return Motion(
        mechanism_of(case),
        frames_of(case, carriers, time - time[0], signal, start=float(time[0]), most=frames),
        case_words(case).replace(" um", " µm"),
        {key: name for key, name in (("sleeve", sleeve), ("mesh", mesh)) if name is not None},
        float(time[0]),
    )


def stage_of(motion: Motion, times: float = 1.0) -> Stage:
    """Return the drawing of a motion; small motions are drawn ``times`` larger than usual."""
    mechanism, frames, title, look, start = motion
    return Stage(mechanism, frames, title=title, times=times, start=start, **look)


def loud_window(result: Result, window: tuple[float, float]) -> tuple[float, float]:
    """Return some mesh periods about the largest force of a mesh; all of a window that is not much longer."""
    case = result.case
    result.runs[0].compute([("drive_force", mesh.label) for mesh in case.meshes])
    loud = [
        (float(np.nanmax(cut(result, "drive_force", mesh.label, window)[1], initial=0.0)), mesh.label)
        for mesh in case.meshes
        if ("drive_force", mesh.label) in result.held()
    ]
    if not loud:
        return window
    return close_up(result, ("drive_force", max(loud)[1]), window) or window
