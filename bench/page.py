"""The page in the system's Chromium: ``python -m bench.page``; ``--moves N`` for another number of slider moves than 100.

Three figures: from the address to the first plot, from a slider's move to the new curves of both models (0.5 s after 0.1 s), and
frames per second of the moving mechanism. The browser renders in software where there is no graphics card.
"""

import shutil
import sys
import tempfile
from pathlib import Path
from statistics import median

from tests.serving import Server, Visit

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FIRST = "window.gearplay.first"
MOVE = """([path, place]) => {
  const slider = document.querySelector(`[data-slider="${path}"]`);
  slider.value = place;
  slider.dispatchEvent(new Event("input"));
}"""
FRAMES = """() => new Promise((done) => {
  let frames = 0;
  const began = performance.now();
  const tick = (now) => { frames += 1; if (now - began < 3000) requestAnimationFrame(tick); else done(frames / (now - began) * 1000); };
  requestAnimationFrame(tick);
})"""
PATHS = ("meshes.0.backlash", "sleeves.ring.radial_clearance", "rotors.pinion.drive.speed")


def part(moves: int = 100) -> list[str]:
    """Return the lines of the report; one that says why not where Chromium or Playwright lack."""
    path = next((found for name in NAMES if (found := shutil.which(name))), None)
    if path is None:
        return ["Not measured: no Chromium on this machine."]
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play, tempfile.TemporaryDirectory() as folder:
        server = Server(Path(folder))
        browser = play.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            Visit(browser, server.url).ready(300.0).close()  # compiles or loads the kernels
            loads = []
            for _ in range(5):
                visit = Visit(browser, server.url).ready()
                loads.append(float(visit.page.evaluate(FIRST)))
                visit.close()
            visit = Visit(browser, server.url).ready()
            visit.page.wait_for_timeout(500)
            before = visit.runs()
            for move in range(moves):
                place = 150 + (7 * move) % 700
                visit.after(lambda: visit.page.evaluate(MOVE, [PATHS[move % len(PATHS)], place]))  # noqa: B023
            found = sorted(visit.page.evaluate("window.gearplay.latencies")[before:])
            frames = float(visit.page.evaluate(FRAMES))
        finally:
            browser.close()
            server.stop()
    late = found[min(len(found) - 1, int(0.95 * len(found)))]
    return [
        "| page | |",
        "|---|---:|",
        f"| address to first plot, warm: median and longest of {len(loads)} | {median(loads):.0f} and {max(loads):.0f} ms |",
        f"| slider to the new curves of both models, {len(found)} moves: median and p95 | {median(found):.0f} and {late:.0f} ms |",
        f"| frames per second of the mechanism, both models | {frames:.0f} |",
    ]


if __name__ == "__main__":
    asked = sys.argv[sys.argv.index("--moves") + 1] if "--moves" in sys.argv else "100"
    print("\n".join(part(int(asked))))
