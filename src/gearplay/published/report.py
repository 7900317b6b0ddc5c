"""Output folder of the study: report, tables, figures."""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

from gearplay.files.atomic import write_bytes, write_figures, write_text
from gearplay.model.case import Case
from gearplay.model.geometry import amplitude_bound
from gearplay.model.pack import pack
from gearplay.pictures.pages import render_page
from gearplay.published import figures as study_figures
from gearplay.published import summary_figures
from gearplay.published.article import LINE_WORDS, conditions
from gearplay.published.assumptions import assumptions
from gearplay.published.calibrated import calibration, fit_of, left_out_radial_error
from gearplay.published.claims.figures import claim_figures
from gearplay.published.claims.repetition import tolerance_words
from gearplay.published.claims.shares import MEASURE_WORDS
from gearplay.published.comparison import (
    article_error,
    line_differences,
    model_amplitudes,
    radial_frequency_error,
    table_rows,
)
from gearplay.published.findings import Finding, findings
from gearplay.published.han2021 import LINE_SEARCH, ConditionResult
from gearplay.published.patterns import GROUPS
from gearplay.published.settings import CALIBRATED, MODELS, Settings, base_case
from gearplay.published.summary import story


@dataclass(frozen=True)
class Study:
    """A finished study: results, how it was run, and the document of the claims."""

    results: Sequence[ConditionResult]
    settings: Settings
    claims: Mapping[str, Any]

    @property
    def calibrated(self) -> bool:
        """Whether the parameters were fitted to the test."""
        return self.settings.parameters == CALIBRATED

    @cached_property
    def case(self) -> Case:
        """The base case of the coupled model."""
        return base_case(self.settings.variants[0], self.settings)

    @cached_property
    def rows(self) -> list[dict[str, Any]]:
        """Tables 3-6 beside ours."""
        return table_rows(self.results, calibrated=self.calibrated)

    @cached_property
    def findings(self) -> list[Finding]:
        """Every claim with its verdict."""
        return findings(self.results, self.claims, calibrated=self.calibrated)

    @cached_property
    def story(self) -> list[tuple[str, str]]:
        """Five questions, each with its answer."""
        return story(self.results, self.settings, self.claims)

    @cached_property
    def errors(self) -> list[dict[str, Any]]:
        """Mean errors [%] of amplitudes and f_r by model: the article's, ours on fresh members, left out, in the search."""
        rows = []
        for model in MODELS:
            row = {
                "model": model,
                "article": (
                    article_error(model, "amplitude_as_printed"),
                    article_error(model, "frequency_hz", "radial"),
                ),
                "fresh": (
                    model_amplitudes(self.results, model).mean_error("unnormalised"),
                    radial_frequency_error(self.results, model),
                ),
            }
            if self.calibrated:
                fit = fit_of(model)
                row |= {
                    "in_sample": fit["in_sample"][0],
                    "left_out": (fit["held_out"][0], left_out_radial_error(model)),
                }
            rows.append(row)
        return rows

    @cached_property
    def figures(self) -> dict[str, bytes]:
        """Every figure: name -> PNG."""
        results = self.results
        figures = {
            "lead": summary_figures.lead_figure(results),
            "mechanism": summary_figures.mechanism_figure(self.case, results),
            "audit": summary_figures.audit_figure(),
            "printed-errors": summary_figures.printed_errors_figure(),
        }
        figures |= {
            f"spectrum-{c.speed_rpm:g}rpm-{c.radial_clearance_um:g}-{c.backlash_um:g}": study_figures.spectrum_figure(
                results, c
            )
            for c in conditions()
        }
        figures["orbits"] = study_figures.orbit_figure(results)
        figures["backlash"] = study_figures.backlash_figure(results)
        figures["radial-frequency"] = study_figures.radial_frequency_figure(results)
        figures["coupled-over-uncoupled"] = study_figures.difference_figure(line_differences(results))
        return figures | claim_figures(self.claims)

    @cached_property
    def statistics(self) -> list[dict[str, Any]]:
        """Contact statistics by condition, model and contact."""
        return [
            {
                "condition": r.condition.label,
                "model": r.model,
                "jam_ratio": r.jam_ratio,
                "contact": contact,
                **values,
            }
            for r in self.results
            for contact, values in r.statistics.items()
        ]

    @property
    def failures(self) -> list[dict[str, str]]:
        """Members that did not finish."""
        return [
            {"condition": r.condition.label, "model": r.model, "message": message}
            for r in self.results
            for message in r.failed
        ]


