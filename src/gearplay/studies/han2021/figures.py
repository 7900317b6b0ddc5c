"""Figures of the simulated results as PNG bytes."""

import io
import math
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import Any, Concatenate, ParamSpec

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import gearplay as gp
from gearplay.studies.han2021 import article
from gearplay.studies.han2021.article import AMPLITUDE, FREQUENCY, LINE_WORDS, LINES, conditions, printed
from gearplay.studies.han2021.comparison import LineDifference, ModelResult, Models

COUPLED, UNCOUPLED, TEST, GREY = "#0b5fa5", "#c8641b", "#222222", "#777777"
COLORS = {"coupled": COUPLED, "uncoupled": UNCOUPLED}
STYLE: Any = {
    "font.size": 7.5, "axes.titlesize": 8.5, "axes.titlelocation": "left",
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e4e6ea", "grid.linewidth": 0.6,
    "axes.axisbelow": True, "lines.linewidth": 0.9, "lines.markersize": 4.0, "errorbar.capsize": 2.0,
}  # fmt: skip
HOLLOW: dict[str, Any] = {"marker": "o", "linestyle": "none", "color": TEST, "markerfacecolor": "none"}
DPI = 130
P = ParamSpec("P")


def as_png(
    width: float, height: float, rows: int = 1, columns: int = 1, **shared: Any
) -> Callable[[Callable[Concatenate[Figure, Any, P], None]], Callable[P, bytes]]:
    """Return a decorator of functions that draw on a figure [inches] and its axes: the PNG in the study's style.

    Several axes have shape [column] or [row, column].
    """

    def decorate(draw: Callable[Concatenate[Figure, Any, P], None]) -> Callable[P, bytes]:
        @wraps(draw)
        def drawn(*args: P.args, **named: P.kwargs) -> bytes:
            buffer = io.BytesIO()
            with mpl.rc_context(STYLE):
                figure = Figure(figsize=(width, height), layout="constrained")
                draw(figure, figure.subplots(rows, columns, **shared), *args, **named)
                engine = figure.get_layout_engine()
                assert engine is not None
                figure.set_dpi(DPI)
                engine.execute(figure)
                figure.set_layout_engine(None)  # laid out: `savefig` draws once, not twice
                figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": "gearplay"})
            return buffer.getvalue()

        return drawn

    return decorate


def mark(color: str, *, marker: str = "o", line: Any = "none", **more: Any) -> Line2D:
    """Return a marker or a line for a legend."""
    return Line2D([], [], color=color, marker=marker, linestyle=line, **more)


def legend(figure: Figure, handles: Mapping[str, Line2D], columns: int = 5) -> None:
    """Draw a legend under the figure."""
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns, frameon=False)


def ticks(condition: article.Condition) -> str:
    """Return a condition's name for an axis: speed, clearances."""
    return f"{condition.speed_rpm:g} rpm\n{article.shown(condition.clearances)}"


@as_png(7.6, 4.8, 1, 3, sharey=True)
def lead(figure: Figure, axes: Any, models: Models) -> None:
    """Draw the 18 amplitudes in the article's ordinate: test, article, and both models with their members' spread."""
    places = np.arange(len(conditions()))
    for k, ax in enumerate(axes):
        ax.plot(places, printed("test", AMPLITUDE)[:, k], **HOLLOW, markersize=8)
        ax.plot(places, printed("coupled", AMPLITUDE)[:, k], "x", color=GREY, markersize=5)
        for shift, (name, color) in zip((-0.16, 0.16), COLORS.items(), strict=True):
            values, spread = (
                models[name].factor * models[name].amplitude[:, k],
                models[name].table("spread")[:, k],
            )
            ends = [values - values * 10.0**-spread, values * 10.0**spread - values]
            ax.errorbar(places + shift, values, yerr=ends, fmt="o", color=color)
        ax.set(yscale="log", title=LINE_WORDS[LINES[k]])
        words = [ticks(c) for c in conditions()]
        ax.set_xticks(places, words, fontsize=6.5, rotation=60, ha="right", rotation_mode="anchor")
        if k == 0:
            ax.set_ylabel("amplitude, in the article's ordinate [as printed]")
    legend(
        figure,
        {
            "test": mark(TEST, markerfacecolor="none", markersize=6),
            "article, coupled": mark(GREY, marker="x"),
            "here, coupled": mark(COUPLED),
            "here, uncoupled": mark(UNCOUPLED),
            "bars: one run's standard deviation": mark(TEST, marker="", line="-"),
        },
        columns=3,
    )


