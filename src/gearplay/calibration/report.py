"""Output folder of a calibration: report, residual table, figures, JSON document."""

import csv
import io
import json
import math
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from gearplay.calibration import figures as figures_of
from gearplay.calibration.model_comparison import CLEAR, OPEN, STRONG, Conclusion, conclude
from gearplay.calibration.out_of_sample import CHECK_SEED, CHOOSE_SEED, mean_error
from gearplay.calibration.plan import Plan
from gearplay.calibration.posterior import KNOWN
from gearplay.calibration.procedure import Fit
from gearplay.calibration.spans import Span, Spans, datum_unit, spans_of
from gearplay.files.atomic import write_figures, write_text
from gearplay.files.json_text import finite
from gearplay.pictures.pages import fixed, render_page
from gearplay.pictures.words import offset_in, shown_in
from gearplay.work.pieces import with_digest

PACKAGES = ("gearplay", "numpy", "scipy", "numba", "optuna", "matplotlib")
COLUMNS = (
    "model", "reading", "condition", "target", "key", "unit", "measured", "simulated",
    "residual_decades", "error_pct", "ensemble_error_decades", "predicted_residual_decades",
)  # fmt: skip


def write_calibration(plan: Plan, fits: Sequence[Fit], folder: Path) -> dict[str, Any]:
    """Write report, residual table, figures and the JSON document into ``folder``; return that document.

    Every file is whole or absent; the document's has a digest. Numbers that do not exist, such as the frequency error of a
    plan without frequencies, are null in the document, empty in the table and a dash on the page.

    Raises `InputError` where the folder cannot be written.
    """
    spans = spans_of(plan, fits)
    conclusion = conclude(
        {name: [fit.standing for fit in fits if fit.reading == name] for name in _readings(fits)}
    )
    document = document_of(plan, fits, spans, conclusion)
    figures = draw_figures(plan, fits, spans)
    write_figures(folder, figures)
    write_text(folder / "residuals.csv", residuals_csv(plan, fits))
    text = json.dumps(with_digest(document), indent=1, allow_nan=False)
    write_text(folder / "calibration.json", text)
    write_text(folder / "report.html", render(plan, fits, document, figures))
    return document


def _readings(fits: Sequence[Fit]) -> list[str]:
    return list(dict.fromkeys(fit.reading for fit in fits))


def document_of(plan: Plan, fits: Sequence[Fit], spans: Spans, conclusion: Conclusion) -> dict[str, Any]:
    """Return the calibration as one JSON-able document; the posterior sample and the history are left out."""
    conclusions = {
        "overall": conclusion.overall,
        "words": _sentences(conclusion),
        "readings": [
            {"reading": r.reading, "winner": r.winner, "words": r.words} for r in conclusion.readings
        ],
    }
    pairs = [
        {"reading": r.reading, **asdict(pair), "winner": pair.winner, "words": pair.words}
        for r in conclusion.readings
        for pair in r.pairs
    ]
    document: dict[str, Any] = finite(
        {
            "title": plan.title,
            "statement": conclusions,
            "answer": summary_of(plan, fits, spans, conclusion),
            "duels": pairs,
            "fits": [_fit_document(plan, fit, spans[fit.model]) for fit in fits],
            "plan": plan.model_dump(mode="json"),
            "versions": {"python": platform.python_version(), **{name: _version(name) for name in PACKAGES}},
        }
    )
    return document


def summary_of(plan: Plan, fits: Sequence[Fit], spans: Spans, conclusion: Conclusion) -> list[str]:
    """Return the summary in sentences: the intervals against the values of the case, which model, how well.

    The model is left out where there is only one; a last sentence reports a fit whose motion has not settled.
    """
    reading = fits[0].reading
    own = [fit for fit in fits if fit.reading == reading]
    where = "" if len(_readings(fits)) == 1 else f" (reading {reading})"
    single = len(plan.conditions) == 1
    errors = "; ".join(
        f"{fit.model} {fixed(fit.amplitude_error, 0)} %"
        + ("" if single else f" and {fixed(mean_error(fit.left_out, frequencies=False), 0)} %")
        for fit in own
    )
    which = "on fresh members" if single else "on fresh members, and under conditions left out of the fit"
    named = next((fit for fit in own if fit.model == conclusion.overall), None)
    best = named or min(own, key=lambda fit: fit.amplitude_error)
    return [
        _interval_words(best, spans[best.model]),
        *(_sentences(conclusion)[:1] if len(plan.models) > 1 else []),
        f"Mean error of amplitudes {which}{where}: {errors}.",
        *(["The plan has one condition: no other record tests the fit."] if single else []),
        *_unsettled(plan, own),
    ]


