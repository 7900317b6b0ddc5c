"""Limit cycles of sampled controls: periodic orbits whose period is a whole number of samples.

What a sampled loop hunts with is a motion of the map x -> P(x) from just before one sample to just before the next. It is either
locked, x_(k+n) = x_k, and then a fixed point of P^n, found by shooting with its multipliers; or it never repeats: its own period
is no rational number of samples, as on an invariant curve of the map (Y. A. Kuznetsov, Elements of Applied Bifurcation Theory,
section 7.3). Locked ranges of a parameter are wide where a period has few samples, and vanish where it has many.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.model.pack import Packed
from gearplay.nonlinear.orbits.period_map import Member, StrobeMap, excitation_rates
from gearplay.nonlinear.orbits.shooting import Orbit, find_orbit
from gearplay.parts.registry import POSITIONER
from gearplay.solver.flow import Flow
from gearplay.vocabulary.errors import InputError, SimulationError

Floats = NDArray[np.float64]

MOST_SAMPLES: Final = 1000
"""Longest period that is sought, in samples."""
SPANS: Final = 50.0
"""Longest time to settle, in durations of the case."""
REPEATED: Final = 1e-3
"""Distance in natural sizes of states that count as one."""
NEAR, TRIED = 0.05, 3
"""Distance in natural sizes of returns that may be to an orbit, and how many of them are tried, each nearer than those before."""
AHEAD: Final = 3.0
"""How much farther than by its slowest multiplier an orbit may be from a motion that still approaches it."""
STILL: Final = 1e-9
"""Distance in natural sizes of successive states of a motion that has come to rest."""
EQUAL: Final = 1e-9
"""Relative difference of times of samples that count as one."""


def sample_time(packed: Packed) -> float | None:
    """Return the time [s] between two samples of a case that only sampled controls excite, None for another.

    Where the position loop is sampled less often, its sample time counts. Raises `InputError` for loops with
    different times.
    """
    loops: Any = packed.system.records[POSITIONER]
    loops = loops[loops["sample_time"] > 0.0]
    rates = [rate for rate in excitation_rates(packed) if rate > 0.0]
    if not len(loops) or len(rates) > len(loops) + np.count_nonzero(loops["every"] > 1):
        return None
    if np.any(loops["speed_resolution"] > 0.0):
        rule = "must be 0 for orbits of a sampled control: the last count would be one more state"
        raise InputError.of("drive.speed_resolution", None, rule, "Measure the speed exactly, or run it")
    times = loops["sample_time"] * loops["every"]
    if np.ptp(times) > EQUAL * times[0]:
        rule = "must be one for all sampled controls of a limit cycle"
        shown = ", ".join(f"{each:g} s" for each in times.tolist())
        raise InputError.of("drive.sample_time", shown, rule, "Give all loops the same")
    return float(times[0])


class Settled(NamedTuple):
    """States of a settled motion just before its samples, shape [sample, state], and the onsets [s] of its contacts."""

    states: Floats
    onsets: Floats


class SampledMap(StrobeMap):
    """The map of a case that nothing but sampled controls excites, from just before one sample to just before the next."""

    def member(self, parameter: float) -> Member:
        """Return the flow and the time between two samples [s] at a parameter."""
        if parameter not in self._kept:
            flow = Flow(self.family(parameter))
            period = sample_time(flow.packed)
            assert period is not None, "chosen for such cases"
            self._kept[parameter] = Member(flow, period)
        return self._kept[parameter]

    def settled(self, parameter: float, returns: int) -> Settled:
        """Return twice `MOST_SAMPLES` states of the motion after a number of returns to its first contact.

        Raises `SimulationError` where it comes to rest.
        """
        flow, period = self.member(parameter)
        course, run = flow.begin(flow.start()), flow.case.run
        longest = SPANS * (run.transient + run.duration)
        states, first, k = list[Floats](), None, 0
        while len(states) < 2 * MOST_SAMPLES:
            k += 1
            course.advance(k * period)
            held = course.closed[self.impact_contacts]
            speeds = np.where(held, course.impact_speeds, 0.0)
            now = np.concatenate([course.state[self.free], speeds])
            log = course.whole_log
            opened = log[log[:, 2] == 0.0]
            first = opened[0, 1] if first is None and len(opened) else first
            if len(states) or np.count_nonzero(opened[:, 1] == first) >= returns:
                states.append(now)
            elif k * period > longest:
                raise SimulationError(
                    f"orbit: {np.count_nonzero(opened[:, 1] == first)} of {returns} returns to the first contact came within "
                    f"{longest:.4g} s: the motion comes to rest, or diverges. Ask for fewer, or for a case that hunts."
                )
        if self.distance(states[-1], states[-2]) < STILL:
            raise SimulationError(
                "orbit: the motion has come to rest: it repeats itself with every sample. Ask for a case that hunts."
            )
        return Settled(np.array(states), log[(log[:, 1] == first) & (log[:, 2] == 0.0), 0])

    def distance(self, one: Floats, other: Floats) -> float:
        """Return the largest difference of two states in natural sizes."""
        return float(np.max(np.abs(one - other) / self.scale))


def sampled_orbit(found: SampledMap, parameter: float, settle: int) -> Orbit:
    """Return the locked limit cycle that the motion of a case at a parameter settles to; its order is that in samples.

    Raises `SimulationError` where the motion does not repeat itself with the samples.
    """
    states, onsets = found.settled(parameter, settle)
    distances = np.array([found.distance(states[n], states[0]) for n in range(1, MOST_SAMPLES + 1)])
    nearest = np.minimum.accumulate(distances)
    nearer = np.flatnonzero(
        (distances < NEAR) & (distances == nearest) & (np.append(np.inf, nearest[:-1]) > distances)
    )
    for n in nearer[:TRIED].tolist():
        try:
            orbit = find_orbit(found, states[0], parameter, order=n + 1)
        except SimulationError:
            continue
        # The rest e of a decaying motion changes by (M - 1) e over the orbit.
        decay = 1.0 - min(1.0, float(np.max(np.abs(orbit.multipliers), initial=0.0)))
        reach = AHEAD * distances[n] / decay if decay > 0.0 else REPEATED
        if found.distance(orbit.states[0], states[0]) < max(reach, REPEATED):
            return orbit
    own = float(np.mean(np.diff(onsets[-20:]))) if len(onsets) > 2 else np.nan
    period, near = found.member(parameter).period, int(np.argmin(distances))
    raise SimulationError(
        f"orbit: the motion is not locked to the samples: its own period is {own:.6g} s, {own / period:.6g} samples, and of the "
        f"first {MOST_SAMPLES} states none repeats one; the nearest, after {near + 1} samples, is {distances[near]:.2g} natural "
        "sizes away. Such a motion is quasi-periodic, or not settled: ask for more returns before (settle), choose another "
        "sample_time, or take sample_time = 0 for the orbit of the continuous loop."
    )