def _draw_orbit(ax: Any, orbit: Mapping[str, Sequence[float]], clearance_um: float, color: str) -> None:
    """Draw a path of the ring's centre [um] in its clearance circle."""
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    circle = clearance_um * np.cos(turn), clearance_um * np.sin(turn)
    ax.plot(*circle, color="#8a8f98", linewidth=0.7, dashes=(4, 5), zorder=3)
    ax.plot(1e6 * np.array(orbit["x"]), 1e6 * np.array(orbit["y"]), color=color, linewidth=0.8)
    reach = 1.06 * clearance_um
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    ax.locator_params(nbins=5)


@as_png(9.0, 4.2, 1, 2)
def mechanism(figure: Figure, axes: Any, case: gp.Case, coupled: ModelResult) -> None:
    """Draw the pair to scale, and the path of the driven gear's centre in its sleeve, magnified."""
    left, right = axes
    mesh, turn = case.meshes[0], np.linspace(0.0, 2.0 * np.pi, 2881)
    teeth = {name: case.rotors[name].teeth or 0 for name in ("ring", "pinion")}
    radius = {name: 500.0 * (mesh.module or 0.0) * count for name, count in teeth.items()}  # mm
    away = radius["ring"] - radius["pinion"]
    for name, centre, phase, color in (("ring", 0.0, 0.0, COUPLED), ("pinion", away, math.pi, UNCOUPLED)):
        wave = radius[name] + 3.4 * np.tanh(2.0 * np.sin(teeth[name] * turn + phase))
        left.plot(centre + wave * np.cos(turn), wave * np.sin(turn), color=color)
        left.plot([centre], [0.0], "+", color=color, markersize=8)
    outer = radius["ring"] + 14.0
    left.plot(outer * np.cos(turn), outer * np.sin(turn), color=COUPLED, linewidth=1.6)
    along = 34.0 * np.array([-math.sin(mesh.pressure_angle), math.cos(mesh.pressure_angle)])
    ends = radius["ring"] + along[0], along[1]
    left.plot([2.0 * radius["ring"] - ends[0], ends[0]], [-ends[1], ends[1]], "--", color=TEST)
    arrow = {"arrowstyle": "-", "color": TEST, "linewidth": 0.6}
    left.annotate("line of action", ends, xytext=(20.0, 62.0), ha="center", arrowprops=arrow)
    left.annotate("pinion, driven\nby the motor", (away, -8.0), ha="center", va="top")
    left.annotate("ring gear on its\nshaft in the sleeve", (0.0, -8.0), ha="center", va="top")
    left.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]", title="the pair, to scale")
    result = coupled.results[1]
    clearance, time = result.condition.radial_clearance_um, result.orbit["time"]
    _draw_orbit(right, result.orbit, clearance, COUPLED)
    words = f"clearance circle, {clearance:g} µm"
    right.annotate(words, (0.0, -0.9 * clearance), ha="center", va="bottom", color="#8a8f98")
    right.set(
        xlabel="x of the ring's centre [µm]",
        ylabel="y of the ring's centre [µm]",
        title=f"{time[-1] - time[0]:.2g} s at {article.shown(result.condition.label)}, coupled",
    )


@as_png(10.0, 5.6, 2, 2, sharex=True, sharey="row")
def spectrum(figure: Figure, axes: Any, models: Models, at: int) -> None:
    """Draw one condition: on the article's axes (linear, its ordinate) and in m/s^2 with the members' spread."""
    condition = conditions()[at]
    top = 2.6 * condition.mesh_frequency
    for (linear, decades), (name, color) in zip(axes.T, COLORS.items(), strict=True):
        result, factor = models[name].results[at], models[name].factor
        f, a, s = (np.array(each) for each in (result.frequency, result.amplitude, result.spread))
        f, a, s = (each[(f > 0.4) & (f <= top)] for each in (f, a, s))
        linear.plot(f, factor * a, color=color)
        words = "± 1 standard deviation of the members"
        decades.fill_between(f, a * 10.0**-s, a * 10.0**s, color=color, alpha=0.15, linewidth=0, label=words)
        decades.semilogy(f, a, color=color, linewidth=0.7, label=f"{name}, {result.members} members")
        for k, line in enumerate(LINES):
            frequency, height = (printed("test", quantity)[at, k] for quantity in (FREQUENCY, AMPLITUDE))
            for ax, value in ((linear, height), (decades, height / factor)):
                ax.plot([frequency], [value], **HOLLOW, markersize=5, label="test" if k == 0 else None)
                ax.annotate(
                    LINE_WORDS[line], (frequency, value), textcoords="offset points", xytext=(7, 5), color=TEST,
                    bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
                )  # fmt: skip
        linear.set(xlim=(0.0, top), ylim=(0.0, None), title=f"{name}, as the article draws it")
        linear.legend(loc="upper right")
        decades.set(xlabel="frequency [Hz]")
        decades.legend(loc="lower right")
    for ax, room, words in (
        (axes[0, 0], 1.08, "amplitude, in the article's ordinate [as printed]"),
        (axes[1, 0], 2.0, "amplitude [m/s²]"),
    ):
        low, high = ax.get_ylim()
        ax.set(ylim=(low, room * high), ylabel=words)
    figure.suptitle(
        f"Acceleration of the driven gear along the centre line, {article.shown(condition.label)}",
        fontsize=10,
    )


