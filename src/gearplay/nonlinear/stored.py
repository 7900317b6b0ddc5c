"""Portrait of a stored result, from its samples, with sections once per mesh period."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.model.rolling import mesh_frequency, nominal_speeds
from gearplay.nonlinear.portrait_figures import portrait_drawing
from gearplay.results.choice import cut, free_rotors, moves
from gearplay.results.mechanism import motion_of
from gearplay.results.provenance import provenance, signal_words
from gearplay.results.result import Result
from gearplay.results.titles import case_words, window_words
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    import xarray as xr


def stored_portrait(result: Result, rotors: list[str], window: tuple[float, float]) -> "xr.Dataset":
    """Return the paths of a stored result as a portrait's dataset, without onsets, which are not stored in a result.

    Sections are interpolated between samples, once per period of the first mesh; there are none without meshes that turn.
    Raises `InputError` where nothing of ``rotors`` (of none, all) moves.
    """
    import xarray as xr

    case = result.case
    free = free_rotors(case)
    speeds = dict(zip(case.rotors, nominal_speeds(case), strict=True))
    signals = [
        f"{rotor}.{name}"
        for rotor in rotors or list(case.rotors)
        for names in ((("x", "y", "vx", "vy") if rotor in free else ()), _turning(result, rotor))
        for name in names
        if (name, rotor) in result.held()
    ]
    if not signals:
        rule = "must name a rotor that moves, with x, y, vx, vy or theta, omega kept"
        raise InputError(Fault("at", ", ".join(rotors) or "none", rule, f"Rotors: {', '.join(case.rotors)}"))
    variables: dict[str, Any] = {
        "contact": ("onset_time", np.zeros(0, dtype=object), {"long_name": "contact that begins"})
    }
    time = cut(result, *_apart(signals[0]), window)[0]
    frequency = abs(mesh_frequency(case, 0)) if case.meshes else 0.0
    count = int((time[-1] - time[0]) * frequency)
    instants = time[0] + np.arange(count) / frequency if count else np.zeros(0)
    motions = {
        rotor: motion_of(case, rotor, time, lambda name, label: cut(result, name, label, window)[1])
        for rotor in free
        if f"{rotor}.x" in signals
    }
    for signal in signals:
        name, rotor = _apart(signal)
        beside = motions.get(rotor, {})
        values = beside[name] if name in beside else cut(result, name, rotor, window)[1]
        if name == "theta":
            values = values - speeds[rotor] * time
            values = values - values[0]
        if name == "omega":
            values = values - speeds[rotor]
        words = signal_words(signal)
        variables[f"path.{signal}"] = ("path_time", values, words)
        variables[f"section.{signal}"] = ("section_time", np.interp(instants, time, values), words)
        variables[f"onset.{signal}"] = ("onset_time", np.zeros(0), words)
    period = 1.0 / frequency if frequency else 0.0
    return xr.Dataset(variables, attrs=provenance(case, period=period))


def _apart(signal: str) -> tuple[str, str]:
    rotor, _, name = signal.rpartition(".")
    return name, rotor


def _turning(result: Result, rotor: str) -> tuple[str, ...]:
    """Return the signals of a rotation that is not a constant speed."""
    held = ("omega", rotor) in result.held()
    return ("theta", "omega") if held and moves(result, "omega", rotor) else ()


def portrait_figure_of(result: Result, rotors: list[str], window: tuple[float, float]) -> Any:
    """Return the figure of phase portraits of a stored result."""
    found = stored_portrait(result, rotors, window)
    title = f"{case_words(result.case)}: portrait, {window_words(window)}".replace(" um", " µm")
    return portrait_drawing(found, rotors=tuple(rotors), title=title)
