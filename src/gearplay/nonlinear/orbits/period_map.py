"""Period map: the state over one period of the excitation, with its exact derivative."""

import math
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import housing_motion
from gearplay.kernels.layout import DRIVE_SPEED
from gearplay.model.case import Case
from gearplay.model.families import Family
from gearplay.model.pack import Packed
from gearplay.model.reading import replace
from gearplay.parts.planetary.paths import settable_path
from gearplay.parts.registry import MESH, POSITIONER, recurrence_rates
from gearplay.solver.flow import Flow, Passage
from gearplay.solver.frames import CarrierFrames
from gearplay.vocabulary.errors import NO_VALUE, InputError

Floats = NDArray[np.float64]
MOST_PERIODS = 2000
"""Most mesh periods that a common period of all excitations may have."""
LOOSEST = 1e-9
"""Error tolerance [1] of orbits, exponents and kinds of motion, unless that of the case is less: orbits are closed to 1e-9."""


class Image(NamedTuple):
    """Image of a state under a map: the state, shape [state]; the derivative, shape [image, state]; the contact changes over
    the period as (contact, 1 onset / 0 release), shape [change, 2]; the period [s] where it is the last unknown, else NaN.
    """

    state: Floats
    matrix: Floats
    contacts: NDArray[np.int64]
    period: float = math.nan


class PeriodMap(Protocol):
    """A map x -> P(x; parameter) over one period, of any system.

    ``scale`` are the natural sizes of the state's entries, shape [state].
    """

    scale: Floats

    def __call__(self, state: Floats, parameter: float) -> Image:
        """Return the image of a state."""
        ...


class Member(NamedTuple):
    """Flow of a case, and the period [s] of its sections."""

    flow: Flow
    period: float


def sharp(case: Case) -> Case:
    """Return a case whose tolerance is no looser than `LOOSEST`.

    >>> from gearplay.model.reading import load_case
    >>> sharp(load_case("han2021")).run.tolerance
    1e-09
    """
    return case if case.run.tolerance <= LOOSEST else replace(case, {"run.tolerance": LOOSEST})


class StrobeMap:
    """The map of a case over a period of its excitation, in the states that are not prescribed.

    A planetary set is described in the frame of its carrier (`solver.frames`).

    ``family`` returns the case at a parameter. Impact speeds stored for sleeves in contact at the section follow the free
    states: those of closed sleeves are part of the state, those of open ones are 0.

    Raises `InputError` for a case whose excitation has no period: a speed must be prescribed, without a ramp.
    """

    def __init__(self, family: Family, parameter: float) -> None:
        self.family = family
        self._kept: dict[float, Member] = {}
        first = self.member(parameter).flow
        self.free, self.impact_contacts = first.free, first.impact_contacts
        self.scale = np.concatenate([first.natural[self.free], first.sizes[first.size :]])
        """Natural sizes of the free states, then of stored impact speeds, shape [state]."""

    def member(self, parameter: float) -> Member:
        """Return the flow and the period [s] at a parameter."""
        if parameter not in self._kept:
            if len(self._kept) > 16:
                self._kept.clear()
            flow = Flow(self.family(parameter))
            self._kept[parameter] = Member(flow, common_period(flow.packed))
        return self._kept[parameter]

    def start(self, parameter: float) -> Floats:
        """Return the case's own initial state as a state of the map."""
        flow = self.member(parameter).flow
        return np.concatenate([flow.start()[self.free], np.zeros(flow.impact_count)])

    def settle(self, state: Floats, parameter: float, periods: int) -> Floats:
        """Return the state after some periods."""
        for _ in range(periods):
            period = self.member(parameter).period
            state = self.pack(self.passage(state, parameter, period), parameter, period)
        return state

    def passage(
        self, state: Floats, parameter: float, period: float, changes: Floats | None = None
    ) -> Passage:
        """Return the integration over a period [s]."""
        flow, free = self.member(parameter).flow, len(self.free)
        full = np.zeros(flow.size)
        full[self.free] = state[:free]
        return flow.go(
            full, period, impact_speeds=state[free:] if flow.impact_count else None, changes=changes
        )

    def pack(self, found: Passage, parameter: float, period: float) -> Floats:
        """Return the end of an integration over a period [s] as a state of the map."""
        held, flow = found.closed[self.impact_contacts], self.member(parameter).flow
        seen = flow.frames.seen(period, found.state)
        return np.concatenate([seen[self.free], np.where(held, found.impact_speeds, 0.0)])

    def __call__(self, state: Floats, parameter: float) -> Image:
        """Return the image of a state after one period, with the exact derivative."""
        period = self.member(parameter).period
        found, matrix = self.propagated(state, parameter, period)
        return Image(self.pack(found, parameter, period), matrix, found.log[:, 1:3].astype(np.int64))

    def propagated(self, state: Floats, parameter: float, period: float) -> tuple[Passage, Floats]:
        """Return the integration over a period [s] and its exact derivative, shape [image, state]."""
        flow, free = self.member(parameter).flow, len(self.free)
        changes = np.zeros((state.size, flow.size + flow.impact_count))
        changes[np.arange(free), self.free] = 1.0
        held = state[free:] > 0.0
        changes[free + np.arange(flow.impact_count)[held], flow.size + np.arange(flow.impact_count)[held]] = (
            1.0
        )
        found = self.passage(state, parameter, period, changes)
        rows = np.concatenate([self.free, flow.size + np.arange(flow.impact_count)])
        moved = flow.frames.turned_back(period, found.changes)
        matrix = moved[:, rows].T.copy()
        matrix[free:][~found.closed[flow.impact_contacts]] = 0.0
        return found, matrix


