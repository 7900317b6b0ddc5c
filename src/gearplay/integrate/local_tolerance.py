"""Local error tolerance, tightened while a contact force or gap is tiny.

The allowed error of a state is a share of a natural size, 0.1 mm or 0.1 m/s. A flank that carries only the drag of a
bearing is deformed by less than 1e-10 m: at a tolerance of 1e-6 the error alone would open it, and a mesh in contact would
appear to rattle.
"""

from gearplay.integrate.run import ERROR_SHARE, TOLERANCE, Run
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import PENETRATION, RATE, TOUCH, System

FAINT = 1e-3  # natural sizes: 1e-7 m, 1e-4 m/s
SHARE = 0.1  # of a penetration or gap, that an error may be at most
FINEST = 1e-9  # tolerance below which nothing is refined any further
TIME = 1e-3  # s, of a contact: natural length over natural speed


@compiled_inline
def refine(system: System, run: Run) -> None:
    """Set the share of the allowed errors that the next step may make: 1 but where a contact presses or parts by less than FAINT.

    Below it errors shrink with the largest of penetration, gap and rate of the faintest contact, as far as FINEST allows. At a
    loose tolerance they begin to where they are a SHARE of these.
    """
    clock = run.clock
    limit = max(FAINT, clock[TOLERANCE] / SHARE)
    faintest = limit
    if clock[TOLERANCE] > FINEST:
        for c in range(1, run.active_set.switches[0] + 1):
            switch = system.switches[run.active_set.switches[c]]
            if switch.role == TOUCH and system.contacts[switch.contact].closed == 0:
                seen, natural = run.loads_0.contacts[switch.contact], system.contacts[switch.contact].natural
                size = max(abs(seen[PENETRATION]), TIME * abs(seen[RATE])) / natural
                if size < faintest:
                    faintest = size
        clock[ERROR_SHARE] = max(faintest / limit, FINEST / clock[TOLERANCE])
