"""Limit cycles: periodic orbits of systems that nothing excites, whose period is an unknown.

Unknowns are the state x and the period T, conditions phi(x, T) = x and that a contact opens at x, its penetration 0: the phase
condition. As a map (x, T) -> (phi(x, T), T + penetration / its natural size) its fixed points are the orbits, so that shooting
and continuation are those of forced systems (R. Seydel, Practical Bifurcation and Stability Analysis, section 7.2).
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate import dispatch
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.switches import make_branch
from gearplay.kernels.layout import PENETRATION
from gearplay.model.families import Family
from gearplay.nonlinear.orbits.period_map import Image, Member, StrobeMap, excitation_rates
from gearplay.parts.protocol import without_slots
from gearplay.solver.flow import Flow
from gearplay.vocabulary.errors import InputError, SimulationError

Floats = NDArray[np.float64]

CHANGES: Final = {"opens": 0.0, "closes": 1.0}
MOST_RETURNS: Final = 400
"""Returns to the section among which one is sought that repeats the first."""
SPANS: Final = 50.0
"""Longest time without a return to the section, in durations of the case."""
REPEATED: Final = 1e-3
"""Distance of two returns in natural sizes within which the first of several is taken."""
AT_SECTION: Final = 1e-6
"""Share of the period around the section within which a contact change is that of the section."""
SHORT: Final = 1e-6
"""Share of the period over which the rates of the state are differences."""


def section_of(flow: Flow, section: str) -> tuple[int, float]:
    """Return the contact and the change (1 onset, 0 release) of a section, ``contact:opens`` or ``contact:closes``.

    Raises `InputError` for a section that the case does not have.
    """
    label, _, change = section.rpartition(":")
    labels = flow.packed.contact_labels
    if change not in CHANGES or label not in labels:
        rule = "must be a contact and what it does, CONTACT:opens or CONTACT:closes"
        raise InputError.of(
            "section", section, rule, f"Choose a contact from: {', '.join(without_slots(labels))}"
        )
    return labels.index(label), CHANGES[change]


def check_autonomous(flow: Flow) -> None:
    """Raise `InputError` for a case that something excites."""
    rates = [rate for rate in excitation_rates(flow.packed) if rate > 0.0]
    if rates:
        rule = f"must be false where something excites the case, here at {max(rates) / (2.0 * np.pi):.4g} Hz"
        cure = "Leave it out, or remove terms, ripples, set-points over time and nominal speeds of meshes"
        raise InputError.of("autonomous", True, rule, cure)


class AutonomousMap(StrobeMap):
    """The map of a case without excitation over an unknown period, the last entry of its state.

    ``section`` is the contact change that orbits are cut at; the first contact that opens if not given.

    Raises `InputError` for an excited case, and for an unknown section.
    """

    def __init__(self, family: Family, parameter: float, section: str | None = None) -> None:
        super().__init__(family, parameter)
        self.scale = np.append(self.scale, 1.0)
        flow = self.member(parameter).flow
        if not flow.packed.contact_labels:
            rule = "must be false for a case without a contact, which has no section for its orbits"
            raise InputError.of("autonomous", True, rule, "Give a coupling a play, or a mesh")
        self._section = None if section is None else section_of(flow, section)

    def member(self, parameter: float) -> Member:
        """Return the flow at a parameter; its period is unknown."""
        if parameter not in self._kept:
            if len(self._kept) > 16:
                self._kept.clear()
            flow = Flow(self.family(parameter))
            check_autonomous(flow)
            self._kept[parameter] = Member(flow, np.nan)
        return self._kept[parameter]

    def start(self, parameter: float) -> Floats:
        """Return the case's own initial state, without a period yet."""
        return np.append(super().start(parameter), np.nan)

    def settle(self, state: Floats, parameter: float, periods: int) -> Floats:
        """Return state and period where the motion repeats itself best after ``periods`` returns to the section.

        Raises `SimulationError` where the motion does not return.
        """
        flow = self.member(parameter).flow
        full = np.zeros(flow.size)
        full[self.free] = state[: len(self.free)]
        course, run = flow.begin(full), flow.case.run
        longest = SPANS * (run.transient + run.duration)
        times, states, end = list[float](), list[Floats](), longest
        while len(times) < periods + MOST_RETURNS:
            rows = course.advance_to_change(end)
            if not len(rows):
                break
            for t, contact, change, _ in rows:
                if self._section is None and change == CHANGES["opens"]:
                    self._section = int(contact), CHANGES["opens"]
                if (int(contact), float(change)) == self._section:
                    times.append(float(t))
                    held = course.closed[self.impact_contacts]
                    speeds = np.where(held, course.impact_speeds, 0.0)
                    states.append(np.concatenate([course.state[self.free], speeds]))
                    end = float(t) + longest
            if len(times) > periods + 1 and self._distance(states[-1], states[periods]) < REPEATED:
                break
        if len(times) < periods + 2:
            raise SimulationError(
                f"orbit: the motion returned {len(times)} times to the section within {end:.4g} s and then comes to rest, or "
                "diverges. Choose another section, for fewer periods before, or for a case that hunts."
            )
        distances = [self._distance(each, states[periods]) for each in states[periods + 1 :]]
        at = next((k for k, d in enumerate(distances) if d < REPEATED), int(np.argmin(distances)))
        period = times[periods + 1 + at] - times[periods]
        self.scale[-1] = period
        return np.append(states[periods + 1 + at], period)

    def _distance(self, one: Floats, other: Floats) -> float:
        return float(np.max(np.abs(one - other) / self.scale[:-1]))

    def __call__(self, state: Floats, parameter: float) -> Image:
        """Return the image of a state and a period, with its derivative."""
        x, period = state[:-1], float(state[-1])
        if not 0.0 < period < 100.0 * self.scale[-1]:
            raise SimulationError(f"orbit: a period of {period:.4g} s is none. Start nearer.")
        found, propagator = self.propagated(x, parameter, period)
        image = self.pack(found, parameter, period)
        n = x.size
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n], matrix[:n, n] = propagator, self._rates(image, parameter, period)
        phase, matrix[n, :n] = self._phase(x, parameter)
        matrix[n, :n] *= self.scale[-1]
        matrix[n, n] = 1.0
        contacts = self._changes(found.log, period)
        return Image(np.append(image, period + self.scale[-1] * phase), matrix, contacts, period)

    def _rates(self, x: Floats, parameter: float, period: float) -> Floats:
        """Return the rates of a state of the map, by a difference over a short time."""
        short = SHORT * period
        return (self.pack(self.passage(x, parameter, short), parameter, short) - x) / short

    def _phase(self, x: Floats, parameter: float) -> tuple[float, Floats]:
        """Return the penetration of the section's contact over its natural size, and its derivative, shape [state]."""
        system = self.member(parameter).flow.packed.system
        assert self._section is not None
        k = self._section[0]
        size, free = float(system.contacts[k].natural), len(self.free)
        slopes = np.zeros(x.size)
        for c in range(free):
            ends = []
            for sign in (1.0, -1.0):
                moved = x.copy()
                moved[c] += sign * 1e-3 * self.scale[c]
                ends.append(self._penetration(moved, parameter, k))
            slopes[c] = (ends[0] - ends[1]) / (2e-3 * self.scale[c] * size)
        return self._penetration(x, parameter, k) / size, slopes

    def _penetration(self, x: Floats, parameter: float, k: int) -> float:
        flow = self.member(parameter).flow
        system, full = flow.packed.system, np.zeros(flow.size)
        full[self.free] = x[: len(self.free)]
        loads = make_loads(system)
        e = int(system.contacts[k].element)
        dispatch.contact_kinematics(system, e, 0.0, full, make_branch(system), loads)
        return float(loads.contacts[k, PENETRATION])

    def _changes(self, log: Floats, period: float) -> NDArray[np.int64]:
        """Return the contact changes over the period, that of the section first and once."""
        assert self._section is not None
        contact, change = self._section
        near = np.minimum(log[:, 0], period - log[:, 0]) < AT_SECTION * period
        own = (log[:, 1] == contact) & (log[:, 2] == change) & near
        return np.vstack([[[contact, int(change)]], log[~own, 1:3]]).astype(np.int64)
