"""`gearplay motion CASE`: classification of the motion, with the evidence."""

from math import isfinite
from typing import Annotated, Any

import typer

from gearplay.cli.arguments import CaseName, Changes, period_of
from gearplay.cli.interrupts import CommandInterruptedError, interruptible
from gearplay.cli.output import Json, print_json, print_text
from gearplay.cli.progress import compile_kernels, progress_bar

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
    compile_kernels(base, quiet=json, derivative=base.run.fixed_step is None)
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
    document = _document(base, found)
    print_json(document) if json else print_text(_words(document))


def _document(base: Any, found: Any) -> dict[str, Any]:
    return {
        "title": base.title,
        "case_sha256": base.sha256,
        "kind": found.kind,
        "order": found.order,
        "reason": found.reason,
        "section": {
            "kind": found.response.kind,
            "period": found.period,
            "evidence": _finite(found.response.evidence),
        },
        "exponent": _exponent(found.exponent),
        "comparisons": [
            {"change": c.change, "statistic": c.statistic, "usual": c.usual, "changed": c.changed, "t": c.t}
            for c in found.comparisons
            if isfinite(c.usual) and isfinite(c.changed)
        ],
        "limit": found.limit if isfinite(found.limit) else None,
    }


def _exponent(exponent: tuple[float, float]) -> dict[str, Any] | None:
    value, half = exponent
    return {"value": value, "half_width": half, "unit": "1/s"} if isfinite(value) else None


def _finite(numbers: Any) -> dict[str, float | None]:
    return {name: value if isfinite(value) else None for name, value in numbers.items()}


def _words(d: dict[str, Any]) -> str:
    order = f" of order {d['order']}" if d["order"] and d["kind"] == "periodic" else ""
    exponent = d["exponent"]
    pace = f"section once per {d['section']['period']:.4g} s."
    size = "No exact derivative with run.fixed_step, so no exponent"
    if exponent:
        size = f"Largest Lyapunov exponent {exponent['value']:.4g} ± {exponent['half_width']:.2g} 1/s (95 %)"
    lines = [f"{d['title'] or 'untitled'}: {d['kind']}{order}", d["reason"], f"{size}; {pace}"]
    if d["comparisons"]:
        worst = max(d["comparisons"], key=lambda each: abs(each["t"]))
        lines.append(
            f"Of {len(d['comparisons'])} statistics with {len({c['change'] for c in d['comparisons']})} changes of the method "
            f"the {worst['statistic']} changes most: {worst['usual']:.4g} to {worst['changed']:.4g} with {worst['change']}, "
            f"t = {worst['t']:.2g} (chance up to {d['limit']:.3g})."
        )
    return "\n".join(lines)
