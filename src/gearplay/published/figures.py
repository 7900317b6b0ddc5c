"""Figures of the article's study as PNG bytes."""

from collections.abc import Sequence

import numpy as np

from gearplay.pictures.canvas import make_figure, to_png
from gearplay.pictures.style import COUPLED, TEST, UNCOUPLED, plot_history, plot_orbit, plot_spectrum
from gearplay.published.article import LINE_WORDS, LINES, Condition, conditions, printed
from gearplay.published.comparison import LineDifference, by_condition, model_amplitudes
from gearplay.published.han2021 import ConditionResult

COLORS = {"coupled": COUPLED, "uncoupled": UNCOUPLED}


def spectrum_figure(results: Sequence[ConditionResult], condition: Condition) -> bytes:
    """Draw one condition: on the article's axes (linear, its ordinate) and in m/s^2 with the members' spread."""
    figure, axes = make_figure(2, 2, 5.6, width=10.0)
    top = 2.6 * condition.mesh_frequency
    for column, model in enumerate(COLORS):
        result = by_condition(results, model)[condition]
        factor = model_amplitudes(results, model).factor
        f, a = np.array(result.frequency), np.array(result.amplitude)
        inside = (f > 0.4) & (f <= top)
        linear, decades = axes[:, column]
        linear.plot(f[inside], factor * a[inside], color=COLORS[model], linewidth=0.9)
        s = np.array(result.spread)[inside]
        decades.fill_between(
            f[inside], a[inside] * 10**-s, a[inside] * 10**s, color=COLORS[model], alpha=0.15, linewidth=0,
            label="± 1 standard deviation of the members",
        )  # fmt: skip
        plot_spectrum(
            decades,
            f[inside],
            a[inside],
            "m/s²",
            color=COLORS[model],
            label=f"{model}, {result.members} members",
        )
        for i, line in enumerate(LINES):
            frequency = printed(condition, line, "frequency_hz").test
            height = printed(condition, line, "amplitude_as_printed").test
            for ax, value in ((linear, height), (decades, height / factor)):
                ax.plot([frequency], [value], marker="o", markersize=5, color=TEST, linestyle="none", markerfacecolor="none",
                        label="test" if i == 0 else None)  # fmt: skip
                ax.annotate(
                    LINE_WORDS[line], (frequency, value), textcoords="offset points", xytext=(7, 5), fontsize=8, color=TEST,
                    bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
                )  # fmt: skip
        for ax in (linear, decades):
            ax.set_xlim(0.0, top)
            ax.legend(fontsize=7, loc="upper right" if ax is linear else "lower right", framealpha=0.9)
        linear.set_ylim(0.0, None)
        linear.set_title(f"{model}, as the article draws it", fontsize=9, loc="left")
        linear.set_xlabel("")
    axes[0, 0].set_ylabel("amplitude, in the article's ordinate [as printed]", fontsize=8)
    for row in axes:
        low, high = min(ax.get_ylim()[0] for ax in row), max(ax.get_ylim()[1] for ax in row)
        for ax in row:
            ax.set_ylim(low, high * (1.05 if row is axes[0] else 2.0))
    axes[1, 1].set_ylabel("")
    figure.suptitle(
        f"Acceleration of the driven gear along the centre line, {condition.label.replace('um', 'µm')}",
        fontsize=10,
    )
    return to_png(figure)


def orbit_figure(results: Sequence[ConditionResult]) -> bytes:
    """Draw the driven gear's centre in its clearance circle, one member a condition and model."""
    figure, axes = make_figure(2, len(conditions()), 5.4, width=15.0)
    for row, model in enumerate(COLORS):
        found = by_condition(results, model)
        for ax, condition in zip(axes[row], conditions(), strict=True):
            orbit = found[condition].orbit
            plot_orbit(
                ax,
                np.array(orbit["x"]),
                np.array(orbit["y"]),
                1e-6 * condition.radial_clearance_um,
                color=COLORS[model],
            )
            if row == 0:
                ax.set_title(condition.label.replace("um", "µm"), fontsize=8)
                ax.set_xlabel("")
        for ax in axes[row, 1:]:
            ax.set_ylabel("")
        axes[row, 0].set_ylabel(f"{model}\ny [µm]", fontsize=8)
    return to_png(figure)


