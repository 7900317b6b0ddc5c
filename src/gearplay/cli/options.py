"""Options of several commands, and the translation of argument names in errors to options."""

import re
from typing import TYPE_CHECKING, Annotated, Final

import typer

from gearplay.vocabulary.errors import GearplayError, InputError

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
Pulses = Annotated[
    int | None,
    typer.Option(
        "--pulses", min=1, help="Pulses per revolution: the channel of --speed is a train of pulses."
    ),
]
Units = Annotated[
    list[str] | None,
    typer.Option(
        "--unit", metavar="NAME=UNIT", help="Unit of a channel, in place of the file's own. May be repeated."
    ),
]
Calibrations = Annotated[
    list[str] | None,
    typer.Option(
        "--calibration",
        metavar="NAME=FACTOR UNIT",
        help='Factor of a channel\'s samples, and their unit then: "channel 1=9.81 m/s^2". Of integers in WAV files the factor '
        "is full scale. May be repeated.",
    ),
]
Period = Annotated[str, typer.Option("--period", help="common, mesh, shaft, or a time: 25ms.")]

OPTIONS: Final = {
    **{name: f"--{name}" for name in ("at", "doublings", "keep", "member", "orbits", "order", "period")},
    **{name: f"--{name}" for name in ("periods", "settle", "show", "signal", "window")},
    **{
        name: f"--{name}" for name in ("hold", "positions", "stages", "temperatures", "tolerances", "columns")
    },
    "torque": "--rated-torque",
    "teeth": "--teeth",
    "bearings": "--bearing",
    "expected": "--line",
    **{name: f"--{name.replace('_', '-')}" for name in ("load_case", "gear_bodies", "allowance")},
    **{name: f"--{name}" for name in ("fmi", "inputs", "outputs", "platforms", "tune")},
    "calibration": "--calibration",
    "change": "--set",
    "ensemble": "--members",
}
"""Options by the names of the arguments that they set."""
PHRASES: Final = {
    "or give overwrite=True": "or say --overwrite",
    "Raise samples_per_revolution, or sample faster": "Sample faster",
    "Write it piece by piece (zarr)": "Say --zarr, which writes it piece by piece",
    "Draw a history": "Draw a history: --kind history",
}
"""Cures in terms of Python, and of the command line."""


def si_number(option: str, text: str, quantity: "Quantity") -> float:
    """Return a quantity of the command line in SI: a plain number is SI already, text has a unit; `InputError` else.

    >>> from gearplay.vocabulary.quantities import FREQUENCY, TIME
    >>> si_number("--sampling", "12.8kHz", FREQUENCY), si_number("--duration", "0.5", TIME)
    (12800.0, 0.5)
    """
    from gearplay.schema.units import quantity_of

    return float(text) if _PLAIN.fullmatch(text.strip()) else quantity_of(option, text, quantity)


def period_of(text: str) -> str | float:
    """Return a period as it is given on the command line: a name, or a time [s].

    >>> period_of("mesh"), period_of("0.5"), period_of("25 ms")
    ('mesh', 0.5, 0.025)
    """
    if not any(letter.isdigit() for letter in text):
        return text
    from gearplay.vocabulary.quantities import TIME

    return si_number("--period", text, TIME)


def with_options(error: GearplayError) -> GearplayError:
    """Return an error with the option names of the command line; the same object where nothing changes.

    >>> print(with_options(InputError.of("at", "rim", "must be a rotor", "Choose another, or give overwrite=True")))
    --at = "rim": must be a rotor. Choose another, or say --overwrite.
    """
    if isinstance(error, InputError):
        faults = [
            each._replace(
                path=OPTIONS.get(each.path.partition("[")[0], each.path), cure=_translated(each.cure)
            )
            for each in error.faults
        ]
        return error if faults == error.faults else type(error)(faults)
    text = str(error)
    return error if _translated(text) == text else type(error)(_translated(text))


def _translated(text: str) -> str:
    for there, here in PHRASES.items():
        text = text.replace(there, here)
    return re.sub(
        r"See help\(gearplay\.(\w+)\)", lambda found: f"See gearplay {_command(found[1])} --help", text
    )


def _command(function: str) -> str:
    return function.replace("_", " " if function.startswith("export_") else "-")
