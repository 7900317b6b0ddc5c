"""Key numbers of the output shaft: speed ripple, torque ripple, transmission error, wind-up, efficiency, rattle."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.initial import initial_state
from gearplay.model.pack import Packed, pack
from gearplay.model.perfect import perfect_case
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.mesh.train.traversal import rotor_order
from gearplay.pictures.words import significant
from gearplay.results.contacts import ContactTable, contacts_of
from gearplay.solver.trajectory import Trajectory, all_columns
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import OUTPUT_STATISTICS

Floats = NDArray[np.float64]
Wanted = Sequence[tuple[str, str]]
Samples = Callable[[Wanted], Floats]
"""Samples [SI] of signals, given as (signal, element), shape [time, signal]."""

MOST_SAMPLES, MOST_OF_MEMBER = 1_000_000, 200_000
"""Samples of all members together, and of each; a longer record is sampled less often."""

DEGREE = math.degrees(1.0)
SCALES = {
    "rad": (("deg", DEGREE), ("arcmin", 60.0 * DEGREE), ("arcsec", 3600.0 * DEGREE)),
    "W": (("kW", 1e-3), ("W", 1.0), ("mW", 1e3), ("uW", 1e6)),
}
"""Display units and factors, the first in which a value is at least 1."""


@dataclass(frozen=True)
class OutputShaft:
    """Motion and load of one shaft relative to the input, of the samples of a run.

    Attributes
    ----------
    rotor, input
        Names of the output and of the input.
    ratio
        Speed of the output per that of the input by rolling; NaN where the train does not fix it.
    each : mapping
        Statistics [SI], shape [member], NaN where one is not defined; those of impacts are of all members together, shape
        [1]. Names and units are in `gearplay.vocabulary.quantities.OUTPUT_STATISTICS`.
    start : float
        Output less ratio times input where drive flanks of perfect, centred gears touch [rad]; NaN without a ratio.
    frictionless : bool
        Whether neither teeth nor sleeves have friction in the case, so that the efficiency is one of damping alone.

    """

    rotor: str
    input: str
    ratio: float
    each: Mapping[str, Floats]
    start: float
    frictionless: bool = False

    @cached_property
    def values(self) -> dict[str, float]:
        """Means of the statistics over the members [SI]."""
        return {name: _mean(found) for name, found in self.each.items()}

    @cached_property
    def spread(self) -> dict[str, float]:
        """Standard deviations over the members [SI], NaN for fewer than two."""
        known = {name: found[np.isfinite(found)] for name, found in self.each.items()}
        return {n: float(np.std(found, ddof=1)) if found.size > 1 else math.nan for n, found in known.items()}

    @property
    def title(self) -> str:
        """Names of the shaft and the input with their ratio."""
        if self.rotor == self.input:
            return f"Shaft {self.rotor}"
        if not math.isfinite(self.ratio):
            return f"Output shaft {self.rotor}, driven by {self.input}"
        if self.ratio == 0.0:
            return f"Output shaft {self.rotor}, driven by {self.input}, held"
        slower = abs(self.ratio) <= 1.0
        words = f"{1.0 / self.ratio:.5g} : 1" if slower else f"1 : {self.ratio:.5g}"
        return f"Output shaft {self.rotor}, driven by {self.input}, ratio {words}"

    def rows(self) -> list[tuple[str, str]]:
        """Return the lines of a table: name and value in display units, undefined statistics left out."""
        found = []
        for name, quantity in OUTPUT_STATISTICS.items():
            value = self.values[name]
            if not math.isfinite(value):
                continue
            text = self._shown(name, value)
            if name == "speed_ripple" and abs(self.values["mean_speed"]) > 0.0:
                share = 100.0 * value / abs(self.values["mean_speed"])
                text += f" ({significant(share)} %)" if share < 1000.0 else ""
            found.append((quantity.long_name, text))
        return found

    @property
    def turns(self) -> bool:
        """Whether the shaft turns on, so that its mean speed is more than half its peak-to-peak speed; not where it hunts."""
        return turns_on(self.values["mean_speed"], self.values["speed_ripple"])

    @property
    def note(self) -> str:
        """Note on the efficiency; empty where the case has friction of teeth or sleeves."""
        if not (math.isfinite(self.values["efficiency"]) and self.frictionless):
            return ""
        return "The efficiency is of damping alone: the case has no friction of teeth and sleeves."

    def _shown(self, name: str, value: float) -> str:
        quantity, spread = OUTPUT_STATISTICS[name], self.spread[name]
        largest = max(abs(value), spread if math.isfinite(spread) else 0.0)
        unit, factor = quantity.display_unit, quantity.display_factor
        if quantity.unit in SCALES and largest > 0.0:
            unit, factor = scale_of(quantity.unit, largest)
        more = f" ± {significant(factor * spread)}" if math.isfinite(spread) and spread > 0.0 else ""
        digits = 4 if name == "efficiency" else 3
        return f"{significant(factor * value, digits)}{more} {unit}"


def scale_of(unit: str, largest: float) -> tuple[str, float]:
    """Return the display unit of angles [rad] or powers [W] up to ``largest``, and its number in one SI unit."""
    return next((each for each in SCALES[unit] if largest * each[1] >= 1.0), SCALES[unit][-1])


def turns_on(mean: float, ripple: float) -> bool:
    """Return whether a speed of this mean and peak-to-peak value [rad/s] keeps its direction, about."""
    return abs(mean) > 0.5 * ripple


def _mean(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.mean(known)) if known.size else math.nan


def input_of(case: Case) -> str:
    """Return the driven rotor, the first of several; the first rotor of a train without a drive."""
    driven = [name for name, rotor in case.rotors.items() if rotor.drive is not None]
    return (driven or list(case.rotors))[0]


def output_of(case: Case) -> str:
    """Return the loaded rotor that is not the input, of several the one with the largest load at nominal speed.

    Of a train without loads the rotor that comes last on the way from the input.
    """
    lead = input_of(case)
    speeds = np.abs(rolling.nominal_speeds(case))
    loads = {
        name: load.torque
        + load.friction
        + sum(abs(term.amplitude) for term in load.terms)
        + load.drag * (speed or 1.0)
        for (name, rotor), speed in zip(case.rotors.items(), speeds.tolist(), strict=True)
        if name != lead and (load := rotor.load) != type(load)()
    }
    if loads:
        return max(loads, key=lambda name: loads[name])
    others = [name for name in rotor_order(case) if name != lead and geometry.carrier_of(case, name) is None]
    return (others or [lead])[-1]


def check_rotor(case: Case, rotor: str | None) -> None:
    """Raise `InputError` unless a name is that of a rotor of the case."""
    if rotor is not None and rotor not in case.rotors:
        cure = f"Choose from: {', '.join(case.rotors)}"
        raise InputError.of("output", rotor, "must be a rotor of the case", cure)


def stride_of(samples: Sequence[int]) -> int:
    """Return the stride of the samples to use, from the numbers of samples of the records."""
    return max(1, -(-sum(samples) // MOST_SAMPLES), -(-max(samples, default=0) // MOST_OF_MEMBER))


def ratio_of(case: Case, rotor: str, lead: str) -> float:
    """Return the speed of a rotor per that of another by rolling; NaN where they turn independently."""
    names, others = list(case.rotors), [r.drive for name, r in case.rotors.items() if name != lead]
    if any(drive is not None and drive.prescribes and drive.nominal_speed() != 0.0 for drive in others):
        return math.nan
    free = case.rotors[lead].model_copy(update={"drive": None})
    turns = rolling.free_turns(case.model_copy(update={"rotors": {**case.rotors, lead: free}}))
    own, other = turns[names.index(rotor)], turns[names.index(lead)]
    size = float(np.linalg.norm(other))
    if size < 1e-9:
        return math.nan
    ratio = float(own @ other) / size**2
    return ratio if np.allclose(own, ratio * other, atol=1e-9) else math.nan


def output_shaft(
    case: Case,
    packed: Packed,
    rotor: str | None,
    contacts: ContactTable,
    members: Sequence[tuple[float, Samples]],
) -> OutputShaft:
    """Return the key numbers of a shaft, `output_of` the case if None.

    ``members`` holds the rate of the samples of each member [Hz] and the function that returns them.

    Raises `InputError` for a rotor that the case does not have.
    """
    case = case.operating
    check_rotor(case, rotor)
    lead, at = input_of(case), rotor or output_of(case)
    ratio = ratio_of(case, at, lead)
    wanted = wanted_of(packed, at, lead)
    start = start_of(case, packed, at, lead, ratio) if math.isfinite(ratio) else math.nan
    each = [_member(case, at, lead, ratio, start, rate, samples(wanted)) for rate, samples in members]
    table = {name: np.array([found.get(name, math.nan) for found in each]) for name in OUTPUT_STATISTICS}
    table["impacts_per_second"], table["impact_power"] = _rattle(case, contacts)
    rubbing = [mesh.friction_coefficient for mesh in case.meshes]
    rubbing += [sleeve.friction_coefficient for sleeve in case.sleeves.values()]
    return OutputShaft(at, lead, ratio, table, start, frictionless=not any(rubbing))


def start_of(case: Case, packed: Packed, at: str, lead: str, ratio: float) -> float:
    """Return theta - ratio theta_lead [rad] where drive flanks of perfect, centred gears just touch.

    The transmission error counts from there; run-out and errors of teeth at the start do not shift it.
    """
    perfect = perfect_case(case)
    names = list(case.rotors)
    start = initial_state(perfect, packed if perfect is case else pack(perfect, moves=False))
    return float(start[3 * names.index(at) + 2] - ratio * start[3 * names.index(lead) + 2])


def shaft_of_runs(case: Case, packed: Packed, rotor: str | None, runs: Sequence[Trajectory]) -> OutputShaft:
    """Return the key numbers of the output shaft of members that were run, as `output_shaft` does."""
    stride = stride_of([run.samples.count for run in runs])
    members = [(run.sampling / stride, partial(run.thinned, stride=stride)) for run in runs]
    return output_shaft(case, packed, rotor, contacts_of(runs), members)


def wanted_of(packed: Packed, at: str, lead: str) -> list[tuple[str, str]]:
    """Return the signals, as (signal, element), behind the statistics of a shaft."""
    losses = [(c.signal, c.label) for c in all_columns(packed) if c.signal.endswith("_power_loss")]
    own = [(name, at) for name in ("omega", "theta", "load_torque", "drive_torque")]
    return [*own, ("theta", lead), *losses]


def _member(
    case: Case, at: str, lead: str, ratio: float, start: float, rate: float, values: Floats
) -> dict[str, float]:
    """Return the statistics of one member from its samples of `wanted_of`, shape [time, signal], at a rate [Hz]."""
    known = np.isfinite(values).all(axis=1)
    values = values if known.all() else values[known]
    if len(values) < 2:
        return {}
    omega, theta, load, drive, turned = values[:, :5].T
    given = case.rotors[at].load
    slip = np.clip(omega / given.friction_speed, -1.0, 1.0)
    brake = given.drag * omega + given.friction * 0.5 * slip * (3.0 - slip**2)
    found = {"mean_speed": float(np.mean(omega)), "speed_ripple": float(np.ptp(omega))}
    delivered = brake - load - drive
    inertia = case.rotors[at].inertia
    torque = 0.5 * (delivered[1:] + delivered[:-1]) + inertia * rate * np.diff(omega)
    turns = turns_on(found["mean_speed"], found["speed_ripple"])
    sense = math.copysign(1.0, found["mean_speed"] if turns else float(np.mean(torque)))
    if at != lead and math.isfinite(ratio):
        error = theta - ratio * turned - start
        found |= {"transmission_error": float(np.ptp(error)), "wind_up": -sense * float(np.mean(error))}
    if at == lead or (given == type(given)() and case.rotors[at].drive is None):  # nothing resists: no output
        return found
    power = float(np.mean(delivered * omega))
    lost = float(np.mean(np.ascontiguousarray(values[:, 5:]).sum(axis=1))) - float(np.mean(brake * omega))
    found |= {
        "mean_torque": sense * float(np.mean(torque)),
        "torque_ripple": float(np.ptp(torque)),
        "output_power": power,
    }
    guided = turns or any(getattr(rotor.drive, "over_time", None) for rotor in case.rotors.values())
    if power > 0.0 and guided:  # a shaft that hunts about a place delivers nothing on purpose
        found["efficiency"] = power / (power + max(lost, 0.0))
    return found


def _rattle(case: Case, contacts: ContactTable) -> tuple[Floats, Floats]:
    """Return impacts per second [1/s] and their kinetic energy per second [W] of all contacts, shape [1] each.

    The energy of an impact is m v^2 / 2 with the approach speed v and the effective mass 1/m = sum n^2/M + r^2/J of both bodies
    along the line of action, of a carrier with the mean of r^2 over all directions at its pin, half the square of the arm;
    bodies whose motion is prescribed or held have none.
    """
    free_mass = {n: 0.0 if geometry.is_held(case, n) else 1.0 / r.mass for n, r in case.rotors.items()}
    free_inertia = {n: 0.0 if r.is_prescribed else 1.0 / r.inertia for n, r in case.rotors.items()}
    mobility: dict[str, float] = {}
    centres = geometry.centres(case)
    for _, name, part in case.every_holder():
        both = free_mass[name]
        if part.on is not None:
            arm = math.dist(centres[name], centres[part.on])
            both += free_mass[part.on] + 0.5 * arm**2 * free_inertia[part.on]
        elements = (label for label in contacts.labels if label.startswith(f"{name}:element"))
        mobility |= dict.fromkeys((name, *elements), both)
    for j, mesh in enumerate(case.meshes):
        pairs = zip((mesh.driver, mesh.driven), geometry.base_radii(case, j), strict=True)
        bodies = [(geometry.rotor_of(case, name), radius) for name, radius in pairs]
        both = sum(free_mass[name] + radius**2 * free_inertia[name] for name, radius in bodies)
        mobility |= dict.fromkeys((f"{mesh.label}:drive", f"{mesh.label}:back"), both)
    for _, label, joint in case.named_joints():
        both = sum(factor**2 * free_inertia[name] for name, factor in joint.rolling().items())
        mobility |= dict.fromkeys((f"{label}:forward", f"{label}:backward"), both)
    rates, speeds = contacts.values["impacts_per_second"], contacts.values["rms_impact_speed"]
    power = sum(
        0.5 * rate * speed**2 / mobility[label]
        for label, rate, speed in zip(contacts.labels, rates, speeds, strict=True)
        if mobility.get(label, 0.0) > 0.0 and np.isfinite(rate) and np.isfinite(speed)
    )
    known = rates[np.isfinite(rates)]
    return np.array([float(known.sum())]), np.array([float(power)])
