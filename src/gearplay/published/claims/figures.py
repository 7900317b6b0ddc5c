"""Figures of the claims."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gearplay.pictures.canvas import SMALL, legend_mark, make_figure, set_legend, to_png
from gearplay.pictures.style import COUPLED, TEST, UNCOUPLED
from gearplay.published.claims.points import MODELS
from gearplay.published.claims.shares import PATTERNS, share_of

COLORS = {
    "coupled": COUPLED,
    "uncoupled": UNCOUPLED,
    "coupled_as_published": COUPLED,
    "uncoupled_as_published": UNCOUPLED,
}
WORDS = {name: name.replace("_as_published", ", as printed") for name in MODELS}


def shares_figure(document: Mapping[str, Any]) -> bytes:
    """Draw the share of points that show each pattern, with 95 % intervals, and the probability in single runs."""
    figure, axes = make_figure(1, 1, 3.8, width=9.0)
    ax = axes[0, 0]
    for at, pattern in enumerate(PATTERNS):
        for k, model in enumerate(MODELS):
            row = share_of(document["shares"], pattern, model)
            x, share = at + 0.18 * (k - 1.5), 100.0 * row["share"]
            hollow = "none" if model.endswith("published") else COLORS[model]
            error = [[share - 100.0 * row["low"]], [100.0 * row["high"] - share]]
            ax.errorbar(
                [x], [share], yerr=np.maximum(error, 0.0), fmt="o", color=COLORS[model], markerfacecolor=hollow,
                markersize=6, linewidth=1.4, capsize=3,
            )  # fmt: skip
            ax.plot([x], [100.0 * row["single_runs"]], marker="_", color=TEST, markersize=9)
        seen = document["test_shows"][pattern]
        ax.annotate(
            f"the test: {'yes' if seen else 'no'}", (at, 103.0), ha="center", fontsize=SMALL, color=TEST
        )
    ax.set_xticks(range(len(PATTERNS)), [w.replace("um", "µm") for w, _ in PATTERNS.values()], fontsize=9)
    ax.set_xlim(-0.6, len(PATTERNS) - 0.4)
    ax.set_ylim(0.0, 112.0)
    ax.set_ylabel("points that show it [%]", fontsize=SMALL)
    handles = {
        WORDS[model]: legend_mark(
            COLORS[model], marker="o" if not model.endswith("published") else "$\\circ$"
        )
        for model in MODELS
    }
    set_legend(figure, handles | {"single runs": legend_mark(TEST, marker="_")})
    return to_png(figure)


def ratios_figure(document: Mapping[str, Any]) -> bytes:
    """Draw coupled over uncoupled by condition [dB]: median and quartiles over the points, both formulations."""
    figure, axes = make_figure(1, 1, 3.2, width=9.0)
    ax, labels = axes[0, 0], document["conditions"]
    for shift, formulation, marker in ((-0.1, "geometric", "o"), (0.1, "as published", "s")):
        rows = [r for r in document["ratios"] if r["formulation"] == formulation and "median" in r]
        middle = np.array([20.0 * np.log10(r["median"]) for r in rows])
        low, high = (20.0 * np.log10([r[end] for r in rows]) for end in ("low", "high"))
        ax.errorbar(
            np.arange(len(rows)) + shift, middle, yerr=[middle - low, high - middle], fmt=marker, color=COUPLED,
            markerfacecolor=COUPLED if marker == "o" else "none", capsize=3, linewidth=1.2,
        )  # fmt: skip
    ax.axhline(0.0, color=TEST, linewidth=0.8)
    ax.set_xticks(
        range(len(labels)), [label.replace("um", "µm").replace(", ", "\n") for label in labels], fontsize=8
    )
    ax.set_ylabel("coupled over uncoupled [dB]", fontsize=SMALL)
    set_legend(
        figure,
        {
            "exact flanks": legend_mark(COUPLED, marker="o"),
            "as printed": legend_mark(COUPLED, marker="s"),
            "bars: half of the points": legend_mark(COUPLED, line="-"),
        },
    )
    return to_png(figure)


def floor_figure(document: Mapping[str, Any]) -> bytes:
    """Draw how near the best of n single runs of the true model comes to another of its runs."""
    figure, axes = make_figure(1, 1, 3.4, width=7.4)
    ax, handles = axes[0, 0], {}
    for floor, line in zip(document["floors"], ("--", "-"), strict=False):
        for curve, color, words in (
            ("best_of", COUPLED, "best run"),
            ("free_per_condition", UNCOUPLED, "best run of each condition"),
        ):
            ax.plot(floor["draws"], floor[curve], line, color=color, marker="o", markersize=3)
            handles[f"{words}, {floor['record']:g} s"] = legend_mark(color, line=line)
    limit = document["floors"][0]["limit"]
    ax.axhline(limit, color=TEST, linewidth=0.9)
    ax.annotate(
        f"the article's {limit:g} %", (1.0, limit), xytext=(0, 4), textcoords="offset points", ha="left",
        fontsize=SMALL, color=TEST,
    )  # fmt: skip
    ax.set_xscale("log")
    ax.set_xticks(document["floors"][0]["draws"], [str(n) for n in document["floors"][0]["draws"]])
    ax.minorticks_off()
    ax.set_ylim(0.0, None)
    ax.set_xlabel("number of runs of the true model to pick from", fontsize=SMALL)
    ax.set_ylabel("mean error of the amplitudes [%]", fontsize=SMALL)
    set_legend(figure, handles)
    return to_png(figure)


def claim_figures(document: Mapping[str, Any]) -> dict[str, bytes]:
    """Draw every figure of the claims: name -> PNG."""
    return {
        "claims-shares": shares_figure(document),
        "claims-ratios": ratios_figure(document),
        "claims-floor": floor_figure(document),
    }
