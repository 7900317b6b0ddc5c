"""The random excited systems: reproducible, well-conditioned, and through every branch."""

import numpy as np
import pytest

from cross.excited_systems import SEEDS, excited_case
from cross.reference import Reference
from cross.riding import ridden


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("seed", SEEDS)
def test_excited_systems_converge(seed: int) -> None:
    """Coarser tolerances and other steps change nothing that counts over 10 ms."""
    assert excited_case(seed) == excited_case(seed)
    case, times = ridden(excited_case(seed)), np.linspace(0.0, 0.01, 11)
    fine, coarse = Reference(case), Reference(case, relative_tolerance=3e-12, max_step=1.1e-5)
    first, second = fine.trajectory(times), coarse.trajectory(times)
    assert [e[1:] for e in fine.events] == [e[1:] for e in coarse.events]
    assert len(fine.events) >= 16
    for name, allowed in (("x", 1e-11), ("y", 1e-11), ("theta", 1e-10), ("omega", 1e-6)):
        np.testing.assert_allclose(second[name], first[name], atol=allowed, rtol=0.0)


@pytest.mark.deep
def test_excited_systems_cover_the_branches() -> None:
    seen = set()
    for seed in SEEDS:
        reference = Reference(ridden(excited_case(seed)))
        reference.trajectory([0.01])
        seen |= {(key[0], key[2], sign) for _, key, sign in reference.events}
    for name in ("forward", "backward"):
        assert {("coupling", name, 1.0), ("coupling", name, -1.0), ("coupling", f"push {name}", -1.0)} <= seen
    assert {("mesh", "drive", 1.0), ("mesh", "back", 1.0), ("sleeve", "contact", 1.0)} <= seen
    assert {("mesh", "parity", 1.0), ("mesh", "parity", -1.0), ("mesh", "above", -1.0)} <= seen
    assert {("servo", "upper", 1.0), ("servo", "lower", 1.0), ("mesh", "double", 1.0)} <= seen
    reference = Reference(excited_case(4))
    reference.trajectory([0.01])
    assert ("servo", 0, "upper") in {key for _, key, _ in reference.events}  # its position servo
