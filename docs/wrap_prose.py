"""Wrap the prose of a Markdown page; tables, code, formulas, headings and HTML stay as they are."""

import re
import textwrap
from typing import Final

WIDTH: Final = 110
MOST: Final = 120
FENCE: Final = re.compile(r"^\s*(```|~~~|\$\$)")
ITEM: Final = re.compile(r"^(\s*)([-*+]|\d+[.)])(\s+)")
KEPT: Final = re.compile(r"^\s*(#|\||<|>|!\[|\[[^]]+\]:|---|===|:::)|^(    |\t)")
OPENING: Final = re.compile(r"^\s*([-*+]\s|\d+[.)]\s|#|>|\||=+$|-+$|<|:\s)")
"""What would begin something else than prose at the start of a line."""
CODE: Final = re.compile(r"`[^`]{1,60}`")
HELD: Final = "\x00"
"""Stands for a blank within code, which stays on one line."""


def wrap_prose(page: str) -> str:
    r"""Return a page whose paragraphs and list items with lines of more than 120 columns are filled anew, to 110.

    >>> print(wrap_prose("# Title\n\n* " + "word " * 30))  # doctest: +ELLIPSIS
    # Title
    <BLANKLINE>
    * word ... word
      word word...
    """
    found: list[str] = []
    block: list[str] = []
    fence = ""
    for line in [*page.split("\n"), ""]:
        opened = FENCE.match(line)
        if fence or opened or not line.strip() or (KEPT.match(line) and not block):
            found += _filled(block)
            block = []
            found.append(line)
            if opened:
                fence = "" if opened[1] == fence else fence or opened[1]
        elif block and (ITEM.match(line) or KEPT.match(line.strip())):
            found += _filled(block)
            block = [] if KEPT.match(line) else [line]
            found += [line] if KEPT.match(line) else []
        else:
            block.append(line)
    return "\n".join(found[:-1])


def _filled(block: list[str]) -> list[str]:
    """Return the lines of a paragraph or item, filled anew where one is too long."""
    if not any(len(line) > MOST for line in block) or any(line.endswith(("  ", "\\")) for line in block):
        return block
    item = ITEM.match(block[0])
    first = item[0] if item else re.match(r"\s*", block[0])[0]  # type: ignore[index]
    words = " ".join([block[0][len(first) :], *(line.strip() for line in block[1:])])
    words = CODE.sub(lambda code: code[0].replace(" ", HELD), words)
    for width in range(WIDTH, 90, -1):
        made = textwrap.wrap(
            words,
            width,
            initial_indent=first,
            subsequent_indent=" " * len(first),
            break_long_words=False,
            break_on_hyphens=False,
        )
        if not any(OPENING.match(line) for line in made[1:]):
            return [line.replace(HELD, " ") for line in made]
    return block
