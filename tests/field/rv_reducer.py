"""Lost motion of an RV reducer from measured transmission errors, for whoever has the files.

    python tests/field/rv_reducer.py FOLDER

FOLDER holds ``1100.0rpm{T}Nm25.0deg.csv`` at several torques T, of the data of
github.com/XiLab-Robotics/Physics-Informed-Neural-Networks (data/Experimental Data/Test_25degree/1100rpm): the transmission error
over the output's position, turning forward and backward under a load that opposes the motion [deg]. At one position of the output
backward less forward is the width of the hysteresis curve at that torque. No file of it is part of this repository.

Printed are that width at each torque, its slopes, and what `gearplay lost-motion` makes of the same points. The exit code is 1
where widths are not those read by hand from the files, so far as their torques are there.
"""

import argparse
import csv
import re
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gearplay as gp

Floats = NDArray[np.float64]
ARCMIN = 60.0
NEAREST = 16
"""Rows about the position at which the branches are compared."""
IDLE = 0.02
BY_HAND = {0.0: 0.0045, 300.0: 0.0309, 800.0: 0.0667, 1600.0: 0.1217}
"""Backward less forward [deg] by torque [N m], read from the files at 1100 rpm, 25 degC."""
READ = 0.002
"""How far these may be off [deg]: less than the ripple of the error, 0.003 deg."""


def column(names: list[str], *words: str) -> int:
    """Return the place of the first column whose name has all words, in any case; ``SystemExit`` where there is none."""
    for place, name in enumerate(names):
        if all(re.search(word, name, re.IGNORECASE) for word in words):
            return place
    sys.exit(f"columns = {', '.join(names)}: must have one of {' and '.join(words)}. Name them by --columns.")


def read(path: Path, chosen: list[str] | None, position: float) -> tuple[Floats, Floats]:
    """Return the transmission errors [deg] forward and backward, of the rows nearest to a position [deg], none with NaN."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.reader(file))
    names = [name.strip() for name in rows[0]]
    if chosen is not None:
        places = [names.index(name) for name in chosen]
    else:  # the files say Poisition
        place = column(names, "out", "po[is]")
        places = [place, column(names, "err", "forward|fw"), column(names, "err", "backward|bw")]
    table = np.full((len(rows) - 1, 3), np.nan)
    for k, row in enumerate(rows[1:]):
        for c, place in enumerate(places):
            try:
                table[k, c] = float(row[place])
            except (ValueError, IndexError):
                continue
    table = table[np.all(np.isfinite(table), axis=1)]
    away = np.abs((table[:, 0] - position + 180.0) % 360.0 - 180.0)
    near = table[np.argsort(away, kind="stable")[:NEAREST]]
    return near[:, 1], near[:, 2]


def widths(folder: Path, chosen: list[str] | None, position: float) -> dict[float, tuple[Floats, Floats]]:
    """Return both errors by torque [N m], of all files of the folder."""
    found = {}
    for path in folder.glob("*.csv"):
        named = re.search(r"rpm([\d.]+)Nm", path.name)
        if named is not None:
            found[float(named[1])] = read(path, chosen, position)
    if len(found) < 3:
        sys.exit(f"{folder}: must have files of three torques or more, named as 1100.0rpm300.0Nm25.0deg.csv.")
    return dict(sorted(found.items()))


def as_curve(found: dict[float, tuple[Floats, Floats]]) -> list[tuple[float, float]]:
    """Return the points of a torque cycle [N m, deg]: forward errors at -T, backward ones at T, down and up again.

    Without load the reducer's own drag decides which flanks touch: these points are at `IDLE` of the largest torque.
    """
    least = IDLE * max(found)
    ends = [(max(torque, least), float(each)) for torque, (_, backward) in found.items() for each in backward]
    starts = [
        (-max(torque, least), float(each)) for torque, (forward, _) in found.items() for each in forward
    ]
    down = ends[::-1] + starts
    return down + down[::-1]


def main(words: list[str] | None = None) -> int:
    """Print the numbers of a folder; return the exit code."""
    parser = argparse.ArgumentParser(
        description="Lost motion of an RV reducer from measured transmission errors."
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--columns", help="output position, error forward, error backward; with commas")
    parser.add_argument("--position", type=float, default=0.0, help="of the output [deg]")
    given = parser.parse_args(words)
    chosen = None if given.columns is None else [each.strip() for each in given.columns.split(",")]
    found = widths(given.folder, chosen, given.position)
    width = {torque: float(np.median(back) - np.median(fore)) for torque, (fore, back) in found.items()}
    off = 0
    for torque, each in width.items():
        wrong = torque in BY_HAND and abs(each - BY_HAND[torque]) > READ
        off += wrong
        by_hand = f", {BY_HAND[torque]} by hand" if torque in BY_HAND else ""
        print(
            f"{torque:7.0f} N m: {each:.4f} deg = {ARCMIN * each:.2f} arcmin{by_hand}{'  OFF' if wrong else ''}"
        )
    for (low, first), (high, second) in zip(list(width.items()), list(width.items())[1:], strict=False):
        print(
            f"{low:7.0f} to {high:.0f} N m: {2.0 * (high - low) / (ARCMIN * (second - first)):.0f} N m/arcmin"
        )
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "curve.csv"
        lines = [
            "Torque [N m],Rotation [deg]",
            *(f"{torque!r},{angle!r}" for torque, angle in as_curve(found)),
        ]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        stages = [torque for torque in found if torque > 0.0][:2]
        result = gp.lost_motion(path, columns=["Torque", "Rotation"], stages=stages)
    print(result.message)
    for name, text in result.rows():
        print(f"{name:>22}  {text}")
    return int(off > 0)


if __name__ == "__main__":
    sys.exit(main())
