"""Period of the sections for classification, and repetition with the common period of the excitation."""

import math
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gearplay.model.pack import Packed
from gearplay.nonlinear.kinds.classify import Response
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]

AUTO = "auto"
MOST_MESH_PERIODS = 20
"""Longest common period [mesh periods] of sections by default; a longer one is that of hunting teeth."""
LEAST_REPEATED = 100
"""Number of sections that must repeat."""
QUIET_KINDS = ("at rest", "chaotic")
"""Kinds that are not tested for repetition with the excitation."""


@dataclass(frozen=True)
class SectionPeriod:
    """Time between two sections [s], and number of sections per period of all excitation, 1 if unknown."""

    step: float
    repeats: int = 1


def chosen_period(packed: Packed, which: str | float) -> SectionPeriod:
    """Return the period of the sections; ``auto`` is the common one of the excitation, or the first mesh's where that is long.

    Raises `InputError` where there is none.
    """
    common = math.inf
    if which in (AUTO, "mesh"):
        try:
            common = section_period(packed, "common")
        except InputError:
            if which == AUTO:
                with suppress(InputError):  # the common one is reported missing, where the mesh's is too
                    return SectionPeriod(section_period(packed, "mesh"))
                raise
    if which == AUTO:
        try:
            mesh = section_period(packed, "mesh")
        except InputError:
            return SectionPeriod(common)
        which = "mesh" if round(common / mesh) > MOST_MESH_PERIODS else "common"
    step = section_period(packed, which)
    return SectionPeriod(step, round(common / step) if math.isfinite(common) else 1)


def with_repetition(
    response: Response, samples: Floats, resolution: Floats, period: SectionPeriod
) -> Response:
    """Return a response as periodic where its sections repeat with the common period of the excitation.

    ``samples`` has shape [period, state], ``resolution`` shape [state]. Where the record is too short to decide, the reason
    states the period of the excitation.
    """
    n = period.repeats
    if n <= 1 or response.kind in QUIET_KINDS or response.kind == "periodic":
        return response
    seconds = f"{n} periods ({n * period.step:.4g} s), after which all that excites the case begins anew"
    if len(samples) < n + LEAST_REPEATED:
        return replace(response, reason=f"{response.reason} The record is shorter than {seconds}.")
    misfit = float(np.max(np.abs(samples[n:] - samples[:-n])[-LEAST_REPEATED:] / resolution))
    if misfit > 1.0:
        return response
    reason = f"The section repeats to {misfit:.2g} of what the tolerance allows after {seconds}."
    evidence = {**response.evidence, "misfit": misfit, "order": float(n)}
    return replace(response, kind="periodic", order=n, reason=reason, evidence=evidence)
