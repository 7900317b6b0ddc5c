"""`gearplay plot RUN.nc`: pictures of a stored result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gearplay.cli.options import si_number
from gearplay.cli.output import Json, print_json, print_text

if TYPE_CHECKING:
    from gearplay.results.result import Result

ENDINGS = (".png", ".svg", ".pdf")
KINDS = ("overview", "history", "orbit", "spectrum", "waterfall", "portrait", "mechanism")
Window = Annotated[
    str | None,
    typer.Option("--window", metavar="FROM:TO", help="Part of the result: 0.5s:0.6s, 0.5s: or :20ms."),
]
Run = Annotated[str, typer.Argument(help="A result that gearplay run has written.", show_default=False)]


def plot(
    run: Run,
    kind: Annotated[
        str | None,
        typer.Option(
            "--kind",
            help=f"{', '.join(KINDS)}.",
            show_default=False,
        ),
    ] = None,
    signal: Annotated[
        list[str] | None,
        typer.Option(
            "--signal", help="A signal, ax or ring.ax; by default the most informative. May be repeated."
        ),
    ] = None,
    at: Annotated[
        str | None, typer.Option("--at", help="A rotor, gear, mesh or coupling.", show_default=False)
    ] = None,
    window: Window = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="A .png, .svg or .pdf [default: in the folder of the result]."),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing picture.")] = False,
    json: Json = False,
) -> None:
    """Draw a result: overview, history, orbit, spectrum, mechanism."""
    from gearplay.files.atomic import check_new, write_bytes
    from gearplay.pictures.canvas import to_bytes
    from gearplay.results.choice import time_window
    from gearplay.vocabulary.errors import InputError
    from gearplay.vocabulary.suggestions import did_you_mean

    chosen = kind or ("history" if signal else "overview")
    if chosen not in KINDS:
        raise InputError.of(
            "--kind", chosen, "must be a kind of picture", did_you_mean(chosen, KINDS, "Kinds")
        )
    if signal and chosen not in ("history", "spectrum", "waterfall"):
        raise InputError.of(
            "--signal", signal[0], f"has no meaning for {chosen}", "Leave it out, or use --at"
        )
    if at and chosen == "overview":
        chosen = "history"
    place = out or Path(run).with_name(f"{Path(run).stem}-{chosen}.png")
    if place.suffix.lower() not in ENDINGS:
        raise InputError.of("--out", place.name, f"must end in {', '.join(ENDINGS)}", "Choose another ending")
    check_new(place, overwrite=overwrite)
    result = result_in(run)
    span = time_window(result, window_of(window))
    figure = _figure(result, chosen, signal or [], at, span)
    write_bytes(place, to_bytes(figure, place.suffix.lower()[1:]))
    if json:
        print_json({"status": "done", "kind": chosen, "out": str(place), "window": list(span)})
    else:
        print_text(f"Wrote {place}: {chosen}, {span[0]:.6g} to {span[1]:.6g} s")


def result_in(run: str) -> Result:
    """Return the stored result that a command names.

    Raises `InputError` for a case, or a result of another function.
    """
    from gearplay.model.bundled import bundled
    from gearplay.public_functions import read_result
    from gearplay.results.result import Result
    from gearplay.vocabulary.errors import InputError

    if run in bundled("gearplay.model", "cases") or run.endswith(".toml"):
        rule = "must be a result, not a case"
        raise InputError.of("run", run, rule, f"Simulate it first: gearplay run {run} --out run.nc")
    found = read_result(run)
    if not isinstance(found, Result):
        rule = f"must be the result of a run, not of {type(found).__name__.lower()}"
        raise InputError.of("run", Path(run).name, rule, "In Python read_result(...).plot() draws it")
    return found


def window_of(text: str | None) -> tuple[float | None, float | None] | None:
    """Return the two ends [s] of a window as it is given on the command line, None for an open one.

    >>> window_of("0.5s:600 ms"), window_of(":0.1"), window_of(None)
    ((0.5, 0.6), (None, 0.1), None)
    """
    from gearplay.vocabulary.errors import InputError
    from gearplay.vocabulary.quantities import TIME

    if text is None:
        return None
    ends = text.split(":")
    if len(ends) != 2:
        raise InputError.of("--window", text, "must be two times with a colon between", "Write 0.5s:0.6s")
    found = [si_number("--window", end, TIME) if end.strip() else None for end in ends]
    return found[0], found[1]


def _figure(result: Result, kind: str, names: list[str], at: str | None, window: tuple[float, float]) -> Any:
    """Return the figure of one of `KINDS`."""
    from gearplay.results import figures
    from gearplay.results.choice import choose

    if kind == "overview":
        return figures.overview_figure(result, window)
    if kind == "orbit":
        return figures.orbit_figure(result, _rotors(result, at), window)
    if kind == "portrait":
        from gearplay.nonlinear.portrait import stored_portrait
        from gearplay.results.titles import case_words, window_words

        rotors = _rotors(result, at)
        title = f"{case_words(result.case)}: portrait, {window_words(window)}".replace(" um", " µm")
        return stored_portrait(result, rotors, window).plot(rotors=tuple(rotors), title=title)
    if kind == "mechanism":
        from gearplay.results.staging import motion_in, stage_of

        stage = stage_of(motion_in(result, window, at=at))
        stage.show(stage.loudest(), "the instant of the largest force")
        return stage.figure
    if kind == "history":
        return figures.history_figure(result, choose(result, names, at), window)
    chosen = choose(result, names, at, kind="spectrum")
    if kind == "spectrum":
        return figures.spectrum_figure(result, chosen, window)

    return figures.waterfall_figure(result, *chosen[0], window)


def _rotors(result: Result, at: str | None) -> list[str]:
    """Return the rotors that a place names, none for all."""
    from gearplay.results.choice import elements_at

    if at is None:
        return []
    named = elements_at(result.case, at)
    pairs = [rotor for mesh in result.case.meshes if mesh.label in named for rotor in mesh.rotors]
    return [name for name in named if name in result.case.rotors] or pairs
