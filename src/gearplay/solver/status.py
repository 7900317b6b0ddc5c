"""Status codes of a run, each with a sentence that names the cause and the cure."""

from enum import IntEnum

from gearplay.integrate import run as kernel
from gearplay.integrate.members import TOO_MANY_STEPS


class Status(IntEnum):
    """Status at the end of a run; a run with any status other than DONE keeps the results so far."""

    DONE = kernel.DONE
    PAUSED = kernel.PAUSED
    NOT_FINITE = kernel.NOT_FINITE
    STEP_TOO_SMALL = kernel.STEP_TOO_SMALL
    CHATTER = kernel.CHATTER
    CANNOT_MESH = kernel.CANNOT_MESH
    BLOW_UP = kernel.BLOW_UP
    MISSED_SWITCH = kernel.MISSED_SWITCH
    TOO_MANY_STEPS = TOO_MANY_STEPS
    OUT_OF_TIME = 21
    INTERRUPTED = 22


WORDS = {
    Status.DONE: "Done.",
    Status.PAUSED: "Paused between two steps.",
    Status.NOT_FINITE: "A state became infinite or NaN. Check stiffnesses, masses and initial values for absurd sizes.",
    Status.STEP_TOO_SMALL: "The step fell below the resolution of time. Loosen `run.tolerance` or soften the stiffest contact.",
    Status.CHATTER: "Contacts switch endlessly within no time."
    " Add damping or restitution below 1, or raise the impact-speed floor.",
    Status.CANNOT_MESH: "A pair of gears left mesh: its centre distance went out of the range that can mesh;"
    " or a journal was pressed deeper than the law johnson of its sleeve holds."
    " Reduce the radial clearances or the loads, or stiffen the sleeves.",
    Status.BLOW_UP: "The motion grew beyond all reason. Check loads, supports and drives: something accelerates for ever.",
    Status.MISSED_SWITCH: "A touch or release was passed without being located, so the motion beyond it would be false."
    " This is a fault of gearplay: please report the case. A tighter `run.tolerance` may avoid it.",
    Status.TOO_MANY_STEPS: "The limit on steps was reached. Raise `run.max_steps` or loosen `run.tolerance`.",
    Status.OUT_OF_TIME: "The limit on wall time was reached. Raise `run.max_wall_time` or shorten `run.duration`.",
    Status.INTERRUPTED: "Interrupted. What was computed so far is kept.",
}
