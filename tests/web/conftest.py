"""A server and a browser for the tests of the page. In CI the browser must be there; elsewhere its absence skips these tests."""

import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from serving import VIEW, Server, Visit, find_browser, launch


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    made = Server(tmp_path_factory.mktemp("served"))
    yield made
    made.stop()


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """Drive the system's Chromium by Playwright."""
    path = find_browser()
    if path is None:
        if os.environ.get("CI"):
            pytest.fail("page tests need the system's Chromium: .ci/run installs it")
        pytest.skip("no Chromium on this machine: page tests are not run (install the package chromium)")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = launch(play, path)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def returning(chromium: Any) -> Any:
    """Return a context of the browser that has its files already, and draws no motion of its own accord."""
    return chromium.new_context(**VIEW, reduced_motion="reduce")


@pytest.fixture
def visit(chromium: Any, returning: Any, server: Server) -> Iterator[Callable[..., Visit]]:
    """Open the served page; at the end nothing may have been complained about, and nothing have left the machine.

    What is asked of the browser, such as its size, makes a first visit in a context of its own.
    """
    made: list[Visit] = []

    def open_(path: str = "/", *, plots: bool = True, **more: Any) -> Visit:
        made.append(Visit(chromium, server.url + path, None if more else returning, plots=plots, **more))
        return made[-1]

    yield open_
    for each in made:
        each.close()
        assert each.complaints == []
        foreign = [url for url in each.asked if not url.startswith((server.url, "data:", "blob:"))]
        assert foreign == []
