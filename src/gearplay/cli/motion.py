"""`gearplay motion CASE`: classification of the motion, with the evidence."""

from dataclasses import asdict
from math import isfinite
from typing import Annotated, Any

import typer

from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.options import CaseName, Changes, period_of
from gearplay.cli.output import Json, print_json, print_text, result_lines
from gearplay.cli.progress import progress_bar

SectionPeriod = Annotated[
    str,
    typer.Option(
        "--period", help="common, mesh, shaft, a time: 25ms; auto: common up to 20 mesh periods, else mesh."
    ),
]


def motion(
    case: CaseName,
    periods: Annotated[int, typer.Option("--periods", help="Number of sections, 100 or more.")] = 1000,
    settle: Annotated[int, typer.Option("--settle", help="Periods that pass first.")] = 300,
    period: SectionPeriod = "auto",
    members: Annotated[
        int, typer.Option("--members", help="Members of each compared ensemble, 4 or more.")
    ] = 12,
    compare: Annotated[
        bool,
        typer.Option(
            "--compare/--no-compare", help="Repeat the ensemble with changed numbers of the method."
        ),
    ] = True,
    changes: Changes = None,
    json: Json = False,
) -> None:
    """Classify the settled motion of a case, with the evidence."""
    import gearplay as gp

    base = gp.load_case(case, changes or ())
    try:
        with interruptible() as stop, progress_bar(quiet=json) as report:
            found = gp.motion(
                base,
                periods=periods,
                settle=settle,
                period=period_of(period),
                ensemble=members,
                compare=compare,
                progress=report,
                stop=stop,
            )
    except KeyboardInterrupt:
        raise CommandInterruptedError("Interrupted before a result.") from None
    if json:
        print_json(_document(base, found))
    else:
        print_text("\n".join(result_lines(found, base.title or "Motion")))


def _document(base: Any, found: Any) -> dict[str, Any]:
    from gearplay.files.json_text import finite

    value, half = found.exponent
    response = found.response
    document: dict[str, Any] = finite(
        {
            "title": base.title,
            "case_sha256": base.sha256,
            "kind": found.kind,
            "order": found.order,
            "reason": found.reason,
            "section": {
                "kind": response.kind,
                "period": found.period,
                "evidence": dict(response.evidence),
            },
            "exponent": {"value": value, "half_width": half, "unit": "1/s"} if isfinite(value) else None,
            "comparisons": [
                asdict(c) for c in found.comparisons if isfinite(c.usual) and isfinite(c.changed)
            ],
            "limit": found.limit,
        }
    )
    return document
