"""The random systems of the cross-checks: reproducible, well-conditioned, and through every branch of the reference."""

from typing import Any

import numpy as np
import pytest

from cross.comparing import begun
from cross.excited_systems import SEEDS, excited_case
from cross.planetary_systems import planetary_case
from cross.random_systems import random_case
from cross.reference import Reference
from cross.riding import ridden

CASES = {
    **{f"random {seed}": (random_case, seed) for seed in range(20)},
    **{f"excited {seed}": (excited_case, seed) for seed in SEEDS},
}


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("name", CASES)
def test_reference__converged(name: str) -> None:
    """Coarser tolerances and other steps change nothing that counts over 10 ms."""
    make, seed = CASES[name]
    assert make(seed) == make(seed)
    case, times = ridden(make(seed)), np.linspace(0.0, 0.01, 11)
    fine, coarse = Reference(case), Reference(case, relative_tolerance=3e-12, max_step=1.1e-5)
    first, second = fine.trajectory(times), coarse.trajectory(times)
    assert [e[1:] for e in fine.events] == [e[1:] for e in coarse.events]
    assert len(fine.events) >= 3
    for name, allowed in (("x", 1e-11), ("y", 1e-11), ("theta", 1e-10), ("omega", 1e-6)):
        np.testing.assert_allclose(second[name], first[name], atol=allowed, rtol=0.0)


def branches(cases: list[Any], end: float) -> set[tuple[str, str, float]]:
    """Return kind, indicator and new sign of all events of some cases."""
    seen = set()
    for case in cases:
        reference = Reference(case)
        reference.trajectory([end])
        seen |= {(key[0], key[2], sign) for _, key, sign in reference.events}
    return seen


BOTH = (("mesh", "drive"), ("mesh", "back"), ("sleeve", "contact"), ("mesh", "double"))
SETS = {
    "random": [("mesh", "full drive"), ("mesh", "push drive"), ("servo", "upper"), ("sleeve", "above")],
    "excited": [
        ("coupling", "forward"),
        ("coupling", "backward"),
        ("coupling", "push forward"),
        ("mesh", "parity"),
    ],
    "planetary": [("mesh", "parity"), ("servo", "lower")],
}


@pytest.mark.deep
@pytest.mark.parametrize("kind", SETS)
def test_random_systems__every_branch(kind: str) -> None:
    cases = {
        "random": lambda: [random_case(seed) for seed in range(20)],
        "excited": lambda: [ridden(excited_case(seed)) for seed in SEEDS],
        "planetary": lambda: [begun(planetary_case(seed)) for seed in (6, 7, 10, 11)],
    }[kind]()
    seen = branches(cases, 6e-3 if kind == "planetary" else 0.01)
    assert {(*each, sign) for each in BOTH for sign in (1.0, -1.0)} <= seen
    assert set(SETS[kind]) <= {each[:2] for each in seen}
