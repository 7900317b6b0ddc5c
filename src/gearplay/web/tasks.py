"""What a worker can do: runs of both models, bifurcation diagrams, maps, and files to download."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gearplay.model.case import Case
from gearplay.model.reading import load_case, replace, to_toml
from gearplay.output.files import netcdf_bytes
from gearplay.solver.simulate import run_batch
from gearplay.solver.status import Status
from gearplay.vocabulary.errors import Fault, InputError, SimulationError
from gearplay.web.frames import pack_frame
from gearplay.web.measures import KEPT, reduction_of, words_of
from gearplay.web.views import mechanism_of, spectrum_lines, views_of

Report = Callable[[float, float], None]
Job = Mapping[str, Any]
MODELS = ("coupled", "uncoupled")
LIMITS = {"run.max_steps": 20_000_000, "run.max_wall_time": 120.0, "run.ensemble": 1}
MOST_SAMPLES = 2_000_000
MOST_POINTS = 100_000  # of a diagram
MOST_CELLS = 2500  # of a map


def limited_case(job: Job) -> Case:
    """Return the case of a job, its limits those of the server.

    Raises `InputError` for a case that cannot be, or one that keeps more samples than a page can use.
    """
    given = job.get("case")
    if not isinstance(given, Mapping):
        raise InputError(Fault("case", given, "must be a table", "Send the case itself"))
    case = load_case(given)
    run = case.run
    limits = {
        path: limit
        for path, limit in LIMITS.items()
        if (now := getattr(run, path[4:])) is None or now > limit
    }
    if run.duration * run.sampling > MOST_SAMPLES:
        rule = f"must give at most {MOST_SAMPLES} samples on the page, not {run.duration * run.sampling:.3g}"
        raise InputError(
            Fault("run.duration x run.sampling", run.duration * run.sampling, rule, "Shorten it, or use gearplay run")
        )  # fmt: skip
    return replace(case, limits) if limits else case


def run(job: Job, report: Report, stop: threading.Event) -> bytes:
    """Run a case with the models asked for; return its result frame."""
    case = limited_case(job)
    models = [model for model in MODELS if model in job.get("models", (case.backlash_model,))]
    cases = [replace(case, {"backlash_model": model}) for model in models] or [case]
    done = run_batch([(each, [0]) for each in cases], progress=report, stop=stop, threads=1)
    runs = [runs[0] for runs in done]
    if any(each.status == Status.INTERRUPTED for each in runs):
        raise KeyboardInterrupt
    for each in runs:
        if not len(each.values):
            raise SimulationError(f"run: {each.message}")
    document = {
        "kind": "run",
        "title": case.title,
        "sha256": case.sha256,
        "case": case.resolved(),
        "mechanism": mechanism_of(case),
        "lines": spectrum_lines(case),
        "test": _test_lines(case),
        "models": {
            each.backlash_model: views_of(each, trajectory)
            for each, trajectory in zip(cases, runs, strict=True)
        },
    }
    return pack_frame(document)


def _test_lines(case: Case) -> list[dict[str, Any]]:
    """Return the lines measured at the article's condition that a case is, as printed; none for any other case."""
    from gearplay.study.published.article import LINE_WORDS, LINES, conditions, printed

    if {"pinion", "ring"} - set(case.rotors) or "ring" not in case.sleeves or not case.meshes:
        return []
    speed = float(getattr(case.rotors["pinion"].drive, "speed", 0.0)) * 30.0 / np.pi
    here = (speed, 1e6 * case.sleeves["ring"].radial_clearance, 1e6 * case.meshes[0].backlash)
    for each in conditions():
        if np.allclose(here, (each.speed_rpm, each.radial_clearance_um, each.backlash_um), rtol=1e-6):
            return [
                {
                    "line": LINE_WORDS[line],
                    "frequency": printed(each, line, "frequency_hz").test,
                    "amplitude": printed(each, line, "amplitude_as_printed").test,
                }
                for line in LINES
            ]
    return []


def bifurcation(job: Job, report: Report, stop: threading.Event) -> bytes:
    """Draw a bifurcation diagram; return its sections."""
    from gearplay.api.nonlinear import bifurcation as diagram_of

    case = limited_case(job)
    count, keep, settle = (_whole(job, name, least, most) for name, least, most in
                           (("count", 2, 1000), ("keep", 1, 400), ("settle", 0, 2000)))  # fmt: skip
    if count * keep > MOST_POINTS:
        raise InputError(Fault("count x keep", count * keep, f"must be at most {MOST_POINTS}", "Lower one"))
    path, low, high = _axis(job)
    found = diagram_of(
        case,
        path,
        np.linspace(low, high, count).tolist(),
        [str(job.get("signal", ""))],
        settle=settle,
        keep=keep,
        period="mesh",
        threads=1,
        progress=report,
        stop=stop,
    )
    if stop.is_set():
        raise KeyboardInterrupt
    name = next(str(each) for each in found.data_vars if each != "reason")
    axis = found[found[name].dims[1]]
    return pack_frame(
        {
            "kind": "bifurcation",
            "title": case.title,
            "case": case.resolved(),
            "signal": name,
            "path": path,
            "unit": found[name].attrs["units"],
            "axis_unit": axis.attrs["units"],
            "x": axis.values,
            "up": found[name].values[0],
            "down": found[name].values[1],
            "failed": int(np.sum(found["reason"].values != "")),
        }
    )


