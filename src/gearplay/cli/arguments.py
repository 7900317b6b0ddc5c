"""Options that several commands share."""

from typing import Annotated

import typer

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


def period_of(text: str) -> str | float:
    """Return a period as it is given on the command line: a name, or a time [s].

    >>> period_of("mesh"), period_of("0.5"), period_of("25 ms")
    ('mesh', 0.5, 0.025)
    """
    try:
        return float(text)
    except ValueError:
        pass
    if not any(letter.isdigit() for letter in text):
        return text
    from gearplay.model.units import UnitError, parse_quantity
    from gearplay.vocabulary.errors import Fault, InputError
    from gearplay.vocabulary.quantities import TIME

    try:
        return parse_quantity(text, TIME)
    except UnitError as error:
        raise InputError(Fault("--period", text, error.rule, "Write common, mesh, shaft or 25 ms")) from None
