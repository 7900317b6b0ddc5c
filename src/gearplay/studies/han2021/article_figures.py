"""Figures of the article's tables and of its claims as PNG bytes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gearplay.studies.han2021 import article, figures
from gearplay.studies.han2021.article import FREQUENCY, LINE_WORDS, conditions, printed
from gearplay.studies.han2021.figures import as_png
from gearplay.studies.han2021.shares import MODELS as FORMULATIONS
from gearplay.studies.han2021.shares import PATTERNS, share_of


@as_png(9.0, 3.4, 1, 2)
def audit(figure: Figure, axes: Any) -> None:
    """Draw the effect of one free factor on the article's errors, and the scatter of its frequency readings."""
    left, right = axes
    for at, (model, color) in enumerate(figures.COLORS.items()):
        for shift, value, hatch in zip((-0.18, 0.18), article.free_factor(model), ("", "///"), strict=True):
            face = "white" if hatch else color
            bar = left.bar([at + shift], [value], width=0.32, color=face, edgecolor=color, hatch=hatch)
            left.bar_label(bar, [f"{value:.1f} %"])
    left.set_xticks([0, 1], [f"article, {model}" for model in article.MODELS])
    left.set(
        ylim=(0.0, 34.0),
        ylabel="mean error of 18 amplitudes [%]",
        title="filled: as printed; hatched: with one free factor",
    )
    colors = dict(zip(article.SOURCES, (figures.TEST, figures.COUPLED, figures.UNCOUPLED), strict=True))
    for harmonic in (1, 2):
        for k, (values, color) in enumerate(
            zip(article.mesh_readings(harmonic), colors.values(), strict=True)
        ):
            right.plot(np.full(values.size, harmonic - 1.0 + 0.15 * (k - 1)), values, "o", color=color)
        words = f"rms {article.reading_scatter(harmonic):.2f} Hz"
        right.annotate(words, (harmonic - 1.0, 1.02), ha="center")
    for k, model in enumerate(article.MODELS):
        errors = printed(model, FREQUENCY)[:, 0] - printed("test", FREQUENCY)[:, 0]
        right.plot(np.full(errors.size, 2.0 + 0.15 * k), errors, "o", color=colors[model])
        words = f"rms {article.radial_error(model):.2f} Hz"
        right.annotate(words, (2.1, 1.02 - 0.14 * k), ha="center", color=colors[model])
    right.axhline(0.0, color=figures.TEST, linewidth=0.7)
    readings = ["f_m, less what\nthe speed makes it", "2 f_m, likewise", "f_r, model\nless test"]
    right.set_xticks([0, 1, 2.07], readings)
    right.set(ylim=(-1.05, 1.2), ylabel="read too high by [Hz]")
    figures.legend(figure, {source: figures.mark(color) for source, color in colors.items()})


@as_png(6.4, 4.2)
def printed_errors(figure: Figure, ax: Any) -> None:
    """Draw every error that the article prints over the one that follows from its printed values."""
    ends = [0.02, 100.0]
    wrong: list[str] = []
    ax.plot(ends, ends, color="#8a8f98", linewidth=0.8)
    for row in article.rows():
        for model, color in figures.COLORS.items():
            error, follows, right = row.printed_errors[model], row.error(model), row.follows(model)
            ax.plot([follows], [error], "o", color=color, alpha=0.5 if right else 1.0)
            if right:
                continue
            place = f"Table {row.table}, {row.condition.speed_rpm:g} rpm, {LINE_WORDS[row.line]}"
            wrong.append(f"{len(wrong) + 1}: {place}: {error:g} % printed, {follows:.3g} % follow")
            ax.plot([follows], [error], "o", color=figures.TEST, markersize=9, fillstyle="none")
            ax.annotate(f"{len(wrong)} ", (follows, error), ha="right", va="bottom")
    ax.text(0.98, 0.04, "\n".join(wrong), transform=ax.transAxes, ha="right", va="bottom")
    ax.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
    ax.set(xlabel="error that follows from the printed values [%]", ylabel="error printed [%]")
    figures.legend(
        figure, {f"article, {model}": figures.mark(color) for model, color in figures.COLORS.items()}
    )


