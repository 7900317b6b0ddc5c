"""Tolerance study of a sweep, as requested by ``[tolerance]`` in its plan: search, page, figures, JSON document."""

import itertools
import json
import math
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.files.atomic import write_figures, write_text
from gearplay.files.json_text import finite
from gearplay.pictures.pages import is_number, render_page
from gearplay.sweeps.plans.design import Design, Random
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.tolerance import Tolerance
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.folder import gather, run_in
from gearplay.sweeps.tolerances import figures as figures_of
from gearplay.sweeps.tolerances import words as words_of
from gearplay.sweeps.tolerances.allowable import Allowable, largest_scale, search_plan, size_words
from gearplay.sweeps.tolerances.figures import Scale, percent
from gearplay.sweeps.tolerances.statistics import Statistics, statistics_of
from gearplay.sweeps.variance import independent_rows, spoken
from gearplay.vocabulary.progress import Progress
from gearplay.vocabulary.version import VERSION
from gearplay.work.engine import Engine
from gearplay.work.folder import locked

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
PAGE, FOLDER = "tolerance.html", "tolerance"
"""The page, and the folder of the search's sweeps."""
MOST_DRAWN = 6  # conditions with figures of their own
MOST_LISTED = 500  # conditions in the table of the page


@dataclass(frozen=True)
class Condition:
    """One combination of the axes with its statistics; ``at`` has its values in SI, ``label`` as text."""

    at: dict[str, Any]
    label: str
    values: Floats
    scale: Scale
    statistics: Statistics


def values_of(product: "xr.Dataset", measure: str) -> Floats:
    """Return a measure of a product, shape [axis, ..., sample, member]; one member where there is no such dimension."""
    array = product[measure]
    last = ["sample", *(["member"] if "member" in array.dims else [])]
    found = array.transpose(*(d for d in array.dims if d not in last), *last).values.astype(np.float64)
    return np.asarray(found if "member" in array.dims else found[..., None])


def limit_of(made: Sweep) -> float:
    """Return the limit of a plan's tolerance in the measure's unit; `InputError` where its unit does not fit."""
    tolerance = made.plan.tolerance
    assert tolerance is not None
    unit = next(kept.unit for kept in made.reducer.layout if kept.name == tolerance.measure)
    return tolerance.limit_in(unit)


def write_tolerances(
    made: Sweep,
    product: "xr.Dataset",
    folder: Path,
    engine: Engine,
    *,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
) -> dict[str, Any]:
    """Write the tolerance page of a finished sweep into its folder and return its document.

    The search for the largest factor simulates; its sweeps are kept in ``tolerance/`` and resumed after an interruption.
    """
    plan, tolerance, search = made.plan, made.plan.tolerance, None
    assert tolerance is not None

    def at(*, fresh: bool) -> Callable[[float], Floats]:
        def evaluate(factor: float) -> Floats:
            part = Sweep(search_plan(plan, tolerance, factor, fresh=fresh))
            part.check_size()
            place = folder / FOLDER / f"{'fresh' if fresh else 'factor'}-{factor!r}"
            with locked(place):
                label = f"tolerances x {factor:.4g}, {'check by fresh draws' if fresh else 'search'}"
                run_in(part, place, engine, label=label, progress=progress, stop=stop)
                return values_of(gather(part, place), tolerance.measure)

        return evaluate

    if tolerance.scale:
        search = largest_scale(
            at(fresh=False),
            limit_of(made),
            probability=tolerance.probability,
            confidence=tolerance.confidence,
            factors=tolerance.factors,
            steps=tolerance.steps,
            check=at(fresh=True),
        )
    return write_tolerance(plan, tolerance, product, folder, search=search)


