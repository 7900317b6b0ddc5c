"""A rolling bearing: one contact for each element, which travels with the cage (docs/theory, section 3).

The functions of `gearplay.integrate.dispatch` that it has: forces (`forces`), their slopes (`slopes`), the events of
dents (`passing`).
"""

from gearplay.parts.bearing.law.forces import (
    apply_forces,
    contact_kinematics,
    forcing_rate,
    may_return,
    mounts,
    observe,
    recurrence_rates,
    stay_open,
)
from gearplay.parts.bearing.law.passing import initialise, initialise_touch, jump, own_switch, switch_own
from gearplay.parts.bearing.law.record import KIND, PER_CONTACT, RECORD, SIGNALS
from gearplay.parts.bearing.law.slopes import SLOPES, add_change, crossing, linearise

__all__ = [
    "KIND",
    "MEMORY",
    "MODES",
    "PER_CONTACT",
    "RECORD",
    "SIGNALS",
    "SLOPES",
    "add_change",
    "apply_forces",
    "contact_kinematics",
    "crossing",
    "forcing_rate",
    "initialise",
    "initialise_touch",
    "jump",
    "linearise",
    "may_return",
    "mounts",
    "observe",
    "own_switch",
    "recurrence_rates",
    "stay_open",
    "switch_own",
]
MEMORY: tuple[float, ...] = ()
MODES = 1  # dents that elements are in, a bit for each
