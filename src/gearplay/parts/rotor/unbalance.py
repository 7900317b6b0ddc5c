"""Unbalance of a rotor."""

from typing import Annotated

from gearplay.schema.fields import Measure, Part
from gearplay.vocabulary import quantities as q


class Unbalance(Part):
    """Mass times eccentricity, and where it points at ``theta = 0``. The rotor's mass and inertia include it; the inertia is
    about the axis, whose displacement x and y are.
    """

    amount: Annotated[float, Measure(q.UNBALANCE, "mass times eccentricity", ge=0.0)]
    phase: Annotated[float, Measure(q.ANGLE, "direction at theta = 0, counter-clockwise from +x")] = 0.0
