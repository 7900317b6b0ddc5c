"""Main figures of the study: all amplitudes, the mechanism in motion, the audit of the tables."""

import math
from collections.abc import Sequence

import numpy as np

from gearplay.model.case import Case
from gearplay.model.geometry import pitch_radius
from gearplay.pictures.canvas import SMALL, legend_mark, make_figure, set_legend, to_png
from gearplay.pictures.style import CLEARANCE, COUPLED, TEST, UNCOUPLED, plot_orbit
from gearplay.published.article import LINE_WORDS, LINES, conditions, printed, printed_rows
from gearplay.published.audit import (
    MESH_LINES,
    SOURCES,
    free_factor,
    mesh_readings,
    radial_error,
    reading_scatter,
)
from gearplay.published.comparison import by_condition, model_amplitudes
from gearplay.published.figures import COLORS
from gearplay.published.han2021 import ConditionResult
from gearplay.published.settings import MODELS

ARTICLE = "#777777"


def lead_figure(results: Sequence[ConditionResult]) -> bytes:
    """Draw the 18 amplitudes in the article's ordinate: test, article, and both models with their members' spread."""
    figure, axes = make_figure(1, 3, 4.6, width=7.6)
    amplitude = "amplitude_as_printed"
    for ax, line in zip(axes[0], LINES, strict=True):
        rows = [printed(c, line, amplitude) for c in conditions()]
        places = np.arange(len(rows))
        ax.plot(places, [r.test for r in rows], "o", color=TEST, markerfacecolor="none", markersize=8)
        ax.plot(places, [r.coupled for r in rows], "x", color=ARTICLE, markersize=5)
        for shift, model in ((-0.16, "coupled"), (0.16, "uncoupled")):
            found = by_condition(results, model)
            factor = model_amplitudes(results, model).factor
            values = np.array([factor * found[c].lines[line].amplitude for c in conditions()])
            spread = np.array([found[c].lines[line].spread for c in conditions()])
            error = [values - values * 10.0**-spread, values * 10.0**spread - values]
            ax.errorbar(
                places + shift, values, yerr=error, fmt="o", color=COLORS[model], markersize=4, linewidth=1.0, capsize=2
            )  # fmt: skip
        ax.set_yscale("log")
        ax.set_title(f"{LINE_WORDS[line]}", fontsize=9, loc="left")
        ax.set_xticks(
            places,
            [f"{c.speed_rpm:g} rpm\n{c.radial_clearance_um:g}/{c.backlash_um:g} µm" for c in conditions()],
            fontsize=6.5,
            rotation=60,
            ha="right",
            rotation_mode="anchor",
        )
    low = min(ax.get_ylim()[0] for ax in axes[0])
    high = max(ax.get_ylim()[1] for ax in axes[0])
    for ax in axes[0]:
        ax.set_ylim(low, high)
    axes[0, 0].set_ylabel("amplitude, in the article's ordinate [as printed]", fontsize=SMALL)
    set_legend(
        figure,
        {
            "test": legend_mark(TEST, marker="$\\bigcirc$"),
            "article, coupled": legend_mark(ARTICLE, marker="x"),
            "here, coupled": legend_mark(COUPLED, marker="o"),
            "here, uncoupled": legend_mark(UNCOUPLED, marker="o"),
            "bars: one run's standard deviation": legend_mark(TEST, line="-"),
        },
    )
    return to_png(figure)


def mechanism_figure(case: Case, results: Sequence[ConditionResult]) -> bytes:
    """Draw the pair to scale, and beside it the actual path of the driven gear's centre in its sleeve, magnified."""
    figure, axes = make_figure(1, 2, 4.2, width=9.0)
    left, right = axes[0]
    mesh = case.meshes[0]
    r_p, r_g = (1e3 * pitch_radius(case, mesh, name) for name in ("pinion", "ring"))
    turn = np.linspace(0.0, 2.0 * np.pi, 2881)
    for radius, teeth, centre, color in ((r_g, 60, 0.0, COUPLED), (r_p, 20, r_g - r_p, UNCOUPLED)):
        wave = radius + 3.4 * np.tanh(2.0 * np.sin(teeth * turn + (0.0 if teeth == 60 else math.pi)))
        left.plot(centre + wave * np.cos(turn), wave * np.sin(turn), color=color, linewidth=0.9)
        left.plot([centre], [0.0], "+", color=color, markersize=8)
    outer = r_g + 14.0
    left.plot(outer * np.cos(turn), outer * np.sin(turn), color=COUPLED, linewidth=1.6)
    pressure = mesh.pressure_angle
    away = 34.0 * np.array([-math.sin(pressure), math.cos(pressure)])
    left.plot([r_g - away[0], r_g + away[0]], [-away[1], away[1]], color=TEST, linewidth=0.9, linestyle="--")
    left.annotate(
        "line of action", (r_g + away[0], away[1]), xytext=(20.0, 62.0), fontsize=SMALL, ha="center",
        arrowprops={"arrowstyle": "-", "color": TEST, "linewidth": 0.6},
    )  # fmt: skip
    left.annotate("pinion, driven\nby the motor", (r_g - r_p, -8.0), fontsize=SMALL, ha="center", va="top")
    left.annotate("ring gear on its\nshaft in the sleeve", (0.0, -8.0), fontsize=SMALL, ha="center", va="top")
    left.set_aspect("equal")
    left.set_xlabel("x [mm]", fontsize=SMALL)
    left.set_ylabel("y [mm]", fontsize=SMALL)
    condition = conditions()[1]
    orbit = by_condition(results, "coupled")[condition].orbit
    c = condition.radial_clearance_um
    plot_orbit(right, np.array(orbit["x"]), np.array(orbit["y"]), 1e-6 * c)
    right.annotate(
        f"clearance circle, {c:g} µm",
        (0.0, -0.9 * c),
        fontsize=SMALL,
        ha="center",
        va="bottom",
        color=CLEARANCE,
    )
    right.set_xlabel("x of the ring's centre [µm]", fontsize=SMALL)
    right.set_ylabel("y of the ring's centre [µm]", fontsize=SMALL)
    duration = orbit["time"][-1] - orbit["time"][0]
    right.set_title(
        f"{duration:.2g} s at {condition.label.replace('um', 'µm')}, coupled", fontsize=8.5, loc="left"
    )
    left.set_title("the pair, to scale", fontsize=8.5, loc="left")
    return to_png(figure)