@as_png(9.0, 3.9)
def claims_shares(figure: Figure, ax: Any, claims: Mapping[str, Any]) -> None:
    """Draw the share of points that show each pattern, with 95 % intervals, and the probability in single runs."""
    handles = {}
    for k, model in enumerate(FORMULATIONS):
        color, face = figures.COLORS[model.partition("_")[0]], "none" if model.endswith("published") else None
        table = [share_of(claims["shares"], pattern, model) for pattern in PATTERNS]
        places = np.arange(len(table)) + 0.18 * (k - 1.5)
        low, values, high = (
            100.0 * np.array([row[name] for row in table]) for name in ("low", "share", "high")
        )
        error = np.maximum([values - low, high - values], 0.0)
        ax.errorbar(places, values, yerr=error, fmt="o", color=color, markerfacecolor=face, markersize=6)
        ax.plot(places, [100.0 * row["single_runs"] for row in table], "_", color=figures.TEST, markersize=9)
        handles[model.replace("_as_published", ", as printed")] = figures.mark(color, markerfacecolor=face)
    for at, pattern in enumerate(PATTERNS):
        words = f"the test: {'yes' if claims['test_shows'][pattern] else 'no'}"
        ax.annotate(words, (at, 103.0), ha="center", color=figures.TEST)
    ax.set_xticks(range(len(PATTERNS)), [article.shown(words) for words, _ in PATTERNS.values()], fontsize=9)
    ax.set(xlim=(-0.6, len(PATTERNS) - 0.4), ylim=(0.0, 112.0), ylabel="points that show it [%]")
    figures.legend(figure, handles | {"single runs": figures.mark(figures.TEST, marker="_")})


@as_png(9.0, 3.4)
def claims_ratios(figure: Figure, ax: Any, claims: Mapping[str, Any]) -> None:
    """Draw coupled over uncoupled by condition [dB]: median and quartiles over the points, both formulations."""
    for shift, formulation, marker, face in (
        (-0.1, "geometric", "o", figures.COUPLED),
        (0.1, "as published", "s", "none"),
    ):
        table = [r for r in claims["ratios"] if r["formulation"] == formulation and "median" in r]
        low, middle, high = (20.0 * np.log10([r[name] for r in table]) for name in ("low", "median", "high"))
        ax.errorbar(
            np.arange(len(table)) + shift, middle, yerr=[middle - low, high - middle], fmt=marker, color=figures.COUPLED,
            markerfacecolor=face,
        )  # fmt: skip
    ax.axhline(0.0, color=figures.TEST, linewidth=0.8)
    ax.set_xticks(range(len(conditions())), [figures.ticks(c) for c in conditions()])
    ax.set_ylabel("coupled over uncoupled [dB]")
    figures.legend(
        figure,
        {
            "exact flanks": figures.mark(figures.COUPLED),
            "as printed": figures.mark(figures.COUPLED, marker="s", markerfacecolor="none"),
            "bars: half of the points": figures.mark(figures.COUPLED, marker="", line="-"),
        },
    )


@as_png(7.4, 3.6)
def claims_floor(figure: Figure, ax: Any, claims: Mapping[str, Any]) -> None:
    """Draw the error of the best of n single runs of the true model against another of its runs."""
    handles, floors = {}, claims["floors"]
    curves = {
        "best_of": (figures.COUPLED, "best run"),
        "free_per_condition": (figures.UNCOUPLED, "best run of each condition"),
    }
    for floor, line in zip(floors, ("--", "-"), strict=False):
        for curve, (color, words) in curves.items():
            ax.plot(floor["draws"], floor[curve], line, color=color, marker="o", markersize=3)
            handles[f"{words}, {floor['record']:g} s"] = figures.mark(color, marker="", line=line)
    limit, draws = floors[0]["limit"], floors[0]["draws"]
    ax.axhline(limit, color=figures.TEST)
    words = f"the article's {limit:g} %"
    ax.annotate(words, (1.0, limit), xytext=(0, 4), textcoords="offset points", color=figures.TEST)
    ax.set_xscale("log")
    ax.set_xticks(draws, [str(n) for n in draws])
    ax.minorticks_off()
    ax.set(
        ylim=(0.0, None),
        xlabel="number of runs of the true model to pick from",
        ylabel="mean error of the amplitudes [%]",
    )
    figures.legend(figure, handles)
