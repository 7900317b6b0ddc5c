"""Write docs/variables.md: every variable of a result with symbol, units and meaning, from the laws of the parts."""

from collections.abc import Iterable
from pathlib import Path

from gearplay.model.variables import VARIABLES
from gearplay.vocabulary.quantities import CONTACT_STATISTICS, OUTPUT_STATISTICS, Quantity

OUT = Path(__file__).with_name("variables.md")
HEAD = """\
# Result variables: every name

Signals of a run, by the dimension that they have in a result: `gp.simulate("han2021").ds["sleeve_penetration"]` has a
value for every time and every sleeve, in SI. In commands and plans a signal is written as `ELEMENT.NAME`,
`ring.sleeve_penetration`; plots and tables use the display unit. Signs: [conventions](conventions.md).

This page is made from the laws of the parts by `make docs`.
"""


def table_of(quantities: Iterable[Quantity]) -> str:
    """Return the table of some variables."""
    lines = ["| variable | symbol | meaning | unit | display unit |", "|---|---|---|---|---|"]
    for each in quantities:
        units = ("" if unit == "1" else unit for unit in (each.unit, each.display_unit))
        lines.append(f"| `{each.name}` | `{each.symbol}` | {each.long_name} | {' | '.join(units)} |")
    return "\n".join(lines)


def page() -> str:
    """Return the complete page."""
    parts = [HEAD, "## Signals"]
    parts += [f"\n### `{kind}`\n\n{table_of(found)}" for kind, found in VARIABLES.items() if found]
    parts += ["\n## Statistics of contacts\n", table_of(CONTACT_STATISTICS.values())]
    parts += ["\n## Statistics of the output shaft\n", table_of(OUTPUT_STATISTICS.values())]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    OUT.write_text(page(), encoding="utf-8")
