"""Finding the first switch inside a step, on its interpolant, and taking the step again so that it ends there."""

import math

from gearplay.integrate import dispatch
from gearplay.integrate.run import ERROR_SHARE, TOLERANCE, Run, T
from gearplay.integrate.switches import switch_values
from gearplay.integrate.trial_step import attempt, evaluate
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import OPEN, RATE, TOUCH, System


@compiled_inline
def allowance(system: System, run: Run, s: int) -> float:
    """Return the overshoot [m or rad] allowed at the end of a step past switch s: at a touch a tenth of its error tolerance.

    At most ``DEEPEST`` of the contact's natural size: at a touch that deep the force is still zero.
    """
    switch = system.switches[s]
    if switch.role != TOUCH:
        return 0.0
    share = min(0.1 * run.clock[ERROR_SHARE] * run.clock[TOLERANCE], DEEPEST)
    return float(share * system.contacts[switch.contact].natural)


DEEPEST = 1e-6  # natural sizes, 1e-10 m
SECANTS = 20
"""Tries of a root by secants; bisection goes on from there."""


@compiled_once
def locate_root(system: System, run: Run, h: float, k: int, high: float, g_high: float) -> float:
    """Return the end x of the smallest bracket in (0, high] on which switch k turns positive (Illinois)."""
    low, g_low = 0.0, min(run.g_0[k], 0.0)
    beyond, side = g_high, 0  # the value at ``high``, which the method's weight g_high is not
    width = max(1e-14, 4e-16 * abs(run.clock[T]) / h)
    close = 0.3 * allowance(system, run, k)
    for n in range(80):
        if high - low <= width or 0.0 <= beyond <= close:
            break
        x = (low * g_high - high * g_low) / (g_high - g_low) if g_high > g_low else 0.5 * (low + high)
        if n >= SECANTS:  # a start that is 0 but for rounding keeps the secant there
            x = 0.5 * (low + high)
        if not (low + 0.25 * width < x < high - 0.25 * width):
            # The secant sits on an end: step off it by just more than the wanted width.
            x = low + 0.75 * width if x - low < high - x else high - 0.75 * width
        if not evaluate(system, run, h, x, k):
            return x
        g = run.g_try[k]
        if g > 0.0:
            high, g_high, beyond = x, g, g
            if side == 1:
                g_low *= 0.5
            side = 1
        else:
            low, g_low = x, g
            if side == -1:
                g_high *= 0.5
            side = -1
    return high


@compiled_once
def locate_peak(system: System, run: Run, h: float, s: int, low: float, high: float) -> float:
    """Return the x in (low, high) where touch switch s peaks, by bisection on its rate, or 1 if it stays negative.

    The bracket is that of `graze_bracket`: a grazing touch is negative at both ends of the step. Stops at the first positive
    value, which is the last one evaluated.
    """
    k = system.switches[s].contact
    sign = 1.0 if run.branch.modes[k] == OPEN else -1.0
    reach = abs(run.loads_0.contacts[k, RATE]) + abs(run.loads.contacts[k, RATE])
    reach += 3.0 * abs(run.g_1[s] - run.g_0[s]) / h  # bounds the cubic's rate
    for _ in range(60):
        x = 0.5 * (low + high)
        if not evaluate(system, run, h, x, s):
            return 1.0
        if run.g_try[s] > 0.0:
            return x
        if run.g_try[s] + reach * (high - low) * h < 0.0:
            return 1.0
        if sign * run.loads_try.contacts[k, RATE] > 0.0:
            low = x
        else:
            high = x
        if high - low < 1e-10:
            break
    return 1.0


