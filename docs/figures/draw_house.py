"""Draw the house from its code: rooms by level, their size, and every import between them."""

import ast
import tomllib
from collections import Counter
from pathlib import Path

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot as plt
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "gearplay"
OUT = Path(__file__).with_name("house.svg")
LEVELS = {"__main__": "interfaces", "calibration": "analyses", "results": "foundations", "solver": "core"}
COLORS = {"interfaces": "#e8eef6", "analyses": "#dfeee4", "foundations": "#f6efdd", "core": "#efe6f3"}


def layers() -> list[list[str]]:
    """Return the rooms of each layer, top first, as the linter holds them."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    found = next(each["layers"] for each in contracts if each["type"] == "layers")
    return [[room.strip() for room in layer.split("|")] for layer in found]


def room_of(path: Path) -> str:
    """Return the room of a module."""
    parts = path.relative_to(SOURCE).parts
    return parts[0].removesuffix(".py")


def imports() -> Counter[tuple[str, str]]:
    """Return how many imports lead from one room to another; those for types only do not count."""
    found: Counter[tuple[str, str]] = Counter()
    for path in SOURCE.rglob("*.py"):
        tree = ast.parse(path.read_text())
        for_types = {
            inner
            for node in ast.walk(tree)
            if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"
            for inner in ast.walk(node)
        }
        for node in ast.walk(tree):
            if (
                isinstance(node, ast.ImportFrom)
                and node not in for_types
                and (node.module or "").startswith("gearplay.")
            ):
                pair = room_of(path), str(node.module).split(".")[1]
                if pair[0] != pair[1]:
                    found[pair] += 1
    return found


def main() -> None:
    """Write ``house.svg``."""
    plt.rcParams["svg.hashsalt"] = "gearplay"
    plt.rcParams["font.family"] = "DejaVu Sans"
    modules, lines = Counter(), Counter()
    for path in SOURCE.rglob("*.py"):
        modules[room_of(path)] += 1
        lines[room_of(path)] += len(path.read_text().splitlines())
    rows, places, level, count = layers(), {}, "", 0
    figure, ax = plt.subplots(figsize=(10.0, 0.86 * len(rows)))
    for at, row in enumerate(rows):
        level = next((LEVELS[room] for room in row if room in LEVELS), level)
        for k, room in enumerate(row):
            aside = (
                1.3 * (1 - 2 * (at % 2)) if len(row) == 1 else 0.0
            )  # or arrows between neighbours hide the others
            x, y = 5.0 + aside + 3.0 * (k - 0.5 * (len(row) - 1)), -float(at)
            places[room] = (x, y)
            ax.add_patch(FancyBboxPatch((x - 1.05, y - 0.27), 2.1, 0.54, boxstyle="round,pad=0.02", facecolor=COLORS[level],
                                        edgecolor="#5b6573", linewidth=0.8, zorder=3))  # fmt: skip
            ax.text(x, y + 0.08, room, ha="center", va="center", fontsize=9.5, fontweight="bold", zorder=4)
            words = f"{modules[room]} module{'s' if modules[room] != 1 else ''}, {lines[room]} lines"
            ax.text(x, y - 0.14, words, ha="center", va="center", fontsize=6.5, color="#5b6573", zorder=4)
        if any(room in LEVELS for room in row):
            ax.text(
                -2.1, -float(at), level, ha="left", va="center", fontsize=9, color="#5b6573", style="italic"
            )
    for (upper, lower), number in sorted(imports().items()):
        if upper not in places or lower not in places:
            continue
        (x0, y0), (x1, y1) = places[upper], places[lower]
        bend = 0.12 * (y0 - y1) * (1 if (hash_of(upper + lower) % 2) else -1)
        ax.add_patch(FancyArrowPatch((x0, y0 - 0.29), (x1, y1 + 0.29), arrowstyle="-|>", mutation_scale=6, zorder=1,
                                     connectionstyle=f"arc3,rad={0.08 * bend:.3f}", color="#0b5fa5",
                                     linewidth=0.3 + 0.05 * min(number, 30), alpha=0.45))  # fmt: skip
        count += number
    ax.set_xlim(-2.2, 10.8)
    ax.set_ylim(-len(rows) + 0.5, 0.5)
    ax.axis("off")
    ax.set_title(
        f"{sum(modules.values())} modules; {count} imports between packages, all downwards", fontsize=9
    )
    figure.savefig(OUT, metadata={"Date": None}, bbox_inches="tight")


def hash_of(text: str) -> int:
    """Return a number that is the same on every run."""
    return sum(map(ord, text))


if __name__ == "__main__":
    main()
