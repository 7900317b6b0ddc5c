"""The site: built strictly, every link leads somewhere, every public name and every field is there and is found by the search."""

import functools
import inspect
import json
import os
import re
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import gearplay as gp
from docs_commands import MADE
from gearplay.model.schema import json_schema
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.vocabulary.quantities import CONTACT_STATISTICS, OUTPUT_STATISTICS
from serving import find_browser, launch

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
MARKDOWN_LINK = re.compile(r"\]\(([^)\s]+)\)")
TABLES = {
    "rotors",
    "sleeves",
    "meshes",
    "couplings",
    "supports",
    "bearings",
    "base",
    "environment",
    "planetary",
    "torsional_pair",
    "run",
}
"""Fields of a case that are headings of the page, not rows."""
ELSEWHERE = ("http:", "https:", "mailto:")


class QuietHandler(SimpleHTTPRequestHandler):
    """Serves the site without a line for each file."""

    def log_message(self, format: str, *args: object) -> None:
        pass


class Page(HTMLParser):
    """Anchors of a page, and where its links, pictures, styles and scripts lead."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if value is None:
                continue
            if name in ("id", "name"):
                self.anchors.add(value)
            if name == "href" and tag == "a":
                self.links.append(value)
            elif name in ("src", "href"):
                self.fetched.append(value)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the site that `make docs` has just built, of `GEARPLAY_SITE`, or build it so.

    From a copy of the docs without the pages that it writes.
    """
    if built := os.environ.get("GEARPLAY_SITE"):
        return Path(built).resolve()
    root = tmp_path_factory.mktemp("docs")
    made = shutil.ignore_patterns(*MADE, "house.svg")
    shutil.copytree(ROOT / "docs", root / "docs", ignore=made)
    for name in ("mkdocs.yml", "pyproject.toml", "src"):
        (root / name).symlink_to(ROOT / name)
    words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet"]
    plain = os.environ | {"EXECUTE_NOTEBOOKS": "false"}  # `make docs` executes them
    done = subprocess.run(words, cwd=root, capture_output=True, text=True, check=False, env=plain)
    assert done.returncode == 0, done.stderr
    return root / "site"


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    return {path: Page(path) for path in site.rglob("*.html") if path.name != "404.html"}


def public_functions() -> list[str]:
    """Return the names of `gearplay` and `gearplay.signals`, as the reference heads them."""
    return [
        f"{room}.{name}"
        for room, of in (("gp", gp), ("gp.signals", gp.signals))
        for name in dir(of)
        if not name.startswith("_") and not inspect.ismodule(getattr(of, name))
    ]


def fields() -> list[tuple[str, str]]:
    """Return every field of the schema of a case: its table, its name."""
    schema = json_schema()
    top = [("", name) for name in schema["properties"] if name not in TABLES]
    return top + [(table, name) for table, node in schema["$defs"].items() for name in node["properties"]]


def test_every_link_of_the_site_leads_somewhere(site: Path, pages: dict[Path, Page]) -> None:
    count = 0
    for path, page in pages.items():
        for link in (*page.links, *page.fetched):
            parts = urlsplit(link)
            if link.startswith((*ELSEWHERE, "data:")) or not link.strip("#"):
                continue  # a notebook that was executed holds its pictures itself
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            assert target.exists(), (path.name, link)
            if parts.fragment and target in pages:
                assert unquote(parts.fragment) in pages[target].anchors, (path.name, link)
            count += 1
    assert count > 1000


def test_a_page_fetches_nothing_from_elsewhere(pages: dict[Path, Page]) -> None:
    assert not [link for page in pages.values() for link in page.fetched if link.startswith(ELSEWHERE)]


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"])
def test_links__of_files_outside_the_docs_exist(name: str, site: Path, pages: dict[Path, Page]) -> None:
    for link in MARKDOWN_LINK.findall((ROOT / name).read_text(encoding="utf-8")):
        if link.startswith(ELSEWHERE):
            continue
        place, _, anchor = link.partition("#")
        assert (ROOT / place).exists(), link
        if anchor:
            built = site / Path(place).relative_to("docs").with_suffix(".html")
            assert anchor in pages[built].anchors, link


