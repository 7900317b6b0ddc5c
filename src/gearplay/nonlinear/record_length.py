"""Record length that conclusions about a motion require."""

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.pack import Packed, pack
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.solver.flow import Flow
from gearplay.vocabulary.errors import Fault, InputError

Floats = NDArray[np.float64]
LEAST = 20
"""Mesh periods that a record must hold: the number of blocks for the scatter of exponents."""
CYCLES = 25
"""Slow oscillations that a record must hold, 5 in each of the 5 parts for the scatter of exponents."""
SAMPLES = 8.618  # per shortest period of the excitation; no whole number, so that no harmonic is aliased to a low frequency
TRUSTED = 1e4  # multiple of the allowed local error below which a scatter is no motion


def shortest_period(packed: Packed) -> float | None:
    """Return the first mesh's period [s], without a mesh that of all excitation, None without either."""
    for which in ("mesh", "common"):
        with suppress(InputError):
            return section_period(packed, which)
    return None


def check_span(case: Case, field: str, given: float | str, span: float, *, per: float = 1.0) -> None:
    """Raise `InputError` for a record of ``span`` [s] that is too short; ``field`` is ``given``, ``per`` of it are a second.

    A case without periodic excitation has no least length.
    """
    period = shortest_period(pack(case))
    if period is not None and span < LEAST * period * (1.0 - 1e-9):
        least = LEAST * period * per
        rule = f"must cover at least {LEAST} mesh periods of {period:.4g} s; it covers {span / period:.3g}"
        raise InputError.of(field, given, rule, f"Give {least:.4g} s or more")


def slow_oscillation(samples: Floats, span: float, still: float = 0.0) -> float:
    """Return the median period [s] of a series: half of its power is in slower oscillations; 0 for a constant series.

    ``samples``, shape [time], are uniform over ``span`` [s]; a series that scatters by no more than ``still`` counts as constant.
    The cosine transform separates the periods: an oscillation of n half waves in the record takes 2 / n of it.

    >>> at = np.arange(600) / 600.0
    >>> round(slow_oscillation(np.cos(2.0 * np.pi * 40.0 * at), 12.0), 3)  # 40 oscillations in 12 s
    0.3
    """
    from scipy.fft import dct

    rest = samples - samples.mean()
    if not float(np.std(rest)) > still:
        return 0.0
    power = np.cumsum(np.square(dct(rest, norm="ortho")))
    return 2.0 * span / max(1, int(np.searchsorted(power, 0.5 * power[-1])))


def velocities(flow: Flow) -> dict[int, str]:
    """Return which of the free entries of a state are velocities, with their names."""
    named = enumerate(flow.free_names)
    return {at: name for at, name in named if name.rpartition(".")[2] in ("vx", "vy", "omega")}


def too_few_oscillations(flow: Flow, samples: Floats, span: float) -> Fault | None:
    """Return the fault of a record of ``span`` [s] that does not hold `CYCLES` slow oscillations of a velocity, or of its square.

    ``samples`` are the velocities, shape [time, velocity]. Squares measure the intensity of rattle: after the start it
    settles more slowly than any velocity, and earlier exponents are those of another motion.
    """
    found: list[tuple[float, str]] = []
    sizes = flow.natural[flow.free]
    for (at, name), column in zip(velocities(flow).items(), samples.T, strict=True):
        size = sizes[at]
        still = TRUSTED * flow.case.run.tolerance * float(size)
        rest = column - column.mean()
        found.append((slow_oscillation(column, span, still), name))
        found.append((slow_oscillation(rest * rest, span, still * float(np.std(rest))), f"{name} squared"))
    swing, name = max(found, default=(0.0, ""))
    if span >= CYCLES * swing:
        return None
    rule = (
        f"must hold {CYCLES} slow oscillations of the motion; half the power of {name} has periods of {swing:.3g} s or more, "
        f"so it holds {span / swing:.3g}"
    )
    cure = f"Give {CYCLES * swing:.2g} s or more, and a transient in which the motion settles"
    return Fault("duration", span, rule, cure)
