"""Rotors: planar rigid bodies with drive, load and initial state."""

from collections.abc import Iterator
from typing import Annotated, Final

from pydantic import AfterValidator, Field, model_validator

from gearplay.parts.drive.schema import Drive, SpeedDrive
from gearplay.parts.drive.terms import Table, Terms, largest_torque
from gearplay.parts.environment import Material, Temperature
from gearplay.parts.rotor.gear import Gear, Internal, Runout, Teeth, Toothing, grown
from gearplay.parts.rotor.unbalance import Unbalance
from gearplay.schema.fields import (
    Counted,
    FrozenTable,
    Listed,
    Measure,
    Name,
    Part,
    Problem,
    is_absent,
    refuse,
)
from gearplay.schema.finding import Finding
from gearplay.vocabulary import quantities as q

Coordinate = Annotated[float, Measure(q.LENGTH, "coordinate of the nominal centre")]


POSITION_TOLERANCE: Final = 1e-7
"""Distance [m] of centres that should lie on each other, or where teeth mesh, below which they do."""


class Weight(Measure):
    """A mass or a moment of inertia: 0, or large enough to divide by."""

    def _within(self, value: float, *, text: bool = False) -> float:
        value = super()._within(value, text=text)
        return value and Measure(self.quantity, self.about, gt=0.0)._within(value, text=text)


Mass = Annotated[
    float, Weight(q.MASS, "mass; 0 in linear analysis only, or where its centre is held", ge=0.0)
]
Inertia = Annotated[
    float, Weight(q.INERTIA, "polar moment of inertia about the centre; 0 in linear analysis only", ge=0.0)
]


class Load(Part):
    """Load of a rotor: torque, its terms and its table oppose its nominal sense, friction and drag its velocity."""

    torque: Annotated[float, Measure(q.TORQUE, "constant load torque", ge=0.0)] = 0.0
    terms: Terms = ()
    table: Table = None
    drag: Annotated[float, Measure(q.ROTATIONAL_DRAG, "viscous drag", ge=0.0)] = 0.0
    friction: Annotated[float, Measure(q.TORQUE, "dry friction torque", ge=0.0)] = 0.0
    friction_speed: Annotated[
        float, Measure(q.ANGULAR_SPEED, "speed within which dry friction is smoothed", gt=0.0)
    ] = 0.01

    def largest_torque(self) -> float:
        """Return a bound of torque, terms and table together [N m]."""
        return largest_torque(self.torque, self.terms, self.table)


class Initial(Part):
    """State at the start; rotations that are not given put drive flanks into touch, speeds that are not given match.

    The order of tables does not matter. Given rotations and speeds are kept; see Starts in the conventions.
    """

    x: Annotated[float, Measure(q.LENGTH, "displacement from the nominal centre along x")] = 0.0
    y: Annotated[float, Measure(q.LENGTH, "displacement from the nominal centre along y")] = 0.0
    vx: Annotated[float, Measure(q.SPEED, "velocity along x")] = 0.0
    vy: Annotated[float, Measure(q.SPEED, "velocity along y")] = 0.0
    theta: Annotated[float, Measure(q.ANGLE, "rotation")] | None = None
    omega: Annotated[float, Measure(q.ANGULAR_SPEED, "speed of rotation")] | None = None


