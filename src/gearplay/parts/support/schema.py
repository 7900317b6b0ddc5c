"""Supports: elastic bearings and torsional springs between a rotor and the ground or a carrier."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from pydantic import Discriminator, Field, Tag, model_validator

from gearplay.parts.assembly import LENGTH_SCALE, blank
from gearplay.parts.joining import ROTATION
from gearplay.parts.protocol import Holder, Packing
from gearplay.parts.support import law
from gearplay.schema.fields import Listed, Measure, Offset, Problem, RotorName, is_absent, refuse
from gearplay.schema.finding import Finding
from gearplay.vocabulary import quantities as q

CUBIC_STIFFNESS = q.Quantity("cubic_stiffness", "k_3", "N/m^3", "N/mm^3", 1e-9, "cubic stiffness")

Stiffness = Annotated[float, Measure(q.STIFFNESS, "stiffness along this axis", ge=0.0)]
Damping = Annotated[float, Measure(q.DAMPING, "damping along this axis", ge=0.0)]
AnyStiffness = Annotated[float, Measure(q.STIFFNESS, "stiffness of a matrix")]
AnyDamping = Annotated[float, Measure(q.DAMPING, "damping of a matrix")]
StiffnessRow = Annotated[
    tuple[AnyStiffness, AnyStiffness], Listed(2, 2, "of the force along one axis, by x and y")
]
DampingRow = Annotated[
    tuple[AnyDamping, AnyDamping], Listed(2, 2, "of the force along one axis, by vx and vy")
]
Matrix = tuple[tuple[float, float], tuple[float, float]]


def _axes_or_matrix(value: Any) -> str:
    first = value[0] if isinstance(value, (list, tuple)) and len(value) > 0 else None
    return "kind:matrix" if isinstance(first, (list, tuple)) else "kind:axes"


def _matrix(value: Any) -> Matrix:
    """Return the matrix of two numbers along the axes, or of one that is given in full."""
    one, two = value
    return value if isinstance(one, tuple) else ((one, 0.0), (0.0, two))


class Support(Holder):
    """Springs and dampers on a rotor's centre, unstressed at its nominal place, and on its rotation, unstressed at theta = 0.

    ``stiffness`` and ``cubic_stiffness`` free the centre, as a sleeve does, and add to one. On a carrier x and y are its axes at
    rotation 0 and turn with it; rates and the angle are relative to it. ``offset`` is its unstressed position relative to the
    nominal centre.
    """

    kind: ClassVar[int] = law.KIND
    noun: ClassVar[str] = "support"

    stiffness: (
        Annotated[
            Annotated[
                tuple[Stiffness, Stiffness],
                Listed(2, 2, "stiffness of the centre along x and y"),
                Tag("kind:axes"),
            ]
            | Annotated[
                tuple[StiffnessRow, StiffnessRow],
                Listed(2, 2, "stiffness matrix of the centre"),
                Tag("kind:matrix"),
            ],
            Discriminator(_axes_or_matrix),
        ]
        | None
    ) = None
    damping: Annotated[
        Annotated[
            tuple[Damping, Damping], Listed(2, 2, "damping of the centre along x and y"), Tag("kind:axes")
        ]
        | Annotated[
            tuple[DampingRow, DampingRow], Listed(2, 2, "damping matrix of the centre"), Tag("kind:matrix")
        ],
        Discriminator(_axes_or_matrix),
    ] = (0.0, 0.0)
    cubic_stiffness: Annotated[
        float,
        Measure(
            CUBIC_STIFFNESS,
            "k3 of the restoring force k3 r^3 at a displacement r of the centre",
            ge=0.0,
            le=1e24,
        ),
        Field(exclude_if=is_absent),
    ] = 0.0
    torsional_stiffness: Annotated[
        float, Measure(q.ROTATIONAL_STIFFNESS, "stiffness against rotation", ge=0.0)
    ] = 0.0
    torsional_damping: Annotated[float, Measure(q.ROTATIONAL_DRAG, "damping of the rotation", ge=0.0)] = 0.0
    on: Annotated[RotorName, Field(description="rotor that carries it; the ground if not given")] | None = (
        None
    )
    offset: Offset = (0.0, 0.0)

    @model_validator(mode="after")
    def _check(self) -> "Support":
        numbers = [each for row in (*self.stiffness_matrix, *self.damping_matrix) for each in row]
        for field, matrix in (("stiffness", self.stiffness_matrix), ("damping", self.damping_matrix)):
            for axis in range(2):
                if matrix[axis][axis] < 0.0:
                    rule = "must be 0 or more on the diagonal"
                    refuse(
                        [
                            Problem(
                                (field, axis, axis),
                                rule,
                                "Remove the minus sign or check what the field means",
                            )
                        ]
                    )
        if not any((*numbers, self.cubic_stiffness, self.torsional_stiffness, self.torsional_damping)):
            rule = "must have a stiffness or a damping that is not 0"
            cure = "Give stiffness, cubic_stiffness, damping, torsional_stiffness or torsional_damping"
            refuse([Problem((), rule, cure)])
        return self

    @property
    def stiffness_matrix(self) -> Matrix:
        """Stiffness of the centre [N/m], of the force along an axis by the displacement along another."""
        return _matrix(self.stiffness or (0.0, 0.0))

    @property
    def damping_matrix(self) -> Matrix:
        """Damping of the centre [N s/m]."""
        return _matrix(self.damping)

    @property
    def axial_stiffness(self) -> tuple[float, float]:
        """Stiffness along x and y [N/m], that of the cubic spring at a natural displacement, for drawings."""
        cubic = self.cubic_stiffness * LENGTH_SCALE**2
        return self.stiffness_matrix[0][0] + cubic, self.stiffness_matrix[1][1] + cubic

    def frees_centre(self) -> bool:
        """Return whether a stiffness along x or y, also 0, or a cubic one is given, which leaves the centre free."""
        return self.stiffness is not None or self.cubic_stiffness > 0.0

    def holds_rotation(self) -> bool:
        """Return whether the support has a torsional stiffness."""
        return self.torsional_stiffness > 0.0

    def dissipates(self) -> bool:
        """Return whether it has damping along any axis."""
        return any(each for row in self.damping_matrix for each in row)

    def pack(self, packing: Packing, name: str, damping: float) -> None:
        """Add its element; on the ground it is a spring of closed-form motion too where it is linear."""
        record, body = blank(law.RECORD), packing.bodies[name]
        (record.stiffness_x, record.stiffness_xy), (record.stiffness_yx, record.stiffness_y) = (
            self.stiffness_matrix
        )
        (damping_x, record.damping_xy), (record.damping_yx, damping_y) = self.damping_matrix
        record.damping_x, record.damping_y = damping_x + damping, damping_y + damping
        record.cubic_stiffness, record.torsional_stiffness = self.cubic_stiffness, self.torsional_stiffness
        record.torsional_damping = self.torsional_damping
        record.journal, record.carrier = packing.place(name), packing.place(self.on)
        record.offset_x, record.offset_y = packing.arm(name, self.on)
        record.misplaced_x, record.misplaced_y = self.offset
        stiffest = max(record.stiffness_x, record.stiffness_y) + 3.0 * self.cubic_stiffness * LENGTH_SCALE**2
        rate = math.sqrt(
            max(
                stiffest / (body.mass or math.inf),
                record.torsional_stiffness / (body.inertia or math.inf),
            )
        )
        assembly = packing.assembly
        assembly.add(law, name, record, [record.journal, record.carrier], always=True, rate=rate)
        crossed = any((record.stiffness_xy, record.stiffness_yx, record.damping_xy, record.damping_yx))
        if (
            self.on is None and not crossed and self.cubic_stiffness == 0.0
        ):  # linear, and no axis acts on another
            alone = {record.journal: 1.0}
            for axis, k, c, rest in (
                (0, record.stiffness_x, record.damping_x, record.misplaced_x),
                (1, record.stiffness_y, record.damping_y, record.misplaced_y),
                (ROTATION, self.torsional_stiffness, self.torsional_damping, 0.0),
            ):
                assembly.join(axis, alone, k, c, rest=rest)

    def findings(self, path: str, *, held: bool, alone: bool) -> Iterator[Finding]:
        """Yield warnings about damping of a held centre, and of a centre without a stiffness."""
        if any(each for row in self.damping_matrix for each in row) and held:
            text = "it does nothing, since the centre is held: give the support a stiffness, or the rotor a sleeve"
            yield Finding("warning", f"{path}.damping", f"{text}.")
        for axis, row in zip("xy", self.stiffness_matrix if self.stiffness is not None else (), strict=False):
            if not any(row) and alone and self.cubic_stiffness == 0.0:
                text = f"the centre is free along {axis}: without a stiffness there any force moves it away for good"
                yield Finding("warning", f"{path}.stiffness", f"{text}.")
