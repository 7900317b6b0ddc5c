"""How large a script of the gallery computes, and where it writes: in full beside its page, or small into another folder."""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

Value = TypeVar("Value")


class Sizes:
    """Set by the command line: `--short` for a look at whether all of it works, `--out` for the folder of the pictures."""

    short = False
    out = Path(__file__).parent

    def __call__(self, full: Value, short: Value) -> Value:
        """Return one of two sizes."""
        return short if self.short else full


sized = Sizes()


def draw(words: Sequence[str] | None, *parts: Callable[[], None]) -> None:
    """Read the command line and run the parts of a gallery; `--only NAME` runs one of them."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--short", action="store_true", help="few values, short runs")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder of the pictures")
    parser.add_argument("--only", choices=[part.__name__ for part in parts], help="one part")
    given = parser.parse_args(words)
    sized.short, sized.out = given.short, given.out
    for part in parts:
        if given.only in (None, part.__name__):
            part()
