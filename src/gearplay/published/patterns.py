"""Significance test of the claimed patterns: location of the largest vibration."""

import math
from collections.abc import Sequence
from itertools import pairwise

from gearplay.published.article import LINE_WORDS, LINES, Condition, printed
from gearplay.published.comparison import by_condition
from gearplay.published.han2021 import ConditionResult

REPRODUCED, EXPLAINED, CONTRADICTED, OPEN = GROUPS = ("reproduced", "explained", "contradicted", "open")
"""What may become of a claim."""
CLEAR = 2.0  # standard errors


def _is_largest(
    found: dict[Condition, ConditionResult], top: Condition, others: Sequence[Condition], line: str
) -> tuple[str, str]:
    """Return whether ``top`` has the highest level of a line by more than `CLEAR` standard errors, and the numbers."""
    level, error = found[top].lines[line].log_level()
    margins = []
    for other in others:
        rival, rival_error = found[other].lines[line].log_level()
        margins.append((level - rival) / math.hypot(error, rival_error))
    rivals = ", ".join(f"{10 ** found[c].lines[line].log_level()[0]:.3g}" for c in others)
    words = f"{LINE_WORDS[line]}: {10**level:.3g} against {rivals} m/s²"
    if min(margins) > CLEAR:
        return REPRODUCED, words
    return (CONTRADICTED if min(margins) < -CLEAR else OPEN), words


SAID = {REPRODUCED: "yes", CONTRADICTED: "no", OPEN: "cannot be told"}


def _joined(parts: Sequence[tuple[str, str]]) -> tuple[str, str]:
    verdicts = {verdict for verdict, _ in parts}
    words = "; ".join(f"{text} ({SAID[verdict]})" for verdict, text in parts) + "."
    if verdicts == {REPRODUCED}:
        return REPRODUCED, words
    return (CONTRADICTED if CONTRADICTED in verdicts else OPEN), words


def peak_at_120(results: Sequence[ConditionResult], model: str) -> tuple[str, str]:
    """Return the verdict on a model's lines being highest at 120 rpm, with the numbers."""
    found = by_condition(results, model)
    slow, middle, fast = (Condition(v, 100.0, 100.0) for v in (60.0, 120.0, 180.0))
    return _joined([_is_largest(found, middle, (slow, fast), line) for line in LINES])


def grows_with_speed(results: Sequence[ConditionResult]) -> tuple[str, str]:
    """Return the verdict on the uncoupled model's lines growing with speed, with numbers, and what the article's table shows."""
    found = by_condition(results, "uncoupled")
    speeds = [Condition(v, 100.0, 100.0) for v in (60.0, 120.0, 180.0)]
    parts = []
    for line in LINES:
        levels = [found[c].lines[line].log_level() for c in speeds]
        steps = [(b[0] - a[0]) / math.hypot(a[1], b[1]) for a, b in pairwise(levels)]
        verdict = REPRODUCED if min(steps) > CLEAR else CONTRADICTED if min(steps) < -CLEAR else OPEN
        numbers = ", ".join(f"{10**v:.3g}" for v, _ in levels)
        parts.append((verdict, f"{LINE_WORDS[line]}: {numbers} m/s² at 60, 120, 180 rpm"))
    verdict, words = _joined(parts)
    grows = [
        line for line in LINES if all(a < b for a, b in pairwise(_in_its_table("uncoupled", line, speeds)))
    ]
    return verdict, f"{words} {_article_shows('uncoupled', grows)}"


def _in_its_table(model: str, line: str, sets: Sequence[Condition]) -> list[float]:
    """Return the amplitudes that the article prints for its own model under some conditions."""
    return [getattr(printed(c, line, "amplitude_as_printed"), model) for c in sets]


def _article_shows(model: str, lines: Sequence[str]) -> str:
    shown = " and ".join(LINE_WORDS[line] for line in lines) or "none of the lines"
    return f"The article's own table of its {model} model shows it for {shown}."


def largest_clearance(
    results: Sequence[ConditionResult], model: str, top: tuple[float, float]
) -> tuple[str, str]:
    """Return the verdict on a model's lines being highest at ``top`` (clearance, backlash [um]) of the three changed ones."""
    found = by_condition(results, model)
    sets = [Condition(120.0, c, b) for c, b in ((200.0, 100.0), (100.0, 200.0), (200.0, 200.0))]
    first = Condition(120.0, *top)
    rivals = [c for c in sets if c != first]
    verdict, words = _joined([_is_largest(found, first, rivals, line) for line in LINES])
    tables = {line: _in_its_table(model, line, [first, *rivals]) for line in LINES}
    highest = [line for line, values in tables.items() if max(values) == values[0]]
    return verdict, f"{words} {_article_shows(model, highest)}"
