"""Cost estimate of a run, and refusal of one that is too large."""

from typing import NamedTuple

from gearplay.model.case import Case
from gearplay.model.pack import Packed
from gearplay.parts.registry import MESH
from gearplay.vocabulary.errors import ResourceError

STEPS_PER_SECOND = 2e4  # typical, per simulated second and contact pair, at the default tolerance
STEPS_PER_WALL_SECOND = 1e6
SAMPLES_PER_WALL_SECOND = 3e6

MAX_BYTES = 16e9
MAX_STEPS = 2e10


class Estimate(NamedTuple):
    """Rough cost of a run: order of magnitude only."""

    steps: float
    samples: float
    bytes: float
    wall_time: float  # s, on one core

    def __str__(self) -> str:
        return (
            f"about {self.steps:.2g} steps, {self.samples:.2g} samples, {self.bytes / 1e9:.2g} GB,"
            f" {self.wall_time:.2g} s on one core"
        )


def estimate(
    case: Case,
    packed: Packed,
    *,
    columns: int,
    members: int,
    sampling: float,
    duration: float,
    transient: float,
) -> Estimate:
    """Estimate the cost of simulating ``members`` members."""
    meshes = max(1, packed.system.records[MESH].size)
    rate = STEPS_PER_SECOND * meshes if case.run.fixed_step is None else 1.0 / case.run.fixed_step
    steps = rate * (duration + transient) * members
    samples = sampling * duration * members
    return Estimate(
        steps=steps,
        samples=samples,
        bytes=8.0 * samples * (columns + 1),
        wall_time=steps / STEPS_PER_WALL_SECOND + samples / SAMPLES_PER_WALL_SECOND,
    )


def check_samples(times: int, columns: int) -> None:
    """Raise `ResourceError` for more samples than a machine of ordinary size should hold."""
    if (needed := 8.0 * times * columns) > MAX_BYTES:
        raise ResourceError(
            f"samples: {times} times of {columns} signals take {needed / 1e9:.3g} GB, more than the limit of"
            f" {MAX_BYTES / 1e9:.0f} GB. Lower the sampling, shorten the window, or ask for one signal."
        )


def check_estimate(wanted: Estimate) -> None:
    """Raise `ResourceError` for a run that no machine of ordinary size should start."""
    if wanted.bytes > MAX_BYTES:
        raise ResourceError(
            f"run: {wanted} are more than the limit of {MAX_BYTES / 1e9:.0f} GB. "
            "Lower run.sampling, run.duration or run.ensemble, or keep fewer signals."
        )
    if wanted.steps > MAX_STEPS:
        raise ResourceError(
            f"run: {wanted} are more than the limit of {MAX_STEPS:.0e} steps. Shorten run.duration or lower run.ensemble."
        )


def check_work(what: str, packed: Packed, *, seconds: float, numbers: float = 0.0) -> None:
    """Raise `ResourceError` for an analysis of ``seconds`` of motion with ``numbers`` stored that is over the limits."""
    steps, held = STEPS_PER_SECOND * max(1, packed.system.records[MESH].size) * seconds, 8.0 * numbers
    if held > MAX_BYTES or steps > MAX_STEPS:
        raise ResourceError(
            f"{what}: {seconds:.2g} s of motion, about {steps:.2g} steps, {held / 1e9:.2g} GB,"
            f" {steps / STEPS_PER_WALL_SECOND:.2g} s on one core, are more than the limits of {MAX_STEPS:.0e} steps and"
            f" {MAX_BYTES / 1e9:.0f} GB. Ask for fewer periods, points or seconds."
        )
