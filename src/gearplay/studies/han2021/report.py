"""Report of the study: document, tables, figures, values of the page, PDF."""

import csv
import io
import json
import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

import gearplay as gp
from gearplay.studies.han2021 import (
    article,
    article_figures,
    comparison,
    figures,
    findings,
    shares,
    simulation,
)
from gearplay.studies.han2021.article import (
    AMPLITUDE,
    FREQUENCY,
    LINE_WORDS,
    LINES,
    MODELS,
    conditions,
    printed,
)
from gearplay.studies.han2021.comparison import ModelResult, Models
from gearplay.studies.han2021.simulation import CALIBRATED, MESH, Settings

STANDARD_GRAVITY = 9.80665  # m/s^2
LOOSE = 0.95  # share of time in contact of the driving flank: with more it does not rattle
QUESTIONS = (
    "What was simulated?",
    "Does it agree?",
    "Where not?",
    "Why not?",
    "What should I believe?",
)


@dataclass(frozen=True)
class Study:
    """A finished study: results, settings, and the document of the claims."""

    results: Sequence[simulation.ConditionResult]
    settings: Settings
    claims: Mapping[str, Any]

    @property
    def calibrated(self) -> bool:
        """Whether the parameters were fitted to the test."""
        return self.settings.parameters == CALIBRATED

    @cached_property
    def case(self) -> gp.Case:
        """The base case of the coupled model."""
        return simulation.base_case(self.settings.variants[0], self.settings)

    @cached_property
    def models(self) -> dict[str, ModelResult]:
        """The results by variant."""
        return comparison.by_model(self.results)

    @cached_property
    def findings(self) -> list[findings.Finding]:
        """Every claim with its verdict."""
        return findings.findings(self.models, self.claims, calibrated=self.calibrated)

    @cached_property
    def errors(self) -> list[dict[str, Any]]:
        """Mean errors [%] of amplitudes and f_r by model: the article's, ours on fresh members, left out, in the search."""
        table = []
        for model in MODELS:
            ours = self.models[model]
            row: dict[str, Any] = {
                "model": model,
                "article": (
                    article.article_error(model, AMPLITUDE),
                    article.article_error(model, FREQUENCY, "radial"),
                ),
                "fresh": (ours.amplitude_error(), ours.radial_error()),
            }
            if self.calibrated:
                radial = [article.left_out_error(model, c, "radial", FREQUENCY) for c in conditions()]
                row["in_sample"] = article.fit_of(model)["in_sample"][0]
                row["left_out"] = (article.fit_of(model)["held_out"][0], sum(radial) / len(radial))
            table.append(row)
        return table

    @cached_property
    def document(self) -> dict[str, Any]:
        """The study as a JSON-able document."""
        by_contact = [
            {"condition": r.condition.label, "model": r.model, "jam_ratio": r.jam_ratio, "contact": contact, **values}
            for r in self.results
            for contact, values in r.statistics.items()
        ]  # fmt: skip
        return {
            "parameters": self.settings.parameters,
            "case": self.settings.variants[0].case,
            "members": self.settings.members,
            "seed": self.settings.seed,
            "drag": self.case.rotors["ring"].load.drag,
            "case_sha256": self.case.sha256,
            "story": [
                {"question": question, "answer": answer}
                for question, answer in story(self.models, self.settings, self.claims)
            ],
            "factors": {model: self.models[model].factor for model in MODELS},
            "errors": self.errors,
            "findings": [finding._asdict() for finding in self.findings],
            "tables": comparison.table_rows(self.models, calibrated=self.calibrated),
            "contact_statistics": by_contact,
            "failures": [
                {"condition": r.condition.label, "model": r.model, "message": message}
                for r in self.results
                for message in r.failed
            ],
        }

    @cached_property
    def figures(self) -> dict[str, bytes]:
        """Every figure: name -> PNG."""
        models, claims = self.models, self.claims
        return {
            "lead": figures.lead(models),
            "mechanism": figures.mechanism(self.case, models["coupled"]),
            "audit": article_figures.audit(),
            "printed-errors": article_figures.printed_errors(),
            **{
                f"spectrum-{c.speed_rpm:g}rpm-{c.radial_clearance_um:g}-{c.backlash_um:g}": figures.spectrum(models, at)
                for at, c in enumerate(conditions())
            },
            "orbits": figures.orbits(models),
            "backlash": figures.backlash(models),
            "radial-frequency": figures.radial_frequency(models),
            "coupled-over-uncoupled": figures.coupled_over_uncoupled(comparison.line_differences(models)),
            "claims-shares": article_figures.claims_shares(claims),
            "claims-ratios": article_figures.claims_ratios(claims),
            "claims-floor": article_figures.claims_floor(claims),
        }  # fmt: skip

    def texts(self) -> dict[str, str]:
        """Return the tables and documents of the output folder by file name."""
        return {
            "tables.csv": _csv_text(self.document["tables"]),
            "contacts.csv": _csv_text(self.document["contact_statistics"]),
            "tables.json": json.dumps(self.document, indent=1, allow_nan=True),
            "claims.json": json.dumps(self.claims, indent=1),
        }

    def page_values(self, others: Mapping[str, str]) -> dict[str, Any]:
        """Return the values of the template ``report.html``, with links to the reports of the ``others``, by parameter set."""
        case, document = self.case, self.document
        largest_share = max(
            float(
                np.max(
                    each.amplitude / findings.amplitude_bound(findings.clearances(), each.table("frequency"))
                )
            )
            for each in self.models.values()
        )
        teeth = next(
            found.message
            for found in gp.check_case(case)
            if found.path == "meshes.0" and found.severity == "note"
        )
        return {
            **{name: document[name] for name in ("story", "factors", "errors", "findings", "failures")},
            "title": "the study of Han et al. 2021",
            "case": case,
            "settings": self.settings,
            "calibrated": self.calibrated,
            "others": others,
            "calibration": article.stored("calibration"),
            "groups": comparison.GROUPS,
            "rows": document["tables"],
            "words": LINE_WORDS,
            "models": MODELS,
            "figures": self.figures,
            "claims": self.claims,
            "tolerance_words": shares.tolerance_words(self.claims),
            "measures": shares.MEASURE_WORDS,
            "statistics": document["contact_statistics"],
            "contact_ratio": teeth.partition(" (")[0],
            "tilt": math.degrees(math.asin(math.hypot(*case.gravity) / STANDARD_GRAVITY)),
            "largest_share": largest_share,
            "record": self.results[0].record,
            "line_search": simulation.LINE_SEARCH,
            "totals": {
                "steps": sum(r.steps for r in self.results),
                "events": sum(r.events for r in self.results),
                "runs": sum(r.members + len(r.failed) for r in self.results),
            },
        }  # fmt: skip

    def pdf(self) -> bytes:
        """Return the report as PDF, by typst from the same document and figures."""
        import typst

        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            source = files(article.PACKAGE).joinpath("report.typ").read_text(encoding="utf-8")
            (place / "report.typ").write_text(source, encoding="utf-8")
            spectra = [name for name in self.figures if name.startswith("spectrum-")]
            text = json.dumps({**self.document, "spectra": spectra}).replace("NaN", "null")
            (place / "study.json").write_text(text, encoding="utf-8")
            for name, png in self.figures.items():
                (place / f"{name}.png").write_bytes(png)
            made: bytes = typst.compile(str(place / "report.typ"), root=str(place))
        return made


