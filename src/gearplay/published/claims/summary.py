"""Summary of the claims as one document, computed or as shipped."""

import json
import threading
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import lru_cache
from importlib.resources import files
from typing import Any

from gearplay.published.article import conditions
from gearplay.published.claims.floor import floors
from gearplay.published.claims.points import ClaimSettings, PointResult, claims_plan, run_points
from gearplay.published.claims.repetition import repeated
from gearplay.published.claims.shares import (
    coupling_ratios,
    dropped,
    is_favoured,
    pattern_shares,
    share_of,
    shown_by_the_test,
    wedging,
)
from gearplay.published.comparison import article_error
from gearplay.published.han2021 import Store
from gearplay.published.settings import Settings
from gearplay.vocabulary.progress import Progress
from gearplay.vocabulary.version import VERSION

SHIPPED = "han2021_claims.json"
RARE = 0.05
"""A pattern is not a property of a model where even the upper end of its share is below this."""


def summarise(
    results: Sequence[PointResult],
    finer: Sequence[PointResult],
    floor: Sequence[dict[str, Any]],
    settings: ClaimSettings,
) -> dict[str, Any]:
    """Return the document: settings, shares, at a finer tolerance too, ratios, wedging, floors, and dropped points."""
    return {
        "version": VERSION,
        "settings": asdict(settings),
        "conditions": [c.label for c in conditions()],
        "ranges": [
            {"name": p.name, "path": p.path, "low": p.low, "high": p.high, "scale": p.scale}
            for p in claims_plan().parameters
        ],
        "test_shows": shown_by_the_test(),
        "shares": pattern_shares(results),
        "repeated": repeated(results, finer),
        "ratios": coupling_ratios(results),
        "wedging": wedging(results),
        "floors": list(floor),
        "dropped": dropped(results),
    }


def run_claims(
    settings: ClaimSettings,
    study: Settings,
    *,
    progress: Progress | None = None,
    store: Store | None = None,
    stop: threading.Event | None = None,
) -> dict[str, Any]:
    """Try the claims over the declared ranges, and find the perfect model's floor with the study's parameters.

    Finished points come from ``store``. Raises `KeyboardInterrupt` soon after ``stop`` is set.
    """
    results, finer = (
        run_points(each, progress=progress, store=store, stop=stop) for each in (settings, settings.finer())
    )
    limit = round(article_error("coupled", "amplitude_as_printed"), 1)
    floor = floors(study, limit, members=settings.floor_runs, progress=progress, stop=stop)
    return summarise(results, finer, floor, settings)


@lru_cache(maxsize=1)
def shipped_claims() -> dict[str, Any]:
    """Return the document that came with the package: 128 points of 8 members each."""
    text = files("gearplay.published").joinpath(SHIPPED).read_text(encoding="utf-8")
    document: dict[str, Any] = json.loads(text)
    return document


def favoured_words(document: Mapping[str, Any]) -> str:
    """Return in one sentence whether the printed, coupled equations favour the peak at 200/100 um, or that it cannot be told."""
    rows, controls = document["shares"], ("uncoupled_as_published", "coupled")
    printed = share_of(rows, "peak_200_100", "coupled_as_published")
    others = [share_of(rows, "peak_200_100", model) for model in controls]
    verdict = (
        "the printed, coupled equations make that peak"
        if is_favoured(rows, "peak_200_100", "coupled_as_published", controls)
        else "whether the printed, coupled equations make that peak cannot be told"
    )
    return (
        f"Largest at 200/100 µm in {_words(printed)} of the points with the coupled equations as printed,"
        f" {_words(others[0])} uncoupled as printed, {_words(others[1])} with exact flanks: {verdict}."
    )


def is_rare(document: Mapping[str, Any]) -> bool:
    """Return whether the peak at 120 rpm with exact flanks is rarer than `RARE`, with 95 % confidence."""
    return bool(share_of(document["shares"], "peak_120", "coupled")["high"] < RARE)


def rare_words(document: Mapping[str, Any]) -> str:
    """Return in one sentence how rare the peak at 120 rpm is with exact flanks, naming the points that show it."""
    row = share_of(document["shares"], "peak_120", "coupled")
    words = f"Largest at 120 rpm in {_words(row)} of the points with exact flanks, coupled"
    if is_rare(document):
        return f"{words}: fewer than {100.0 * RARE:.0f} % with 95 % confidence."
    seen = f"; seen at points {', '.join(map(str, row['points']))}" if row["points"] else ""
    return f"{words}, so that {100.0 * RARE:.0f} % cannot be excluded{seen}."


def _words(row: dict[str, Any]) -> str:
    return f"{100.0 * row['share']:.0f} % ({100.0 * row['low']:.0f} to {100.0 * row['high']:.0f} %)"
