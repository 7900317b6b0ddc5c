"""REXS in XML, read by expat: no document type, no entities, bounded depth and size."""

from typing import Any, Final
from xml.parsers import expat

from gearplay.rexs.records import Attribute, Component, Gearbox, LoadCase, Relation, refused
from gearplay.rexs.values import Budget, decoded, whole
from gearplay.vocabulary.errors import InputError, shorten

DEEPEST: Final = 16
"""Deepest nesting of elements."""


class _Reader:
    """Handlers of expat's events, which fill a `Gearbox`."""

    def __init__(self) -> None:
        self.budget = Budget()
        self.box: Gearbox | None = None
        self.open: list[str] = []
        self.text: list[str] = []
        self.component: Component | None = None
        self.case: LoadCase | None = None
        self.relation: Relation | None = None
        self.attribute: dict[str, str] = {}
        self.rows: list[Any] | None = None
        self.row: list[Any] = []
        self.code = ""
        self.in_accumulation = False

    def start(self, tag: str, has: dict[str, str]) -> None:
        """Open an element."""
        name = tag.rpartition(":")[2]
        self.budget.take()
        self.open.append(name)
        if len(self.open) > DEEPEST:
            raise refused("file", f"must nest elements at most {DEEPEST} deep", "Export it again")
        if self.box is None:
            if name != "model":
                rule = f"must be a REXS model, whose first element is <model>, not <{shorten(name, 20)}>"
                raise refused("file", rule, "Export the gearbox as REXS")
            self.box = Gearbox(
                has.get("version", ""), has.get("applicationId", ""), has.get("applicationVersion", "")
            )
        elif name == "relation":
            self.relation = Relation(has.get("type", ""), [], whole(has.get("order"), "relation, order", 0))
            self.box.relations.append(self.relation)
        elif name == "ref" and self.relation is not None:
            self.relation.refs.append((has.get("role", ""), whole(has.get("id"), "relation, ref")))
        elif name == "load_case":
            self.case = LoadCase(whole(has.get("id"), "load_case"), {})
            self.box.load_cases.append(self.case)
        elif name == "accumulation":
            self.in_accumulation = self.box.accumulated = True
        elif name == "component":
            self._start_component(has)
        elif name == "attribute":
            self.attribute, self.rows, self.code = has, None, ""
        elif name in ("array", "matrix"):
            self.rows, self.code = self.rows or [], has.get("code", "")
        elif name == "r":
            self.row = []
        self.text = []

    def _start_component(self, has: dict[str, str]) -> None:
        assert self.box is not None
        number = whole(has.get("id"), "component")
        self.component = Component(number, has.get("type", ""), has.get("name", ""), {})
        if self.in_accumulation:
            return
        if self.case is not None:
            self.case.attributes[number] = self.component.attributes
        else:
            self.box.add(self.component)

    def data(self, text: str) -> None:
        """Take text."""
        self.text.append(text)

    def end(self, tag: str) -> None:
        """Close an element."""
        name = self.open.pop()
        text = "".join(self.text).strip()
        if name == "c" and self.rows is not None:
            (self.row if "r" in self.open[-1:] else self.rows).append(text)
        elif name == "r" and self.rows is not None:
            self.rows.append(self.row)
        elif name in ("array", "matrix") and self.code:
            self.rows = decoded(text, self.code, self.attribute.get("id", ""), self.budget)
        elif name == "attribute" and self.component is not None:
            value = text if self.rows is None else self.rows
            key = self.attribute.get("id", "")
            self.component.attributes[key] = Attribute(key, self.attribute.get("unit", ""), value)
            self.rows = None
        elif name == "component":
            self.component = None
        elif name == "load_case":
            self.case = None
        elif name == "accumulation":
            self.in_accumulation = False
        self.text = []


def _no_declarations(*_: Any) -> None:
    rule = "must have no document type and no entities, which can expand to any size or read other files"
    raise refused("file", rule, "Remove the <!DOCTYPE ...> from it")


def read_xml(content: bytes) -> Gearbox:
    """Return the model of an XML document; `InputError` where it is damaged, or has a document type or entities."""
    reader = _Reader()
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = reader.start, reader.end
    parser.CharacterDataHandler = reader.data
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = _no_declarations
    try:
        parser.Parse(content, True)
    except InputError:
        raise
    except (expat.ExpatError, ValueError, LookupError) as error:  # LookupError: an unknown encoding
        reason = shorten(str(error), 80)
        raise refused("file", f"is not valid XML: {reason}", "Export it again") from None
    assert reader.box is not None  # a document has an element
    reader.box.check()
    return reader.box
