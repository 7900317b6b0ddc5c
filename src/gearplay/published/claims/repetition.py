"""Repetition of the points at a finer tolerance."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gearplay.published.claims.points import MODELS, PointResult
from gearplay.published.claims.shares import OVERALL, PATTERNS, levels
from gearplay.published.significance import holm


def repeated(results: Sequence[PointResult], finer: Sequence[PointResult]) -> list[dict[str, Any]]:
    """Return a row for each pattern and model: how many points show it in the vibration, at both tolerances.

    The motion is chaotic, so the members of a point are other runs at another tolerance, and points at which a pattern comes
    and goes change sides: ``lost`` and ``gained``. Were the tolerance of no account, either would be as likely: ``p`` is of the
    exact test of McNemar, Psychometrika 12 (1947) 153, and ``agree`` says that the difference is not significant after Holm's
    correction for all rows. ``single_runs`` are the shares of single runs at both tolerances.
    """
    from scipy.stats import binomtest

    rows: list[dict[str, Any]] = []
    for pattern, (words, test) in PATTERNS.items():
        for model in MODELS:
            first, second = (
                {r.point: r for r in each if r.model == model and not r.reason} for each in (results, finer)
            )
            points = sorted(first.keys() & second.keys())
            if not points:
                continue
            pairs = [(first[point], second[point]) for point in points]
            one, other = (
                test(levels(np.array([pair[side].ensemble for pair in pairs]), OVERALL)) for side in (0, 1)
            )
            lost, gained = int(np.sum(one & ~other)), int(np.sum(~one & other))
            changed = lost + gained
            singles = [np.concatenate([pair[side].single for pair in pairs]) for side in (0, 1)]
            rows.append(
                {
                    "pattern": pattern,
                    "words": words,
                    "model": model,
                    "of": len(points),
                    "first": int(np.sum(one)),
                    "finer": int(np.sum(other)),
                    "lost": lost,
                    "gained": gained,
                    "p": float(binomtest(lost, changed).pvalue) if changed else 1.0,
                    "single_runs": [
                        float(np.mean(test(levels(s[np.all(np.isfinite(s), axis=(1, 2))], OVERALL)))) for s in singles
                    ],
                }
            )  # fmt: skip
    apart = holm([row["p"] for row in rows])
    return [{**row, "agree": not each} for row, each in zip(rows, apart, strict=True)]


def tolerance_words(document: Mapping[str, Any]) -> str:
    """Return in one or two sentences whether a finer tolerance gives the same shares, naming those that it does not."""
    rows, settings = document["repeated"], document["settings"]
    if not rows:
        return "No point could be compared with itself at a finer tolerance."
    points = max(row["of"] for row in rows)
    words = f"The first {points} points again at a tolerance of {settings['finer_tolerance']:g}"
    apart = [
        f"{row['words'].replace('um', 'µm')}, {row['model'].replace('_as_published', ' as printed')}:"
        f" {row['first']} and {row['finer']} of {row['of']}"
        for row in rows
        if not row["agree"]
    ]
    if apart:
        return f"{words}: {len(apart)} of {len(rows)} shares differ ({'; '.join(apart)})."
    most = max(rows, key=lambda row: abs(row["first"] - row["finer"]))
    single = 100.0 * max(abs(row["single_runs"][0] - row["single_runs"][1]) for row in rows)
    return (
        f"{words}: none of the {len(rows)} shares differs significantly (McNemar's test, Holm's correction, 5 %). Points"
        f" at which a pattern comes and goes change sides, at most from {most['first']} to {most['finer']} of {most['of']};"
        f" shares of single runs differ by at most {single:.1f} percentage points."
    )