def make_map(job: Job, report: Report, stop: threading.Event) -> bytes:
    """Run a small map over two fields; return a measure at each of its points."""
    from gearplay.api.sweep import Policy, sweep

    case = limited_case(job)
    columns, rows = (_whole(job, name, 2, 60) for name in ("columns", "rows"))
    if columns * rows > MOST_CELLS:
        raise InputError(
            Fault("columns x rows", columns * rows, f"must be at most {MOST_CELLS}", "Lower one")
        )
    first, second = _axis(job, "first"), _axis(job, "second")
    if first[0] == second[0]:
        raise InputError(
            Fault("second.path", second[0], "must be another field than first", "Choose another")
        )
    measure, of = str(job.get("measure", "")), str(job.get("of", ""))
    across, up = np.linspace(*first[1:], columns), np.linspace(*second[1:], rows)
    found = sweep(
        case,
        {second[0]: up.tolist(), first[0]: across.tolist()},
        reduce=[reduction_of(case, measure, of)],
        policy=Policy(workers=1),
        progress=lambda _, done, total: report(done, total),
        stop=stop,
    )
    kept = found[KEPT if KEPT in found else f"{KEPT}_amplitude"]
    return pack_frame(
        {
            "kind": "map",
            "title": case.title,
            "case": case.resolved(),
            "measure": words_of(measure, of),
            "unit": kept.attrs["units"],
            "paths": [first[0], second[0]],
            "units": [found[kept.dims[at]].attrs["units"] for at in (1, 0)],
            "x": across,
            "y": up,
            "values": kept.values,
            "reasons": sorted({str(each) for each in found["reason"].values.ravel() if each})[:5],
        }
    )


def export(job: Job, report: Report, stop: threading.Event) -> bytes:
    """Run a case and return its result as a file: ``nc``, ``csv`` or the case itself as ``toml``."""
    case, form = limited_case(job), job.get("form")
    if form == "toml":
        return to_toml(case).encode("utf-8")
    if form not in ("nc", "csv"):
        raise InputError(Fault("form", form, "must be nc, csv or toml", "Choose one"))
    from gearplay.api.result import Result

    runs = run_batch([(case, [0])], progress=report, stop=stop, threads=1)[0]
    if stop.is_set():
        raise KeyboardInterrupt
    return _csv(runs[0]) if form == "csv" else netcdf_bytes(Result(case, runs).ds)


def _csv(run: Any) -> bytes:
    """Return all signals of a run as a table: a line of names with units, then a line per sample."""
    from gearplay.vocabulary.quantities import RESULT_VARIABLES

    names = [f"{c.label}.{c.signal} [{RESULT_VARIABLES[c.signal].unit}]" for c in run.columns]
    table = np.column_stack([run.time, run.values])
    lines = [",".join(["time [s]", *names])]
    lines += [",".join(f"{value:.9g}" for value in row) for row in table]
    return ("\n".join(lines) + "\n").encode("utf-8")


def _axis(job: Job, name: str = "axis") -> tuple[str, float, float]:
    """Return a field's path and its ends [SI]."""
    given = job.get(name)
    if not isinstance(given, Mapping) or not isinstance(given.get("path"), str):
        raise InputError(Fault(name, str(given), "must have a path, low and high", "Choose a field"))
    low, high = given.get("low"), given.get("high")
    if not (
        isinstance(low, (int, float)) and isinstance(high, (int, float)) and -np.inf < low < high < np.inf
    ):
        rule = f"must be a number below high, {high}"
        raise InputError(Fault(f"{name}.low", str(low), rule, "Correct it"))
    return given["path"], float(low), float(high)


def _whole(job: Job, name: str, least: int, most: int) -> int:
    value = job.get(name)
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise InputError(Fault(name, value, f"must be a whole number from {least} to {most}", "Correct it"))
    return value


TASKS: Mapping[str, Callable[[Job, Report, threading.Event], bytes]] = {
    "run": run,
    "bifurcation": bifurcation,
    "map": make_map,
    "export": export,
}