def _csv_text(rows: Sequence[Mapping[str, Any]]) -> str:
    buffer = io.StringIO()
    names = list(dict.fromkeys(name for row in rows for name in row))
    writer = csv.DictWriter(buffer, names, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})
    return buffer.getvalue()


def story(models: Models, settings: Settings, claims: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the summary: each question with its answer in one sentence, from the numbers of this run."""
    coupled = models["coupled"]
    sentences = (
        _simulated(settings),
        _agrees(coupled, settings),
        _worst(coupled),
        _why(coupled, claims),
        _believe(models, settings),
    )
    return list(zip(QUESTIONS, sentences, strict=True))


def _simulated(settings: Settings) -> str:
    kind = "parameters fitted to the test" if settings.parameters == CALIBRATED else "assumed parameters"
    return (
        f"The article's internal gear pair, its driven shaft loose in a sleeve: {len(conditions())} test conditions, coupled"
        f" and uncoupled backlash, {settings.members} runs of {settings.duration:g} s each, with {kind}, which the article does"
        " not give."
    )


def _agrees(coupled: ModelResult, settings: Settings) -> str:
    left_out = ""
    if settings.parameters == CALIBRATED:
        error = article.fit_of("coupled")["held_out"][0]
        left_out = f", {error:.0f} % under conditions that had no part in the choice of the parameters"
    return (
        f"With one common factor the coupled model meets the 18 amplitudes to {coupled.amplitude_error():.0f} % and f_r to"
        f" {coupled.radial_error():.0f} % on runs that no fit has seen{left_out}; the article reports"
        f" {article.article_error('coupled', AMPLITUDE):.1f} and {article.article_error('coupled', FREQUENCY, 'radial'):.1f} %."
    )


def _worst(coupled: ModelResult) -> str:
    ratio = (coupled.factor * coupled.amplitude / printed("test", AMPLITUDE)).ravel()
    parts = [
        f"{LINE_WORDS[LINES[k % len(LINES)]]} at {article.shown(conditions()[k // len(LINES)].label)} is"
        f" {max(ratio[k], 1.0 / ratio[k]):.1f} times too {'high' if ratio[k] > 1.0 else 'low'}"
        for k in np.argsort(-np.abs(np.log(ratio)))[:2]
    ]
    return f"The amplitude of {parts[0]} and that of {parts[1]}, the worst of the 18."


def _why(coupled: ModelResult, claims: Mapping[str, Any]) -> str:
    rattling = sum(r.statistics[f"{MESH}:drive"]["share_of_time"] < LOOSE for r in coupled.results)
    where = (
        "" if rattling == len(coupled.results) else f" under {rattling} of {len(coupled.results)} conditions"
    )
    median = claims["floors"][-1]["quantiles"]["50"]
    return (
        f"The motion is chaotic{where}, so that single runs even of a perfect model differ from each other by"
        f" {median:.0f} % in the median, and the article's frequencies are read no better than to"
        f" {article.reading_scatter(1):.1f} Hz: one record cannot tell a right model from a wrong one more finely."
    )


def _kept_up(coupled: ModelResult) -> str:
    if not coupled.swing_lasts:
        return " but, with these parameters, does not keep up"
    if not coupled.shaking:
        return ""
    return f" where something like a floor that shakes by {coupled.shaking:.2g} mm/s² rms keeps it up"


def _believe(models: Models, settings: Settings) -> str:
    kept = _kept_up(models["coupled"])
    swing = f"That f_r is the swing of the driven gear in its clearance, which either model has{kept}"
    if settings.parameters != CALIBRATED:
        errors = [models[model].amplitude_error() for model in MODELS]
        return (
            f"{swing}; which model is better these assumed parameters cannot say (mean errors {errors[0]:.0f} and"
            f" {errors[1]:.0f} %), a fit decides."
        )
    errors = [article.fit_of(model)["held_out"][0] for model in MODELS]
    where = f"({errors[0]:.0f} against {errors[1]:.0f} % under left-out conditions)"
    winner = article.stored("calibration")["winner"]
    if winner is None:
        return f"{swing}; whether coupling explains the test better cannot be told from these data {where}."
    return f"{swing}, and that the {winner.replace('_', ' ')} model explains the test best {where}."
