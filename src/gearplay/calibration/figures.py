"""Figures of a calibration as PNG bytes."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.plan import Plan
from gearplay.calibration.procedure import Fit, Row
from gearplay.calibration.spans import Span, Spans, label_of
from gearplay.pictures.canvas import PALETTE, SMALL, TEXT, WIDTH, legend_mark, make_figure
from gearplay.pictures.panels import finished, make_panels, round_ticks
from gearplay.pictures.style import CLEARANCE, TEST
from gearplay.pictures.words import plain, short, wrapped

Floats = NDArray[np.float64]
MARKERS = "os^Dv<>Pp*X"
MOST_PAIRS = 8  # parameters in a pair plot; of more, the best identified ones
BAND = math.log10(0.9), math.log10(1.1)  # decades
WIDEST = 2.0  # decades: values further off are drawn at the edge


def colors_of(fits: Sequence[Fit]) -> dict[str, str]:
    """Return a color for each model, the same in every figure."""
    models = list(dict.fromkeys(fit.model for fit in fits))
    return {model: PALETTE[at % len(PALETTE)] for at, model in enumerate(models)}


def convergence_figure(fits: Sequence[Fit], colors: Mapping[str, str]) -> bytes:
    """Draw the least objective against the number of finished trials, a panel per reading."""
    readings = list(dict.fromkeys(fit.reading for fit in fits))
    figure, axes = make_panels(len(readings), len(readings), 2.7, alone=(2.7, 6.0))
    for ax, reading in zip(axes[0], readings, strict=True):
        own = [fit for fit in fits if fit.reading == reading]
        for fit in own:
            ax.step(
                range(1, len(fit.history) + 1),
                fit.history,
                where="post",
                color=colors[fit.model],
                linewidth=1.3,
            )
        if all(min(fit.history, default=0.0) > 0.0 for fit in own):
            ax.set_yscale("log")
            ax.tick_params(which="both", labelsize=SMALL)
        ax.set_title(reading, fontsize=TEXT, loc="left")
        ax.set_xlabel("finished trials [1]", fontsize=TEXT)
    axes[0, 0].set_ylabel("least objective, −2 ln likelihood + constant [1]", fontsize=TEXT)
    handles = {model: legend_mark(color, line="-") for model, color in colors.items()}
    return finished(figure, "Convergence of the search", handles)


def density_of(units: Floats) -> tuple[Floats, Floats]:
    """Return places in the unit interval and the density of a sample there, 1 for the prior.

    A Gaussian kernel of Silverman's width, reflected at both ends so that nothing is lost beyond them.
    """
    quarter = np.subtract(*np.percentile(units, [75, 25])) / 1.34
    spread = min(float(np.std(units)), float(quarter)) or float(np.std(units))
    width = max(0.9 * spread * units.size**-0.2, 0.004)
    at = np.linspace(0.0, 1.0, 401)
    images = np.concatenate([units, -units, 2.0 - units])
    kernel = np.exp(-0.5 * ((at[:, None] - images) / width) ** 2)
    return at, np.asarray(kernel.sum(axis=1) / (units.size * width * math.sqrt(2.0 * math.pi)))


def posterior_figure(fits: Sequence[Fit], spans: Spans, colors: Mapping[str, str]) -> bytes:
    """Draw the posterior of each parameter over its searched range, the models of one reading overlaid."""
    drawn = {span.name: span for fit in fits for span in spans[fit.model]}
    figure, axes = make_panels(len(drawn), 3, 1.9, alone=(1.9, 6.0))
    for place, (ax, span) in enumerate(zip(axes.flat, drawn.values(), strict=False)):
        for fit in fits:
            names = [each.name for each in spans[fit.model]]
            if not fit.sample or span.name not in names:
                continue
            at = names.index(span.name)
            x, density = density_of(np.array(fit.sample)[:, at])
            ax.fill_between(x, density, color=colors[fit.model], alpha=0.12, linewidth=0)
            ax.plot(x, density, color=colors[fit.model], linewidth=1.2)
            best = {"marker": "^", "markersize": 6, "color": colors[fit.model]}
            ax.plot([fit.unit[at]], [0.0], clip_on=False, zorder=5, **best)
        ax.axhline(1.0, color=TEST, linewidth=0.8, linestyle=":")
        ax.set_xticks(*span.ticks(5))
        ax.set_xlim(0.0, 1.0)
        ax.set_ylim(0.0, None)
        ax.set_xlabel(
            f"{plain(span.name)} [{plain(span.unit)}]", fontsize=TEXT if len(span.name) < 24 else SMALL
        )
        if place % axes.shape[1] == 0:
            ax.set_ylabel("density [prior = 1]", fontsize=TEXT)
    handles = {model: legend_mark(colors[model], line="-") for model in dict.fromkeys(f.model for f in fits)}
    handles["prior"] = legend_mark(TEST, line=":")
    handles["best point"] = legend_mark(CLEARANCE, marker="^")
    title = f"Posterior of each parameter over the range searched, reading {fits[0].reading}"
    return finished(figure, title, handles)


def pairs_of(fit: Fit) -> list[int]:
    """Return the indices of the parameters for a pair plot, in order: at most `MOST_PAIRS`, the best identified ones."""
    spread = np.std(np.array(fit.sample), axis=0)
    return sorted(int(i) for i in np.argsort(spread, kind="stable")[:MOST_PAIRS])


def pair_figure(fit: Fit, spans: Sequence[Span], color: str) -> bytes:
    """Draw the posterior of every pair of parameters of one fit, with their correlations above the diagonal."""
    sample, chosen = np.array(fit.sample), pairs_of(fit)
    number = len(chosen)
    size = {2: 5.5, 3: 7.0}.get(number, WIDTH)
    figure, axes = make_figure(number, number, size, width=size)
    for row, i in enumerate(chosen):
        for column, j in enumerate(chosen):
            ax = axes[row, column]
            ax.tick_params(labelsize=7)
            ax.set_xlim(0.0, 1.0)
            if row == column:
                x, density = density_of(sample[:, i])
                ax.fill_between(x, density, color=color, alpha=0.25, linewidth=0)
                ax.plot(x, density, color=color, linewidth=1.0)
                ax.axvline(fit.unit[i], color=TEST, linewidth=0.8, linestyle="--")
                ax.set_ylim(0.0, None)
            elif row > column:
                ax.plot(sample[:, j], sample[:, i], ".", color=color, markersize=2.5, alpha=0.45)
                ax.plot([fit.unit[j]], [fit.unit[i]], "+", color=TEST, markersize=8, markeredgewidth=1.4)
                ax.set_ylim(0.0, 1.0)
            else:
                strength = fit.correlation[i][j]
                ax.axis("off")
                if math.isfinite(strength):
                    ax.text(0.5, 0.5, f"{strength:+.2f}", ha="center", va="center", fontsize=8 + 4 * abs(strength),
                            color=TEST, alpha=0.6 + 0.4 * min(1.0, abs(strength)))  # fmt: skip
                continue
            _pair_ticks(ax, row, column, number, spans[j], spans[i])
    left_out = (
        "" if number == sample.shape[1] else f", the {number} of {sample.shape[1]} parameters told best"
    )
    figure.align_labels()
    return finished(figure, f"Pairs of parameters, {short(fit.model)}, reading {fit.reading}{left_out}")


def _pair_ticks(ax: Any, row: int, column: int, number: int, across: Span, up: Span) -> None:
    """Label the outer panels only; the diagonal's ordinate is a density."""
    places, labels = across.ticks(3)
    ax.set_xticks(places, labels if row == number - 1 else [])
    if row == number - 1:
        ax.set_xlabel(label_of(across), fontsize=SMALL)
    if row == column:
        ax.set_yticks([])
        if row == 0:
            ax.set_ylabel("density of\n" + plain(wrapped(across.name, 15)), fontsize=SMALL)
        return
    places, labels = up.ticks(3)
    ax.set_yticks(places, labels if column == 0 else [])
    if column == 0:
        ax.set_ylabel(label_of(up), fontsize=SMALL)