class Rotor(Toothing):
    """A planar rigid body: a gear, a ring, a carrier, a shaft with several gears or a plain disc."""

    teeth: Teeth | None = None
    internal: Internal = False
    mass: Mass
    inertia: Inertia
    drive: Drive | None = None
    load: Load = Load.model_construct()
    position: (
        Annotated[tuple[Coordinate, Coordinate], Listed(2, 2, "nominal centre; from the meshes if not given")]
        | None
    ) = None
    initial: Initial = Initial.model_construct()
    radial_damping: Annotated[
        float,
        Measure(q.DAMPING, "viscous damping of the centre's motion, beside its pin if it is carried", ge=0.0),
    ] = 0.0
    floating: Annotated[bool, Field(description="true leaves a rotor without a sleeve free in the plane")] = (
        False
    )
    runout: Runout = Runout.model_construct()
    unbalance: Annotated[Unbalance | None, Field(exclude_if=is_absent)] = None
    material: Annotated[Material | None, Field(description="what it is made of", exclude_if=is_absent)] = None
    temperature: Annotated[Temperature | None, Field(exclude_if=is_absent)] = None
    gears: Annotated[
        dict[Name, Gear],
        Field(description="gears of a shaft by name, instead of teeth, internal and runout"),
        Counted(0, 20),
        AfterValidator(FrozenTable),
    ] = Field(default_factory=FrozenTable, exclude_if=is_absent)

    @model_validator(mode="after")
    def _check(self) -> "Rotor":
        problems = []
        if isinstance(self.drive, SpeedDrive):
            for name in ("theta", "omega"):
                if getattr(self.initial, name) is not None:
                    rule = "must not be given for a rotor whose drive prescribes its rotation"
                    problems.append(
                        Problem(("initial", name), rule, "Remove it, or use a torque or servo drive")
                    )
        if self.gears:
            unused = (("teeth", None), ("internal", False), ("runout", Runout()))
            for name in [*(name for name, value in unused if getattr(self, name) != value), *self.drawn]:
                rule = "must not be given together with gears, each of which has its own"
                problems.append(Problem((name,), rule, "Write it into one of the gears"))
        elif self.teeth is None and (self.internal or self.drawn):
            what = "an internal gear" if self.internal else f"a gear with {self.drawn[0]}"
            problems.append(Problem(("teeth",), f"is required for {what}", "Give the number of teeth"))
        if self.unbalance is not None and self.unbalance.amount**2 >= self.mass * self.inertia:
            rule = "must be less than sqrt(mass inertia), since the inertia about the axis includes it"
            problems.append(Problem(("unbalance", "amount"), rule, "Check unbalance, mass and inertia"))
        refuse(problems)
        return self

    @property
    def is_prescribed(self) -> bool:
        """Whether its drive prescribes the rotation."""
        return self.drive is not None and self.drive.prescribes

    def excites(self) -> bool:
        """Return whether load, runout, unbalance, start or drive make a train do more than roll at constant speed."""
        load, start = self.load, self.initial
        return (
            any((load.drag, load.friction, load.largest_torque()))
            or self.unbalance is not None
            or self.runout.amplitude != 0.0
            or any(gear.runout.amplitude for gear in self.gears.values())
            or any((start.x, start.y, start.vx, start.vy, start.theta, start.omega))
            or (self.drive is not None and self.drive.excites())
        )

    def findings(self, path: str, span: float, *, held: bool) -> Iterator[Finding]:
        """Yield findings for a run of ``span`` [s], transient included; ``held`` is whether the centre cannot move."""
        if self.unbalance is not None and self.is_prescribed and held:
            text = "it does nothing, since centre and rotation are held; its force on the bearing is in no signal"
            yield Finding("warning", f"{path}.unbalance", f"{text}.")
        if self.drive is not None:
            yield from self.drive.findings(f"{path}.drive", span)

    def gear(self, name: str) -> "Gear | Rotor":
        """Return the gear of a name, or for "" the only one: the rotor itself where it has no table of gears.

        Raises ``KeyError`` for a name that it has not, ``ValueError`` for "" where it has several.
        """
        if name:
            return self.gears[name]
        if not self.gears:
            return self
        (gear,) = self.gears.values()
        return gear

    def at_temperature(self, factor: float, centre: tuple[float, float]) -> "Rotor":
        """Return the rotor with the factor of its lengths and its nominal centre [m] at temperature."""
        gears = {name: gear.model_copy(update=grown(gear, factor)) for name, gear in self.gears.items()}
        update = {"position": centre, **grown(self, factor), "gears": FrozenTable(gears)}
        return self.model_copy(update=update)


def place_words(x: float, y: float) -> str:
    """Return a place in the plane [m] as a case file has it, to 0.1 um.

    >>> place_words(0.08, -0.0000005)
    '[80 mm, -0.0005 mm]'
    """
    return "[" + ", ".join(f"{round(1e3 * each, 4) + 0.0:.10g} mm" for each in (x, y)) + "]"
