"""Rolling bearings: balls or rollers between a rotor and the ground or a carrier."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field, model_validator

from gearplay.parts.assembly import Contact, blank
from gearplay.parts.bearing import law
from gearplay.parts.bearing.details import HuntCrossley, Ring, Wave, clearance_of_class
from gearplay.parts.bearing.faults import Dent, gaps_of, offsets_of
from gearplay.parts.bearing.geometry import (
    CATALOGUE,
    PassOrders,
    ball_stiffness,
    pass_orders,
    ranges_at,
)
from gearplay.parts.protocol import Holder, Packing
from gearplay.parts.sleeve.contact_laws import solved_dissipation
from gearplay.schema.fields import HertzStiffness, Listed, Measure, Offset, Problem, RotorName, refuse
from gearplay.schema.finding import Finding, micrometres
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError

TYPICAL_DEPTH = 1e-6
"""Penetration [m] at which a contact's angular frequency is estimated."""
AVERAGED = 240
"""Elements, at least, over which the mean law of a bearing is a sum."""
STEEL = (206e9, 0.3)
"""Modulus [Pa] and Poisson's ratio of bearing steel, for `groove_ratio`."""


class Bearing(Holder):
    """Balls or rollers between the ring of a rotor, the table's name, and that of the ground or of a carrier.

    Each element is a one-sided contact of stiffness ``stiffness`` between both rings, or that of a ball in grooves
    (``groove_ratio``, steel). Elements travel with the cage, which rolls without slip. ``internal_clearance`` is diametral.
    """

    kind: ClassVar[int] = law.KIND
    noun: ClassVar[str] = "bearing"
    has_clearance: ClassVar[bool] = True

    catalogue: (
        Annotated[str, Field(max_length=40, description="designation of a bearing whose geometry is known")]
        | None
    ) = None
    rolling_elements: (
        Annotated[int, Field(ge=2, le=1000, description="number of balls or rollers")] | None
    ) = None
    element_diameter: (
        Annotated[float, Measure(q.LENGTH, "diameter of a ball or roller", gt=0.0, le=10.0)] | None
    ) = None
    pitch_diameter: (
        Annotated[
            float, Measure(q.LENGTH, "diameter of the circle of the elements' centres", gt=0.0, le=100.0)
        ]
        | None
    ) = None
    bore: (
        Annotated[
            float, Measure(q.LENGTH, "bore of the inner ring, for a class of clearance", gt=0.0, le=100.0)
        ]
        | None
    ) = None
    contact_angle: Annotated[float, Measure(q.ANGLE, "contact angle", ge=0.0, lt=0.5 * math.pi)] = 0.0
    internal_clearance: Annotated[
        float,
        Measure(
            q.LENGTH,
            "radial internal clearance, diametral (ISO 5753), or its class; negative: preload",
            ge=-1e-3,
            le=0.01,
        ),
        BeforeValidator(clearance_of_class),
    ] = 0.0
    exponent: Annotated[
        float, Measure(None, "exponent of the penetration: 1.5 for balls, 10/9 for rollers", ge=1.0, le=3.0)
    ] = 1.5
    stiffness: (
        Annotated[
            float, HertzStiffness(q.HERTZ_STIFFNESS, "stiffness of one element between both rings", gt=0.0)
        ]
        | None
    ) = None
    groove_ratio: (
        Annotated[float, Measure(None, "radius of the raceways over the ball's diameter", gt=0.5, le=1.0)]
        | None
    ) = None
    damping: HuntCrossley | None = None
    restitution: (
        Annotated[
            float,
            Measure(None, "coefficient of restitution of one contact at reference_speed", gt=0.0, le=1.0),
        ]
        | None
    ) = None
    reference_speed: Annotated[float, Measure(q.SPEED, "impact speed at which restitution holds", gt=0.0)] = (
        0.1
    )
    cage_phase: Annotated[float, Measure(q.ANGLE, "direction of element 0 at t = 0")] = 0.0
    cage_torque: Annotated[
        bool, Field(description="rings give the power of the cage's motion; false: it is put in")
    ] = True
    waviness: Annotated[tuple[Wave, ...], Listed(0, 64, "terms of the rings' waviness")] = ()
    rotor_ring: Annotated[Ring, Field(description="ring that the rotor has")] = "inner"
    on: (
        Annotated[RotorName, Field(description="rotor that carries its other ring; the ground if not given")]
        | None
    ) = None
    offset: Offset = (0.0, 0.0)

    @model_validator(mode="after")
    def _check(self) -> "Bearing":
        refuse(self._problems())
        return self

    def _problems(self) -> Iterator[Problem]:
        if self.catalogue is not None and self.catalogue not in CATALOGUE:
            rule = f"must be one of {', '.join(CATALOGUE)}"
            yield Problem(
                ("catalogue",), rule, "Give rolling_elements, element_diameter and pitch_diameter instead"
            )
            return
        missing = False
        for field in ("rolling_elements", "element_diameter", "pitch_diameter"):
            if getattr(self, field) is None and self.catalogue is None:
                missing = True
                yield Problem(
                    (field,), "is required, or catalogue", "Give it, or the designation of a known bearing"
                )
        if missing:
            return
        if self.element_size >= self.pitch_size * math.sin(math.pi / self.elements):
            apart = 1e3 * self.pitch_size * math.sin(math.pi / self.elements)
            rule = f"must be less than {apart:.4g} mm, the distance of neighbours on the pitch circle"
            yield Problem(("element_diameter",), rule, "Correct a diameter or the number of elements")
        if (self.stiffness is None) == (self.groove_ratio is None):
            rule = (
                "is required, or groove_ratio"
                if self.stiffness is None
                else "must not be given together with groove_ratio"
            )
            yield Problem(("stiffness",), rule, "Give one of the two")
        if self.groove_ratio is not None and self.exponent != 1.5:
            yield Problem(
                ("exponent",), "must be 1.5 for balls in grooves", "Remove it, or give the stiffness itself"
            )
        if self.damping is not None and self.restitution is not None:
            yield Problem(
                ("restitution",), "must not be given together with damping", "Remove one of the two"
            )

    @property
    def elements(self) -> int:
        """Number of elements."""
        return self.rolling_elements or CATALOGUE[self.catalogue or ""].elements

    @property
    def element_size(self) -> float:
        """Diameter of an element [m]."""
        return self.element_diameter or CATALOGUE[self.catalogue or ""].element_diameter

    @property
    def pitch_size(self) -> float:
        """Pitch diameter [m]."""
        return self.pitch_diameter or CATALOGUE[self.catalogue or ""].pitch_diameter

    @property
    def bore_size(self) -> float | None:
        """Bore [m], None where it is not known."""
        return self.bore or (None if self.catalogue is None else CATALOGUE[self.catalogue].bore)

    @property
    def ratio(self) -> float:
        """D cos(contact angle) / d_m."""
        return self.element_size * math.cos(self.contact_angle) / self.pitch_size

    @property
    def shares(self) -> tuple[float, float]:
        """Shares of the rotor's rotation and of its other ring's in the cage's."""
        inner, outer = 0.5 * (1.0 - self.ratio), 0.5 * (1.0 + self.ratio)
        return (inner, outer) if self.rotor_ring == "inner" else (outer, inner)

    @property
    def orders(self) -> PassOrders:
        """Pass orders per turn of the inner ring against the outer."""
        return pass_orders(self.elements, self.element_size / self.pitch_size, self.contact_angle)

    def clearance(self) -> float:
        """Return half the internal clearance [m], 0 with preload."""
        return max(0.0, 0.5 * self.internal_clearance)

    def element_stiffness(self) -> float:
        """Return the stiffness of one element between both rings [N/m^exponent]."""
        if self.stiffness is not None:
            return self.stiffness
        assert self.groove_ratio is not None, "validated"
        grooves = (self.groove_ratio, self.groove_ratio)
        return ball_stiffness(self.element_size, self.pitch_size, self.ratio, grooves, *STEEL)

    def dissipation(self) -> float:
        """Return chi [s/m]; with a restitution that of an impact on one element at the reference speed."""
        if self.damping is not None:
            return self.damping.value
        return (
            0.0 if self.restitution is None else solved_dissipation(self.restitution) / self.reference_speed
        )

    def dissipates(self) -> bool:
        """Return whether its contacts have damping."""
        return self.dissipation() > 0.0

    def pack(self, packing: Packing, name: str, damping: float) -> None:
        """Add its element: a contact for each ball or roller."""
        record, rotors, contacts = self._element(packing, name, damping)
        faults = packing.faults_of("bearings", name)
        offsets = offsets_of(faults, self)
        gaps = gaps_of(offsets)
        dents = [fault.rows(self, min(gaps)) for fault in faults if isinstance(fault, Dent)]
        slopes = [(abs(rate) / arc * math.pi, depth) for (rate, _, arc), (depth, *_) in dents]
        record.dents, _ = packing.add_terms(row for rows in dents for row in rows)
        if any(offsets):
            steps = [offsets[0], *gaps[:-1]]
            record.pitch_cosine = record.pitch_sine = 0.0
            packing.add_terms(
                (offset, math.cos(step), math.sin(step)) for offset, step in zip(offsets, steps, strict=True)
            )
        record.dent_count = len(dents)
        record.dent_slope = sum(turn * depth for turn, depth in slopes)
        record.dent_bend = sum(turn * turn * depth for turn, depth in slopes)
        record.dent_travel = min((math.pi / turn for turn, _ in slopes), default=0.0)
        packing.assembly.add(
            law, name, record, rotors, contacts,
            always=damping > 0.0, switches=len(dents), **self._numbers(packing, name),
        )  # fmt: skip

    def _element(self, packing: Packing, name: str, damping: float) -> tuple[Any, list[int], list[Contact]]:
        r, count = blank(law.RECORD), self.elements
        outer = self.rotor_ring == "outer"
        r.half_clearance, r.exponent = 0.5 * self.internal_clearance, self.exponent
        r.stiffness, r.dissipation = self.element_stiffness(), self.dissipation()
        r.share_a, r.share_b = self.shares
        # A displacement of the outer ring presses the elements on its other side.
        r.cage_phase = self.cage_phase + (math.pi if outer else 0.0)
        r.pitch_cosine, r.pitch_sine = math.cos(2.0 * math.pi / count), math.sin(2.0 * math.pi / count)
        for key, ring in (("a", self.rotor_ring), ("b", "inner" if outer else "outer")):
            waves = sorted((wave for wave in self.waviness if wave.ring == ring), key=lambda wave: wave.order)
            phases = [wave.phase - (wave.order * math.pi if outer else 0.0) for wave in waves]
            rows = [
                (float(wave.order), wave.amplitude * math.cos(phase), wave.amplitude * math.sin(phase))
                for wave, phase in zip(waves, phases, strict=True)
            ]
            first, number = packing.add_terms(rows)
            bounds = {
                f"waves_{key}": first,
                f"count_{key}": number,
                f"slope_{key}": sum(wave.order * wave.amplitude for wave in waves),
                f"bend_{key}": sum(wave.order**2 * wave.amplitude for wave in waves),
                f"highest_{key}": float(max((wave.order for wave in waves), default=0)),
            }
            vars(r).update(bounds)
        r.damping, r.cage_torque = damping, int(self.cage_torque)
        r.rotor, r.carrier = packing.place(name), packing.place(self.on)
        r.misplaced_x, r.misplaced_y = self.offset
        r.offset_x, r.offset_y = (a + b for a, b in zip(packing.arm(name, self.on), self.offset, strict=True))
        return r, [r.rotor, r.carrier], [Contact(f"element{k}") for k in range(count)]

    def _numbers(self, packing: Packing, name: str) -> dict[str, Any]:
        depth = max(TYPICAL_DEPTH, -0.5 * self.internal_clearance)
        stiffness = (
            0.5 * self.elements * self.element_stiffness() * self.exponent * depth ** (self.exponent - 1.0)
        )
        inv_mass = max(packing.records[packing.place(name)].inv_mass, 1e-3)
        return {"rate": math.sqrt(stiffness * inv_mass), "hides": self.dissipation() > 0.0}

    def at_temperature(self, path: str, journal: float, bush: float) -> "Bearing":
        """Return the bearing at temperature: raceways expand with the seats of their rings, elements with the rotor.

        Of the inner ring's raceway d_m - D - G/2 and the outer's d_m + D + G/2, less two diameters D: G f_rotor where both
        expand alike. Raises `InputError` where the preload would be beyond a thousandth of the pitch diameter.
        """
        if bush == 1.0 and journal == 1.0:
            return self
        cold, size, pitch = self.internal_clearance, self.element_size, self.pitch_size
        inner, outer = pitch - size - 0.5 * cold, pitch + size + 0.5 * cold
        factors = (journal, bush) if self.rotor_ring == "inner" else (bush, journal)
        hot = outer * factors[1] - inner * factors[0] - 2.0 * size * journal
        if hot < -1e-3 * pitch:
            rule = (
                f"is {1e6 * hot:.4g} um at temperature: a preload beyond a thousandth of the pitch diameter"
            )
            raise InputError.of(
                f"{path}.internal_clearance",
                f"{1e6 * cold:.4g} um",
                rule,
                "Raise it, or choose materials that expand alike",
            )
        grown = {
            "internal_clearance": hot,
            "element_diameter": size * journal,
            "pitch_diameter": 0.5 * pitch * (journal + bush),
        }
        return self.model_copy(update=grown)

    def thermal_change(self, hot: "Bearing") -> tuple[str, str]:
        """Return its clearance at temperature as a text."""
        warm, cold = hot.internal_clearance, self.internal_clearance
        return (
            "internal_clearance",
            f"at temperature it is {1e6 * warm:.1f} um, {micrometres(warm - cold)}",
        )

    def time_invariant(self) -> "MeanBearing":
        """Return its mean over all angles of the cage, without damping and waviness."""
        still = {
            "waviness": (),
            "damping": None,
            "restitution": None,
            "stiffness": self.element_stiffness(),
            "groove_ratio": None,
        }
        return MeanBearing.model_construct(**{**vars(self), **still})

    def findings(self, path: str, *, held: bool, alone: bool) -> Iterator[Finding]:
        """Yield its pass orders, the range of a class of clearance, and a preload."""
        orders, clearance = self.orders, self.internal_clearance
        yield Finding(
            "note",
            path,
            f"per turn of the inner ring against the outer: cage {orders.cage:.6g} (FTF), elements pass the outer ring "
            f"{orders.outer:.6g} times (BPFO), the inner ring {orders.inner:.6g} times (BPFI), "
            f"and spin {orders.spin:.6g} times (BSF).",
        )
        for grade, (low, high) in ranges_at(self.bore_size).items():
            if abs(clearance - 0.5 * (low + high)) < 1e-12:
                text = f"the middle of class {grade}, {1e6 * low:g} to {1e6 * high:g} um (ISO 5753)"
                yield Finding("note", f"{path}.internal_clearance", f"{text}.")
        if clearance < 0.0:
            depth, n = -0.5 * clearance, self.exponent
            stiffness = 0.5 * self.elements * n * self.element_stiffness() * depth ** (n - 1.0)
            force = self.element_stiffness() * depth**n
            text = f"preload: each element is pressed with {force:.4g} N, the bearing has {1e-6 * stiffness:.4g} N/um"
            yield Finding("note", f"{path}.internal_clearance", f"{text}.")
        if self.exponent == 1.5 and self.stiffness is not None and not 1e8 <= self.stiffness <= 1e12:
            text = "one ball of steel has some 1e10 N/m^1.5: check the number and its unit"
            yield Finding("warning", f"{path}.stiffness", f"{text}.")


class MeanBearing(Bearing):
    """A bearing whose force is the mean over all angles of the cage, which stands still: for linear systems.

    The mean of F(e) over the cage is the force of many elements of less stiffness.
    """

    def pack(self, packing: Packing, name: str, damping: float) -> None:
        """Add its element, with a multiple of its balls or rollers."""
        times = -(-AVERAGED // self.elements)
        many = self.model_copy(
            update={"rolling_elements": times * self.elements, "stiffness": self.element_stiffness() / times}
        )
        record, rotors, contacts = Bearing._element(many, packing, name, damping)
        record.share_a = record.share_b = 0.0
        record.cage_torque = 0
        packing.assembly.add(
            law, name, record, rotors, contacts, always=damping > 0.0, **self._numbers(packing, name)
        )