@compiled_once
def locate_interior_maximum(system: System, run: Run, h: float, s: int, place: float) -> float:
    """Return an x in (0, place) where switch s is positive, its last evaluation, or 1 (golden section; assumes one maximum)."""
    low, high = 0.0, place
    left, right = low + 0.381966 * place, low + 0.618034 * place
    g_left, g_right = 0.0, 0.0
    x, at_left = left, True
    for n in range(26):
        if not evaluate(system, run, h, x, s):
            return 1.0
        if run.g_try[s] > 0.0:
            return x
        if at_left:
            g_left = run.g_try[s]
        else:
            g_right = run.g_try[s]
        if n == 0:
            x, at_left = right, False
        elif g_left > g_right:
            high, right, g_right = right, left, g_left
            left = low + 0.381966 * (high - low)  # not low + high - right, whose rounding grows past the ends
            x, at_left = left, True
        else:
            low, left, g_left = left, right, g_right
            right = low + 0.618034 * (high - low)
            x, at_left = right, False
    return 1.0


@compiled_inline
def graze_bracket(system: System, run: Run, h: float, s: int) -> tuple[float, float]:
    """Return where in (0, 1) of a step of h [s] touch switch s may have a positive maximum; (1, 0) if nowhere.

    The switch is negative at both ends. Its rate is positive at the lower end of the bracket and negative at the upper one. Where
    the rate has one sign at both ends of the step, the cubic through values and rates decides: its maximum lies on one side of
    its inflection.
    """
    k, g_0, g_1 = system.switches[s].contact, run.g_0[s], run.g_1[s]
    sign = h if run.branch.modes[k] == OPEN else -h
    rise_0, rise_1 = sign * run.loads_0.contacts[k, RATE], sign * run.loads.contacts[k, RATE]
    # A cubic rises by at most 4/27 of each above its ends.
    if max(g_0, g_1) + 0.5 * (abs(rise_0) + abs(rise_1)) <= 0.0:
        return 1.0, 0.0
    if g_0 >= 0.0 or rise_0 * rise_1 < 0.0:
        return (0.0, 1.0) if g_0 < 0.0 and rise_0 > 0.0 else (1.0, 0.0)
    # g = g_0 + rise_0 x + b x^2 + c x^3
    b, c = 3.0 * (g_1 - g_0) - 2.0 * rise_0 - rise_1, rise_0 + rise_1 - 2.0 * (g_1 - g_0)
    root = b * b - 3.0 * c * rise_0
    if root <= 0.0 or c == 0.0:
        return 1.0, 0.0
    x = -(b + math.sqrt(root)) / (3.0 * c)
    higher = x * (rise_0 + x * (b + c * x))
    # The interpolant is of order 4: twice as high as the cubic stands above the ends.
    if not 0.0 < x < 1.0 or max(g_0, g_1) + 2.0 * (g_0 + higher - max(g_0, g_1)) <= 0.0:
        return 1.0, 0.0
    curvature = -b / (3.0 * c)
    return (0.0, min(curvature, 1.0)) if rise_0 > 0.0 else (max(curvature, 0.0), 1.0)


@compiled_once
def first_switch(system: System, run: Run, h: float, hidden: bool) -> tuple[int, float]:
    """Return the first switch of the step just taken and its place x in (0, 1]; (-1, 1) without one.

    With ``hidden`` the step is also searched for pulls and own switches that are negative at both of its ends.
    """
    first, place = -1, 1.0
    active_set = run.active_set
    for c in range(1, active_set.switches[0] + 1):
        s = active_set.switches[c]
        high, g_high = place, run.g_1[s]
        if first >= 0 and run.g_1[s] > 0.0:
            if not evaluate(system, run, h, place, s):
                continue
            g_high = run.g_try[s]
        if g_high > 0.0:
            # A switch that was never on its own side changes over at the end.
            x = high if run.g_0[s] > 0.0 else locate_root(system, run, h, s, high, g_high)
            if first < 0 or x < place:
                first, place = s, x
        elif system.switches[s].role == TOUCH:
            low, high = graze_bracket(system, run, h, s)
            peak = locate_peak(system, run, h, s, low, high) if low < high else 1.0
            if peak < 1.0:  # behind its root, which alone says whether it is the first
                x = locate_root(system, run, h, s, peak, run.g_try[s])
                if x < place:
                    first, place = s, x
    searched = False
    for c in range(1, (active_set.hiding[0] if hidden else 0) + 1):
        s = active_set.hiding[c]
        e, local, k = system.switches[s].element, system.switches[s].local, system.switches[s].contact
        if k >= 0 and run.branch.modes[k] == OPEN:
            continue  # nothing of an open contact is hidden
        if max(run.g_0[s], run.g_1[s]) <= 0.0 and dispatch.may_return(
            system, e, local, h, run.branch, run.loads_0, run.loads, run.g_0, run.g_1, run.stages
        ):
            searched = True
            peak = locate_interior_maximum(system, run, h, s, place)
            if peak < place:
                first, place = s, locate_root(system, run, h, s, peak, run.g_try[s])
    if searched and first >= 0 and place < 1.0:
        evaluate(system, run, h, place, first)  # `retake` goes by what is seen there
    return first, place