def section_period(packed: Packed, which: str | float = "common") -> float:
    """Return the time [s] between two sections: "common" of all excitation, of the first "mesh", of its driver ("shaft"), or [s].

    Raises `InputError` where there is none.
    """
    if not isinstance(which, str):
        if not (math.isfinite(which) and which > 0.0):
            raise InputError.of("period", which, "must be above 0 s", "Correct it")
        return float(which)
    if which == "common":
        return common_period(packed)
    if which not in ("mesh", "shaft"):
        raise InputError.of("period", which, "must be common, mesh, shaft or a time in s", "Choose one")
    _check_prescribed(packed)
    if not packed.system.records[MESH].size:
        raise InputError.of(
            "period", which, "must be common or a time in s in a case without a mesh", "Say common"
        )
    mesh, speeds = packed.system.records[MESH][0], packed.system.rotors["nominal_speed"]
    rate = abs(float(speeds[mesh["driver"]]))
    if which == "mesh":
        frame = float(speeds[mesh["frame"]]) if mesh["frame"] >= 0 else 0.0
        rate = abs(float(mesh["z_driver"] * (speeds[mesh["driver"]] - frame)))
    if rate == 0.0:
        raise InputError.of("drive.speed", 0.0, "must not be 0 for a periodic motion", "Choose a speed")
    return 2.0 * math.pi / rate


def _check_prescribed(packed: Packed) -> None:
    """Raise `InputError` where gears mesh and no speed is prescribed, or one with a ramp."""
    rotors: Any = packed.system.rotors
    prescribed = [i for i in range(rotors.size) if rotors[i].drive == DRIVE_SPEED]
    meshes = packed.system.records[MESH].size
    rule = "must be a prescribed speed without a ramp where gears mesh, for a motion that can be periodic"
    if not prescribed and meshes:
        cure = "Prescribe a speed, or give the period in s"
        raise InputError.of("rotors", "none with a drive of kind speed", rule, cure)
    for i in prescribed:
        ramp, name = float(rotors[i].ramp_time), packed.rotor_names[i]
        if ramp > 0.0:
            sets = {each.partition(".")[0]: None for each in packed.rotor_names if "." in each}
            path = settable_path({"planetary": sets}, f"rotors.{name}.drive")
            cure = f"Set {path}.ramp to 0 s"
            raise InputError.of(path, f"speed with a ramp of {ramp:g} s", rule, cure)


def common_period(packed: Packed) -> float:
    """Return the common period [s] of all excitation.

    That is a number of periods of the first mesh: stiffness and errors repeat with their mesh, runouts and unbalances with their
    rotor, ripples and terms of torques with their order or frequency, the housing with its own. A coaxial planetary set is seen
    from its turning carrier: its pins stand still there, runouts turn against it, gravity and uneven supports turn the other way.

    Raises `InputError` where there is none.
    """
    _check_prescribed(packed)
    rates = [rate for rate in excitation_rates(packed) if rate > 0.0]
    if not rates:
        rule = "must not be 0 for a periodic motion where nothing else excites it"
        raise InputError.of("drive.speed", 0.0, rule, "Choose a speed")
    base = rates[0]
    for count in range(1, MOST_PERIODS + 1):
        turns = np.array(rates) * count / base
        if np.all(np.abs(turns - np.round(turns)) < 1e-9 * np.maximum(turns, 1.0)):
            return float(2.0 * math.pi * count / base)
    rule = f"must have a common period of at most {MOST_PERIODS} periods of the first mesh, or of what excites it"
    cure = "Leave out what does not repeat with the mesh (runout, unbalance, ripple, terms, base), or change numbers of teeth"
    raise InputError.of("excitation", NO_VALUE, rule, cure)


def excitation_rates(packed: Packed) -> list[float]:
    """Return the angular frequencies [rad/s] of all excitation, the first mesh's first."""
    rotors: Any = packed.system.rotors
    frames = CarrierFrames(packed.system)
    speeds, relative = rotors.nominal_speed, np.abs(rotors.nominal_speed - frames.speeds)
    rates = recurrence_rates(packed.system, speeds, frames.speeds)
    loops = packed.system.records[POSITIONER]
    slow = loops[(loops["sample_time"] > 0.0) & (loops["every"] > 1)]
    rates += (2.0 * math.pi / (slow["sample_time"] * slow["every"])).tolist()
    rates += [math.nan] * int(np.sum(rotors.set_points > 0))
    rates += packed.system.terms[rotors.wave[rotors.wave >= 0], 0].tolist()
    if np.any(np.isnan(rates)):
        rule = "must not be given for a motion that can be periodic"
        where = "a table, step or trapezoid over time"
        raise InputError.of("rotors", where, rule, "Give terms or a sine, or remove it")
    rates += [abs(speeds[i]) for i in range(rotors.size) if rotors[i].ripple_count > 0]
    rates += [
        relative[i] for i in range(rotors.size) if rotors[i].unbalance > 0.0 and rotors[i].inv_mass > 0.0
    ]
    rates += np.abs(frames.speeds[frames.breaks]).tolist()
    kind, rate = packed.system.base[housing_motion.KIND], float(packed.system.base[housing_motion.RATE])
    if kind not in (housing_motion.NONE, housing_motion.HARMONIC):
        rule = "must be harmonic for a motion that can be periodic"
        raise InputError.of("base.acceleration.kind", NO_VALUE, rule, "Choose harmonic, or remove the base")
    rates += [rate] if kind == housing_motion.HARMONIC else []
    return [float(rate) for rate in rates]
