"""Axes of shafts and gears in the plane of the mechanism."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from gearplay.rexs.notes import Notes
from gearplay.rexs.records import Component, Gearbox, refused

PARALLEL: Final = 1e-6
"""Sine of the angle between two axes below which they are parallel."""
DEEPEST: Final = 50
"""Longest chain of components that are placed relative to each other."""
Vector = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """Origin [m] and axes of a component, the rows u, v, w."""

    origin: Vector
    axes: Vector


def frame_of(box: Gearbox, component: Component, below: tuple[int, ...] = ()) -> Frame | None:
    """Return the frame of a component in space, through the components that its position refers to; None where it is not given.

    Raises `InputError` for a reference that leads back to itself or to nothing, and for axes without a length.
    """
    if component.id in below or len(below) > DEEPEST:
        raise refused(str(component), "must not be placed relative to itself", "Export the model again")
    at, u, w = (box.vector(component, name) for name in ("support_vector", "u_axis_vector", "w_axis_vector"))
    if at is None or u is None or w is None:
        return None
    own = Frame(np.array(at), _axes(component, np.array(u), np.array(w)))
    number = box.number(component, None, "reference_component_for_position")
    if number is None or int(number) == component.id:
        return own
    reference = box.components.get(int(number))
    if reference is None:
        raise refused(
            str(component),
            f"is placed relative to component {int(number)}, which is not there",
            "Export it again",
        )
    base = frame_of(box, reference, (*below, component.id))
    if base is None:
        return own
    return Frame(base.origin + own.origin @ base.axes, own.axes @ base.axes)


def _axes(component: Component, u: Vector, w: Vector) -> Vector:
    along = float(np.linalg.norm(u))
    u = u / along if along > 0.0 else u
    w = w - (w @ u) * u
    across = float(np.linalg.norm(w))
    if along == 0.0 or across == 0.0:
        raise refused(
            str(component),
            "must have axis vectors u and w that differ in direction",
            "Export the model again",
        )
    w = w / across
    return np.array([u, np.cross(w, u), w])


class Plane:
    """The plane across the axes: x along v, y along w of the gear unit, seen against u; angles count from v to w."""

    def __init__(self, box: Gearbox, axes: list[Component], notes: Notes) -> None:
        """Choose the plane; ``axes`` are the components whose axes must be parallel."""
        self.box = box
        frames = {each.id: frame_of(box, each) for each in axes}
        for each in axes:  # a gear is on the axis of its shaft
            for shaft in box.assemblies(each.id, "shaft"):
                frames[each.id] = frames.get(shaft.id) or frames[each.id]
        self.frames = {number: frame for number, frame in frames.items() if frame is not None}
        placed = [each for each in axes if each.id in self.frames]
        self.basis: Vector = np.eye(3)
        if not placed:
            notes.assume(
                "no positions can be read: places follow from centre distances and the rotating angles of the stages, "
                "and all shafts turn about axes of one direction"
            )
            return
        self.basis = self.frames[placed[0].id].axes
        for unit in box.of_type("gear_unit"):
            own = frame_of(box, unit)
            if own is not None and abs(own.axes[0] @ self.basis[0]) > 1.0 - PARALLEL:
                self.basis = own.axes
        for each in placed:
            if np.linalg.norm(np.cross(self.frames[each.id].axes[0], self.basis[0])) > PARALLEL:
                rule = f"must have an axis parallel to that of {placed[0]}: gearplay's mechanisms lie in one plane"
                raise refused(
                    str(each), rule, "Take out what is beyond the crossing of the axes, and export the rest"
                )

    def sense(self, number: int) -> float:
        """Return 1 where the component's u axis points as the plane's, else -1."""
        frame = self.frames.get(number)
        return 1.0 if frame is None or frame.axes[0] @ self.basis[0] > 0.0 else -1.0

    def place(self, number: int) -> tuple[float, float] | None:
        """Return the place of a component's axis [m]."""
        frame = self.frames.get(number)
        if frame is None:
            return None
        x, y = (self.basis[1:] @ frame.origin).tolist()
        return x, y

    def direction(self, first: int, second: int) -> float | None:
        """Return the direction [rad] from one axis to another, None where they are not placed or coincide."""
        a, b = self.place(first), self.place(second)
        if a is None or b is None or math.dist(a, b) < 1e-9:
            return None
        return math.atan2(b[1] - a[1], b[0] - a[0])

    def distance(self, first: int, second: int) -> float | None:
        """Return the distance [m] of two axes."""
        a, b = self.place(first), self.place(second)
        return None if a is None or b is None else math.dist(a, b)
