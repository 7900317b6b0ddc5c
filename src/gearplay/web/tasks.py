"""Tasks of a worker: runs of both models, bifurcation diagrams, maps, lost motion, ensemble averages, downloads."""

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from gearplay.files.netcdf import netcdf_bytes
from gearplay.model.case import Case
from gearplay.model.check import check_case, findings_of
from gearplay.model.pack import Packed, pack
from gearplay.model.reading import replace, to_toml
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.results.lines import spectrum_lines
from gearplay.results.mechanism import mechanism_of
from gearplay.solver.simulate import run_batch
from gearplay.solver.status import Status
from gearplay.solver.trajectory import Trajectory
from gearplay.vocabulary.errors import InputError, SimulationError
from gearplay.vocabulary.progress import Tick
from gearplay.web.frames import pack_frame
from gearplay.web.jobs import (
    LONGEST_DIAGRAM,
    MOST_SAMPLES,
    Job,
    averaged_case,
    axis_of,
    failures_of,
    heading,
    limited_case,
    models_of,
    whole,
)
from gearplay.web.lost_motion import lost_motion
from gearplay.web.maps import make_map
from gearplay.web.measured import measured, measured_lines
from gearplay.web.toml_edits import edited
from gearplay.web.views import spectra_of, statistics_of, views_of

MOST_POINTS = 100_000  # of a diagram
FEWEST_SAMPLES = 20.0
"""Number of samples of a run of which only the contacts are evaluated."""
SPECTRAL = ["ax", "ay"]


def run(job: Job, report: Tick, stop: threading.Event) -> bytes:
    """Run a case with the requested models; return its result frame."""
    case = limited_case(job)
    cases = models_of(job, case)
    packs = [pack(each) for each in cases]
    members = list(range(case.run.ensemble))
    with ThreadPoolExecutor(1) as beside:
        described = beside.submit(_described, job, case, cases, packs)  # while compiled code runs
        done = run_batch(
            [(each, members) for each in cases],
            packs=packs,
            progress=report,
            stop=stop,
            threads=len(cases),
        )
    _check_runs((run for runs in done for run in runs), complete=False)
    views = zip(cases, packs, done, strict=True)
    return pack_frame(
        {
            **described.result(),
            "members": len(members),
            "models": {each.backlash_model: views_of(each, packed, runs) for each, packed, runs in views},
        }
    )


def _described(job: Job, case: Case, cases: Sequence[Case], packs: Sequence[Packed]) -> dict[str, Any]:
    """Return the part of a run's result that is known before it; ``packs`` are of ``cases``, the case with each model."""
    same = [
        packed
        for each, packed in zip(cases, packs, strict=True)
        if each.backlash_model == case.backlash_model
    ]
    findings = findings_of(case, same[0]) if same else check_case(case)
    return {
        **heading("run", job, case),
        "mechanism": mechanism_of(case),
        "lines": spectrum_lines(case),
        "test": measured_lines(case),
        "warnings": [f"{each.path}: {each.message}" for each in findings if each.severity == "warning"],
    }


def _check_runs(runs: Iterable[Trajectory], *, complete: bool = True) -> None:
    """Raise `KeyboardInterrupt` for an interrupted run, `SimulationError` for one without samples, or not ``complete``."""
    for run in runs:
        if run.status == Status.INTERRUPTED:
            raise KeyboardInterrupt
        if not len(run.values) or (complete and not run.success):
            raise SimulationError(
                f"member {run.member}: {run.message}" if complete else f"run: {run.message}"
            )


