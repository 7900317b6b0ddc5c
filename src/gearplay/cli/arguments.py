"""Options that several commands share."""

import re
from typing import TYPE_CHECKING, Annotated, Final

import typer

if TYPE_CHECKING:
    from gearplay.vocabulary.quantities import Quantity

_PLAIN: Final = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d{1,3})?", re.ASCII)

CaseName = Annotated[
    str, typer.Argument(help="A case file, or a bundled case: gearplay copy lists them.", show_default=False)
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="PATH=VALUE", help="Change the case: --set meshes.0.backlash=200um. May be repeated."
    ),
]
Period = Annotated[str, typer.Option("--period", help="common, mesh, shaft, or a time: 25ms.")]


def si_number(option: str, text: str, quantity: "Quantity") -> float:
    """Return a quantity of the command line in SI: a plain number is SI already, text has a unit; `InputError` else.

    >>> from gearplay.vocabulary.quantities import FREQUENCY, TIME
    >>> si_number("--sampling", "12.8kHz", FREQUENCY), si_number("--duration", "0.5", TIME)
    (12800.0, 0.5)
    """
    from gearplay.schema.units import UnitError, parse_quantity
    from gearplay.vocabulary.errors import Fault, InputError

    try:
        return float(text) if _PLAIN.fullmatch(text.strip()) else parse_quantity(text, quantity)
    except UnitError as error:
        raise InputError(Fault(option, text, error.rule, error.cure)) from None


def period_of(text: str) -> str | float:
    """Return a period as it is given on the command line: a name, or a time [s].

    >>> period_of("mesh"), period_of("0.5"), period_of("25 ms")
    ('mesh', 0.5, 0.025)
    """
    if not any(letter.isdigit() for letter in text):
        return text
    from gearplay.vocabulary.quantities import TIME

    return si_number("--period", text, TIME)
