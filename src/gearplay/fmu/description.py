"""Model description of an FMU, FMI 2.0 and 3.0: variables with units and descriptions, capabilities."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final
from xml.etree import ElementTree as Xml

from gearplay.fmu.units import base_powers
from gearplay.vocabulary.version import VERSION

INPUT, OUTPUT, PARAMETER, TIME = "input", "output", "parameter", "independent"
_ATTRIBUTES: Final = {
    2: {
        "canHandleVariableCommunicationStepSize": "true",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "true",
    },
    3: {
        "canHandleVariableCommunicationStepSize": "true",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
    },
}


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU; ``display`` is a unit for people and its factor."""

    name: str
    reference: int
    role: str
    unit: str
    description: str
    start: float | None = None
    low: float | None = None
    high: float | None = None
    display: tuple[str, float] | None = None


@dataclass(frozen=True)
class Model:
    """Attributes of a model description: names, token, variables, default experiment [s, 1]."""

    name: str
    identifier: str
    token: str
    description: str
    variables: tuple[Variable, ...]
    duration: float
    tolerance: float


def describe(model: Model, version: int) -> bytes:
    """Return the XML of a model description, of FMI 2.0 or 3.0."""
    root = Xml.Element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{version}.0",
            "modelName": model.name,
            "guid" if version == 2 else "instantiationToken": model.token,
            "description": model.description,
            "generationTool": f"gearplay {VERSION}",
            "variableNamingConvention": "flat",
        },
    )
    Xml.SubElement(root, "CoSimulation", {"modelIdentifier": model.identifier, **_ATTRIBUTES[version]})
    _add_units(root, model.variables)
    Xml.SubElement(Xml.SubElement(root, "LogCategories"), "Category", {"name": "logStatusError"})
    experiment = {"startTime": "0.0", "stopTime": repr(model.duration), "tolerance": repr(model.tolerance)}
    Xml.SubElement(root, "DefaultExperiment", experiment)
    shown = [each for each in model.variables if version == 3 or each.role != TIME]
    listed = Xml.SubElement(root, "ModelVariables")
    for each in shown:
        (_add_2 if version == 2 else _add_3)(listed, each)
    structure = Xml.SubElement(root, "ModelStructure")
    outputs = [(n, each) for n, each in enumerate(shown, start=1) if each.role == OUTPUT]
    if version == 2:
        for name in ("Outputs", "InitialUnknowns"):
            place = Xml.SubElement(structure, name) if outputs else structure
            for n, _ in outputs:
                Xml.SubElement(place, "Unknown", {"index": str(n)})
    else:
        for name in ("Output", "InitialUnknown"):
            for _, each in outputs:
                Xml.SubElement(structure, name, {"valueReference": str(each.reference)})
    Xml.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{Xml.tostring(root, encoding="unicode")}\n'.encode()


def _units(variables: Sequence[Variable]) -> Iterator[tuple[str, dict[str, float]]]:
    """Yield units with the units for people of variables in them."""
    for unit in dict.fromkeys(each.unit for each in variables if each.unit != "1"):
        yield unit, dict(each.display for each in variables if each.unit == unit and each.display is not None)


def _add_units(root: Xml.Element, variables: Sequence[Variable]) -> None:
    found = list(_units(variables))
    place = Xml.SubElement(root, "UnitDefinitions") if found else root
    for unit, displayed in found:
        made, powers = Xml.SubElement(place, "Unit", {"name": unit}), base_powers(unit)
        if powers is not None:
            Xml.SubElement(made, "BaseUnit", {base: str(power) for base, power in powers.items()})
        for name, factor in displayed.items():
            Xml.SubElement(made, "DisplayUnit", {"name": name, "factor": repr(factor)})


def _typed(each: Variable) -> dict[str, str]:
    """Return the attributes of a real variable."""
    found = {} if each.unit == "1" else {"unit": each.unit}
    if each.display is not None:
        found["displayUnit"] = each.display[0]
    numbers = (("min", each.low), ("max", each.high), ("start", each.start))
    return found | {name: repr(value) for name, value in numbers if value is not None}


def _common(each: Variable) -> dict[str, str]:
    found = {
        "name": each.name,
        "valueReference": str(each.reference),
        "description": each.description,
        "causality": each.role,
        "variability": "fixed" if each.role == PARAMETER else "continuous",
    }
    initial = {OUTPUT: "calculated", PARAMETER: "exact"}.get(each.role)
    return found if initial is None else {**found, "initial": initial}


def _add_2(place: Xml.Element, each: Variable) -> None:
    Xml.SubElement(Xml.SubElement(place, "ScalarVariable", _common(each)), "Real", _typed(each))


def _add_3(place: Xml.Element, each: Variable) -> None:
    Xml.SubElement(place, "Float64", {**_common(each), **_typed(each)})
