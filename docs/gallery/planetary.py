"""Draw the pictures of docs/gallery/planetary.md beside this file and print its numbers: python docs/gallery/planetary.py;
--short --out FOLDER tries it.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import brentq
from sizes import draw, sized

import gearplay as gp
from gearplay.pictures.canvas import SMALL, legend_mark, make_figure, set_legend, set_title, to_png
from gearplay.pictures.style import CLEARANCE, COUPLED, UNCOUPLED

HERE = Path(__file__).parent
CASE = gp.load_case(HERE / "two-stage-planetary.toml")
RPM = 30.0 / np.pi
ERRORS, FLOATING = "planetary.second.pin_errors", "planetary.second.sun.floating"
LIMIT = 1.2


def modes() -> None:
    """Mode shapes, and where the first stage's mesh meets them."""
    found = gp.modes(CASE)
    (sized.out / "planetary-modes.png").write_bytes(to_png(found.plot(most=8)))
    print(found.message)
    diagram = gp.campbell(CASE, np.linspace(20.0, 7000.0, sized(120, 20)) / RPM)
    (sized.out / "planetary-campbell.png").write_bytes(to_png(diagram.plot()))


def off_by(error: float, *, floating: bool) -> gp.Case:
    """Return the case with one pin of the second stage ahead of its place [m]."""
    return gp.replace(CASE, {ERRORS: [{"planet": 1, "tangential": error}], FLOATING: floating})


def sharing() -> None:
    """Load sharing with a pin 50 um ahead, sun floating and held; the error that a held sun allows."""
    for floating in (True, False):
        print(
            "floating" if floating else "held",
            gp.load_sharing(off_by(50e-6, floating=floating), name="second").message,
        )
    moving = gp.simulate(off_by(50e-6, floating=True), duration=sized(1.0, 0.2))
    (sized.out / "planetary-sharing.png").write_bytes(to_png(gp.load_sharing(moving, name="second").plot()))
    errors = np.linspace(0.0, 50e-6, sized(41, 6))
    figure, axes = make_figure(1, 1, 3.8)
    ax = axes[0, 0]
    for floating, color in ((True, COUPLED), (False, UNCOUPLED)):
        ax.plot(1e6 * errors, [factor(e, floating=floating) for e in errors], color=color, linewidth=1.4)
    allowed = brentq(lambda e: factor(e, floating=False) - LIMIT, 1e-6, 30e-6)
    print(f"a held sun allows {1e6 * allowed:.2f} um")
    ax.axhline(LIMIT, color=CLEARANCE, linestyle="--", linewidth=1.0)
    ax.axvline(1e6 * allowed, color=CLEARANCE, linestyle=":", linewidth=1.0)
    ax.set_xlabel("one pin ahead of its place [µm]", fontsize=SMALL)
    ax.set_ylabel("largest load-sharing factor [1]", fontsize=SMALL)
    marks = {"sun floats": legend_mark(COUPLED, line="-"), "sun held": legend_mark(UNCOUPLED, line="-")}
    set_legend(figure, marks | {f"limit {LIMIT}": legend_mark(CLEARANCE, line="--")})
    set_title(figure, "Second stage: what an error of one pin does to the load")
    (sized.out / "planetary-tolerance.png").write_bytes(to_png(figure))


def factor(error: float, *, floating: bool) -> float:
    """Return the largest load-sharing factor with one pin ahead of its place [m]."""
    found = gp.load_sharing(off_by(error, floating=floating), name="second")
    return float(found.ds["load_sharing_factor"].max())


def run_up() -> None:
    """Contact of the first stage's meshes over speed, at a small and at the full load."""
    speeds = np.linspace(500.0, 8500.0, sized(33, 5))
    figure, axes = make_figure(2, 1, 5.6)
    natural = gp.modes(gp.replace(CASE, {"planetary.second.carrier.load.torque": 20.0})).ds
    orders = 20.0 * (1.0 - 20.0 / 92.0) / 60.0  # mesh frequency [Hz] per rpm of the sun
    for load, color in ((20.0, UNCOUPLED), (200.0, COUPLED)):
        cases = [
            gp.replace(
                CASE,
                {
                    "planetary.first.sun.drive.speed": speed / RPM,
                    "planetary.second.carrier.load.torque": load,
                    "run.duration": 0.05,
                    "run.transient": 0.05,
                    "run.ensemble": 2,
                },
            )
            for speed in speeds
        ]
        results = gp.simulate(cases, signals=["drive_force"])
        names = [f"first.sun-first.planet{k}:drive" for k in range(1, 5)]
        touching, swing = [], []
        for result in results:
            shares = dict(zip(result.contacts.labels, result.contacts.values["share_of_time"], strict=True))
            touching.append(np.mean([shares[name] for name in names]))
            forces = np.concatenate(
                [result.signal("drive_force", n.removesuffix(":drive"), m) for n in names for m in range(2)]
            )
            swing.append(np.percentile(forces, 99.0) / max(forces.mean(), 1e-9))
        axes[0, 0].plot(speeds, 100.0 * np.array(touching), ".-", color=color, linewidth=1.0, markersize=4)
        axes[1, 0].plot(speeds, swing, ".-", color=color, linewidth=1.0, markersize=4)
        lowest = speeds[int(np.argmin(touching))]
        print(f"{load} N m: least contact {100 * min(touching):.1f} % at {lowest:.0f} rpm")
    for mode, kind in zip(natural["frequency"].values, natural["kind"].values, strict=True):
        if kind == "rotational" and mode < speeds[-1] * orders:
            for ax in axes[:, 0]:
                ax.axvline(mode / orders, color=CLEARANCE, linestyle=":", linewidth=0.9)
    axes[0, 0].set_ylim(0.0, 105.0)
    axes[0, 0].set_ylabel("time in contact [%]", fontsize=SMALL)
    axes[1, 0].set_ylabel("99 % of the mesh force over its mean [1]", fontsize=SMALL)
    axes[1, 0].set_xlabel("speed of the first sun [rpm]", fontsize=SMALL)
    marks = {
        "20 N m": legend_mark(UNCOUPLED, marker=".", line="-"),
        "200 N m": legend_mark(COUPLED, marker=".", line="-"),
    }
    set_legend(
        figure, marks | {"mesh frequency at a rotational mode, 20 N m": legend_mark(CLEARANCE, line=":")}
    )
    set_title(figure, "First stage: sun's meshes over speed, mean of 2 members and 4 planets")
    (sized.out / "planetary-run-up.png").write_bytes(to_png(figure))


def main(words: Sequence[str] | None = None) -> None:
    """Draw all of it."""
    draw(words, modes, sharing, run_up)


if __name__ == "__main__":
    main()
