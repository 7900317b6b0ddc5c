r"""Typeset the formulas of a page as it is built: `$...$` within the text, and blocks that begin with ```math.

MathML, which browsers draw themselves: no script, no font, nothing is fetched when a page is read. A block that ends with
`\tag{T4}` gets this number and an anchor of the same name; on its own page every later or earlier T4 becomes a link to it.
"""

import html
import re
from typing import Any

from latex2mathml.converter import convert

FENCE = re.compile(r"^(?P<fence>```+)(?P<kind>[a-z]*)\n(?P<text>.*?)^(?P=fence)$", re.DOTALL | re.MULTILINE)
CODE = re.compile(r"(`+)(?!`).*?(?<!`)\1(?!`)", re.DOTALL)
INLINE = re.compile(r"(?<![\\$\w])\$(?! )([^$]+?)(?<! )\$(?![\w$])")
TAG = re.compile(r"\s*\\tag\{(?P<number>[A-Z]\d+)\}\s*$")
NUMBER = re.compile(r"\b[A-Z]\d+\b")
FUNCTION = re.compile(
    r"(?<!<msup>)(?<!<msub>)<mi>(sin|cos|tan|cot|ln|inv)</mi>(?!<mspace|<mo[^>]*>(&#x00028;|\())"
)
HELD = "formula{}held"
"""Stands for a formula while the page is made from Markdown, which would take its underscores for emphasis."""


def mathml(formula: str, display: str = "inline") -> str:
    """Return a formula of TeX as MathML, with a thin space between a function and what it is of."""
    made = convert(
        html.unescape(formula).replace("{aligned}", "{align*}"), display=display
    )  # its name of the same
    return FUNCTION.sub(r'\g<0><mspace width="0.167em" />', made)


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Put a placeholder where each formula stands, and number the blocks."""
    formulas: list[str] = []

    def hold(made: str) -> str:
        formulas.append(made)
        return HELD.format(len(formulas) - 1)

    numbers = {
        m["number"] for b in FENCE.finditer(markdown) if b["kind"] == "math" and (m := TAG.search(b["text"]))
    }
    parts, at = [], 0
    for block in FENCE.finditer(markdown):
        parts.append(_prose(markdown[at : block.start()], numbers, hold))
        parts.append(_block(block["text"], hold) if block["kind"] == "math" else block[0])
        at = block.end()
    parts.append(_prose(markdown[at:], numbers, hold))
    page.formulas = formulas
    return "".join(parts)


def on_page_content(content: str, page: Any, **_: Any) -> str:
    """Put the formulas where their placeholders are."""
    for number, formula in enumerate(page.formulas):
        content = content.replace(HELD.format(number), formula)
    return content


def _block(text: str, hold: Any) -> str:
    tag = TAG.search(text)
    formula = hold(mathml(TAG.sub("", text), "block"))
    if tag is None:
        return f'<div class="formula" tabindex="0">{formula}</div>'
    return f'<div class="formula" tabindex="0" id="{tag["number"]}">{formula}<span class="number">{tag["number"]}</span></div>'


def _prose(text: str, numbers: set[str], hold: Any) -> str:
    """Return text with its formulas held and its references linked; code is left alone."""
    parts, at = [], 0
    for code in CODE.finditer(text):
        parts += [_plain(text[at : code.start()], numbers, hold), code[0]]
        at = code.end()
    return "".join([*parts, _plain(text[at:], numbers, hold)])


def _plain(text: str, numbers: set[str], hold: Any) -> str:
    def link(found: re.Match[str]) -> str:
        return f"[{found[0]}](#{found[0]})" if found[0] in numbers else found[0]

    parts, at = [], 0
    for formula in INLINE.finditer(text):
        parts += [NUMBER.sub(link, text[at : formula.start()]), hold(mathml(formula[1]))]
        at = formula.end()
    return "".join([*parts, NUMBER.sub(link, text[at:])])