def test_every_public_name_is_on_the_site_and_found_by_the_search(site: Path) -> None:
    index = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))
    titles = {entry["title"] for entry in index["docs"]}
    assert len(public_functions()) > 60
    assert not set(public_functions()) - titles
    words = {word for title in titles for word in re.split(index["config"]["separator"], title)}
    assert not {name.rpartition(".")[2] for name in public_functions()} - words


def test_every_field_of_a_case_is_on_the_site_and_found_by_the_search(site: Path) -> None:
    cells = re.findall(
        r"<tr>\s*<td><code>([^<]+)</code></td>", (site / "case-file.html").read_text(encoding="utf-8")
    )
    assert len(fields()) > 150
    assert len(cells) == len(fields())
    assert {name for _, name in fields()} == set(cells)
    headings = re.findall(r"<h2[^>]*><code>\[+(\w+)", (site / "case-file.html").read_text(encoding="utf-8"))
    assert set(headings) == TABLES
    index = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))
    text = " ".join(entry["text"] for entry in index["docs"] if entry["location"].startswith("case-file"))
    assert not {name for _, name in fields()} - set(re.findall(r"\w+", text))


def test_every_variable_of_a_result_is_on_the_site_with_its_units(site: Path) -> None:
    page = (site / "variables.html").read_text(encoding="utf-8")
    rows = dict(re.findall(r"<tr>\s*<td><code>(\w+)</code></td>(.*?)</tr>", page, re.DOTALL))
    assert not {*RESULT_VARIABLES, *CONTACT_STATISTICS, *OUTPUT_STATISTICS} - set(rows)
    assert "<td>deflection of the support</td>\n<td>m</td>\n<td>um</td>" in rows["support_deflection"]


def test_every_page_is_in_the_nav_and_in_the_search(site: Path) -> None:
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    docs = site.parent / "docs"
    every = {path.relative_to(docs).as_posix() for kind in ("*.md", "*.ipynb") for path in docs.rglob(kind)}
    assert every == set(re.findall(r": ([\w/-]+\.(?:md|ipynb))$", nav, re.MULTILINE))
    index = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))
    found = {entry["location"].partition("#")[0] for entry in index["docs"]}
    assert {re.sub(r"\.(md|ipynb)$", ".html", page) for page in every} <= found


def first_found(address: str, words: str) -> str:
    """Return the first name that the search of a served site finds."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        page = launch(play, find_browser() or "").new_page()
        page.goto(address)
        asked = page.locator("input[data-md-component=search-query]")
        asked.click()
        asked.press_sequentially(words)
        found = page.locator(".md-search-result__list h2")  # of a section; h1 is its page
        found.first.wait_for(timeout=30_000)
        return found.first.inner_text()


@pytest.mark.deep
@pytest.mark.skipif(find_browser() is None, reason="no Chromium")
def test_the_search_finds_a_name_when_the_site_is_served(site: Path) -> None:
    handler = functools.partial(QuietHandler, directory=str(site))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}/index.html"
        with ThreadPoolExecutor(1) as apart:  # page tests may hold a browser in this thread
            assert apart.submit(first_found, address, "load_sharing").result() == "gp.load_sharing"
        server.shutdown()


SYNONYMS = {
    "plain bearing": "sleeve",
    "journal bearing": "sleeve",
    "tooth wedging": "jam",
    "pseudo-interference": "jam",
    "run-out": "runout",
    "annulus": "ring",
    "spider": "carrier",
    "tooth play": "backlash",
    "tooth-passing frequency": "mesh frequency",
}


@pytest.mark.parametrize(("elsewhere", "here"), SYNONYMS.items())
def test_the_glossary_knows_the_words_of_the_field(elsewhere: str, here: str) -> None:
    rows = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines()
    assert any(elsewhere in row.partition(" | ")[0] and here in row.partition(" | ")[2] for row in rows)