def bifurcation(job: Job, report: Tick, stop: threading.Event) -> bytes:
    """Draw a bifurcation diagram; return its sections."""
    from gearplay.nonlinear.bifurcation import bifurcation as diagram_of

    case = replace(limited_case(job, longest=LONGEST_DIAGRAM), {"run.ensemble": 1})
    count, keep, settle = (whole(job, name, least, most) for name, least, most in
                           (("count", 2, 1000), ("keep", 1, 400), ("settle", 0, 2000)))  # fmt: skip
    if count * keep > MOST_POINTS:
        raise InputError.of("count x keep", count * keep, f"must be at most {MOST_POINTS}", "Lower one")
    path, low, high = axis_of(job)
    found = diagram_of(
        case,
        path,
        np.linspace(low, high, count).tolist(),
        [str(job.get("signal", ""))],
        settle=settle,
        keep=keep,
        period="mesh",
        threads=1,
        progress=lambda _, done, total: report(done, total),
        stop=stop,
    )
    if stop.is_set():
        raise KeyboardInterrupt
    words = found.ds[found.names[0]]
    axis = found.ds[words.dims[1]]
    return pack_frame(
        {
            **heading("bifurcation", job, case),
            "signal": found.names[0],
            "path": path,
            "unit": words.attrs["units"],
            "axis_unit": axis.attrs["units"],
            "x": axis.values,
            "up": words.values[0],
            "down": words.values[1],
            "failures": failures_of(np.array(found.reasons, dtype=object)),
            "starts": failures_of(np.array(found.starts, dtype=object)),
            "not_carried": list(found.interruptions[:5]),
            **found.account.as_document(),
        }
    )


def average(job: Job, report: Tick, stop: threading.Event) -> bytes:
    """Return contacts and spectra of a case over ``members``, for each requested model.

    Contacts are of members of ``duration`` after ``transient``, drawn as those of a map's cell. Spectra are of members as long as
    the case's own run, so that their lines lie where those of the run do.
    """
    case, count = averaged_case(job)
    own = limited_case(job).run
    fit = max(2, min(count, int(MOST_SAMPLES // (own.duration * own.sampling))))
    members, few = list(range(count)), list(range(fit))
    models = models_of(job, case)
    share = case.run.duration / (case.run.duration + own.duration)
    contacts = run_batch(
        [(each, members) for each in models],
        sampling=FEWEST_SAMPLES / case.run.duration,
        progress=lambda done, total: report(share * done, total),
        stop=stop,
        threads=1,
    )
    records = run_batch(
        [(replace(each, {"run.duration": own.duration}), few) for each in models],
        signals=SPECTRAL,
        sampling=own.sampling,
        progress=lambda done, total: report(share * total + (1.0 - share) * done, total),
        stop=stop,
        threads=1,
    )
    _check_runs(run for runs in (*contacts, *records) for run in runs)
    found = {
        each.backlash_model: {"statistics": statistics_of(long), "spectra": spectra_of(each, brief)}
        for each, long, brief in zip(models, contacts, records, strict=True)
    }
    return pack_frame(
        {
            "kind": "average",
            "members": count,
            "duration": case.run.duration,
            "transient": case.run.transient,
            "records": fit,
            "models": found,
        }
    )


def export(job: Job, report: Tick, stop: threading.Event) -> bytes:
    """Run a case and return its result as a file: ``nc``, ``csv`` or the case itself as ``toml``."""
    form, source, changes = job.get("form"), job.get("source"), job.get("changes")
    if form == "toml" and isinstance(source, str) and isinstance(changes, Mapping):
        return edited(source, changes).encode("utf-8")
    case = limited_case(job)
    if form == "toml":
        return to_toml(case).encode("utf-8")
    if form not in ("nc", "csv"):
        raise InputError.of("form", form, "must be nc, csv or toml", "Choose one")
    from gearplay.results.result import Result

    runs = run_batch([(case, list(range(case.run.ensemble)))], progress=report, stop=stop, threads=1)[0]
    if stop.is_set():
        raise KeyboardInterrupt
    return _csv(runs) if form == "csv" else netcdf_bytes(Result(case, runs).ds)


def _csv(runs: Sequence[Trajectory]) -> bytes:
    """Return all signals of a run as a table: a line of names with units, then a line per sample, member by member."""
    names = [f"{c.label}.{c.signal} [{RESULT_VARIABLES[c.signal].unit}]" for c in runs[0].columns]
    lines = [",".join(["member", "time [s]", *names])]
    for member, run in enumerate(runs):
        table = np.column_stack([run.time, run.values])
        lines += [f"{member}," + ",".join(f"{value:.9g}" for value in row) for row in table]
    return ("\n".join(lines) + "\n").encode("utf-8")


TASKS: Mapping[str, Callable[[Job, Tick, threading.Event], bytes]] = {
    "run": run,
    "bifurcation": bifurcation,
    "map": make_map,
    "lost_motion": lost_motion,
    "average": average,
    "export": export,
    "measured": measured,
}
