"""Shortest record length for a conclusion about the motion."""

from contextlib import suppress

from gearplay.model.case import Case
from gearplay.model.pack import Packed, pack
from gearplay.nonlinear.orbits.period_map import section_period
from gearplay.vocabulary.errors import Fault, InputError

LEAST = 20
"""Mesh periods that a record must hold: as many as the blocks over which the scatter of exponents is judged."""


def shortest_period(packed: Packed) -> float | None:
    """Return the first mesh's period [s], or that of all excitation where there is no mesh; None where there is neither."""
    for which in ("mesh", "common"):
        with suppress(InputError):
            return section_period(packed, which)
    return None


def check_span(case: Case, field: str, given: float | str, span: float, *, per: float = 1.0) -> None:
    """Raise `InputError` for a record of ``span`` [s] that is too short; ``field`` was ``given``, ``per`` of it make a second.

    Of a case that nothing excites periodically nothing is asked.
    """
    period = shortest_period(pack(case))
    if period is not None and span < LEAST * period * (1.0 - 1e-9):
        least = LEAST * period * per
        rule = f"must cover at least {LEAST} mesh periods of {period:.4g} s; it covers {span / period:.3g}"
        raise InputError(Fault(field, given, rule, f"Give {least:.4g} s or more"))
