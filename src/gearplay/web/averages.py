"""Ensemble averages shown with a single run, with their standard error."""

import threading

from gearplay.model.reading import replace
from gearplay.solver.simulate import run_batch
from gearplay.solver.status import Status
from gearplay.vocabulary.errors import SimulationError
from gearplay.vocabulary.progress import Tick
from gearplay.web.frames import pack_frame
from gearplay.web.jobs import MOST_SAMPLES, Job, averaged_case, limited_case, models_of
from gearplay.web.views import spectra_of, statistics_of

FEWEST_SAMPLES = 20.0
"""Number of samples of a run of which only the contacts are evaluated."""
SPECTRAL = ["ax", "ay"]


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
    for run in (run for runs in (*contacts, *records) for run in runs):
        if run.status == Status.INTERRUPTED:
            raise KeyboardInterrupt
        if not run.success:
            raise SimulationError(f"member {run.member}: {run.message}")
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