@as_png(15.0, 5.4, 2, 6)
def orbits(figure: Figure, axes: Any, models: Models) -> None:
    """Draw the driven gear's centre in its clearance circle, one member per condition and model."""
    for row, (name, color) in zip(axes, COLORS.items(), strict=True):
        for ax, result in zip(row, models[name].results, strict=True):
            _draw_orbit(ax, result.orbit, result.condition.radial_clearance_um, color)
            if name == "coupled":
                ax.set_title(article.shown(result.condition.label))
            else:
                ax.set_xlabel("x [µm]")
        row[0].set_ylabel(f"{name}\ny [µm]")


@as_png(12.0, 5.4, 2, 3)
def backlash(figure: Figure, axes: Any, models: Models) -> None:
    """Draw the backlash history of one member per condition, coupled and uncoupled."""
    for at, (ax, condition) in enumerate(zip(axes.flat, conditions(), strict=True)):
        for name, color in COLORS.items():
            orbit = models[name].results[at].orbit
            values = 1e6 * np.array(orbit["backlash"])
            ax.plot(orbit["time"], values, color=color, linewidth=0.7, label=name)
            if name == "coupled" and values.min() < 5.0:
                ax.axhline(0.0, color=TEST, linewidth=0.8, linestyle=":")
        ax.ticklabel_format(useOffset=False)
        ax.set_title(article.shown(condition.label))
    for ax in axes[:, 0]:
        ax.set_ylabel("backlash, total, normal [µm]")
    for ax in axes[1]:
        ax.set_xlabel("time [s]")
    axes[0, 0].legend()


@as_png(6.4, 4.0)
def radial_frequency(figure: Figure, ax: Any, models: Models) -> None:
    """Draw f_r of test, article and both models over sqrt(speed / clearance)."""
    abscissa = np.array([math.sqrt(c.speed_rpm / c.radial_clearance_um) for c in conditions()])
    test, theirs = (printed(source, FREQUENCY)[:, 0] for source in ("test", "coupled"))
    ax.plot(abscissa, test, **HOLLOW, label="test")
    ax.plot(abscissa, theirs, "x", color=GREY, label="article, coupled")
    for marker, (name, color) in zip("^v", COLORS.items(), strict=True):
        ax.plot(abscissa, models[name].table("frequency")[:, 0], marker, color=color, label=f"ours, {name}")
    slope = float(np.sum(test * abscissa) / np.sum(abscissa**2))
    ends = np.array([0.0, 1.05 * abscissa.max()])
    ax.plot(ends, slope * ends, ":", color=TEST, label=f"{slope:.2f} · sqrt(speed / clearance)")
    ax.set(
        xlim=(0.0, None),
        ylim=(0.0, None),
        xlabel="sqrt(pinion speed [rpm] / radial clearance [µm])",
        ylabel="radial frequency f_r [Hz]",
    )
    ax.legend(loc="upper left")


@as_png(8.6, 3.4)
def coupled_over_uncoupled(figure: Figure, ax: Any, differences: Sequence[LineDifference]) -> None:
    """Draw the ratio coupled over uncoupled at each line [dB] with its 95 % interval, grouped by condition."""
    places = [at + at // len(LINES) for at in range(len(differences))]
    for at, d in zip(places, differences, strict=True):
        color = COUPLED if d.significant else "#9aa0a8"
        ax.errorbar([at], [20.0 * d.decades], yerr=[20.0 * 1.96 * d.standard_error], fmt="o", color=color)
    ax.axhline(0.0, color=TEST, linewidth=0.8)
    ax.set_xticks(places, [LINE_WORDS[d.line] for d in differences], fontsize=6.5)
    for group, condition in enumerate(conditions()):
        middle = group * (len(LINES) + 1) + 1
        ax.annotate(ticks(condition), (middle, 1.01), xycoords=("data", "axes fraction"), ha="center")
    ax.set_ylabel("coupled over uncoupled,\nsame parameters [dB]")