def _csv_text(rows: Sequence[Mapping[str, Any]]) -> str:
    names = list(dict.fromkeys(name for row in rows for name in row))
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, names, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})
    return buffer.getvalue()


def _largest_share(results: Sequence[ConditionResult]) -> float:
    """Return the largest of our amplitudes over its kinematic bound, which it must obey."""
    return max(
        found.amplitude / amplitude_bound(1e-6 * r.condition.radial_clearance_um, found.frequency)
        for r in results
        for found in r.lines.values()
    )


def render(study: Study, beside: Mapping[str, str]) -> str:
    """Return the report as one self-contained HTML page, with links to those of other parameters ``beside`` it."""
    results, case = study.results, study.case
    return render_page(
        "gearplay.published",
        "report.html",
        title="the study of Han et al. 2021",
        case=case,
        settings=study.settings,
        calibrated=study.calibrated,
        beside=beside,
        calibration=calibration(),
        story=study.story,
        groups=GROUPS,
        findings=study.findings,
        errors=study.errors,
        rows=study.rows,
        words=LINE_WORDS,
        models=MODELS,
        factors={m: model_amplitudes(results, m).factor for m in MODELS},
        figures=study.figures,
        claims=study.claims,
        tolerance_words=tolerance_words(study.claims),
        measures=MEASURE_WORDS,
        statistics=study.statistics,
        assumptions=assumptions(case, pack(case), calibrated=study.calibrated),
        largest_share=_largest_share(results),
        record=results[0].record,
        line_search=LINE_SEARCH,
        failures=study.failures,
        totals={
            "steps": sum(r.steps for r in results),
            "events": sum(r.events for r in results),
            "runs": sum(r.members + len(r.failed) for r in results),
        },
    )


def summary_of(study: Study) -> dict[str, Any]:
    """Return the study as a document for a machine to read."""
    return {
        "parameters": study.settings.parameters,
        "case": study.settings.variants[0].case,
        "members": study.settings.members,
        "seed": study.settings.seed,
        "drag": study.case.rotors["ring"].load.drag,
        "case_sha256": study.case.sha256,
        "story": [{"question": question, "answer": answer} for question, answer in study.story],
        "factors": {m: model_amplitudes(study.results, m).factor for m in MODELS},
        "errors": study.errors,
        "findings": [
            {"claim": f.claim, "verdict": f.verdict, "evidence": f.evidence, "figure": f.figure}
            for f in study.findings
        ],
        "tables": study.rows,
        "contact_statistics": study.statistics,
        "failures": study.failures,
    }


def write_study(
    study: Study, folder: Path, *, pdf: bool = False, beside: Mapping[str, str] = MappingProxyType({})
) -> dict[str, Any]:
    """Write report, tables and figures into ``folder``; return a summary for a machine to read.

    ``beside`` are the addresses of reports of other parameters, by the names of these.
    """
    summary = summary_of(study)
    write_figures(folder, study.figures)
    write_text(folder / "tables.csv", _csv_text(study.rows))
    write_text(folder / "contacts.csv", _csv_text(study.statistics))
    write_text(folder / "tables.json", json.dumps(summary, indent=1, allow_nan=True))
    write_text(folder / "claims.json", json.dumps(study.claims, indent=1))
    write_text(folder / "report.html", render(study, beside))
    if pdf:
        from gearplay.published.pdf import report_pdf

        write_bytes(folder / "report.pdf", report_pdf(summary, study.figures))
    return summary
