"""The page in the system's Chromium: ``python -m bench.page``; ``--moves N`` for another number of slider moves than 100.

Three figures: from the address to the first plot, from a slider's move to the new curves of both models (0.5 s after 0.1 s), and
frames per second of the moving mechanism. The browser renders in software where there is no graphics card.
"""

import sys
import tempfile
from pathlib import Path
from statistics import median

from tests.serving import Server, Visit, find_browser, launch

FIRST = "[window.gearplay.moving, window.gearplay.first]"
MOVE = """([path, place]) => {
  const slider = document.querySelector(`[data-slider="${path}"]`);
  slider.value = place;
  slider.dispatchEvent(new Event("input"));
}"""
FRAMES = """() => new Promise((done) => {
  let frames = 0;
  const began = performance.now();
  const tick = (now) => {
    frames += 1;
    if (now - began < 3000) requestAnimationFrame(tick);
    else done((1000 * frames) / (now - began));
  };
  requestAnimationFrame(tick);
})"""
PATHS = ("meshes.0.backlash", "sleeves.ring.radial_clearance", "rotors.pinion.drive.speed")


def part(moves: int = 100) -> list[str]:
    """Return the lines of the report; one that says why not where Chromium or Playwright lack."""
    path = find_browser()
    if path is None:
        return ["Not measured: no Chromium on this machine."]
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play, tempfile.TemporaryDirectory() as folder:
        server = Server(Path(folder))
        browser = launch(play, path)
        try:
            Visit(browser, server.url).ready(300.0).close()  # compiles or loads the kernels
            fresh, again = [], []
            for _ in range(5):
                visit = Visit(browser, server.url).ready()
                fresh.append(visit.page.evaluate(FIRST))
                visit.page.wait_for_timeout(500)
                visit.page.reload()
                again.append(visit.ready().page.evaluate(FIRST))
                visit.close()
            visit = Visit(browser, server.url).ready()
            visit.after(lambda: visit.page.check("#compare"))
            visit.page.wait_for_timeout(500)
            before, wholes = visit.runs(), int(visit.page.evaluate("window.gearplay.whole.length"))
            for move in range(moves):
                place = 150 + (7 * move) % 700
                visit.after(lambda: visit.page.evaluate(MOVE, [PATHS[move % len(PATHS)], place]))  # noqa: B023
            seen = visit.page.evaluate("window.gearplay.latencies")[before:]
            whole = visit.page.evaluate("window.gearplay.whole")[wholes:]
            frames = float(visit.page.evaluate(FRAMES))
        finally:
            browser.close()
            server.stop()
    lines = ["| page | median | p95 |", "|---|---:|---:|"]
    for words, times in (
        ("first visit of a browser: to the moving mechanism", [each[0] for each in fresh]),
        ("first visit of a browser: to the first plots", [each[1] for each in fresh]),
        ("later visit: to the moving mechanism", [each[0] for each in again]),
        ("later visit: to the first plots", [each[1] for each in again]),
        (f"slider to the new curves in view, both models, {moves} moves", seen),
        (f"slider to all new curves, both models, {moves} moves", whole),
    ):
        lines.append(f"| {words} | {median(times):.0f} ms | {_late(times):.0f} ms |")
    return [*lines, f"| frames per second of the mechanism, both models | {frames:.0f} | |"]


def _late(times: list[float]) -> float:
    """Return the time that 95 % do not pass."""
    return sorted(times)[max(0, -(-95 * len(times) // 100) - 1)]


if __name__ == "__main__":
    asked = sys.argv[sys.argv.index("--moves") + 1] if "--moves" in sys.argv else "100"
    print("\n".join(part(int(asked))))
