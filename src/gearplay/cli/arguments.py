"""Options that several commands share."""

from typing import Annotated

import typer

Changes = Annotated[
    list[str] | None,
    typer.Option("--set", help="Change the case: --set meshes.0.backlash=200um. May be repeated."),
]
Period = Annotated[str, typer.Option("--period", help="common, mesh, shaft, or seconds.")]


def period_of(text: str) -> str | float:
    """Return a period as it is given on the command line: a name, or a time [s].

    >>> period_of("mesh"), period_of("0.5")
    ('mesh', 0.5)
    """
    try:
        return float(text)
    except ValueError:
        return text
