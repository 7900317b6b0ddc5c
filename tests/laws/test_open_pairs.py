"""Open contacts of pairs of teeth: left out of the forces of stages, in the contact table after each step."""

import numpy as np
import pytest

from building import Document, case_of, run_of
from gearplay.integrate import dispatch, stepper
from gearplay.integrate import run as kernel
from gearplay.integrate.right_hand_side import make_loads
from gearplay.kernels.layout import OPEN, PENETRATION, RATE
from gearplay.model.pack import pack
from gearplay.parts.registry import MESH
from helical_pairs import helical


@pytest.mark.parametrize("contact", ["pairs", "mesh"])
def test_contact_table__has_open_contacts_after_each_step(contact: str) -> None:
    """A loaded pair on springs: penetrations and rates that touches are located by, against those of the state itself."""
    relief: Document = {"tip_relief": {"amount": 1e-5, "length": 3e-3}}
    document = helical(0.2, 0.02, one=relief, two=relief)
    document["supports"] = {name: {"stiffness": [1e8, 8e7]} for name in ("one", "two")}
    document["rotors"]["one"] |= {"drive": {"kind": "speed", "speed": 60.0}}
    document["rotors"]["two"] |= {"load": {"torque": 100.0}}
    if contact == "mesh":
        document["meshes"][0] |= {"contact": contact, "stiffness": {"kind": "harmonic", "mean": 2e8}}
    case = case_of(document)
    packed = pack(case)
    run, system = run_of(case, packed), packed.system
    run.clock[kernel.T_END] = 1.0
    element, loads = int(np.flatnonzero(system.elements["kind"] == MESH)[0]), make_loads(system)
    assert system.elements[element]["deferred"] == 1
    opened = 0
    for _ in range(60):
        assert stepper.advance(system, run, 1) == kernel.PAUSED
        t = float(run.clock[kernel.T])
        assert dispatch.contact_kinematics(system, element, t, run.y, run.branch, loads) == 0
        for column in (PENETRATION, RATE):
            found, expected = run.loads_0.contacts[:, column], loads.contacts[:, column]
            assert found == pytest.approx(expected, rel=1e-12, abs=1e-17)
        modes = run.branch.modes[: len(loads.contacts)]
        opened += int(np.any(modes == OPEN) and np.any(modes != OPEN))
    assert opened > 20
