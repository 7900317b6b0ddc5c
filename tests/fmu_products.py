"""What tests of FMUs compare with: the stepper's numbers, the program of the docs, names of the two-stage reducer."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import gearplay as gp

DOCUMENTED = Path(__file__).parents[1] / "docs" / "fmu-host.c"
INPUTS, OUTPUTS = ["output.load.torque"], ["output.theta", "output.omega", "output.x", "output.y"]


def token(folder: Path) -> str:
    root = Xml.parse(folder / "modelDescription.xml").getroot()
    return root.get("guid") or root.get("instantiationToken") or ""


def stepped(
    case: Any, inputs: Sequence[str], outputs: Sequence[str], values: Any, count: int, dt: float
) -> Any:
    stepper = gp.Stepper(case, inputs=inputs, outputs=outputs)
    for _ in range(count):
        found = stepper.step(dt, values)
    return found
