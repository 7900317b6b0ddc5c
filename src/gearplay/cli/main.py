"""The command ``gearplay``: registration of the commands, errors as one sentence and an exit code."""

from __future__ import annotations

import atexit
import os
import signal
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Annotated, Final

import typer

from gearplay.cli.interrupts import CommandInterruptedError, interruptible, leave_at_once
from gearplay.cli.options import with_options
from gearplay.cli.output import error_document, open_streams, output_failure, print_json, say_error, silence
from gearplay.vocabulary.errors import NO_VALUE, Fault, GearplayError, InputError
from gearplay.vocabulary.exit_codes import BROKEN, DONE, INTERRUPTED
from gearplay.vocabulary.memory import is_too_little_memory, too_little_memory

COMMANDS: Final = (
    "check",
    "copy",
    "run",
    "plot",
    "animate",
    "study",
    "sweep",
    "resume",
    "modes",
    "load_sharing",
    "motion",
    "portrait",
    "bifurcation",
    "measure",
    "analyze",
    "calibrate",
    "serve",
    "schema",
)
"""Functions of the commands, in modules of `gearplay.cli` of their names; heavy libraries are imported when they run."""
MODULES: Final = {"resume": "sweep"}
"""Modules of other names."""

FIRST_STEP: Final = """\
Begin with: gearplay run han2021 --set sleeves.ring.radial_clearance=50um

Bundled cases and plans: gearplay copy
"""


def _make_app() -> typer.Typer:
    made = typer.Typer(
        name="gearplay",
        help="Dynamics of gear mechanisms whose small clearances are coupled.",
        epilog=FIRST_STEP,
        add_completion=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    made.callback()(_options)
    for name in COMMANDS:
        module = import_module(f"gearplay.cli.{MODULES.get(name, name)}")
        made.command()(getattr(module, name))
    return made


def _print_version(wanted: bool) -> None:
    if wanted:
        from gearplay import __version__

        sys.stdout.write(f"gearplay {__version__}\n")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Take the options that stand before a command; `main` has read --debug already."""


app = _make_app()

_UsageError: Final = typer.BadParameter.__bases__[0]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit code.

    Parameters
    ----------
    arguments
        Words after ``gearplay``; those of the process if not given. ``--debug`` may stand anywhere.

    """
    open_streams()
    os.environ["MPLBACKEND"] = "agg"  # commands open no window, and one that does not exist stops matplotlib
    words = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in words
    code = run([word for word in words if word != "--debug"], debug=debug)
    leave_at_once(code)
    if code == INTERRUPTED:  # without waiting for what a library still does on a thread
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)  # while Python itself ends
    sys.exit(code)


def run(words: Sequence[str], *, debug: bool = False) -> int:
    """Run one command and return its exit code; every error a user can meet ends here.

    With `debug`, errors are raised as they are.
    """
    wants_json = "--json" in words
    with interruptible() as stop:
        try:
            code = app(args=list(words) or ["--help"], prog_name="gearplay", standalone_mode=False)
            sys.stdout.flush()
            if code == INTERRUPTED:  # what typer makes of Ctrl-C
                return _interrupted()
            return code if isinstance(code, int) else DONE
        except (KeyboardInterrupt, typer.Abort):
            return _interrupted()
        except BrokenPipeError:
            silence(1)
            return 0
        except Exception as error:
            if stop.is_set() and not isinstance(error, CommandInterruptedError):  # what a library made of it
                return _interrupted()
            error = too_little_memory(error) if is_too_little_memory(error) else output_failure(error)
            if debug:
                raise error
            return _report(error, wants_json)


def _interrupted() -> int:
    say_error("Interrupted.")
    return INTERRUPTED


def _report(error: Exception, wants_json: bool) -> int:
    """Print an error in one sentence and return its exit code."""
    code = BROKEN
    if isinstance(error, GearplayError):
        error = with_options(error)
        code, shown = error.exit_code, str(error)
    elif isinstance(error, _UsageError):
        code = InputError.exit_code
        where = getattr(getattr(error, "ctx", None), "command_path", "gearplay")
        error = InputError(Fault("gearplay", NO_VALUE, _sentence(error), f"Run {where} --help"))
        shown = str(error)
    else:
        shown = f"gearplay failed: {type(error).__name__}: {error}. Run again with --debug and report it."
    say_error(shown)
    if wants_json:
        print_json(error_document(error, code))
    return code


def _sentence(error: Exception) -> str:
    format_message: Callable[[], str] = getattr(error, "format_message", error.__str__)
    return " ".join(format_message().split()).rstrip(".")


if __name__ == "__main__":
    main()