def _interval_words(fit: Fit, spans: Sequence[Span]) -> str:
    """Return the sentence about a fit's parameters: each interval against the value of the case."""
    identified, others = [], []
    for span, each in zip(spans, fit.intervals, strict=True):
        name, unit = span.name.replace("_", " "), "" if span.unit == "1" else f" {span.unit}"
        words = f"{name} {span.words(each.low)} to {span.words(each.high)}{unit}"
        if not each.identified:
            others.append(words)
            continue
        if math.isfinite(span.drawn):
            place = "below" if span.drawn < each.low else "above" if span.drawn > each.high else "inside"
            words += f" (the case's {span.words(span.drawn)} lies {place})"
        identified.append(words)
    if not identified:
        return (
            f"The data identify none of the {len(spans)} parameters of the model {fit.model}; 90 % intervals:"
            f" {', '.join(others)}."
        )
    rest = f"; not identified: {', '.join(others)}" if others else ""
    return f"90 % intervals of the model {fit.model}: {', '.join(identified)}{rest}."


def _unsettled(plan: Plan, fits: Sequence[Fit]) -> list[str]:
    """Return the sentence about fits whose motion changes after the transient, if there are any."""
    changing = [fit for fit in fits if fit.drift]
    if not changing:
        return []
    most = max((fit.drift[0] for fit in changing), key=lambda drift: abs(drift.decades))
    models = " and ".join(fit.model for fit in changing)
    return [
        f"The start is not forgotten ({models}): the {most.key} of {most.target}, {most.condition}, is"
        f" {10.0**most.decades:.2g} times as large after {most.transient:g} s as after {plan.simulation.transient:g} s. Lengthen"
        " simulation.transient, or the fit explains the initial states that were drawn."
    ]


def _sentences(conclusion: Conclusion) -> list[str]:
    """Return the conclusion as lines: over all readings, then each reading with its evidence."""
    lines = [
        conclusion.words[:1].upper() + conclusion.words[1:]
        if conclusion.overall == OPEN
        else conclusion.words
    ]
    for each in conclusion.readings:
        if len(conclusion.readings) > 1:
            lines.append(f"Reading {each.reading}: {each.words}")
        lines += [pair.words for pair in each.pairs]
    return lines


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # run from a source tree
        return "unknown"


def _fit_document(plan: Plan, fit: Fit, spans: Sequence[Span]) -> dict[str, Any]:
    """Return one fit with the additions of the report: units, bounds, verdicts, means over conditions.

    Numbers are in SI; of the unit shown there are ``shown_factor`` in one of SI, 0 in SI is
    ``shown_offset``.
    """
    held = {key: value for key, value in asdict(fit).items() if key not in ("sample", "history")}
    predicted = _predicted(fit)
    held["parameters"] = [
        {
            "name": span.name,
            "unit": span.si,
            "shown_unit": span.unit,
            "shown_factor": span.factor,
            "case": span.drawn,
            "shown_offset": offset_in(span.unit),
            "searched": [(end - offset_in(span.unit)) / span.factor for end in (span.low, span.high)],
            "scale": span.scale,
            "best": fit.best[span.name],
            "low": interval.low,
            "median": interval.median,
            "high": interval.high,
            "half_width": interval.half_width,
            "identified": interval.identified,
        }
        for span, interval in zip(spans, fit.intervals, strict=True)
    ]
    held["rows"] = [
        {
            **asdict(row),
            "unit": datum_unit(plan, fit.reading, row),
            "error": row.error,
            "predicted_residual": predicted.get((row.condition, row.target, row.key), math.nan),
        }
        for row in fit.rows
    ]
    held["predicted_amplitude_error"] = _mean([each.amplitude_error for each in fit.predicted])
    held["predicted_frequency_error"] = _mean([each.frequency_error for each in fit.predicted])
    held["left_out_amplitude_error"] = mean_error(fit.left_out, frequencies=False)
    held["left_out_frequency_error"] = mean_error(fit.left_out, frequencies=True)
    held["standing"]["predictive"] = fit.standing.predictive
    return held


