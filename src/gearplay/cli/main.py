"""The command ``gearplay``: registration of the commands, errors as one sentence and an exit code."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup
from typer.main import get_command

from gearplay.cli.interrupts import CommandInterruptedError, interruptible, leave_at_once
from gearplay.cli.options import with_options
from gearplay.cli.output import error_document, open_streams, output_failure, print_json, say_error, silence
from gearplay.vocabulary.errors import NO_VALUE, GearplayError, InputError
from gearplay.vocabulary.exit_codes import BROKEN, DONE, INTERRUPTED
from gearplay.vocabulary.memory import is_too_little_memory, too_little_memory

COMMANDS: Final = (
    "check",
    "copy",
    "import_",
    "run",
    "plot",
    "animate",
    "export",
    "export_fmu",
    "export_dxf",
    "study",
    "sweep",
    "resume",
    "dataset",
    "teeth",
    "modes",
    "load_sharing",
    "lost_motion",
    "wear",
    "motion",
    "portrait",
    "bifurcation",
    "measure",
    "analyze",
    "diagnose",
    "calibrate",
    "serve",
    "schema",
    "validate",
)
"""Functions of the commands, in modules of `gearplay.cli` of their names, which are imported when they are called or listed."""
MODULES: Final = {"resume": "sweep"}
"""Modules of other names."""
WORDS: Final = {"export_fmu": "export fmu", "export_dxf": "export dxf", "import_": "import"}
"""Words of commands that are not those of their functions."""

FIRST_STEP: Final = """\
Begin with: gearplay run han2021 --set sleeves.ring.radial_clearance=50um

Bundled cases and plans: gearplay copy
"""


OUTPUT: Final[Mapping[str, Any]] = {"pretty_exceptions_enable": False, "rich_markup_mode": None}


@cache
def _command(name: str) -> Any:
    """Return a command, made from the function of its module."""
    alone = typer.Typer(add_completion=False, **OUTPUT)
    alone.command()(getattr(import_module(f"gearplay.cli.{MODULES.get(name, name)}"), name))
    return get_command(alone)


class _Commands(Mapping[str, Any]):
    """Commands by the names on the command line."""

    _names: Final = {WORDS.get(name, name.replace("_", "-")): name for name in COMMANDS}

    def __getitem__(self, name: str) -> Any:
        return _command(self._names[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


class _Group(TyperGroup):
    """Group that imports only the command that is called."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        self.commands = _Commands()  # type: ignore[assignment]

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command of the first word, or of the first two."""
        if " ".join(args[:2]) in WORDS.values():
            args = [" ".join(args[:2]), *args[2:]]
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="gearplay",
    cls=_Group,
    help="Dynamics of gear mechanisms whose small clearances are coupled.",
    epilog=FIRST_STEP,
    add_completion=True,
    **OUTPUT,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from gearplay import __version__

        sys.stdout.write(f"gearplay {__version__}\n")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Define the options before the command; `main` has read --debug already."""


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
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # not searched for in all packages
    words = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in words
    code = run([word for word in words if word != "--debug"], debug=debug)
    leave_at_once(code)
    if code == INTERRUPTED:  # without waiting for what a library still does on a thread
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    gc.freeze()  # or Python's end spends a tenth of a second on a last collection
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)  # while Python itself ends
    sys.exit(code)


def run(words: Sequence[str], *, debug: bool = False) -> int:
    """Run one command and return its exit code; handles every error of a user.

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
        error = InputError.of("gearplay", NO_VALUE, _sentence(error), f"Run {where} --help")
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
