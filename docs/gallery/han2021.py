"""Draw the pictures of docs/gallery/han2021.md beside this file: python docs/gallery/han2021.py;
--short --out FOLDER tries it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from sizes import draw, sized

import gearplay as gp
from gearplay.nonlinear.figures import WAYS
from gearplay.nonlinear.orbits.figures import branch_marks, draw_branch
from gearplay.parts.mesh.train.geometry import jam_ratio
from gearplay.pictures.canvas import SMALL, legend_mark, make_figure, set_legend, set_title, to_png
from gearplay.pictures.style import COUPLED, UNCOUPLED
from gearplay.solver.simulate import run_members

RPM = 30.0 / np.pi
MODELS = {"coupled": COUPLED, "uncoupled": UNCOUPLED}
LOADED = {
    "rotors.pinion.runout.amplitude": 0.0,
    "rotors.ring.runout.amplitude": 0.0,
    "rotors.ring.radial_damping": 1.0,
}
TORQUE = "rotors.ring.load.torque"


def portrait() -> None:
    """Orbit and phase portraits of the article's pair."""
    found = gp.portrait("han2021", settle=sized(200, 50), keep=sized(500, 100), show=60, period="mesh")
    (sized.out / "han2021-portrait.png").write_bytes(to_png(found.plot()))


def models() -> None:
    """Coupled against uncoupled, over speed and over the jam ratio."""
    figure, axes = make_figure(2, 2, 6.4)
    clearance = "sleeves.ring.radial_clearance"
    for column, (model, color) in enumerate(MODELS.items()):
        case = gp.replace(gp.load_case("han2021"), {"backlash_model": model})
        speeds = np.linspace(10.0, 400.0, sized(300, 12))
        clearances = np.linspace(5e-6, 300e-6, sized(300, 12))
        ratios = [jam_ratio(gp.replace(case, {clearance: float(each)}), 0) for each in clearances]
        rows: list[tuple[str, Any, Any, str, str, str]] = [
            ("rotors.pinion.drive.speed", speeds / RPM, speeds, "ring.vx", "speed [rpm]", "ring's dx/dt [mm/s]"),
            (clearance, clearances, ratios, "ring.x", "jam ratio", "ring's x [µm]"),
        ]  # fmt: skip
        for ax, (path, values, shown, signal, across, up) in zip(axes[:, column], rows, strict=True):
            found = gp.bifurcation(
                case,
                path,
                values.tolist(),
                [signal],
                period="mesh",
                settle=sized(400, 50),
                keep=sized(100, 20),
                directions=["up"],
            ).ds
            factor = 1e3 if signal == "ring.vx" else 1e6
            sections = factor * found[signal].values[0]
            ax.plot(np.repeat(shown, sections.shape[1]), sections.ravel(), ",", color=color, rasterized=True)
            ax.set_xlabel(across, fontsize=SMALL)
            ax.set_ylabel(up, fontsize=SMALL)
            ax.set_title(model, fontsize=SMALL)
    for row in axes:
        low = min(ax.get_ylim()[0] for ax in row)
        high = max(ax.get_ylim()[1] for ax in row)
        for ax in row:
            ax.set_ylim(low, high)
    set_title(figure, "Han 2021: 100 sections, one a mesh period, after 400 periods")
    (sized.out / "han2021-models.png").write_bytes(to_png(figure))


def tongue() -> None:
    """Orbits of the pair under load: the shaft swings in its sleeve at half the mesh frequency."""
    figure, axes = make_figure(1, 2, 4.2)
    values = np.linspace(0.02, 0.4, sized(160, 6))
    trees = {}
    for ax, model in zip(axes[0], MODELS, strict=True):
        case = gp.replace(gp.load_case("han2021"), LOADED | {"backlash_model": model, TORQUE: 0.3})
        found = gp.bifurcation(
            case, TORQUE, values.tolist(), ["ring.x"], period="mesh", settle=sized(400, 50), keep=20
        ).ds
        for way, name in enumerate(found["direction"].values):
            sections = 1e6 * found["ring.x"].values[way]
            ax.plot(
                np.repeat(values, sections.shape[1]), sections.ravel(), ".", color=WAYS[name], markersize=2.0
            )
        tree = trees[model] = gp.branches(
            case, TORQUE, *sized((0.08, 0.4), (0.298, 0.302)), doublings=sized(1, 0), settle=400
        )
        for branch, levels in zip(tree, tree.levels(["ring.x"]), strict=True):
            draw_branch(ax, branch, 1e6 * levels[:, :, 0])
            for special in branch.special:
                print(model, branch.order, special.kind, f"{special.orbit.parameter:.6f}")
        ax.set_xlabel("load torque [N m]", fontsize=SMALL)
        ax.set_ylabel("ring's x [µm]", fontsize=SMALL)
        ax.set_title(model, fontsize=SMALL)
        ax.set_xlim(values[0], values[-1])
    handles = {"sweep up": legend_mark(WAYS["up"], marker="o"), "sweep down": legend_mark(WAYS["down"], marker="o")}  # fmt: skip
    set_legend(figure, handles | branch_marks(trees["coupled"]))
    set_title(figure, "Han 2021 under load, 1 N s/m of radial damping, no run-out: parametric resonance")
    (sized.out / "han2021-tongue.png").write_bytes(to_png(figure))


