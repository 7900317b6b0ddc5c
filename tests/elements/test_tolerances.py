"""Tolerance: random cases of every element end in the same state at 1e-9 and at 1e-12."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Floats, Measured, case_of
from depth import TORTURE, sized
from elements.test_elements import every_kind, own
from gearplay.solver.flow import Flow
from gearplay.vocabulary.errors import SimulationError

pytestmark = [pytest.mark.hostile, pytest.mark.compiled]
CASES = sized(1000, 100) if TORTURE else sized(1000, 100) // 10
"""Of each kind: for `make torture` a thousand, else about a thousand of all kinds together."""
SPAN = 5e-3
NUDGE, TAME, SAME = 1e-13, 1e-6, 1e-4
"""In natural sizes: a change at the start; how far it may move the end of a case that counts; how far tolerances may."""


def _ends(document: dict[str, Any], rng: np.random.Generator) -> tuple[Floats, Floats, Floats] | None:
    """Return the ends at 1e-9, at 1e-12 and from a start beside it, in natural sizes; None where the motion ends early."""
    case = case_of(document)
    fine, coarse = (Flow(gp.replace(case, {"run.tolerance": each})) for each in (1e-12, 1e-9))
    state, free = fine.start(), fine.free
    state[free] += 0.3 * fine.natural[free] * rng.uniform(-1.0, 1.0, free.size)
    beside = state.copy()
    beside[free] += NUDGE * fine.natural[free] * rng.choice([-1.0, 1.0], free.size)
    try:
        found = [
            flow.go(start, SPAN).state for flow, start in ((coarse, state), (fine, state), (fine, beside))
        ]
    except SimulationError:
        return None
    a, b, c = (each / fine.natural for each in found)
    return a, b, c


@every_kind
def test_tolerances_agree(kind: str, measured: Measured, tried: Callable[[int], None]) -> None:
    """Where a change of 1e-13 at the start moves the end less than 1e-6, tolerances 1e-9 and 1e-12 agree within 1e-4."""
    counted, worst, wrong = 0, 0.0, []
    for seed in range(CASES):
        rng = np.random.default_rng([77, seed])
        found = _ends(own(kind).sample(rng), rng)
        if found is None or np.max(np.abs(found[2] - found[1])) > TAME:
            continue
        counted += 1
        apart = float(np.max(np.abs(found[0] - found[1])))
        worst = max(worst, apart)
        if apart > SAME:
            wrong.append((seed, apart))
    assert not wrong, (kind, wrong)
    assert counted > 0.3 * CASES
    measured(f"{kind}: tolerances 1e-9 and 1e-12 apart [natural sizes]", worst, f"{SAME:g}")
    tried(counted)