def backlash_figure(results: Sequence[ConditionResult]) -> bytes:
    """Draw the backlash history of one member a condition, coupled and uncoupled."""
    figure, axes = make_figure(2, 3, 5.4, width=12.0)
    for at, (ax, condition) in enumerate(zip(axes.flat, conditions(), strict=True)):
        for model, color in COLORS.items():
            orbit = by_condition(results, model)[condition].orbit
            plot_history(
                ax, np.array(orbit["time"]), np.array(orbit["backlash"]), "backlash", color=color, label=model
            )
        if min(by_condition(results, "coupled")[condition].orbit["backlash"]) < 5e-6:
            ax.axhline(0.0, color=TEST, linewidth=0.8, linestyle=":")
        ax.set_title(condition.label.replace("um", "µm"), fontsize=9)
        ax.set_ylabel("backlash, total, normal [µm]" if at % 3 == 0 else "", fontsize=8)
        ax.set_xlabel("time [s]" if at >= 3 else "", fontsize=8)
    axes[0, 0].legend(fontsize=7)
    return to_png(figure)


def radial_frequency_figure(results: Sequence[ConditionResult]) -> bytes:
    """Draw f_r of test, article and both models over sqrt(speed / clearance)."""
    figure, axes = make_figure(1, 1, 4.0, width=6.4)
    ax = axes[0, 0]
    abscissa = np.array([np.sqrt(c.speed_rpm / c.radial_clearance_um) for c in conditions()])
    rows = [printed(c, "radial", "frequency_hz") for c in conditions()]
    test = np.array([r.test for r in rows])
    ax.plot(abscissa, test, "o", color=TEST, markerfacecolor="none", label="test")
    ax.plot(abscissa, [r.coupled for r in rows], "x", color="#777777", label="article, coupled")
    for model, marker in (("coupled", "^"), ("uncoupled", "v")):
        found = by_condition(results, model)
        values = [found[c].lines["radial"].frequency for c in conditions()]
        ax.plot(abscissa, values, marker, color=COLORS[model], label=f"ours, {model}", markersize=5)
    slope = float(np.sum(test * abscissa) / np.sum(abscissa**2))
    line = np.array([0.0, 1.05 * abscissa.max()])
    ax.plot(
        line,
        slope * line,
        color=TEST,
        linewidth=0.8,
        linestyle=":",
        label=f"{slope:.2f} · sqrt(speed / clearance)",
    )
    ax.set_xlim(0.0, None)
    ax.set_ylim(0.0, None)
    ax.set_xlabel("sqrt(pinion speed [rpm] / radial clearance [µm])", fontsize=8)
    ax.set_ylabel("radial frequency f_r [Hz]", fontsize=8)
    ax.legend(fontsize=7, loc="upper left")
    return to_png(figure)


def difference_figure(differences: Sequence[LineDifference]) -> bytes:
    """Draw the ratio coupled over uncoupled at each line [dB] with its 95 % interval, grouped by condition."""
    figure, axes = make_figure(1, 1, 3.4, width=8.6)
    ax = axes[0, 0]
    for at, d in enumerate(differences):
        color = COUPLED if d.significant else "#9aa0a8"
        ax.errorbar(
            [at + at // len(LINES)], [20.0 * d.decades], yerr=[20.0 * 1.96 * d.standard_error], fmt="o", color=color,
            markersize=4, linewidth=1,
        )  # fmt: skip
    ax.axhline(0.0, color=TEST, linewidth=0.8)
    groups = len(differences) // len(LINES)
    ax.set_xticks(
        [at + at // len(LINES) for at in range(len(differences))],
        [LINE_WORDS[d.line] for d in differences],
        fontsize=6.5,
    )
    for group in range(groups):
        label = differences[group * len(LINES)].condition.label.replace("um", "µm").replace(", ", "\n")
        ax.annotate(
            label, (group * (len(LINES) + 1) + 1, 1.01), xycoords=("data", "axes fraction"), ha="center", fontsize=7.5
        )  # fmt: skip
    ax.set_ylabel("coupled over uncoupled,\nsame parameters [dB]", fontsize=8)
    return to_png(figure)