def audit_figure() -> bytes:
    """Draw what one free factor does to the article's errors, and how its frequency readings scatter."""
    figure, axes = make_figure(1, 2, 3.2, width=9.0)
    left, right = axes[0]
    for at, model in enumerate(MODELS):
        found = free_factor(model)
        for shift, value, hollow in ((-0.18, found.as_printed, False), (0.18, found.with_factor, True)):
            left.bar(
                [at + shift], [value], width=0.32, color="white" if hollow else COLORS[model], edgecolor=COLORS[model],
                hatch="///" if hollow else None,
            )  # fmt: skip
            left.annotate(f"{value:.1f} %", (at + shift, value), ha="center", va="bottom", fontsize=SMALL)
    left.set_xticks([0, 1], ["article, coupled", "article, uncoupled"], fontsize=8)
    left.set_ylim(0.0, 34.0)
    left.set_ylabel("mean error of 18 amplitudes [%]", fontsize=SMALL)
    left.set_title("filled: as printed; hatched: with one free factor", fontsize=8.5, loc="left")
    marks = dict(zip(SOURCES, (TEST, COUPLED, UNCOUPLED), strict=True))
    for at, line in enumerate(MESH_LINES):
        for k, color in enumerate(marks.values()):
            values = mesh_readings(line)[k]
            right.plot(np.full(values.size, at + 0.15 * (k - 1)), values, "o", color=color, markersize=4)
        rms = reading_scatter(line)
        right.annotate(f"rms {rms:.2f} Hz", (at, 1.02), ha="center", fontsize=SMALL)
    for k, model in enumerate(MODELS):
        value = radial_error(model)
        rows = [printed(c, "radial", "frequency_hz") for c in conditions()]
        errors = [getattr(r, model) - r.test for r in rows]
        right.plot(np.full(6, 2.0 + 0.15 * k), errors, "o", color=marks[model], markersize=4)
        right.annotate(
            f"rms {value:.2f} Hz", (2.1, 1.02 - 0.14 * k), ha="center", fontsize=SMALL, color=marks[model]
        )
    right.axhline(0.0, color=TEST, linewidth=0.7)
    right.set_ylim(-1.05, 1.2)
    right.set_xticks(
        [0, 1, 2.07],
        ["f_m, less what\nthe speed makes it", "2 f_m, likewise", "f_r, model\nless test"],
        fontsize=8,
    )
    right.set_ylabel("read too high by [Hz]", fontsize=SMALL)
    set_legend(figure, {source: legend_mark(color, marker="o") for source, color in marks.items()})
    return to_png(figure)


def printed_errors_figure() -> bytes:
    """Draw every error that the article prints over the one that follows from its printed values."""
    figure, axes = make_figure(1, 1, 4.0, width=6.4)
    ax = axes[0, 0]
    ends = [0.02, 100.0]
    wrong: list[str] = []
    ax.plot(ends, ends, color=CLEARANCE, linewidth=0.8)
    for row in printed_rows():
        for model in MODELS:
            error, follows = row.printed_error(model), row.recomputed_error(model)
            right = row.printed_error_follows(model)
            ax.plot([follows], [error], "o", color=COLORS[model], markersize=4, alpha=0.5 if right else 1.0)
            if not right:
                place = f"Table {row.table}, {row.condition.speed_rpm:g} rpm, {LINE_WORDS[row.line]}"
                wrong.append(f"{len(wrong) + 1}: {place}: {error:g} % printed, {follows:.3g} % follow")
                ax.plot([follows], [error], "o", color=TEST, markersize=9, fillstyle="none")
                ax.annotate(
                    str(len(wrong)), (follows, error), xytext=(-7, 4), textcoords="offset points",
                    fontsize=SMALL, ha="right",
                )  # fmt: skip
    ax.text(0.98, 0.04, "\n".join(wrong), transform=ax.transAxes, ha="right", va="bottom", fontsize=SMALL)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(ends)
    ax.set_ylim(ends)
    ax.set_xlabel("error that follows from the printed values [%]", fontsize=SMALL)
    ax.set_ylabel("error printed [%]", fontsize=SMALL)
    set_legend(figure, {f"article, {model}": legend_mark(COLORS[model], marker="o") for model in MODELS})
    return to_png(figure)
