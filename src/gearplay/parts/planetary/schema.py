"""Planetary sets: one table for sun, ring, carrier and planets, with pins and meshes."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Final, Literal

from pydantic import BeforeValidator, Field, model_validator

from gearplay.parts.bearing.schema import Bearing
from gearplay.parts.drive.schema import SpeedDrive
from gearplay.parts.mesh.backlash import Backlash, CenterDistance
from gearplay.parts.mesh.schema import (
    FRICTION_SPEED,
    Damping,
    ErrorTerm,
    Mesh,
    Module,
    PlanetMesh,
    PressureAngle,
    TipContact,
    ToothContact,
)
from gearplay.parts.mesh.stiffness import Stiffness
from gearplay.parts.mesh.wear import FlankWear
from gearplay.parts.planetary.members import Eccentricity, Member, PinError, Planets, Toothed, problems_of
from gearplay.parts.planetary.names import MEMBERS, MOST_PLANETS
from gearplay.parts.rotor.allowance import DistanceAllowance, allowance_middle
from gearplay.parts.rotor.gear import Runout
from gearplay.parts.rotor.schema import POSITION_TOLERANCE, Coordinate, Rotor, place_words
from gearplay.parts.sleeve.schema import MOST_CLEARANCE, Sleeve
from gearplay.parts.support.schema import Support
from gearplay.schema.fields import Listed, Measure, Part, Problem, is_absent, refuse
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair
from gearplay.vocabulary import quantities as q

FIT: Final = 1e-6
"""Part of a tooth by which a planet may be off where teeth mesh."""

SHARED: Final = (
    "module", "pressure_angle", "center_distance", "center_distance_allowance", "backlash", "damping",
    "transmission_error", "friction_coefficient", "friction_speed", "contact", "tip_contact", "wear",
)  # fmt: skip
"""Fields that every mesh of a set has of it."""
SEATS: Final = ("pin", "support", "bearing")
"""Fields of how planets sit on their pins, of which a set has one."""


def _usually(**usual: str) -> BeforeValidator:
    """Return a validator that fills in what a part of a set is where its table says nothing."""
    return BeforeValidator(lambda given: {**usual, **given} if isinstance(given, Mapping) else given)


class Planetary(Part):
    """A planetary set: sun, planets on a carrier, ring.

    It stands for the rotors ``NAME.sun``, ``NAME.ring``, ``NAME.carrier`` and ``NAME.planet1`` ..., the pins of the planets on
    the carrier (sleeves by `pin`, elastic supports by `support`, or rolling bearings by `bearing`) and the meshes of every
    planet with sun and ring. The member with a drive is the input: from it power goes through the planets to the other side.
    """

    module: Module
    pressure_angle: PressureAngle = math.radians(20.0)
    center_distance: CenterDistance | None = Field(default=None, exclude_if=is_absent)
    center_distance_allowance: (
        Annotated[
            DistanceAllowance,
            Field(description="of the centre distance: a class of DIN 3964, as js7, or upper and lower"),
        ]
        | None
    ) = Field(default=None, exclude_if=is_absent)
    backlash: Annotated[Backlash, Field(description="of every mesh")] | None = None
    stiffness: Annotated[Stiffness | None, Field(description="of both kinds of mesh")] = None
    sun_planet: Annotated[Stiffness | None, Field(description="stiffness of the sun's meshes")] = None
    planet_ring: Annotated[Stiffness | None, Field(description="stiffness of the ring's meshes")] = None
    contact: ToothContact = "mesh"
    tip_contact: TipContact = True
    wear: FlankWear | None = Field(default=None, exclude_if=is_absent)
    damping: Damping = Damping.model_construct()
    transmission_error: Annotated[
        tuple[ErrorTerm, ...], Listed(0, 64, "terms of the static transmission error of every mesh")
    ] = ()
    friction_coefficient: Annotated[
        float, Measure(None, "coefficient of friction of the teeth", ge=0.0, le=1.0)
    ] = 0.0
    friction_speed: Annotated[
        float, Measure(q.SPEED, "sliding speed of the flanks from which on friction is full", gt=0.0)
    ] = FRICTION_SPEED
    sun: Toothed
    planets: Planets
    ring: Toothed
    carrier: Member
    pin: Annotated[
        Sleeve | None,
        _usually(rotor_side="bush"),
        Field(description="sleeve of every planet on its pin; the planet is the bush if not given"),
    ] = None
    support: Annotated[Support | None, Field(description="elastic pin of every planet, instead")] = None
    bearing: Annotated[
        Bearing | None,
        _usually(rotor_ring="outer"),
        Field(
            description="rolling bearing of every planet on its pin, instead; the planet has the outer ring if not given",
            exclude_if=is_absent,
        ),
    ] = None
    pin_errors: Annotated[tuple[PinError, ...], Listed(0, 24, "pins that are off their place")] = ()
    eccentricities: Annotated[tuple[Eccentricity, ...], Listed(0, 24, "planets with their own runout")] = ()
    position: Annotated[
        tuple[Coordinate, Coordinate],
        Listed(2, 2, "centre of the set"),
        Field(exclude_if=lambda at: not any(at)),
    ] = (0.0, 0.0)

    @model_validator(mode="after")
    def _check(self) -> "Planetary":
        refuse(self._problems())
        return self

    @property
    def distance(self) -> float:
        """Distance [m] of the planets' centres from that of the set: given, or that of sun and planet without backlash."""
        if self.center_distance is not None:
            return self.center_distance + allowance_middle(self.center_distance_allowance)
        if not self._is_drawn:
            return 0.5 * self.module * (self.sun.teeth + self.planets.teeth)
        return GearPair(self._gear(self.sun), self._gear(self.planets), math.nan).shifted_distance

    @property
    def _is_drawn(self) -> bool:
        """Whether the centre distance need not be that of the reference circles."""
        parts = (self.sun, self.planets, self.ring)
        return self.center_distance is not None or any(
            each.profile_shift or each.helix_angle for each in parts
        )

    def _gear(self, part: Toothed | Planets, *, internal: bool = False) -> DrawnGear:
        return part.drawing(self.module, self.pressure_angle, part.teeth, internal=internal)

    @property
    def input(self) -> Literal["sun", "ring", "carrier"]:
        """The member that drives: with a drive that turns it; the sun where none has."""
        for name in MEMBERS:
            drive = getattr(self, name).drive
            if drive is not None and not (isinstance(drive, SpeedDrive) and drive.speed == 0.0):
                return name
        return "sun"

    def _problems(self) -> Iterator[Problem]:
        for kind in ("sun_planet", "planet_ring"):
            if self.stiffness is None and getattr(self, kind) is None:
                rule = "is required, or stiffness for both kinds of mesh"
                yield Problem((kind,), rule, "Give one")
            if self.stiffness is not None and getattr(self, kind) is not None:
                yield Problem((kind,), "must not be given together with stiffness", "Remove one of the two")
        given = [part for part in SEATS if getattr(self, part) is not None]
        if not given:
            rule = f"is required, or {' or '.join(SEATS[1:])}"
            yield Problem((SEATS[0],), rule, "Say how the planets sit on their pins")
        elif len(given) > 1:
            rule = f"must not be given together with {given[1]}"
            yield Problem((given[0],), rule, "Say how the planets sit on their pins")
        for part in SEATS:
            held = getattr(self, part)
            if held is not None and held.on is not None:
                yield Problem((part, "on"), "must not be given: pins are on the carrier", "Remove it")
            if held is not None and any(held.offset):
                yield Problem((part, "offset"), "must not be given for all pins at once", "Use pin_errors")
        if self.support is not None and self.support.stiffness is None:
            yield Problem(("support", "stiffness"), "is required of a pin", "Give it along both axes")
        if self.sun_planet or self.planet_ring or self.stiffness:
            yield from problems_of(
                lambda: self._mesh(driver="sun", driven="planet", stiffness=self._stiffness("sun"))
            )
        yield from self._misfits()
        yield from self._clearance_problems()
        for field in ("pin_errors", "eccentricities"):
            named = [entry.planet for entry in getattr(self, field)]
            for k, planet in enumerate(named):
                if planet > self.planets.count:
                    rule = f"must be at most {self.planets.count}, the number of planets"
                    yield Problem((field, k, "planet"), rule, "Correct it")
                elif planet in named[:k]:
                    yield Problem((field, k, "planet"), "must not be named twice", "Remove one of the two")

    def _clearance_problems(self) -> Iterator[Problem]:
        for k, error in enumerate(self.pin_errors):
            at = ("pin_errors", k, "clearance")
            if error.clearance and self.pin is None:
                yield Problem(at, "must not be given without pin, whose sleeves have one", "Remove it")
            elif self.pin is not None and self.pin.radial_clearance + error.clearance > MOST_CLEARANCE:
                rule = f"must be at most {1e3 * MOST_CLEARANCE:g} mm together with pin.radial_clearance"
                yield Problem(at, rule, "Lower one of the two")

    def _misfits(self) -> Iterator[Problem]:
        """Check assembly: centre distances, spacing, contact of planets."""
        z_s, z_p, z_r = self.sun.teeth, self.planets.teeth, self.ring.teeth
        if self._is_drawn:
            problem = self._distance_problem()
            if problem is not None:
                yield problem
                return
        elif z_r != z_s + 2 * z_p:
            rule = (
                f"must be {z_s + 2 * z_p}, since the planets are {z_s} + {z_p} = {z_s + z_p} half modules from the sun's centre "
                f"and {z_r} - {z_p} = {z_r - z_p} from the ring's"
            )
            yield Problem(("ring", "teeth"), rule, "Correct a number of teeth: ring = sun + 2 x planet")
            return
        planets, count = self.planets, self.planets.count
        if planets.angles is not None and len(planets.angles) != count:
            rule = f"must have {count} items, one for each planet"
            yield Problem(("planets", "angles"), rule, "Add or remove items, or correct count")
            return
        teeth = z_s + z_r
        if planets.angles is None:
            if teeth % count:
                rule = (
                    f"must divide the teeth of sun and ring, {z_s} + {z_r} = {teeth}, for equal spacing; "
                    f"{teeth}/{count} = {teeth / count:.6g}"
                )
                cure = f"Choose of {self._counts()} planets, other teeth, or give angles"
                yield Problem(("planets", "count"), rule, cure)
                return
        else:
            radius = self.distance
            for k, angle in enumerate(planets.angles):
                steps = (angle - planets.angles[0]) * teeth / (2.0 * math.pi)
                off = abs(steps - round(steps))
                if off > FIT and off * 2.0 * math.pi / teeth * radius > POSITION_TOLERANCE:
                    fit = math.degrees(planets.angles[0] + round(steps) * 2.0 * math.pi / teeth)
                    rule = (
                        f"must be a whole number of steps of 360/({z_s} + {z_r}) = {360.0 / teeth:.6g} deg "
                        f"from planet 1, so that teeth mesh; it is {steps:.6g}"
                    )
                    place = place_words(
                        radius * math.cos(math.radians(fit)), radius * math.sin(math.radians(fit))
                    )
                    cure = f"The nearest is {fit:.10g} deg, its centre at {place} from the sun's"
                    yield Problem(("planets", "angles", k), rule, cure)
        tips = self._tips
        places = sorted(angle % (2.0 * math.pi) for angle in planets.directions)
        gaps = [
            later - earlier
            for earlier, later in zip(places, [*places[1:], places[0] + 2.0 * math.pi], strict=True)
        ]
        apart = self._spaced(min(gaps)) if count > 1 else math.inf
        if apart <= tips:
            rule = (
                f"must leave neighbours apart: their centres are {1e3 * apart:.4g} mm apart, their tip diameter is "
                f"{1e3 * tips:.4g} mm"
            )
            at = ("planets", "count") if planets.angles is None else ("planets", "angles")
            equal = planets.angles is None
            cure = f"Choose of {self._counts()} planets" if equal else "Take fewer planets, or move them"
            yield Problem(at, rule, f"{cure}, or take smaller ones")

    @property
    def _tips(self) -> float:
        """Tip diameter [m] of a planet."""
        return 2.0 * self._gear(self.planets).tip

    def _counts(self) -> str:
        """Return the numbers of equally spaced planets that mesh with sun and ring and whose tips are apart."""
        teeth = self.sun.teeth + self.ring.teeth
        counts = [n for n in range(1, MOST_PLANETS + 1) if teeth % n == 0]
        return ", ".join(str(n) for n in counts if n == 1 or self._spaced(2.0 * math.pi / n) > self._tips)

    def _spaced(self, angle: float) -> float:
        """Return the distance [m] of the centres of planets an angle [rad] apart."""
        return 2.0 * self.distance * math.sin(0.5 * min(angle, math.pi))

    def _distance_problem(self) -> Problem | None:
        """Return the problem of a distance of drawn gears: teeth that do not reach each other or interfere."""
        sun, planet, ring = (
            self._gear(self.sun),
            self._gear(self.planets),
            self._gear(self.ring, internal=True),
        )
        at = ("center_distance",)
        for one, pair in (
            ("sun", GearPair(sun, planet, self.distance)),
            ("ring", GearPair(planet, ring, self.distance)),
        ):
            least, most = pair.range_of_distances
            if not least < self.distance < most:
                rule = (
                    f"must be between {1e3 * least:.6g} and {1e3 * most:.6g} mm for planets to mesh with the {one}; it is "
                    f"{1e3 * self.distance:.6g} mm"
                )
                return Problem(at, rule, "Check numbers of teeth, profile shifts and tip diameters")
        return None

    def parts(
        self, name: str
    ) -> tuple[dict[str, Rotor], dict[str, Sleeve], dict[str, Support], dict[str, Bearing], list[Mesh]]:
        """Return the rotors, sleeves, supports and bearings by name and the meshes of the expanded set ``name``."""
        called = {member: f"{name}.{member}" for member in MEMBERS}
        rotors = {
            called["sun"]: self.sun.rotor(
                self.position, teeth=self.sun.teeth, runout=self.sun.runout, **self.sun.toothing()
            ),
            called["ring"]: self.ring.rotor(
                self.position,
                teeth=self.ring.teeth,
                internal=True,
                runout=self.ring.runout,
                **self.ring.toothing(),
            ),
            called["carrier"]: self.carrier.rotor(self.position),
        }
        members = {member: getattr(self, member) for member in MEMBERS}
        sleeves = {called[m]: part.sleeve for m, part in members.items() if part.sleeve is not None}
        supports = {called[m]: part.support for m, part in members.items() if part.support is not None}
        bearings: dict[str, Bearing] = {}
        shared = {"mass", "inertia", "teeth", "radial_damping", "load", "material", "temperature"}
        runouts = {entry.planet: entry for entry in self.eccentricities}
        errors = {entry.planet: entry for entry in self.pin_errors}
        names = [f"{name}.planet{k}" for k in range(1, self.planets.count + 1)]
        for k, (planet, direction) in enumerate(zip(names, self.planets.directions, strict=True), start=1):
            c, s = math.cos(direction), math.sin(direction)
            own = runouts.get(k)
            runout = (
                Runout(amplitude=own.amplitude, phase=own.phase) if own is not None else self.planets.runout
            )
            A = self.distance
            rotors[planet] = Rotor.model_validate(
                {field: getattr(self.planets, field) for field in shared}
                | {"position": (self.position[0] + A * c, self.position[1] + A * s), "runout": runout}
                | self.planets.toothing()
            )
            off = errors.get(k, PinError(planet=k))
            place = {
                "on": called["carrier"],
                "offset": (off.radial * c - off.tangential * s, off.radial * s + off.tangential * c),
            }
            if self.pin is not None:
                play = {"radial_clearance": self.pin.radial_clearance + off.clearance}
                sleeves[planet] = self.pin.model_copy(update=place | play)
            if self.support is not None:
                supports[planet] = self.support.model_copy(update=place)
            if self.bearing is not None:
                bearings[planet] = self.bearing.model_copy(update=place)
        return rotors, sleeves, supports, bearings, self._meshes(called, names)

    def _meshes(self, called: Mapping[str, str], planets: list[str]) -> list[Mesh]:
        # A carrier drives the planets along the member that stands still; they drive the other one.
        along = "sun" if self.sun.stands and not self.ring.stands else "ring"
        first = along if self.input == "carrier" else self.input
        last = "ring" if first == "sun" else "sun"
        # A planet's two flanks are half a pitch apart, and so are tooth and gap on opposite sides of an odd one.
        # Pairs of teeth have both from the places of the teeth.
        half_pitch = math.pi if self.planets.teeth % 2 == 0 and self.contact == "mesh" else 0.0
        return [
            self._mesh(
                driver=called[first] if incoming else planet,
                driven=planet if incoming else called[last],
                stiffness=self._stiffness(first if incoming else last),
                phase=0.0 if incoming else half_pitch,
            )
            for incoming in (True, False)
            for planet in planets
        ]

    def _stiffness(self, member: str) -> object:
        """Return the stiffness of the meshes with the sun, or with the ring."""
        return self.stiffness or (self.sun_planet if member == "sun" else self.planet_ring)

    def _mesh(self, **own: object) -> Mesh:
        shared = {name: getattr(self, name) for name in SHARED}
        if self._is_drawn and self.center_distance is None:
            shared["center_distance"] = self.distance
        return PlanetMesh.model_validate(shared | own)
