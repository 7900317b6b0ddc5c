"""A mesh: two gears, external or internal, whose drive and back flanks are one-sided contacts (docs/theory, section 2).

Two contacts, drive then back. Each flank has a switch of its own, the end of its damping ramp; a square wave of stiffness adds
one for the mesh, its next edge; friction adds the hand-over to the next pair of teeth and, for each flank, the edge of the band
in which its sliding is slow. Gears on a carrier roll in its frame.
"""

from gearplay.parts.mesh.law.forces import (
    apply_forces,
    contact_kinematics,
    end_step,
    forcing_rate,
    observe,
    show_free,
    start_step,
    stay_open,
)
from gearplay.parts.mesh.law.record import (
    KIND,
    MEMORY,
    MODES,
    PER_CONTACT,
    RECORD,
    SIGNALS,
    joined_centres,
    recurrence_rates,
)
from gearplay.parts.mesh.law.slopes import SLOPES, add_change, crossing, linearise
from gearplay.parts.mesh.law.switches import (
    initialise,
    initialise_touch,
    jump,
    locate_kinks,
    may_return,
    own_switch,
    switch_own,
)

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
    "end_step",
    "forcing_rate",
    "initialise",
    "initialise_touch",
    "joined_centres",
    "jump",
    "linearise",
    "locate_kinks",
    "may_return",
    "observe",
    "own_switch",
    "recurrence_rates",
    "show_free",
    "start_step",
    "stay_open",
    "switch_own",
]
