"""Draw the pictures of docs/pictures.md and the README: python docs/figures/draw_pictures.py."""

import tempfile
from pathlib import Path

from gearplay.cli.main import run

HERE = Path(__file__).parent


def main() -> None:
    """Simulate once and draw."""
    with tempfile.TemporaryDirectory() as folder:
        result = f"{folder}/run.nc"
        run(["run", "han2021-calibrated", "--out", result, "--set", "run.start=drawn", "--duration", "1s"])
        for kind in ("mechanism", "overview"):
            out = str(HERE / f"{kind}.png")
            run(["plot", result, "--kind", kind, "--out", out, "--overwrite"])


if __name__ == "__main__":
    main()
