"""A served page as a process, and a visit to it in a browser, for the tests of the page."""

import asyncio
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
VIEW = {"viewport": {"width": 1400, "height": 1000}}
COMMAND = "from gearplay.cli.main import main; main()"


def find_browser() -> str | None:
    """Return the path of the system's Chromium, None where there is none."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


def launch(play: Any, path: str) -> Any:
    """Start the browser at a path by Playwright."""
    return play.chromium.launch(executable_path=path, args=["--no-sandbox"])


def together(work: Callable[[], Coroutine[Any, Any, Any]]) -> Any:
    """Run a coroutine on a thread of its own: the browser's driver keeps a loop on this one."""
    found: list[Any] = []
    fault: list[BaseException] = []

    def go() -> None:
        try:
            found.append(asyncio.run(work()))
        except BaseException as error:
            fault.append(error)

    thread = threading.Thread(target=go)
    thread.start()
    thread.join()
    if fault:
        raise fault[0]
    return found[0]


class Server:
    """`gearplay serve` as a process of its own."""

    def __init__(self, folder: Path, *more: str, port: int = 0) -> None:
        self.folder, self.more = folder, more
        self.start(port)

    def start(self, port: int = 0) -> None:
        self.log = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115 - it is kept
        words = ["serve", "--no-browser", "--port", str(port), "--folder", str(self.folder), *self.more]
        self.process = subprocess.Popen(
            [sys.executable, "-c", COMMAND, *words],
            stdout=subprocess.PIPE,
            stderr=self.log,
            text=True,
            start_new_session=True,
            env={name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"},
        )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        found = re.search(r"http://[^/]+:(\d+)/", line)
        assert found, (line, self.said())
        self.port = int(found[1])
        self.url = f"http://127.0.0.1:{self.port}"

    def said(self) -> str:
        """Return what it has logged."""
        self.log.seek(0)
        return self.log.read()

    def kill(self) -> None:
        """End it at once, and its workers with it."""
        self.process.kill()
        self.process.wait()
        self._close()

    def _close(self) -> None:
        self.log.close()
        if self.process.stdout is not None:
            self.process.stdout.close()

    def stop(self) -> None:
        """End it as Ctrl-C does; it may not have logged a traceback."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(10)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        if self.log.closed:
            return
        said = self.said()
        self._close()
        assert "Traceback" not in said, said


class Visit:
    """A page that is open, with all that it complained about and asked for.

    It is a tab of the context given, else of a context of its own: that of a first visit. With ``plots=False`` plotly.js does not
    come until `release`: plots remain sketches, and no averages are requested.
    """

    def __init__(
        self, browser: Any, url: str, context: Any = None, *, plots: bool = True, **more: Any
    ) -> None:
        self.context = context or browser.new_context(**{**VIEW, **more})
        self.page = self.context.new_page()
        self._closed = self.page if context else self.context
        self.complaints: list[str] = []
        self.asked: list[str] = []
        self.page.on(
            "console", lambda m: self.complaints.append(m.text) if m.type in ("error", "warning") else None
        )
        self.page.on("pageerror", lambda e: self.complaints.append(str(e)))
        self.page.on("request", lambda r: self.asked.append(r.url))
        self.page.on("dialog", lambda d: (self.complaints.append(f"dialog: {d.message}"), d.dismiss()))
        self._drawn = "window.gearplay.state.whole"
        self._held: list[Any] = []
        if not plots:
            self._drawn = "document.querySelectorAll('.sketch').length === 4"
            self.page.route("**/plotly.js", lambda route: self._held.append(route))
        self.page.goto(url)

    def until(self, expression: str, seconds: float = 60.0) -> Any:
        """Wait until an expression in the page is true; return it."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            found = self.page.evaluate(expression)
            if found:
                return found
            time.sleep(0.02)
        raise AssertionError(
            f"not within {seconds} s: {expression}; message {self.page.text_content('#message')!r}"
        )

    def ready(self, seconds: float = 60.0) -> "Visit":
        """Wait for the plots of the first run."""
        self.until(f"Boolean(window.gearplay && window.gearplay.first && {self._drawn})", seconds)
        return self

    def release(self) -> None:
        """Let plotly.js come, once the page has asked for it."""
        while not self._held:
            self.page.wait_for_timeout(20)
        self._held[0].continue_()
        self._drawn = "window.gearplay.state.whole"

    def runs(self) -> int:
        """Return how many runs the page has shown."""
        return int(self.page.evaluate("window.gearplay.latencies.length"))

    def after(self, act: Callable[[], Any]) -> None:
        """Do something and wait for the run that it starts."""
        before = self.runs()
        act()
        drawn = (
            self._drawn if self._drawn.endswith("whole") else "true"
        )  # sketches are drawn before a run counts as shown
        self.until(
            f"window.gearplay.latencies.length > {before} && !window.gearplay.state.running && {drawn}"
        )

    def close(self) -> None:
        self._closed.close()
