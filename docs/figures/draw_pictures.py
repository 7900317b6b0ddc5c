"""Draw the pictures of docs/pictures.md, README, first steps and how-to pages: python docs/figures/draw_pictures.py."""

import contextlib
import re
import shlex
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import gearplay as gp
from gearplay.cli.main import run
from gearplay.pictures.canvas import SMALL, make_figure, to_png
from gearplay.pictures.style import COUPLED, UNCOUPLED

HERE = Path(__file__).parent
HOW_TO = HERE.parent / "how-to"
AXIS = ["--signal", "wheel.theta", "--signal", "motor.drive_torque"]


def axis() -> None:
    """Draw how the axis of docs/how-to hunts with one sampling time and rests with another."""
    for name, sample_time in (("axis-1ms", "1ms"), ("axis-fast", "0.5ms")):
        with tempfile.TemporaryDirectory() as folder:
            result = f"{folder}/axis.nc"
            change = f"rotors.motor.drive.sample_time={sample_time}"
            run(["run", str(HOW_TO / "position-drive.toml"), "--set", change, "--out", result])
            run(["plot", result, *AXIS, "--out", str(HOW_TO / f"{name}.png"), "--overwrite"])


def diagnosis() -> None:
    """Draw what docs/how-to/diagnose.md shows of its first record, which the tests make."""
    sys.path.insert(0, str(HERE.parents[1] / "tests"))
    from docs_files import make_motor

    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "motor.mat"
        make_motor(record)
        bearing = ["--bearing", "9, 7.94mm, 39.04mm", "--speed", "1797 rpm", "--unit", "X105_DE_time=g"]
        run(["diagnose", str(record), *bearing, "--out", f"{folder}/out"])
        shutil.copy(f"{folder}/out/diagnosis.png", HOW_TO / "diagnosis.png")


def crack() -> None:
    """Draw the difference signals of docs/how-to/crack.md, with the functions of that page."""
    blocks = re.findall(r"```python\n(.*?)```", (HOW_TO / "crack.md").read_text(encoding="utf-8"), re.DOTALL)
    page: dict[str, Any] = {}
    with contextlib.chdir(HERE.parents[1]):
        exec(blocks[0].split("\nfor state")[0], page)
        figure, panels = make_figure(1, 2, 3.2)
        axes = panels[0]
        states = {"180 N m": {}, "2 N m and a speed ripple of 3 %": page["rattling"]}
        for axis, (title, state) in zip(axes, states.items(), strict=True):
            for label, faults, line, color in (
                ("sound", {"faults": []}, "-", COUPLED),
                ("crack of 2 mm", {}, "--", UNCOUPLED),
            ):
                found = page["difference"](gp.replace(page["case"], {**state, **faults}))
                angle = 360.0 * np.arange(found.size) / found.size
                axis.plot(angle, 1e6 * found, line, color=color, lw=1.0, label=label)
            axis.set_title(title, fontsize=SMALL, loc="left")
            axis.set(xlabel="angle of the pinion [deg]", xticks=range(0, 361, 90))
        axes[0].set_ylabel("difference signal of the wheel [µm]")
        axes[0].legend(frameon=False, fontsize=SMALL)
        (HOW_TO / "crack.png").write_bytes(to_png(figure))


def play() -> None:
    """Draw what docs/how-to/wear.md and lost-motion.md show, by the first commands of these pages."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(HERE.parents[1]):
        for page, made in (("wear", "wear.png"), ("lost-motion", "lost-motion.png")):
            text = (HOW_TO / f"{page}.md").read_text(encoding="utf-8")
            words = shlex.split(text.split("```sh\n")[1].splitlines()[0])[1:]
            words = words[: words.index("--out")] if "--out" in words else words
            run([*words, "--out", f"{folder}/{page}"])
            shutil.copy(f"{folder}/{page}/{made}", HOW_TO / made)


def main() -> None:
    """Simulate once and draw."""
    with tempfile.TemporaryDirectory() as folder:
        result = f"{folder}/run.nc"
        run(["run", "han2021-calibrated", "--out", result, "--set", "run.start=drawn", "--duration", "1s"])
        for kind in ("mechanism", "overview"):
            out = str(HERE / f"{kind}.png")
            run(["plot", result, "--kind", kind, "--out", out, "--overwrite"])


def first_run() -> None:
    """Draw what docs/first-steps.md shows of its first run."""
    with tempfile.TemporaryDirectory() as folder:
        result = f"{folder}/run.nc"
        run(["run", "han2021", "--set", "run.start=drawn", "--out", result])
        run(["plot", result, "--out", str(HERE / "first-run.png"), "--overwrite"])


def motion() -> None:
    """Draw the moving picture of the README."""
    with tempfile.TemporaryDirectory() as folder:
        result = f"{folder}/run.nc"
        run(["run", "han2021", "--set", "run.duration=0.5s", "--out", result])
        run(["animate", result, "--frames", "40", "--out", str(HERE / "motion.gif"), "--overwrite"])


def teeth() -> None:
    """Draw the pair of docs/teeth.md."""
    text = (HERE.parent / "teeth.md").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "wind-stage.toml"
        case.write_text(text.split("```toml\n")[1].split("```")[0], encoding="utf-8")
        run(["teeth", str(case), "--out", folder])
        (HERE / "teeth.png").write_bytes((Path(folder) / "teeth.png").read_bytes())


def maps() -> None:
    """Draw the maps over series of the tooth thickness of docs/how-to/drawing.md and gearbox-program.md."""
    sys.path.insert(0, str(HERE.parents[1] / "tests"))
    from docs_files import make_backlash_map, make_drawn

    with tempfile.TemporaryDirectory() as folder:
        box = HERE.parent / "gearboxes" / "FVA_two_stages_1.4.rexsz"
        run(["import", str(box), "--gear-bodies", "solid", "--out", f"{folder}/box.toml"])
        make_drawn(Path(folder) / "drawn.toml")
        for name, make in (("drawing-map", make_drawn), ("gearbox-map", make_backlash_map)):
            plan = Path(folder) / f"{name}.toml"
            make(plan)
            run(["sweep", str(plan), "--out", f"{folder}/{name}"])
            shutil.copy(f"{folder}/{name}/figures/lines-speed-1.png", HOW_TO / f"{name}.png")


if __name__ == "__main__":
    main()
    motion()
    axis()
    first_run()
    teeth()
    maps()
    diagnosis()
    crack()
    play()
