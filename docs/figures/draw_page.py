"""Draw docs/figures/page.png: the page as the system's Chromium shows it, `pinion-idler-ring` looked at in its idler."""

import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
from serving import Server, Visit, find_browser, launch

HERE = Path(__file__).parent


def main() -> None:
    path = find_browser()
    if path is None:
        raise SystemExit("no Chromium on this machine: install the package chromium")
    with sync_playwright() as play, tempfile.TemporaryDirectory() as folder:
        server = Server(Path(folder))
        browser = launch(play, path)
        try:
            visit = Visit(browser, server.url, viewport={"width": 1280, "height": 960}).ready(300.0)
            visit.after(lambda: visit.page.select_option("#case", "pinion-idler-ring"))
            visit.page.click("#play")
            visit.page.select_option("#sleeve-of", "idler")
            visit.page.select_option("#mesh-of", "idler-ring")
            visit.page.locator("#scrub").evaluate(
                "(each) => { each.value = 0.217; each.dispatchEvent(new Event('input')); }"
            )
            visit.page.evaluate("document.activeElement.blur()")
            visit.page.wait_for_timeout(500)
            visit.page.screenshot(path=HERE / "page.png")
        finally:
            browser.close()
            server.stop()


if __name__ == "__main__":
    main()