def write_tolerance(
    plan: SweepPlan,
    tolerance: Tolerance,
    product: "xr.Dataset",
    folder: Path,
    *,
    search: Allowable | None = None,
) -> dict[str, Any]:
    """Write tolerance.html, tolerance.json and the figures into ``folder``; return the document.

    ``product`` is that of the plan, which has a design; ``search`` the result of `largest_scale`. Every file is whole or
    absent. A plan with axes has results for each of their combinations, figures for the first few. Numbers that do not
    exist are null in the document and a dash on the page.

    Raises `InputError` for a limit in another unit than the measure's, or a folder that cannot be written.
    """
    assert plan.design is not None
    limit = tolerance.limit_in(str(product[tolerance.measure].attrs["units"]))
    found = list(conditions_of(plan, tolerance, product, limit))
    scales = {p.name: _scale_of(product, p.name) for p in plan.design.parameters}
    document = document_of(plan, tolerance, product, found, scales, search, limit)
    figures = draw_figures(tolerance, found, search, plan.design)
    write_figures(folder, figures, add=True)
    write_text(folder / "tolerance.json", json.dumps(document, indent=1, allow_nan=False))
    write_text(folder / PAGE, render(plan, found, scales, document, figures))
    return document


def conditions_of(
    plan: SweepPlan, tolerance: Tolerance, product: "xr.Dataset", limit: float
) -> Iterator[Condition]:
    """Yield the statistics at each combination of the axes."""
    assert plan.design is not None
    array = product[tolerance.measure]
    drawn = np.column_stack([product[p.name].values.astype(np.float64) for p in plan.design.parameters])
    table, unit = values_of(product, tolerance.measure), str(array.attrs["units"])
    axes = [str(d) for d in array.dims if d not in ("sample", "member")]
    name = str(array.attrs["long_name"])
    for place in itertools.product(*(range(product.sizes[a]) for a in axes)):
        values = table[place]
        largest = float(np.nanmax(np.abs(values), initial=abs(limit), where=np.isfinite(values)))
        at = {a: product[a].values[i] for a, i in zip(axes, place, strict=True)}
        label = ", ".join(
            f"{a} {value if isinstance(value, str) else _scale_of(product, a).words(float(value))}"
            for a, value in at.items()
        )
        statistics = statistics_of(
            plan.design, drawn, values, limit, confidence=tolerance.confidence, seed=plan.design.seed
        )
        yield Condition(at, label, values, Scale.of(name, unit, largest), statistics)


def _scale_of(product: "xr.Dataset", name: str) -> Scale:
    values = product[name].values
    largest = float(np.max(np.abs(values))) if values.dtype.kind in "if" and values.size else 0.0
    return Scale.of(name, str(product[name].attrs.get("units", "1")), largest)


def document_of(
    plan: SweepPlan,
    tolerance: Tolerance,
    product: "xr.Dataset",
    found: list[Condition],
    scales: dict[str, Scale],
    search: Allowable | None,
    limit: float,
) -> dict[str, Any]:
    """Return the study as one JSON-able document, numbers in SI."""
    assert plan.design is not None
    attributes = product[tolerance.measure].attrs
    sought = None
    if search is not None:
        grown = [p for p in plan.design.parameters if p.name in tolerance.scale]
        sought = {
            **asdict(search),
            "safe": search.safe,
            "advised": search.advised,
            "confirmed": search.confirmed,
            "sizes": _sizes(search, grown, tolerance.scaling),
            "words": words_of.search_words(search, grown, tolerance.scaling),
        }
    document: dict[str, Any] = finite(
        {
            "title": plan.title,
            "measure": {
                "name": tolerance.measure,
                "unit": attributes["units"],
                "long_name": attributes["long_name"],
            },
            "limit": limit,
            "tolerance": tolerance.model_dump(mode="json"),
            "design": {"kind": plan.design.kind, "count": plan.design.count, "seed": plan.design.seed},
            "members": plan.members,
            "conditions": [_condition_document(each, tolerance, scales) for each in found],
            "search": sought,
            "gearplay_version": VERSION,
        }
    )
    return document | {"answer": first_words(document)}


