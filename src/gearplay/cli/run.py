"""`gearplay run CASE`: simulate one case, print its key numbers, save it."""

import shlex
from dataclasses import asdict
from math import isfinite
from pathlib import Path
from threading import Event
from time import perf_counter
from typing import Annotated, Any, TypeAlias

import typer

from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.options import CaseName, Changes
from gearplay.cli.output import Json, print_json, print_text, say_error
from gearplay.cli.progress import progress_bar
from gearplay.vocabulary.errors import SimulationError, TakenError
from gearplay.vocabulary.exit_codes import INTERRUPTED, PARTLY

MOST_CONTACTS = 12
"""Largest number of listed contacts."""

Saved: TypeAlias = tuple[Path | None, CommandInterruptedError | None]
"""Path of the saved result, or the reason why there is none."""


def _short(name: str, example: str) -> Any:
    """Return the option that sets ``run.NAME``."""
    help_text = f"Short for --set run.{name}={example}."
    return typer.Option(f"--{name}", metavar="VALUE", help=help_text, show_default=False)


def run(
    case: CaseName,
    out: Annotated[
        Path | None, typer.Option("--out", help="Write the result here: its motion, netCDF-4.")
    ] = None,
    changes: Changes = None,
    duration: Annotated[str | None, _short("duration", "2s")] = None,
    transient: Annotated[str | None, _short("transient", "1s")] = None,
    ensemble: Annotated[str | None, _short("ensemble", "16")] = None,
    seed: Annotated[str | None, _short("seed", "1")] = None,
    output: Annotated[
        str | None,
        typer.Option("--output", metavar="ROTOR", help="Shaft to report on, instead of the loaded one."),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing result.")] = False,
    json: Json = False,
) -> None:
    """Simulate a case: motion of the output shaft, contacts."""
    short = {"duration": duration, "transient": transient, "ensemble": ensemble, "seed": seed}
    given = [*(changes or ()), *(f"run.{name}={value}" for name, value in short.items() if value is not None)]
    result: Any = None
    shaft: Any = None
    saved: Saved | None = None
    document: dict[str, Any] = {}
    with interruptible() as stop:  # libraries that load may swallow the exception, not the event
        from gearplay.files.atomic import check_new
        from gearplay.files.netcdf import check_ending
        from gearplay.kernels.compiled import INTERPRETED
        from gearplay.kernels.library import library
        from gearplay.model.reading import load_case
        from gearplay.results.output_shaft import check_rotor
        from gearplay.results.simulate import simulate

        chosen = load_case(case, given)
        if out is not None:
            check_ending(out)
            check_new(out, overwrite=overwrite)
        check_rotor(chosen, output)
        if stop.is_set():
            raise KeyboardInterrupt
        if not INTERPRETED:
            library()  # its build after an installation is no part of the time of the run
        began, elapsed = perf_counter(), 0.0
        try:
            with progress_bar(quiet=json) as report:
                result = simulate(chosen, progress=report, stop=stop)
            elapsed = perf_counter() - began
            if out is not None:
                saved = _save(result, out, overwrite=overwrite, stop=stop)
            shaft = result.output_at(output)
            document = _summary(result, shaft, elapsed)
        except KeyboardInterrupt:
            if result is None or out is None:
                raise
            elapsed = elapsed or perf_counter() - began
            saved = saved or _save(result, out, overwrite=overwrite, stop=stop)
        stopped = result.status.name == "INTERRUPTED"
        place, lost = saved or (None, None)
        shaft = shaft or result.output_at(output)
        document = document or _summary(result, shaft, elapsed)
        document["out"] = None if place is None else str(place)
        error = lost
        if lost is not None:
            document["lost"] = str(lost)
        elif place is not None and stop.is_set() and not stopped:  # the result itself does not say so
            what = "the result is whole" if result.success else "what was computed is kept"
            error = CommandInterruptedError(f"Interrupted, but {what}: it is saved to {place}.")
            document["kept"] = str(error)
        if json:
            print_json(document)
        else:
            print_text(_words(document, shaft))
    if error is not None:
        if not json:
            raise error
        raise typer.Exit(error.exit_code)
    if stopped:
        raise typer.Exit(INTERRUPTED)
    if not result.success:
        say_error(f"{case}: {result.message}")
        partly = any(run.success for run in result.runs)
        raise typer.Exit(PARTLY if partly else SimulationError.exit_code)


def _save(result: Any, out: Path, *, overwrite: bool, stop: Event) -> Saved:
    """Save a result, after Ctrl-C its motion alone; return its path, or the error if Ctrl-C prevented it.

    An incomplete result never replaces an existing file: it is saved as ``NAME.partial.nc``.
    """
    partial = out.with_name(f"{out.stem}.partial{out.suffix}")
    for place, may_replace in [(out, overwrite)] if result.success else [(out, False), (partial, overwrite)]:
        before, taken = _mark(place), False
        try:
            result.save(place, overwrite=may_replace, signals=[] if stop.is_set() else None)
        except KeyboardInterrupt:
            words = f"while the result was saved. Nothing was written to {place}"
        except Exception as error:
            taken = isinstance(error, TakenError)
            if taken and place is out and not result.success:
                continue
            if not stop.is_set():
                raise
            words = f"and the result could not be saved: {str(error).rstrip('.')}"
        else:
            return place, None  # nothing in between where Ctrl-C could come
        if not taken and _mark(place) not in (None, before):  # its name comes before the last sync
            return place, None
        break
    return None, CommandInterruptedError(f"Interrupted {words}; the same command starts again.")


def _mark(path: Path) -> tuple[int, int] | None:
    """Return an identifier that changes when a file is replaced, None where there is no file."""
    try:
        found = path.lstat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns


def _summary(result: Any, shaft: Any, elapsed: float) -> dict[str, Any]:
    from gearplay.model.initial import usual_member
    from gearplay.results.contacts import SHOWN

    table = result.contacts
    return {
        "title": result.case.title,
        "case_sha256": result.case.sha256,
        "status": result.status.name,
        "message": result.message,
        "members": result.members,
        "simulated_time": result.reached,
        **asdict(result.work),
        "elapsed": elapsed,
        "output": {
            "rotor": shaft.rotor,
            "input": shaft.input,
            "ratio": shaft.ratio if isfinite(shaft.ratio) else None,
            **{name: value if isfinite(value) else None for name, value in shaft.values.items()},
        },
        "contacts": {
            label: {name: _finite(table.values[name][at]) for name in SHOWN}
            | ({"angular": True} if table.angular[at] else {})
            for at, label in enumerate(table.labels)
        },
        "contacts_of": table.words or "one run",
        "centred": result.members == 1 and usual_member(result.case) > 0,
    }


def _finite(value: Any) -> float:
    return float(value) if isfinite(value) else 0.0


def _words(d: dict[str, Any], shaft: Any) -> str:
    lines = [
        f"{d['title'] or 'untitled'}: {d['message']}",
        f"{d['simulated_time']:g} s simulated in {d['elapsed']:.3g} s, {d['steps']} steps, {d['events']} contact events"
        + (f", {d['members']} members, {d['wall_time']:.3g} core seconds" if d["members"] > 1 else ""),
        "",
        shaft.title,
        *(f"  {name:<40}{text}" for name, text in shaft.rows()),
        *([f"  {shaft.note}"] if shaft.note else []),
        "",
        *_contact_lines(d),
    ]
    if d["centred"]:
        lines.append(
            "It started exactly centred in a clearance; --set run.start=drawn starts as an ensemble does."
        )
    if d["out"] is not None:
        lines.append(f"Saved to {d['out']}, {Path(d['out']).stat().st_size / 1e6:.3g} MB")
        lines.append(f"See it: gearplay plot {shlex.quote(d['out'])}")
    return "\n".join(lines)


def _contact_lines(d: dict[str, Any]) -> list[str]:
    """Return the table of the contacts that closed, those with impacts first, and the names of the others."""
    from gearplay.pictures.words import significant

    closed = {label: c for label, c in d["contacts"].items() if c["share_of_time"] > 0.0}
    first = sorted(closed, key=lambda label: -closed[label]["impacts_per_second"])
    wide = max(24, *(len(label) + 1 for label in closed)) if closed else 24
    lines = []
    turned = ["angular" in c for c in closed.values()]
    peak = "peak torque" if all(turned) else "peak" if any(turned) else "peak force"
    if closed:
        lines.append(
            f"{'Contacts':<{wide}}{'time in contact':>16}{'impacts':>12}{'mean speed':>14}{peak:>13}"
        )
    for label in first[:MOST_CONTACTS]:
        c = closed[label]
        speed, force = ("mrad/s", "N m") if "angular" in c else ("mm/s", "N")
        lines.append(
            f"{label:<{wide}}"
            + f"{significant(100 * c['share_of_time'])} %".rjust(16)
            + f"{significant(c['impacts_per_second'])} 1/s".rjust(12)
            + " "
            + f"{significant(1e3 * c['mean_impact_speed'])} {speed}".rjust(13)
            + " "
            + f"{significant(c['peak_force'])} {force}".rjust(12)
        )
    if len(first) > MOST_CONTACTS:
        lines.append(f"and {len(first) - MOST_CONTACTS} more; --json lists all")
    if closed and d["members"] > 1:
        lines.append(f"Contacts: {d['contacts_of']}.")
    never = [label for label in d["contacts"] if label not in closed]
    if never:
        names = ", ".join(never[:4]) + (f" and {len(never) - 4} more" if len(never) > 4 else "")
        lines.append(f"Never in contact: {names}")
    return lines
