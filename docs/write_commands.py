"""Write docs/commands.md: every command with its arguments and options, from the command line itself."""

import re
from pathlib import Path
from typing import Any

import typer
from wrap_prose import wrap_prose

from gearplay.cli.main import app

OUT = Path(__file__).with_name("commands.md")
HEAD = """\
# Commands

`gearplay COMMAND --help` says the same. Every command takes `--json` (one document on standard output, messages on standard
error). A case is a TOML file or a bundled name (`gearplay copy` lists them); `--set PATH=VALUE` changes any of its fields and may
be repeated: `--set sleeves.ring.radial_clearance=50um --set run.ensemble=16`.

Exit codes: 0 done, 2 bad input, 3 simulation failed, 4 partly done, 5 over a resource limit, 6 unreadable measurement, 130
interrupted (what was kept is said). Long work shows progress and goes on where it was stopped.

This page is made from the command line by `make docs`.
"""


def shown(parameter: Any) -> tuple[str, str]:
    """Return how an argument or option is written, and what it says."""
    text = (getattr(parameter, "help", None) or "").replace("|", "\\|")
    if parameter.param_type_name == "argument":
        name = parameter.name.upper()
        return (f"`{name}`" if parameter.required else f"`[{name}]`"), text
    flags = ", ".join(f"`{flag}`" for flag in (*parameter.opts, *parameter.secondary_opts))
    value = parameter.default
    plain = (
        value is not None and not callable(value) and value is not False and value != () and value is not True
    )
    if plain and str(value).strip() and "UNSET" not in str(value).upper():
        text += f" Default: {value}."
    return flags, text


def entry(name: str, command: Any) -> str:
    """Return the part of the page on one command."""
    context = typer.Context(command, info_name=f"gearplay {name}")
    words = re.sub(r"\s+", " ", " ".join(command.collect_usage_pieces(context)))
    lines = [f"## {name}", "", (command.help or "").strip(), "", f"```text\ngearplay {name} {words}\n```", ""]
    rows = [shown(each) for each in command.params if each.name != "help"]
    lines += ["| | |", "|---|---|", *(f"| {flags} | {text} |" for flags, text in rows), ""]
    return "\n".join(lines)


def page() -> str:
    """Return the whole page."""
    group: Any = typer.main.get_command(app)
    return "\n".join([HEAD, *(entry(name, command) for name, command in group.commands.items())])


if __name__ == "__main__":
    OUT.write_text(wrap_prose(page()), encoding="utf-8")
