"""The formulas of the theory page: numbered in order, each reference to one that is there, all of them typeset."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from programs import load_script

ROOT = Path(__file__).resolve().parents[2]
THEORY = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
TAG = re.compile(r"\\tag\{T(\d+)\}")
REFERENCE = re.compile(r"\bT(\d{1,2})\b")
CITED = re.compile(r"theory(?:\.md)?\W{1,3}T(\d{1,2})\b")
SOURCES = [
    *(path for room in ("src", "tests", "bench", "docs") for path in (ROOT / room).rglob("*.py")),
    *(ROOT / "docs").rglob("*.md"),
    ROOT / "CONTRIBUTING.md",
]


def typeset() -> Any:
    """Return the hook that the site is built with."""
    return load_script(ROOT / "docs" / "typeset.py")


def test_the_formulas_are_numbered_in_the_order_of_the_page() -> None:
    numbers = [int(number) for number in TAG.findall(THEORY)]
    assert len(numbers) > 20
    assert numbers == list(range(1, len(numbers) + 1))


def test_every_reference_is_to_a_formula_that_is_there() -> None:
    known = {int(number) for number in TAG.findall(THEORY)}
    prose = TAG.sub("", THEORY)
    assert {int(number) for number in REFERENCE.findall(prose)} <= known
    cited = {
        (path.name, int(number))
        for path in SOURCES
        for number in CITED.findall(path.read_text(encoding="utf-8"))
    }
    assert len(cited) >= 3
    assert {number for _, number in cited} <= known


CARRY, SLOPES, BACKLASH, RESTITUTION = "carried over by", "F_\\psi", "b_t = -(p_d + p_b)", "1 - a\\,e_{out}"


@pytest.mark.parametrize(
    ("file", "what"),
    [
        ("src/gearplay/integrate/saltation.py", "f_- - f_+"),
        ("src/gearplay/parts/mesh/law/slopes.py", SLOPES),
        ("tests/building.py", BACKLASH),
        ("CONTRIBUTING.md", RESTITUTION),
    ],
)
def test_code_cites_the_formula_that_it_means(file: str, what: str) -> None:
    number = CITED.search((ROOT / file).read_text(encoding="utf-8"))
    assert number is not None
    blocks = re.findall(r"```math\n(.*?)```", THEORY, re.DOTALL)
    meant = next(block for block in blocks if f"\\tag{{T{number[1]}}}" in block)
    assert what in meant


def test_formulas_become_mathml_with_anchors_and_links() -> None:
    hook, page = typeset(), SimpleNamespace()
    text = 'In T1 is $a_b$ and `$no$` and 5 $.\n\n```math\nx^2 = y \\tag{T1}\n```\n\n```sh\necho "$HOME $USER"\n```\n'
    held = hook.on_page_markdown(text, page)
    made = hook.on_page_content(held, page)
    assert '<div class="formula" tabindex="0" id="T1"><math' in made
    assert "[T1](#T1)" in made
    assert "<msub><mi>a</mi><mi>b</mi></msub>" in made
    assert "`$no$` and 5 $." in made
    assert 'echo "$HOME $USER"' in made
    assert "\\tag" not in made


def test_no_formula_is_left_as_text() -> None:
    hook, page = typeset(), SimpleNamespace()
    made = hook.on_page_content(hook.on_page_markdown(THEORY, page), page)
    assert made.count("<math") == len(page.formulas) > 150
    assert "$" not in re.sub(r"`[^`]*`", "", made)
    # A command that the converter does not know would be shown as its name.
    assert not [formula for formula in page.formulas if "\\" in re.sub(r"&#x0005C;", "\\\\", formula)]
