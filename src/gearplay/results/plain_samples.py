"""Choice of the samples that a file of a run has in addition to its motion."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gearplay.model.pack import Packed
from gearplay.solver.kept_samples import KeptSamples
from gearplay.solver.trajectory import Trajectory, WrittenSamples, all_columns, choose_columns
from gearplay.vocabulary.errors import InputError

PLAIN_BYTES, FEWEST_PLAIN = 4000.0, 64
"""Size of the samples where nothing else is requested [byte per simulated second and member]; least number."""


class Lack(NamedTuple):
    """Reason why a result has no motion, worded as a rule, and its cure."""

    rule: str = "must be absent: only samples were kept, no motion"
    cure: str = "Simulate with gearplay.simulate"

    def error(self, name: str, value: object) -> InputError:
        """Return the error of a request that needs the motion and not only samples."""
        return InputError.of(name, value, self.rule, self.cure)


def samples_to_write(
    packed: Packed,
    runs: Sequence[Trajectory],
    signals: list[str] | None,
    sampling: float | None,
    lack: Lack,
    *,
    full: bool,
) -> list[Trajectory]:
    """Return members with the samples to write: those that `Result.save` describes.

    Raises `InputError` for an unknown signal, a rate that is not positive, more than one choice, or what was not kept.
    """
    if full and (signals is not None or sampling is not None):
        rule = "must be left out where signals or a sampling are chosen"
        raise InputError.of("full", True, rule, "Give one of them")
    if sampling is not None and not (0.0 < sampling < np.inf):
        raise InputError.of("sampling", sampling, "must be positive [Hz]", "Give samples per second")
    first = runs[0]
    columns, places = first.columns, None
    if signals is not None:
        columns, places = choose_columns(packed, signals)
    kept = [run.samples for run in runs if isinstance(run.samples, KeptSamples)]
    if len(kept) < len(runs):
        if sampling is not None:
            raise lack.error("sampling", sampling)
        if any(column not in first.columns for column in columns):
            raise lack.error("signals", ", ".join(signals or ()))
        own = [first.columns.index(column) for column in columns]
        parts = [run if signals is None else WrittenSamples(run.samples.some(own)) for run in runs]
        return [
            run if isinstance(part, Trajectory) else replace(run, columns=columns, samples=part)
            for run, part in zip(runs, parts, strict=True)
        ]
    if sampling is None and signals is None:
        if full or len(columns) < len(all_columns(packed)):
            return list(runs)
        sampling = _plain_sampling(first, len(columns))
    rate, chosen = sampling or first.sampling, kept[0].places if places is None else places
    return [
        replace(run, columns=columns, sampling=rate, samples=samples.chosen(chosen, rate))
        for run, samples in zip(runs, kept, strict=True)
    ]


def _plain_sampling(run: Trajectory, columns: int) -> float:
    """Return the rate [Hz] of the samples of all signals where no others are requested: a divisor of the record's rate."""
    stride = min(run.sampling * 8.0 * columns / PLAIN_BYTES, run.samples.count / FEWEST_PLAIN)
    return run.sampling / max(1, int(stride))