@compiled_once
def retake(system: System, run: Run, h: float, s: int, x: float) -> float:
    """Take the step again so that it ends just past switch s; return its length [s], or -1 on failure.

    Where switch s all but touches zero, on the interpolant alone, the step ends there with s still negative.
    """
    ahead, switch = allowance(system, run, s), system.switches[s]
    slope = 0.0  # of g, for the first try and its corrections
    if switch.role == TOUCH and run.g_try[s] != run.g_0[s]:
        slope = abs(run.loads_try.contacts[switch.contact, RATE])
    elif x < 1.0:
        g = run.g_try[s]
        slope = (run.g_1[s] - g) / ((1.0 - x) * h)
        if slope <= 0.0:  # it comes back within the step
            evaluate(system, run, h, 0.99 * x, s)
            slope = (g - run.g_try[s]) / (0.01 * x * h)
    short = x * h
    if slope > 0.0:
        short += min(ahead / slope, 0.01 * h)
    nudge, taken = max(1e-15 * h, 4e-16 * abs(run.clock[T])), short
    for _ in range(8):
        taken = short
        if attempt(system, run, taken) != 0:
            return -1.0
        t = run.clock[T] + taken
        switch_values(system, run.active_set, t, run.y_new, run.branch, run.loads, run.g_1)
        if run.g_1[s] >= 0.0 or run.g_0[s] > 0.0:
            break
        # The interpolant was a little early: continue by the step that the slope gives, a little longer each time.
        if slope > 0.0:
            short += min((ahead + 1.5 * abs(run.g_1[s])) / slope, 0.01 * h)
        short += nudge
        nudge *= 8.0
    return taken


RETAKES = 10  # of one step; each is shorter than the one before
NARROW = 1e-6  # of a step: what a retake overshoots by where it cannot be made shorter


@compiled_inline
def passes_touch(system: System, run: Run, first: int) -> bool:
    """Return whether a touch other than switch ``first`` is passed at the end of the step by more than it may be."""
    for c in range(1, run.active_set.switches[0] + 1):
        s = run.active_set.switches[c]
        passed = s != first and run.g_0[s] <= 0.0 and run.g_1[s] > 0.0
        if passed and (system.switches[s].role != TOUCH or run.g_1[s] > allowance(system, run, s)):
            return True
    return False


@compiled_once
def end_at_switch(system: System, run: Run, h: float, first: int, place: float) -> tuple[int, float]:
    """Take a step of h [s] again so that it ends at its first switch; return that switch, -1 for none, and the length [s].

    A retaken step may show that the switch is not reached (it touches zero on the interpolant alone), or pass another one that
    the interpolant had later. Then the retaken step is searched in turn: none of its switches is passed unseen. The length is
    negative where a pair cannot mesh.
    """
    taken = h
    for _ in range(RETAKES):
        if place >= 1.0:
            break  # it was positive from the start, and changes over at the end
        taken = retake(system, run, taken, first, place)
        if taken < 0.0:
            break
        reached = run.g_0[first] > 0.0 or run.g_1[first] >= 0.0
        if reached and not passes_touch(system, run, first):
            break
        earlier, place = first_switch(system, run, taken, False)
        if earlier < 0:
            first = first if reached else -1
            break
        if reached and earlier == first and place > 1.0 - NARROW:
            break  # the other one is passed at the same instant
        first = earlier
    return first, taken
