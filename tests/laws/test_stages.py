"""Shafts with several gears: orders, statics and vibrations of the PHM 2009 spur train; what a turned drawing leaves alone."""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.model.pack import pack
from gearplay.parts.mesh.train.geometry import centres
from gearplay.parts.mesh.train.rolling import mesh_frequency, nominal_speeds
from gearplay.solver.flow import Flow
from gearplay.solver.simulate import run_members
from gearplay.vocabulary.errors import InputError

REDUCER = "two-stage-reducer"
INPUT_HZ = 30.0
ALPHA = math.radians(20.0)
SMOOTH = {
    "meshes.0.stiffness.amplitude": 0.0,
    "meshes.1.stiffness.amplitude": 0.0,
    "rotors.input.runout.amplitude": 0.0,
    "rotors.layshaft.gears.wheel.runout.amplitude": 0.0,
    "rotors.layshaft.gears.pinion.runout.amplitude": 0.0,
    "rotors.output.runout.amplitude": 0.0,
    "rotors.output.load.drag": 0.0,
}
"""Constant stiffness, true toothings: what is left is statics on turning shafts."""
SETTLE = {f"rotors.{name}.radial_damping": 3e4 for name in ("input", "layshaft", "output")}
BASE = {name: 1e-3 * z * math.cos(ALPHA) for name, z in (("z32", 32), ("z96", 96), ("z48", 48), ("z80", 80))}


def reducer(changes: dict[str, Any]) -> gp.Case:
    return gp.replace(gp.load_case(REDUCER), changes)


def test_turns_and_orders_of_the_phm09_train(measured: Measured) -> None:
    """V7: mesh orders 32 and 16 of the input, a fifth of the input's turns at the output."""
    case = gp.load_case(REDUCER)
    speeds = nominal_speeds(case) / (2.0 * math.pi * INPUT_HZ)
    assert speeds == pytest.approx([1.0, -1.0 / 3.0, 0.2], rel=1e-12)
    assert [mesh_frequency(case, j) / INPUT_HZ for j in range(2)] == pytest.approx([32.0, 16.0], rel=1e-12)
    run = run_members(case, [0], duration=0.5001, sampling=1e4, transient=0.2)[0]
    # Half a second: 15 turns of the input, 5 of the layshaft, 3 of the output, after which all that ripples is back.
    turns = {name: float(np.diff(run.signal("theta", name)[[0, 5000]])[0]) for name in case.rotors}
    ratio = turns["output"] / turns["input"]
    assert ratio == pytest.approx(0.2, abs=1e-6)
    measured("output turns of the PHM09 train per input turn, against 0.2", abs(ratio - 0.2), "1e-6")


def test_force_at_the_mesh_orders() -> None:
    """The first mesh's force moves at order 32 of the input, the second's at 16."""
    changes = {path: value for path, value in SMOOTH.items() if "stiffness" not in path}
    case = reducer({**changes, **SETTLE})
    run = run_members(case, [0], duration=0.5, sampling=2e4, transient=0.3)[0]
    for label, order in (("input-layshaft.wheel", 32.0), ("layshaft.pinion-output", 16.0)):
        force = run.signal("drive_force", label)
        lines = np.abs(np.fft.rfft(force - force.mean()))
        assert np.argmax(lines) * 2.0 / INPUT_HZ == pytest.approx(order)


@pytest.mark.parametrize("angles", [(0.0, 0.0), (0.7, -1.9)])
def test_forces_and_reactions_are_statics(angles: tuple[float, float], measured: Measured) -> None:
    """Torques by the base radii; each bearing carries the sum of its shaft's mesh forces, at the deflected pressure angles."""
    case = reducer({**SMOOTH, **SETTLE, "meshes.0.angle": angles[0], "meshes.1.angle": angles[1]})
    case = gp.replace(case, {f"meshes.{j}.damping.ratio": 0.3 for j in range(2)})
    run = run_members(case, [0], duration=0.02, sampling=1e4, transient=0.6)[0]
    force = {
        label: run.signal("drive_force", label).mean()
        for label in ("input-layshaft.wheel", "layshaft.pinion-output")
    }
    second = 50.0 / BASE["z80"]
    first = second * BASE["z48"] / BASE["z96"]
    assert list(force.values()) == pytest.approx([first, second], rel=1e-6)
    # The flank force turns the driven gear on: along the line of action, the pressure angle off the tangent.
    vectors, places = [], centres(case)
    for j, (size, sense) in enumerate(((first, 1.0), (second, -1.0))):
        a, b = case.meshes[j].rotors
        at = [np.array(places[n]) + [run.signal(c, n).mean() for c in "xy"] for n in (a, b)]
        u = (at[1] - at[0]) / np.linalg.norm(at[1] - at[0])
        alpha = float(run.signal("working_pressure_angle", case.meshes[j].label).mean())
        tangent = np.array([-u[1], u[0]]) * sense
        vectors.append(size * (math.cos(alpha) * tangent + math.sin(alpha) * u))
    wanted = {"input": -vectors[0], "layshaft": vectors[0] - vectors[1], "output": vectors[1]}
    worst = 0.0
    for name, load in wanted.items():
        found = np.array([run.signal(f"sleeve_force_{c}", name).mean() for c in "xy"])
        worst = max(worst, float(np.max(np.abs(found + load)) / np.linalg.norm(load)))
    assert worst < 1e-6
    measured("bearing reactions of the PHM09 train against statics", worst, "1e-6")