def _predicted(fit: Fit) -> dict[tuple[str, ...], float]:
    """Return the residual [decades] of each datum predicted from the other conditions."""
    return {
        (each.condition, *label.rsplit(", ", 2)[1:]): residual
        for each in fit.predicted
        for label, residual in zip(each.labels, each.residuals, strict=True)
    }


def _mean(values: Sequence[float]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return float(np.mean(known)) if known else math.nan


def residuals_csv(plan: Plan, fits: Sequence[Fit]) -> str:
    """Return the residuals of every datum, model and reading as CSV, all digits kept, missing numbers empty."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(COLUMNS)
    for fit in fits:
        predicted = _predicted(fit)
        for row in fit.rows:
            foretold = predicted.get((row.condition, row.target, row.key), math.nan)
            numbers = (row.measured, row.simulated, row.residual, row.error, row.ensemble_error, foretold)
            unit = datum_unit(plan, fit.reading, row)
            writer.writerow(
                [fit.model, fit.reading, row.condition, row.target, row.key, unit]
                + [repr(float(v)) if math.isfinite(v) else "" for v in numbers]
            )
    return buffer.getvalue()


def draw_figures(plan: Plan, fits: Sequence[Fit], spans: Spans) -> dict[str, bytes]:
    """Draw every figure of the report: name -> PNG."""
    colors = figures_of.colors_of(fits)
    models = list(colors)
    found = {"convergence": figures_of.convergence_figure(fits, colors)}
    for reading in _readings(fits):
        own = [fit for fit in fits if fit.reading == reading]
        found[f"posterior-{reading}"] = figures_of.posterior_figure(own, spans, colors)
        for fit in (fit for fit in own if fit.sample and len(fit.unit) > 1):
            name = f"pairs-{reading}-{models.index(fit.model) + 1}-{_slug(fit.model)}"
            found[name] = figures_of.pair_figure(fit, spans[fit.model], colors[fit.model])
        found[f"match-{reading}"] = figures_of.match_figure(
            plan, own, partial(datum_unit, plan, reading), colors
        )
        if any(fit.predicted for fit in own):
            found[f"predicted-{reading}"] = figures_of.predicted_figure(plan, own, colors)
    return found


def _slug(text: str) -> str:
    """Return a user's name as a part of a file name.

    >>> _slug("../Coupled, as published!")
    'coupled-as-published'
    """
    return re.sub(r"[^a-z0-9_]+", "-", text.lower()).strip("-")[:40]


def _shown_unit(row: Mapping[str, Any]) -> str:
    """Return the unit in which the page shows a datum."""
    return shown_in(row["unit"], abs(row["measured"] or 0.0))[0]


def _shown(row: Mapping[str, Any], name: str) -> float | None:
    """Return a value of a datum in the unit in which the page shows it.

    >>> _shown({"unit": "m", "measured": 2e-6, "simulated": 1e-6}, "simulated")
    1.0
    """
    factor = shown_in(row["unit"], abs(row["measured"] or 0.0))[1]
    return None if row[name] is None else float(f"{factor * row[name]:.12g}")


def render(plan: Plan, fits: Sequence[Fit], document: dict[str, Any], figures: dict[str, bytes]) -> str:
    """Return the report as one self-contained HTML page."""
    readings = _readings(fits)
    return render_page(
        "gearplay.calibration",
        "report.html",
        filters={"shown": _shown, "shown_unit": _shown_unit},
        figures=figures,
        title=plan.title or "Calibration",
        plan=plan,
        document=document,
        readings=readings,
        by_reading={r: [f for f in document["fits"] if f["reading"] == r] for r in readings},
        undecided=OPEN,
        known=100.0 * KNOWN,
        strong=STRONG,
        clear=CLEAR,
        seeds={"choose": plan.effort.seed + CHOOSE_SEED, "check": plan.effort.seed + CHECK_SEED},
    )
