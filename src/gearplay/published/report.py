"""The study's output folder: report, tables, figures; and the store that lets a stopped study go on."""

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gearplay.files.atomic import make_folder, write_bytes, write_text
from gearplay.model.geometry import amplitude_bound
from gearplay.model.pack import pack
from gearplay.pictures.pages import data_uri, render_page
from gearplay.published import figures as study_figures
from gearplay.published.article import LINE_WORDS, conditions
from gearplay.published.assumptions import Assumption, assumptions
from gearplay.published.comparison import line_differences, model_amplitudes, table_rows
from gearplay.published.findings import Finding, findings
from gearplay.published.han2021 import ConditionResult
from gearplay.published.settings import MODELS, Settings, base_case


def _csv_text(rows: Sequence[dict[str, Any]]) -> str:
    names = list(dict.fromkeys(name for row in rows for name in row))
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, names, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})
    return buffer.getvalue()


def study_figures_of(results: Sequence[ConditionResult]) -> dict[str, bytes]:
    """Draw every figure of the study: name -> PNG."""
    figures = {
        f"spectrum-{c.speed_rpm:g}rpm-{c.radial_clearance_um:g}-{c.backlash_um:g}": study_figures.spectrum_figure(
            results, c
        )
        for c in conditions()
    }
    figures["orbits"] = study_figures.orbit_figure(results)
    figures["backlash"] = study_figures.backlash_figure(results)
    figures["radial-frequency"] = study_figures.radial_frequency_figure(results)
    figures["coupled-over-uncoupled"] = study_figures.difference_figure(line_differences(results))
    return figures


def _statistics(results: Sequence[ConditionResult]) -> list[dict[str, Any]]:
    return [
        {
            "condition": r.condition.label,
            "model": r.model,
            "jam_ratio": r.jam_ratio,
            "contact": contact,
            **values,
        }
        for r in results
        for contact, values in r.statistics.items()
    ]


def _bounds(results: Sequence[ConditionResult]) -> list[dict[str, Any]]:
    """Return the kinematic bound beside each simulated line: our own amplitudes must obey it."""
    rows = []
    for r in results:
        for line, found in r.lines.items():
            limit = amplitude_bound(1e-6 * r.condition.radial_clearance_um, found.frequency)
            rows.append({"line": line, "share": found.amplitude / limit})
    return rows


def render(results: Sequence[ConditionResult], settings: Settings, figures: dict[str, bytes]) -> str:
    """Return the report as one self-contained HTML page."""
    case = base_case(settings)
    images = {name: data_uri(png) for name, png in figures.items()}
    noted: list[Finding] = findings(results)
    assumed: list[Assumption] = assumptions(case, pack(case))
    return render_page(
        "gearplay.published",
        "report.html",
        title="the study of Han et al. 2021",
        case=case,
        settings=settings,
        findings=noted,
        rows=table_rows(results),
        words=LINE_WORDS,
        models=MODELS,
        factors={m: model_amplitudes(results, m).factor for m in MODELS},
        errors={m: model_amplitudes(results, m).mean_error("unnormalised") for m in MODELS},
        images=images,
        statistics=_statistics(results),
        assumptions=assumed,
        largest_share=max(b["share"] for b in _bounds(results)),
        record=results[0].record,
        failures=[(r.condition.label, r.model, m) for r in results for m in r.failed],
        totals={
            "steps": sum(r.steps for r in results),
            "events": sum(r.events for r in results),
            "runs": sum(r.members + len(r.failed) for r in results),
        },
    )


def write_study(results: Sequence[ConditionResult], settings: Settings, folder: Path) -> dict[str, Any]:
    """Write report, tables and figures into ``folder``; return a summary for a machine to read."""
    figures = study_figures_of(results)
    rows = table_rows(results)
    noted = findings(results)
    summary = {
        "case": settings.case,
        "members": settings.members,
        "drag": base_case(settings).rotors["ring"].load.drag,
        "case_sha256": base_case(settings).sha256,
        "factors": {m: model_amplitudes(results, m).factor for m in MODELS},
        "findings": [{"claim": f.claim, "verdict": f.verdict, "evidence": f.evidence} for f in noted],
        "tables": rows,
        "contact_statistics": _statistics(results),
        "failures": [
            {"condition": r.condition.label, "model": r.model, "message": m}
            for r in results
            for m in r.failed
        ],
    }
    make_folder(folder / "figures")
    for name, png in figures.items():
        write_bytes(folder / "figures" / f"{name}.png", png)
    write_text(folder / "tables.csv", _csv_text(rows))
    write_text(folder / "contacts.csv", _csv_text(_statistics(results)))
    write_text(folder / "tables.json", json.dumps(summary, indent=1, allow_nan=True))
    write_text(folder / "report.html", render(results, settings, figures))
    return summary
