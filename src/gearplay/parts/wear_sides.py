"""Wear coefficients of the two sides of a contact, of which one may be 0: a side that does not wear."""

from gearplay.schema.fields import Problem, refuse


def both_sides(first: float, other: float | None) -> tuple[float, float]:
    """Return the coefficients of both sides [m^2/N]; the first is that of the other too where none is given.

    >>> both_sides(2e-16, None), both_sides(2e-16, 0.0)
    ((2e-16, 2e-16), (2e-16, 0.0))
    """
    return first, first if other is None else other


def refuse_no_wear(first: float, other: float | None, field: str) -> None:
    """Refuse coefficients of which none is above 0; ``field`` is the name of the other one."""
    if not any(both_sides(first, other)):
        rule = f"must be greater than 0 m^2/N unless {field} is"
        refuse([Problem(("coefficient",), rule, f"Give {field}, or remove wear where neither side wears")])
