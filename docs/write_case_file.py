"""Write docs/case-file.md: every field of a case file with meaning, unit, default and bounds, from the schema."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from wrap_prose import wrap_prose

from gearplay.model.schema import json_schema

OUT = Path(__file__).with_name("case-file.md")
SCHEMA = json_schema()
PLACES = {
    "rotors": "[rotors.NAME]",
    "sleeves": "[sleeves.ROTOR]",
    "meshes": "[[meshes]]",
    "couplings": "[[couplings]]",
    "supports": "[supports.ROTOR]",
    "bearings": "[bearings.ROTOR]",
    "base": "[base]",
    "environment": "[environment]",
    "planetary": "[planetary.NAME]",
    "torsional_pair": "[torsional_pair]",
    "run": "[run]",
}
"""Tables of a case file, as they are headed there."""
DRAWINGS = {
    "rotors": ("conventions.svg", "Axes, senses and lines of action of an internal and an external pair"),
    "sleeves": ("clearances.svg", "What radial clearance, backlash and runout measure"),
    "couplings": (
        "elements.svg",
        "Several gears on a rotor, coupling, support, unbalance, base, friction of the teeth",
    ),
}
"""Drawings by the table at whose head they stand."""
HEAD = """\
# Case file: every field

A case is a TOML file. Plain numbers are SI (m, kg, s, N, rad, rad/s); text carries a unit: `"100 um"`, `"120 rpm"`, `"20 deg"`.
Every fault of a file is reported together, with the field, the rule and the cure. `gearplay copy han2021` gives a first file,
`gearplay check FILE` says what does not fit, `gearplay schema` prints the same as below for editors. Drawings of every element
and its signs: [conventions](conventions.md#elements).

This page is made from the schema by `make docs`.
"""


def reference(node: Any) -> Iterator[str]:
    """Yield the names of the definitions that a part of the schema refers to, in order."""
    if isinstance(node, dict):
        if "$ref" in node:
            yield node["$ref"].rpartition("/")[2]
        for key, each in node.items():
            if key != "default":
                yield from reference(each)
    elif isinstance(node, list):
        for each in node:
            yield from reference(each)


def title_of(name: str) -> str:
    """Return a definition's name as its heading.

    >>> title_of("gearplay__model__sleeve__Material"), title_of("SpeedDrive")
    ('Material (sleeve)', 'Speed drive')
    """
    if "__" in name:
        *_, room, last = name.split("__")
        return f"{last} ({room})"
    return re.sub(r"(?<=[a-z])(?=[A-Z0-9])", " ", name).capitalize()


def slug(text: str) -> str:
    """Return the anchor that a heading gets."""
    return re.sub(r"[^a-z0-9 _-]", "", text.lower()).strip().replace(" ", "-")


def leaves(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the alternatives of a field but for null and text with a unit."""
    for key in ("anyOf", "oneOf"):
        if key in node:
            for each in node[key]:
                yield from leaves(each)
            return
    if node.get("type") != "null" and node.get("description") != "number and unit":
        yield node


def found(node: dict[str, Any], key: str) -> Any:
    """Return what a field or one of its alternatives says under a key."""
    if key in node:
        return node[key]
    for group in ("anyOf", "oneOf", "prefixItems"):
        for each in node.get(group, []):
            if (value := found(each, key)) is not None:
                return value
    return None


def first_sentence(text: str) -> str:
    r"""Return the first sentence of a description, without its stop, as a table takes it.

    >>> first_sentence("A journal in a bush. More.\n\nAnd more.")
    'a journal in a bush'
    """
    first = re.split(r"[.:;](?:\s|$)", text.replace("|", "\\|"))[0]
    return first[:1].lower() + first[1:]


def number(value: Any) -> str:
    """Return a number or list of the schema as TOML would have it."""
    if isinstance(value, float):
        return f"{value:.6g}"
    return json.dumps(value)


def bounds_of(node: dict[str, Any]) -> str:
    """Return the rule for a value in words."""
    words = []
    for leaf in leaves(node):
        if "enum" in leaf:
            words += [" \\| ".join(f"`{each}`" for each in leaf["enum"])]
        low = [f"> {number(leaf[k])}" for k in ("exclusiveMinimum",) if k in leaf]
        low += [f"≥ {number(leaf['minimum'])}" for _ in "1" if "minimum" in leaf]
        high = [f"< {number(leaf[k])}" for k in ("exclusiveMaximum",) if k in leaf]
        high += [f"≤ {number(leaf['maximum'])}" for _ in "1" if "maximum" in leaf]
        words += [", ".join(low + high)] if low or high else []
        if leaf.get("type") == "boolean":
            words.append("true or false")
        if leaf.get("type") == "array" and "maxItems" in leaf:
            few, most = leaf.get("minItems", 0), leaf["maxItems"]
            words.append(f"{most} values" if few == most else f"{few} to {most} entries")
    return "; ".join(dict.fromkeys(words))


def kind_of(node: dict[str, Any]) -> str:
    """Return links to the tables that a field holds."""
    names = dict.fromkeys(reference({k: v for k, v in node.items() if k != "default"}))
    return " or ".join(f"[{title_of(name)}](#{slug(title_of(name))})" for name in names)


def default_of(name: str, node: dict[str, Any], required: list[str]) -> str:
    """Return what holds where a field is not given."""
    if name in required:
        return "**required**"
    value = node.get("default")
    if value is None or isinstance(value, dict) or value == [] or value == "":
        return ""
    return f"`{number(value)}`"


def table_of(properties: dict[str, Any], required: list[str]) -> str:
    """Return the table of some fields."""
    lines = ["| field | meaning | unit | default | values |", "|---|---|---|---|---|"]
    for name, node in properties.items():
        unit = found(node, "x-unit") or ""
        words = (found(node, "description") or "").replace(f" [{unit}]", "").replace("|", "\\|")
        if found(node, "const") is not None:
            words, shown = "", f"`{found(node, 'const')}`"
        else:
            shown = bounds_of(node)
        if not words and len(names := list(dict.fromkeys(reference(node)))) == 1:
            words = first_sentence(SCHEMA["$defs"][names[0]].get("description", ""))
        meaning = ": ".join(part for part in (words, kind_of(node)) if part)
        cells = (
            f"`{name}`",
            meaning,
            unit.replace("1", "") if unit == "1" else unit,
            default_of(name, node, required),
            shown,
        )
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def described(name: str) -> str:
    """Return the part of the page on one definition: what it is, and its fields."""
    definition = SCHEMA["$defs"][name]
    text = re.sub(r"``([^`]+)``", r"`\1`", definition.get("description", ""))
    return f"{text}\n\n{table_of(definition['properties'], definition.get('required', []))}\n"


def page() -> str:
    """Return the whole page."""
    top = SCHEMA["properties"]
    parts = [
        HEAD,
        "## Top of the file\n",
        table_of({n: p for n, p in top.items() if n not in PLACES}, SCHEMA.get("required", [])),
    ]
    told: list[str] = []
    for name, heading in PLACES.items():
        (own,) = dict.fromkeys(reference(top[name]))
        told.append(own)
        file, words = DRAWINGS.get(name, ("", ""))
        drawing = f"![{words}](figures/{file})\n\n" if file else ""
        parts.append(f'\n## `{heading}`\n\n<a id="{slug(title_of(own))}"></a>\n\n{drawing}{described(own)}')
    parts.append("\n## Tables inside tables\n")
    waiting = [each for name, field in top.items() if name not in PLACES for each in reference(field)]
    waiting += [each for own in told for each in reference(SCHEMA["$defs"][own]["properties"])]
    while waiting:
        name = waiting.pop(0)
        if name not in told:
            told.append(name)
            parts.append(f"\n### {title_of(name)}\n\n{described(name)}")
            waiting += reference(SCHEMA["$defs"][name]["properties"])
    assert set(told) == set(SCHEMA["$defs"]), set(SCHEMA["$defs"]) - set(told)
    return "\n".join(parts)


if __name__ == "__main__":
    OUT.write_text(wrap_prose(page()), encoding="utf-8")
