"""Directional derivatives of an FMU: closed forms, differences of its own steps of length 0, no trace in the motion."""

import sys
import zipfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

import gearplay as gp
from gearplay.kernels.compiled import INTERPRETED

pytestmark = pytest.mark.skipif(INTERPRETED or sys.platform != "linux", reason="nothing is compiled here")
fmpy = pytest.importorskip("fmpy")

INPUTS = ["motor.drive.speed", "load.drive.torque", "axis.drive.angle"]
OUTPUTS = [
    "motor.drive_torque",
    "load.drive_torque",
    "axis.position_torque",
    "axis.position_error",
    "load.omega",
]
KP, GAIN = 0.7, 12.0
EXACT = np.array([[KP, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, GAIN], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
"""Derivative of the outputs by the inputs: gains of the loops, a torque that is itself."""


def plant() -> gp.Case:
    """Return a servo motor and a load behind play, and an axis of its own."""
    servo = {
        "kind": "servo",
        "speed": 3.0,
        "proportional_gain": KP,
        "integral_gain": 2.0,
        "torque_limit": 50.0,
    }
    loop = {
        "kind": "position",
        "angle": 0.1,
        "proportional_gain": GAIN,
        "derivative_gain": 0.2,
        "torque_limit": 1e3,
    }
    return gp.load_case(
        {
            "rotors": {
                "motor": {"mass": 1.0, "inertia": 1e-3, "drive": servo},
                "load": {"mass": 1.0, "inertia": 4e-3, "drive": {"kind": "torque", "torque": -0.2}, "load": {"drag": 0.05}},
                "axis": {"mass": 1.0, "inertia": 2e-3, "drive": loop},
            },
            "couplings": [{"between": ["motor", "load"], "torsional_stiffness": 500.0, "torsional_damping": 0.05, "play": 2e-3}],
            "run": {"duration": 0.1, "tolerance": 1e-10},
        }
    )  # fmt: skip


class Instance:
    """An instance of an FMU, of either version, with the same names."""

    def __init__(self, file: Path, fmi: int) -> None:
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Slave

        about = fmpy.read_model_description(str(file))
        root = Xml.fromstring(zipfile.ZipFile(file).read("modelDescription.xml"))
        attribute = "providesDirectionalDerivative" + ("s" if fmi == 3 else "")
        assert root.find("CoSimulation").get(attribute) == "true"  # type: ignore[union-attr]
        self.fmi, self.places = fmi, {each.name: each.valueReference for each in about.modelVariables}
        kind: Any = FMU2Slave if fmi == 2 else FMU3Slave
        self.it = kind(
            guid=about.guid, unzipDirectory=fmpy.extract(str(file)), modelIdentifier=about.coSimulation.modelIdentifier,
            instanceName="it",
        )  # fmt: skip
        self.it.instantiate()
        if fmi == 2:
            self.it.setupExperiment(startTime=0.0)
        self.it.enterInitializationMode()
        self.it.exitInitializationMode()
        self.time = 0.0

    def of(self, names: list[str]) -> list[int]:
        return [self.places[name] for name in names]

    def set(self, name: str, value: float) -> None:
        (self.it.setReal if self.fmi == 2 else self.it.setFloat64)(self.of([name]), [value])

    def get(self) -> Any:
        return np.array((self.it.getReal if self.fmi == 2 else self.it.getFloat64)(self.of(OUTPUTS)))

    def step(self, dt: float) -> None:
        self.it.doStep(currentCommunicationPoint=self.time, communicationStepSize=dt)
        self.time += dt

    def derivative(self, seed: list[float]) -> Any:
        return np.array(self.it.getDirectionalDerivative(self.of(OUTPUTS), self.of(INPUTS), seed))


@pytest.fixture(scope="module", params=[2, 3])
def instance(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    file = tmp_path_factory.mktemp("derivatives") / "plant.fmu"
    gp.export_fmu(plant(), file, inputs=INPUTS, outputs=OUTPUTS, fmi=request.param)
    return lambda: Instance(file, request.param)


def test_derivative__is_that_of_the_control_laws(instance: Any) -> None:
    it = instance()
    for _ in range(5):
        it.step(1e-3)
        for k, column in enumerate(EXACT.T):
            seed = [0.0, 0.0, 0.0]
            seed[k] = 1.0
            assert it.derivative(seed) == pytest.approx(column, rel=1e-9, abs=1e-9)
    assert it.derivative([2.0, -1.0, 0.5]) == pytest.approx(EXACT @ [2.0, -1.0, 0.5], rel=1e-9, abs=1e-9)


def test_derivative__is_a_difference_of_steps_of_no_length(instance: Any) -> None:
    columns = []
    for k, name in enumerate(INPUTS):
        ends = []
        for sign in (1.0, -1.0):
            it = instance()
            it.step(2e-3)
            it.set(name, [3.0, -0.2, 0.1][k] + sign * 1e-3)
            it.step(0.0)
            ends.append(it.get())
        columns.append((ends[0] - ends[1]) / 2e-3)
    it = instance()
    it.step(2e-3)
    found = np.array([it.derivative(row.tolist()) for row in np.eye(3)])
    assert found == pytest.approx(np.array(columns), rel=1e-9, abs=1e-9)
    assert np.abs(found).max() > 1.0


def test_derivative__leaves_no_trace(instance: Any) -> None:
    """The load, free within the play, keeps its closed form, which another torque would end."""
    one, other = instance(), instance()
    for _ in range(40):
        one.derivative([1.0, 1.0, 1.0])
        for it in (one, other):
            it.step(1e-3)
        assert one.get().tolist() == other.get().tolist()
    for it in (one, other):
        it.it.terminate()
        it.it.freeInstance()


def test_derivative__beyond_a_limit_is_none(instance: Any) -> None:
    """A servo at its largest torque does not follow its set-point."""
    it = instance()
    it.step(1e-3)
    it.set("motor.drive.speed", 1e3)
    assert it.derivative([1.0, 0.0, 0.0])[0] == 0.0


def test_derivative__refused(instance: Any) -> None:
    it = instance()
    it.step(1e-3)
    for unknowns, knowns in (
        ([it.places[INPUTS[0]]], it.of(INPUTS[:1])),
        (it.of(OUTPUTS[:1]), [it.places[OUTPUTS[1]]]),
    ):
        with pytest.raises(Exception, match=r"[dD]irectionalDerivative"):
            it.it.getDirectionalDerivative(unknowns, knowns, [1.0])
