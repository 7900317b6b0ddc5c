"""Fields of rolling bearings: waviness, damping, clearance by its class."""

from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo

from gearplay.parts.bearing.geometry import CATALOGUE, CLASSES, LARGEST_BORE, LEAST_BORE, clearance_range
from gearplay.schema.fields import Measure, Part, Problem, refuse
from gearplay.vocabulary import quantities as q

DISSIPATION = q.Quantity("dissipation", "chi", "s/m", "s/m", 1.0, "coefficient of Hunt and Crossley")


Ring = Literal["inner", "outer"]


class Wave(Part):
    """One term of the waviness of a ring: A cos(order angle + phase), the angle counted on the ring."""

    order: Annotated[int, Field(ge=1, le=1000, description="waves around the ring")]
    amplitude: Annotated[
        float, Measure(q.LENGTH, "amplitude (half peak to peak), towards the elements", ge=0.0, le=1e-3)
    ]
    phase: Annotated[float, Measure(q.ANGLE, "phase at the ring's angle 0")] = 0.0
    ring: Annotated[Ring, Field(description="ring that is wavy")] = "outer"


class HuntCrossley(Part):
    """Damping of each contact, F = K d^n (1 + chi d')."""

    kind: Literal["hunt-crossley"] = "hunt-crossley"
    value: Annotated[
        float, Measure(DISSIPATION, "coefficient chi, whatever the speed of the contact", ge=0.0, le=1e3)
    ]


def clearance_of_class(value: Any, info: ValidationInfo) -> Any:
    """Return the middle of the range [m] where a clearance is given by its class; it needs the bore."""
    if not isinstance(value, str) or value not in CLASSES:
        return value
    known = CATALOGUE.get(info.data.get("catalogue") or "")
    bore = info.data.get("bore") or (None if known is None else known.bore)
    if bore is None:
        rule = f"{value} needs the bore of the inner ring, which decides its range"
        refuse([Problem((), rule, "Give bore, or the clearance itself")])
        return value
    if not LEAST_BORE < bore <= LARGEST_BORE:
        rule = f"must be a length for a bore of {1e3 * bore:.4g} mm: ranges of classes are known over {1e3 * LEAST_BORE:g} up to "
        refuse([Problem((), f"{rule}{1e3 * LARGEST_BORE:g} mm", "Give the clearance itself")])
    return 0.5 * sum(clearance_range(value, bore))