def _sizes(search: Allowable, grown: list[Random], scaling: str) -> list[dict[str, str]]:
    """Return the distribution of each parameter of the search: as planned, at the advised factor, at the estimate."""
    factors = {"planned": 1.0, "advised": search.advised, "estimate": search.factor}
    return [
        {"name": p.name}
        | {key: size_words(p, scaling, f) if math.isfinite(f) else "–" for key, f in factors.items()}
        for p in grown
    ]


def first_words(document: dict[str, Any]) -> list[str]:
    """Return the summary in at most three sentences: limit kept or not, safe size, dominant parameter."""
    conditions, search = document["conditions"], document["search"]
    if len(conditions) != 1:
        counts = Counter(each["verdict"] for each in conditions)
        verdicts = ", ".join(
            f"{words} in {counts[key]}" for key, words in words_of.STANDING.items() if counts[key]
        )
        return [f"{document['measure']['name']} over {len(conditions)} conditions: {verdicts}."]
    words = conditions[0]["words"]
    indices = next((line for line in words if "matter" in line), "")
    return [line for line in (words[0], search["words"][0] if search else "", indices) if line]


def _condition_document(found: Condition, tolerance: Tolerance, scales: dict[str, Scale]) -> dict[str, Any]:
    own, measure, wanted = found.statistics, tolerance.measure, tolerance.probability
    words = words_of.exceedance_words(own.exceedance, measure, found.scale, wanted)
    words += words_of.indices_words(own.indices)
    if own.cuts and own.cuts[0].probability < own.exceedance.probability:
        words.append(words_of.cut_words(own.cuts[0], scales[own.cuts[0].name]))
    verdict = words_of.verdict_of(own.exceedance, wanted)
    return {"at": found.at, "label": found.label, "verdict": verdict, "words": words, **asdict(own)}


def draw_figures(
    tolerance: Tolerance, found: list[Condition], search: Allowable | None, design: Design | None = None
) -> dict[str, bytes]:
    """Draw every figure of the page: name -> PNG."""
    figures: dict[str, bytes] = {}
    for at, each in enumerate(found[:MOST_DRAWN]):
        tail = f"-{at + 1}" if len(found) > 1 else ""
        where = f", {each.label}" if each.label else ""
        values = each.values if design is None else each.values[independent_rows(design)]
        figures[f"distribution{tail}"] = figures_of.distribution_figure(
            values, each.statistics.distribution, each.statistics.exceedance, each.scale,
            f"Distribution of {tolerance.measure}{where}", wanted=tolerance.probability,
        )  # fmt: skip
        indices = each.statistics.indices
        if not indices.reason:
            made = "" if indices.source == "sobol" else f" of a polynomial of degree {indices.degree}"
            figures[f"indices{tail}"] = figures_of.indices_figure(
                indices, f"Where the scatter of {tolerance.measure} comes from: Sobol indices{made}{where}"
            )
    if search is not None:
        names = " and ".join(map(spoken, tolerance.scale))
        title = f"How large {names} may be: {tolerance.measure} within its limit"
        grows = "each of them"
        if len(tolerance.scale) == 1 and design is not None:
            (one,) = (p for p in design.parameters if p.name in tolerance.scale)
            grows = f"{names} (1: {size_words(one, tolerance.scaling)})"
        figures["search"] = figures_of.search_figure(search, title, grows)
    return figures


def _percent(value: Any) -> str:
    return percent(value) if is_number(value) else "–"


def render(
    plan: SweepPlan,
    found: list[Condition],
    scales: dict[str, Scale],
    document: dict[str, Any],
    figures: dict[str, bytes],
) -> str:
    """Return the page, self-contained HTML."""
    return render_page(
        "gearplay.sweeps.tolerances",
        "page.html",
        filters={"percent": _percent},
        figures=figures,
        title=plan.title or "Tolerance study",
        plan=plan,
        found=found[:MOST_LISTED],
        more=max(0, len(found) - MOST_LISTED),
        drawn=MOST_DRAWN,
        scales=scales,
        document=document,
        caption=words_of.CAPTION,
    )