def match_figure(
    plan: Plan, fits: Sequence[Fit], unit_of: Callable[[Row], str], colors: Mapping[str, str]
) -> bytes:
    """Draw simulated against measured values of one reading, a panel per kind and unit, with a band of ± 10 %.

    Bars: one standard uncertainty of the measurement as the plan gives it, one standard error of the ensemble.
    """
    groups = list(dict.fromkeys((row.key, unit_of(row)) for fit in fits for row in fit.rows))
    figure, axes = make_panels(len(groups), 2, 3.9, alone=(3.9, 5.5))
    markers = markers_of(plan)
    for ax, (key, unit) in zip(axes.flat, groups, strict=False):
        measured = [r.measured for f in fits for r in f.rows if (r.key, unit_of(r)) == (key, unit)]
        low, high = math.log10(min(measured)) - 0.15, math.log10(max(measured)) + 0.15
        ends = np.array([low, high])
        low_end, high_end = (10.0 ** (ends + edge) for edge in BAND)
        ax.fill_between(10.0**ends, low_end, high_end, color=CLEARANCE, alpha=0.25, linewidth=0)
        ax.plot(10.0**ends, 10.0**ends, color=CLEARANCE, linewidth=0.9)
        for fit in fits:
            for r in fit.rows:
                if (r.key, unit_of(r)) == (key, unit) and math.isfinite(r.residual):
                    _match(ax, r, uncertainty_of(plan, r), colors[fit.model], markers[r.target])
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlim(10.0**low, 10.0**high)
        round_ticks(ax.xaxis, *ax.get_xlim(), fine=True)
        round_ticks(ax.yaxis, *ax.get_ylim(), fine=True)
        ax.set_xlabel(f"measured {key} [{unit}]", fontsize=TEXT)
        ax.set_ylabel(f"simulated {key} [{unit}]", fontsize=TEXT)
    title = f"Measured against simulated at the best point, fresh members, reading {fits[0].reading}"
    return finished(figure, title, _handles(plan, fits, colors))