def test_torsional_vibrations_are_those_of_the_closed_eigenproblem(measured: Measured) -> None:
    """Rigid bearings, constant stiffness, the input held by its drive: K v = w^2 M v of layshaft and output."""
    document = reducer({**SMOOTH, "meshes.0.damping.ratio": 0.0, "meshes.1.damping.ratio": 0.0}).resolved()
    case = gp.load_case({**document, "sleeves": {}})
    flow = Flow(gp.replace(case, {"run.tolerance": 1e-12}))
    k, (j_1, j_2) = 3e8, (case.rotors[name].inertia for name in ("layshaft", "output"))
    r_1, r_2, r_3 = BASE["z96"], BASE["z48"], BASE["z80"]
    stiffness = k * np.array([[r_1**2 + r_2**2, r_2 * r_3], [r_2 * r_3, r_3**2]])
    expected = np.sqrt(np.linalg.eigvalsh(stiffness / np.sqrt(np.outer([j_1, j_2], [j_1, j_2]))))
    start = flow.start()
    f_2 = 50.0 / r_3  # start at rest under the load: the flanks pressed in by F / k
    turn_1 = -(f_2 * r_2 / r_1) / k / r_1
    rest = {5: turn_1, 8: (f_2 / k + r_2 * abs(turn_1)) / r_3}
    for place, angle in rest.items():
        start[place] += (
            -abs(angle) if flow.packed.system.rotors["nominal_speed"][place // 3] > 0.0 else abs(angle)
        )
    free = [5, 8, 14, 17]
    span = 2e-4
    moved = flow.go(start, span, changes=np.eye(start.size)[free])
    assert moved.events == 0
    product = moved.changes[:, free].T
    rates = np.log(np.linalg.eigvals(product).astype(complex)) / span
    found = np.sort(np.abs(rates.imag))[::2]
    assert found == pytest.approx(expected, rel=1e-6)
    measured(
        "torsional frequencies of the PHM09 train against the eigenproblem",
        float(np.max(np.abs(found / expected - 1.0))),
        "1e-6",
    )


def test_a_table_of_one_gear_is_the_short_form() -> None:
    plain = gp.load_case("external-pair").resolved()
    for name in list(plain["rotors"]):
        rotor = plain["rotors"][name]
        rotor["gears"] = {"only": {key: rotor.pop(key) for key in ("teeth", "internal", "runout")}}
    for driven in ("output", "output.only"):
        plain["meshes"][0]["driven"] = driven
        case = gp.load_case(plain)
        runs = [
            run_members(c, [0], duration=0.01, transient=0.0)[0]
            for c in (gp.load_case("external-pair"), case)
        ]
        assert np.array_equal(runs[0].final_state, runs[1].final_state)
    assert case.meshes[0].label == "input-output.only"


def test_loops_must_let_the_train_turn() -> None:
    """A second way from input to output: with its own teeth it turns, with others it is held fast, which is said."""
    document = gp.load_case(REDUCER).resolved()
    document["rotors"]["countershaft"] = {
        **document["rotors"]["layshaft"],
        "gears": {"wheel": {"teeth": 96}, "pinion": {"teeth": 48}},
    }
    document["sleeves"] |= {"countershaft": document["sleeves"]["layshaft"]}
    first, second = document["meshes"]
    document["meshes"] = [
        {**first, "angle": 0.5},
        {**second, "angle": math.pi + 0.5 - 1.0},
        {**first, "driven": "countershaft.wheel", "angle": -0.5},
        {**second, "driver": "countershaft.pinion"},
    ]
    case = gp.load_case(document)
    where = centres(case)
    assert math.dist(where["input"], where["output"]) == pytest.approx(2.0 * 0.128 * math.sin(0.5), rel=1e-9)
    assert nominal_speeds(case)[2:] == pytest.approx(2.0 * math.pi * INPUT_HZ * np.array([0.2, -1.0 / 3.0]))
    document["rotors"]["countershaft"]["gears"]["pinion"]["teeth"] = 47
    with pytest.raises(InputError, match=r"meshes: must let the train turn, but a loop .* holds it fast"):
        pack(gp.load_case(document))
