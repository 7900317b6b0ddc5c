"""The mechanism at an instant: gears with involute teeth, shafts in their sleeves, forces; small motions magnified.

The complete mechanism with close-ups of one sleeve and one mesh. It is built once and shows one frame after another, for pictures
and animations; its data come from `gearplay.results.mechanism`. The page and its player draw the same (``mechanism.js``).
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.canvas import SMALL, set_title
from gearplay.pictures.gears import (
    Gear,
    Look,
    arm_of,
    axis_of,
    gear_on,
    magnification,
    mesh_look,
    outline,
    pair_of,
    phases,
    pitch_point,
    rim_radius,
    sides_of,
    sleeve_look,
    toward,
    whole_look,
)
from gearplay.pictures.joints import CIRCLE, SOFT, Joints
from gearplay.pictures.style import COUPLED, TEST, blank_figure, tidy
from gearplay.pictures.words import plain, short

Floats = NDArray[np.float64]
FILLS = ("#d3dae4", "#f3ecdd")
FORCE = "#a3123a"
MM = 1e3
AROUND = np.column_stack([np.cos(CIRCLE), np.sin(CIRCLE)])


class _Pane(NamedTuple):
    """One view: its axes, its window, whether carriers turn in it, its moving artists."""

    ax: Any
    look: Look
    turning: bool
    gears: list[tuple[Any, Gear]]
    arms: list[tuple[Any, str, str]]
    shafts: list[tuple[Any, Gear]]
    sleeves: list[tuple[Any, Gear, float, int]]
    forces: list[Any]
    joints: Joints


class Stage:
    """The drawing of a mechanism and its frames, as `mechanism_of` and `frames_of` return them.

    Small motions are drawn ``times`` larger than usual. ``sleeve`` and ``mesh`` name the elements of the close-ups, by default
    the first; the time of the frames counts from ``start`` [s].
    """

    def __init__(
        self,
        mechanism: Mapping[str, Any],
        frames: Mapping[str, Any],
        *,
        title: str = "",
        times: float = 1.0,
        sleeve: str | None = None,
        mesh: str | None = None,
        start: float = 0.0,
    ) -> None:
        self.mechanism, self.frames, self.start = mechanism, frames, start
        self.factor = magnification(mechanism, times)
        self.phases = phases(mechanism["gears"], mechanism["meshes"])
        self.peak = max(float(np.max(np.abs(frames[key]), initial=0.0)) for key in ("sleeves", "meshes"))
        self.figure = blank_figure(9.0, 5.4)
        found = (sleeve_look(mechanism, sleeve, self.factor), mesh_look(mechanism, mesh))
        looks = [each for each in found if each is not None]
        widths = [1.9, 1.0] if looks else [1.0]
        grid = self.figure.add_gridspec(max(1, len(looks)), len(widths), width_ratios=widths)
        self.panes = [self._pane(self.figure.add_subplot(grid[:, 0]), whole_look(mechanism))]
        for row, look in enumerate(looks):
            self.panes.append(self._pane(self.figure.add_subplot(grid[row, 1]), look))
        set_title(self.figure, title)
        place = {"ha": "center", "va": "bottom", "family": "monospace"}
        self.clock = self.figure.text(0.5, 0.005, "", fontsize=SMALL, color=SOFT, **place)
        self.figure.get_layout_engine().set(rect=(0.0, 0.035, 1.0, 0.965))

    def show(self, i: int, words: str = "") -> None:
        """Show frame ``i``; ``words`` come after its time and the magnification."""
        time = self.start + float(self.frames["t"][i])
        large = f"clearances and small motions {float(f'{self.factor:.2g}'):g} times larger"
        self.clock.set_text(plain("   ".join(part for part in (f"t = {time:.5f} s", large, words) if part)))
        for pane in self.panes:
            self._place(pane, i)

    def loudest(self) -> int:
        """Return the index of the frame with the largest force; 0 without contacts."""
        count = len(self.frames["t"])
        forces = [np.abs(self.frames[key]).reshape(-1, count) for key in ("sleeves", "meshes")]
        whole = np.concatenate(forces)
        return int(np.argmax(whole.max(axis=0))) if whole.size else 0

    def _gear(self, rotor: str) -> Gear:
        return gear_on(self.mechanism, rotor)

    def _pane(self, ax: Any, look: Look) -> _Pane:
        """Make a view's artists, which `_place` moves."""
        mechanism, close_up = self.mechanism, bool(look.words)
        tidy(ax).grid(False)
        ax.set_aspect("equal")
        self._focus(ax, look, look.x, look.y)
        ax.locator_params(nbins=5)
        if close_up:
            ax.set_xticks([])
            ax.set_yticks([])
            ax.spines[["top", "right"]].set_visible(True)
            ax.set_title(plain(short(look.words, 56)), fontsize=SMALL)
        else:
            ax.set_xlabel("x [mm]", fontsize=SMALL)
            ax.set_ylabel("y [mm]", fontsize=SMALL)

        def line(**style: Any) -> Any:
            return ax.plot([], [], **style)[0]

        gears, arms = self._gears(ax), []
        for each in mechanism["carried"]:
            if not close_up and arm_of(mechanism, self._gear(each["rotor"])) > 0.0:
                arm = line(color=SOFT, alpha=0.55, linewidth=5.0, solid_capstyle="round", zorder=3)
                arms.append((arm, each["rotor"], each["on"]))
        for x, y, to_x, to_y in mechanism["axes"]:
            ends = [MM * x, MM * to_x], [MM * y, MM * to_y]
            ax.plot(*ends, color=COUPLED, linewidth=0.9, linestyle="-.", zorder=3.5)
        shafts, sleeves = self._shafts(ax, look.shaft, line)
        if not close_up:
            self._names(ax)
        count = len(mechanism["sleeves"]) + 2 * len(mechanism["meshes"])
        forces = [line(color=FORCE, linewidth=1.5, zorder=6, clip_on=close_up) for _ in range(count)]
        return _Pane(ax, look, not close_up, gears, arms, shafts, sleeves, forces, Joints(ax, mechanism))

    def _gears(self, ax: Any) -> list[tuple[Any, Gear]]:
        """Return the patches of the toothed gears, small ones on top."""
        from matplotlib.patches import PathPatch

        toothed = [gear for gear in self.mechanism["gears"] if gear["teeth"] and gear["module"]]
        sides, found = sides_of(self.mechanism), []
        for k, gear in enumerate(sorted(toothed, key=rim_radius, reverse=True)):
            style = {"facecolor": FILLS[sides[gear["name"]]], "edgecolor": TEST, "linewidth": 0.6}
            found.append((ax.add_patch(PathPatch(self._path(gear), **style, zorder=2 + 0.01 * k)), gear))
        return found

    def _shafts(
        self, ax: Any, radius: float | None, line: Callable[..., Any]
    ) -> tuple[list[tuple[Any, Gear]], list[tuple[Any, Gear, float, int]]]:
        """Return the discs of the shafts, of this radius [m] or their own, and the rings of the sleeves around them."""
        from matplotlib.patches import Polygon

        shafts, sleeves = [], []
        held = [each["name"] for each in self.mechanism["sleeves"]]
        drawn = {(each["rotor"], each["plane"]): each for each in reversed(self.mechanism["gears"])}
        for gear in drawn.values():
            own = radius or gear["shaft"]
            if gear["rotor"] in held:
                k = held.index(gear["rotor"])
                play = self.factor * self.mechanism["sleeves"][k]["clearance"]
                ring = line(color=SOFT, linewidth=1.1, linestyle="-" if play > 0.0 else ":", zorder=5)
                sleeves.append((ring, gear, own + play if play > 0.0 else 1.3 * own, k))
            shafts.append((ax.add_patch(Polygon(own * AROUND, facecolor=COUPLED, zorder=4)), gear))
        return shafts, sleeves

    @staticmethod
    def _focus(ax: Any, look: Look, x: float, y: float) -> None:
        """Set the window of a view about a middle [m]."""
        ax.set_xlim(MM * (x - look.half_x), MM * (x + look.half_x))
        ax.set_ylim(MM * (y - look.half_y), MM * (y + look.half_y))

    def _names(self, ax: Any) -> None:
        """Write the names of the gears next to their shafts, that of a ring in its rim."""
        from matplotlib.patheffects import withStroke

        around, hubs = ({each[key] for each in self.mechanism["carried"]} for key in ("rotor", "on"))
        words: dict[tuple[float, float], list[str]] = {}
        for gear in self.mechanism["gears"]:
            if gear["rotor"] in around or (gear["rotor"] in hubs and not gear["teeth"]):
                continue  # it goes around, or is a carrier behind a sun
            ring = gear["internal"]
            up = rim_radius(gear) - 1.4 * gear["module"] if ring else -1.8 * gear["shaft"]
            own = (gear["x"], gear["y"] + up)
            place = next((at for at in words if not ring and math.dist(at, own) < abs(up)), own)
            words.setdefault(place, []).append(short(gear["shown"], 24))
        style = {"fontsize": SMALL, "ha": "center", "va": "center", "zorder": 7}
        halo = [withStroke(linewidth=2.5, foreground="white")]
        for (x, y), names in words.items():
            ax.text(MM * x, MM * y, plain(", ".join(names)), path_effects=halo, **style)

    def _path(self, gear: Gear) -> Any:
        """Return a gear's teeth with the magnified backlash, a ring's within its rim."""
        from matplotlib.path import Path

        meshes = [m for m in self.mechanism["meshes"] if gear["name"] in (m["driver"], m["driven"])]
        gap = self.factor * max([0.0, *(m["backlash"] for m in meshes if math.isfinite(m["backlash"]))])
        teeth = Path(outline(gear, min(gap, 0.8 * math.pi * gear["module"])), closed=True)
        if not gear["internal"]:
            return teeth
        rim = rim_radius(gear) * AROUND * (1.0, -1.0)
        return Path.make_compound_path(Path(rim, closed=True), teeth)

    def _place(self, pane: _Pane, i: int) -> None:
        """Update all artists of a view for frame ``i``."""
        from matplotlib.transforms import Affine2D

        frames, M = self.frames, self.factor

        def set_of(gear: Gear) -> Any:
            """Return the rotation of a gear's set with its carrier."""
            if not pane.turning:
                return Affine2D()
            angle = float(frames["orbit"][gear["index"], i])
            return Affine2D().rotate_around(*axis_of(self.mechanism, gear), angle)

        def centre(gear: Gear) -> Floats:
            dx, dy = frames["rotors"][gear["index"], :2, i]
            return np.array([gear["x"] + M * dx, gear["y"] + M * dy])

        def turn(gear: Gear) -> float:
            return float(frames["turns"][gear["index"], i] + M * frames["rotors"][gear["index"], 2, i])

        def bush(gear: Gear, k: int) -> Floats:
            found: Floats = np.array([gear["x"], gear["y"]]) + M * frames["bushes"][k, :, i]
            return found

        if pane.look.sleeve is not None:
            gear = self._gear(self.mechanism["sleeves"][pane.look.sleeve]["name"])
            self._focus(pane.ax, pane.look, *bush(gear, pane.look.sleeve))
        data = pane.ax.transData
        pane.joints.place(centre, turn, lambda gear, points: MM * set_of(gear).transform(points))
        for patch, gear in pane.gears:
            angle = self.phases.get(gear["name"], 0.0) + turn(gear)
            own = Affine2D().rotate(angle).translate(*centre(gear))
            patch.set_transform(own + set_of(gear) + Affine2D().scale(MM) + data)
        for line, pin, hub in pane.arms:
            ends = [centre(self._gear(name)) for name in (hub, pin)]
            line.set_data(*(MM * set_of(self._gear(pin)).transform(np.array(ends))).T)
        for patch, gear in pane.shafts:
            own = Affine2D().translate(*centre(gear))
            patch.set_transform(own + set_of(gear) + Affine2D().scale(MM) + data)
        for ring, gear, radius, k in pane.sleeves:
            ring.set_data(*(MM * set_of(gear).transform(bush(gear, k) + radius * AROUND)).T)
        for line, (gear, foot, force) in zip(pane.forces, self._forces(i), strict=True):
            span = 0.3 / MM * min(np.ptp(pane.ax.get_xlim()), np.ptp(pane.ax.get_ylim()))
            line.set_data(*(MM * set_of(gear).transform(_arrow(foot, force, self.peak, span))).T)

    def _forces(self, i: int) -> list[tuple[Gear, Floats, Floats]]:
        """Return a gear to turn with, foot [m] and force [N] of every contact at a frame."""
        found = []
        for k, sleeve in enumerate(self.mechanism["sleeves"]):
            gear = self._gear(sleeve["name"])
            moved = self.factor * self.frames["rotors"][gear["index"], :2, i]
            found.append((gear, np.array([gear["x"], gear["y"]]) + moved, self.frames["sleeves"][k, :, i]))
        for j, mesh in enumerate(self.mechanism["meshes"]):
            a, b = pair_of(self.mechanism, mesh)
            for flank, sense in ((0, 1.0), (1, -1.0)):
                angle = toward(a, b) + sense * (a["sense"] or 1.0) * (0.5 * math.pi - mesh["pressure_angle"])
                way = np.array([math.cos(angle), math.sin(angle)])
                found.append((a, np.array(pitch_point(a, b)), self.frames["meshes"][j, flank, i] * way))
        return found


def _arrow(foot: Floats, force: Floats, peak: float, reach: float) -> Floats:
    """Return an arrow, shape [point, 2], of a length proportional to the root of the force; NaN for none."""
    size = float(np.hypot(*force))
    if not size > 1e-6 * peak > 0.0:
        return np.full((1, 2), np.nan)
    length = reach * math.sqrt(size / peak)
    way = force / size
    tip, head = foot + length * way, min(0.16 * reach, 0.5 * length)
    sides = []
    for turn in (2.6, -2.6):
        c, s = math.cos(turn), math.sin(turn)
        sides.append(tip + head * np.array([c * way[0] - s * way[1], s * way[0] + c * way[1]]))
    return np.array([foot, tip, sides[0], tip, sides[1]])