def _match(ax: Any, row: Row, uncertainty: float, color: str, marker: str) -> None:
    """Draw one datum; one beyond the limits of the axes is a hollow marker at the edge."""
    shown = row.measured * 10.0 ** max(-WIDEST, min(WIDEST, row.residual))
    inside = abs(row.residual) <= WIDEST
    across, up = (10.0**e - 1.0 for e in (uncertainty, row.ensemble_error if inside else 0.0))
    ax.errorbar(
        [row.measured],
        [shown],
        xerr=[[row.measured * across / (1.0 + across)], [row.measured * across]],
        yerr=[[shown * up / (1.0 + up)], [shown * up]],
        color=color, marker=marker, markersize=4.5, linewidth=0.7, alpha=0.85, markerfacecolor=color if inside else "none",
    )  # fmt: skip


def uncertainty_of(plan: Plan, row: Row) -> float:
    """Return the standard uncertainty [decades] of a datum by the plan, without the scatter of its record."""
    target = next(t for t in plan.targets if t.name == row.target)
    if row.key == "frequency":
        own, default = target.frequency_uncertainty, plan.frequency_uncertainty
    else:
        own, default = target.uncertainty, plan.uncertainty
    return own if own is not None else default


def markers_of(plan: Plan) -> dict[str, str]:
    """Return a marker for each target, the same in every figure."""
    return {target.name: MARKERS[at % len(MARKERS)] for at, target in enumerate(plan.targets)}


def _handles(plan: Plan, fits: Sequence[Fit], colors: Mapping[str, str]) -> dict[str, Any]:
    """Return legend entries: a line for each model, a marker for each target."""
    handles = {fit.model: legend_mark(colors[fit.model], line="-") for fit in fits}
    for target, marker in markers_of(plan).items():
        handles[target if target not in handles else f"target {target}"] = legend_mark(TEST, marker=marker)
    return handles


def predicted_figure(plan: Plan, fits: Sequence[Fit], colors: Mapping[str, str]) -> bytes:
    """Draw log10(predicted / measured) of each condition predicted from the others, for one reading of the ordinate."""
    conditions = list(dict.fromkeys(each.condition for fit in fits for each in fit.predicted))
    figure, axes = make_figure(1, 1, 1.6 + 0.22 * len(conditions) * max(2, len(fits)))
    ax, markers = axes[0, 0], markers_of(plan)
    everything = [abs(r) for f in fits for each in f.predicted for r in each.residuals if math.isfinite(r)]
    edge = min(WIDEST, 1.15 * max([*everything, 2.0 * BAND[1]]))
    ax.axvspan(*BAND, color=CLEARANCE, alpha=0.25, linewidth=0)
    ax.axvline(0.0, color=CLEARANCE, linewidth=0.9)
    for at, fit in enumerate(fits):
        shift = 0.7 * ((at + 0.5) / len(fits) - 0.5)
        for each in fit.predicted:
            for label, residual in zip(each.labels, each.residuals, strict=True):
                if not math.isfinite(residual):
                    continue
                _, target, key = label.rsplit(", ", 2)
                ax.plot(
                    [max(-edge, min(edge, residual))],
                    [conditions.index(each.condition) + shift],
                    color=colors[fit.model], marker=markers[target], markersize=5, linestyle="none", alpha=0.85,
                    markerfacecolor="none" if key == "frequency" else colors[fit.model], clip_on=False,
                )  # fmt: skip
    for at in range(1, len(conditions)):
        ax.axhline(at - 0.5, color="#e4e6ea", linewidth=0.8)
    ax.set_yticks(range(len(conditions)), [plain(wrapped(short(c, 52), 26)) for c in conditions])
    ax.set_ylim(len(conditions) - 0.5, -0.5)
    ax.grid(False, axis="y")
    ax.set_xlim(-edge, edge)
    from matplotlib.ticker import FuncFormatter

    ax.xaxis.set_major_formatter(
        FuncFormatter(lambda v, _: f"{v:+g}\n(× {10.0**v:.3g})" if v else "0\n(× 1)")
    )
    ax.set_xlabel("predicted over measured [decades]; hollow: frequencies; grey: ± 10 %", fontsize=TEXT)
    title = f"Each condition predicted from all the others, reading {fits[0].reading}"
    return finished(figure, title, _handles(plan, fits, colors))