def impact_speeds(case: gp.Case, step: float | None, contacts: str) -> tuple[np.ndarray, int]:
    """Return the rms impact speed [mm/s] on the drive flank of the members of 24 that do not blow up, and how many do."""
    case = gp.replace(case, {"run.fixed_step": step, "run.fixed_step_contacts": contacts})
    runs = run_members(case, range(1, sized(25, 5)), signals=["ring.omega"])
    speeds = [1e3 * float(run.statistics.rms_impact_speed[1]) for run in runs if run.success]
    error = np.std(speeds, ddof=1) / len(speeds) ** 0.5 if len(speeds) > 1 else np.nan
    mean = np.mean(speeds or np.nan)
    print(case.formulation, step, contacts, f"{mean:.3f} +- {error:.3f}, {len(runs) - len(speeds)} blow up")
    return np.array(speeds), len(runs) - len(speeds)


def artefact() -> None:
    """Draw how impact speeds of the published formulation at 200/100 um hang on the step, and on where contacts are judged."""
    figure, axes = make_figure(1, 1, 3.8)
    ax = axes[0, 0]
    steps = sized([0.5e-6, 1e-6, 2e-6, 5e-6, 10e-6, 20e-6], [5e-6, 20e-6])
    handles = {}
    for color, (formulation, words) in zip(
        (UNCOUPLED, COUPLED), (("as_published", "as published"), ("geometric", "geometric")), strict=True
    ):
        clearance, method = (
            {"sleeves.ring.radial_clearance": 2e-4},
            {"run.sampling": 1e3, "run.tolerance": 1e-9},
        )
        case = gp.replace(gp.load_case("han2021"), {"formulation": formulation} | clearance | method)
        speeds, _ = impact_speeds(case, None, "step")
        mean, spread = speeds.mean(), 2.0 * speeds.std(ddof=1) / np.sqrt(speeds.size)
        ax.axhspan(mean - spread, mean + spread, color=color, alpha=0.25, linewidth=0)
        for contacts, fill, aside in (("step", color, 0.97), ("stage", "white", 1.03)):
            for step in steps:
                speeds, failed = impact_speeds(case, step, contacts)
                if failed > speeds.size or speeds.size < 2:  # what survives says nothing
                    continue
                mean, spread = speeds.mean(), 2.0 * speeds.std(ddof=1) / np.sqrt(speeds.size)
                at = 1e6 * step * aside
                ax.errorbar(at, mean, spread, fmt="o", color=color, mfc=fill, markersize=4, capsize=2)
                if failed:
                    ax.annotate(
                        f"{failed} of {failed + speeds.size} blow up", (at, mean),
                        xytext=(-6, 6), textcoords="offset points", fontsize=SMALL, ha="right",
                    )  # fmt: skip
        hollow = legend_mark(color, marker="o")
        hollow.set_markerfacecolor("white")
        handles[f"{words}, contacts frozen over a step"] = legend_mark(color, marker="o")
        handles[f"{words}, contacts judged at every stage"] = hollow
        handles[f"{words}, located contacts (band)"] = legend_mark(color, line="-")
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel("length of a plain step [µs]", fontsize=SMALL)
    ax.set_ylabel("rms impact speed of the drive flank [mm/s]", fontsize=SMALL)
    set_legend(figure, handles)
    set_title(figure, "200/100 µm: mean of 24 runs of 2 s with twice its standard error")
    (sized.out / "han2021-artefact.png").write_bytes(to_png(figure))


def main(words: Sequence[str] | None = None) -> None:
    """Draw all of it."""
    draw(words, portrait, models, artefact, tongue)


if __name__ == "__main__":
    main()
