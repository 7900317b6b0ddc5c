"""`gearplay validate`: published numbers compared with those of gearplay."""

import typer

from gearplay.cli.interrupts import interruptible
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.progress import progress_bar
from gearplay.vocabulary.exit_codes import BROKEN


def validate(json: Json = False) -> None:
    """Compare published numbers with those of gearplay.

    Gear geometry, backlash from allowances, stiffness of teeth, natural frequencies, rolling bearings, events and temperature,
    each with its deviation, tolerance and source. Exit code 1 where a deviation is beyond its tolerance.
    """
    import gearplay as gp

    with interruptible(), progress_bar(quiet=json) as report:
        found = gp.validate(progress=report)
    if json:
        print_json({"message": found.message, "passed": found.passed, "numbers": found.numbers()})
    else:
        print_text(str(found))
    if not found.passed:
        raise typer.Exit(BROKEN)
