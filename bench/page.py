"""How quick the page is in Chromium: python -m bench.page. Load to first plot, slider to new curves, frames per second."""

import shutil
import sys
import tempfile
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from serving import Server, Visit

MOVES, LOADS = 100, 9
FRAMES = """new Promise((end) => {
  let n = 0; const began = performance.now();
  const tick = () => { n += 1; performance.now() - began < 3000 ? requestAnimationFrame(tick) : end(n / 3); };
  requestAnimationFrame(tick);
})"""


def main():
    """Measure and print."""
    from playwright.sync_api import sync_playwright

    server = Server(Path(tempfile.mkdtemp()))
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=path, args=["--no-sandbox"])
        visit = Visit(browser, server.url).ready()
        loads = []
        for _ in range(LOADS):
            visit.page.goto(server.url)
            visit.ready()
            loads.append(visit.page.evaluate("window.gearplay.first"))
        visit.page.evaluate("window.gearplay.latencies.length = 0")
        visit.page.locator('input[data-slider="sleeves.ring.radial_clearance"]').focus()
        for n in range(MOVES):
            visit.after(lambda n=n: visit.page.keyboard.press("ArrowRight" if n % 20 < 10 else "ArrowLeft"))
        moves = sorted(visit.page.evaluate("window.gearplay.latencies"))
        frames = visit.page.evaluate(FRAMES)
        browser.close()
    server.stop()
    late = moves[int(0.95 * len(moves))]
    print(f"load to first plot, warm: median {median(loads):.0f} ms, worst of {LOADS} {max(loads):.0f} ms")
    print(
        f"slider to new curves, 0.5 s of both models: median {median(moves):.0f} ms, p95 {late:.0f} ms of {MOVES}"
    )
    print(f"animation: {frames:.0f} frames per second")


if __name__ == "__main__":
    main()
