"""Numbers of gear pairs as drawn, computed as a user would: `gearplay.teeth` of a case."""

import math
from collections.abc import Sequence
from typing import Any

import gearplay as gp

Gear = tuple[int, float, dict[str, Any]]
"""Teeth, profile shift, further fields."""
NO_LOAD_FACTOR = "1 kN/mm"
"""Line load above which ISO 6336-1 does not reduce the stiffness."""
SINGLE_OVER_THEORETICAL = 0.8 * 0.975
"""C_M C_B of ISO 6336-1 for a rack of dedendum 1.25 and 20 deg."""


def pair(module: str, first: Gear, second: Gear, *, internal: bool = False, **mesh: Any) -> gp.Case:
    """Return the case of one pair; ``mesh`` has further fields of the mesh."""
    rotors = {}
    for name, (teeth, shift, more) in (("first", first), ("second", second)):
        rotors[name] = {"teeth": teeth, "profile_shift": shift, "mass": 1.0, "inertia": 1e-3, **more}
    if internal:
        rotors["second"]["internal"] = True
    table: dict[str, Any] = {"driver": "first", "driven": "second", "module": module}
    table["stiffness"] = {"kind": "harmonic", "mean": 1e8}
    return gp.load_case({"rotors": rotors, "meshes": [table | mesh], "run": {"duration": 1e-3}})


def geometry(case: gp.Case, mesh: str | None = None) -> dict[str, float]:
    """Return numbers of a pair in mm, deg and um, lengths of both gears with ``_1`` and ``_2``."""
    found = gp.teeth(case, mesh)
    values = found.values
    numbers = {
        "angle": math.degrees(values["working_pressure_angle"]),
        "ratio": values["contact_ratio"],
        "distance": 1e3 * values["center_distance"],
        "backlash": 1e6 * values["backlash"],
        "tight": 1e3 * values["zero_backlash_center_distance"],
    }
    if values["backlash_range"] is not None:
        numbers["least"], numbers["largest"] = (1e6 * each for each in values["backlash_range"])
    for number, gear in enumerate(found.gears.values(), 1):
        numbers[f"base_{number}"] = 1e3 * gear["base_diameter"]
        numbers[f"working_{number}"] = 1e3 * gear["working_pitch_diameter"]
    return numbers


def external_with_shift() -> Sequence[float]:
    """12/24, module 3, x 0.6/0.36."""
    tips = ({"tip_diameter": "44.840 mm"}, {"tip_diameter": "79.400 mm"})
    found = geometry(pair("3 mm", (12, 0.6, tips[0]), (24, 0.36, tips[1])))
    names = ("angle", "distance", "base_1", "base_2", "working_1", "working_2", "ratio")
    return [found[name] for name in names]


def internal_with_shift() -> Sequence[float]:
    """16/24, module 3, x 0/0.5."""
    found = geometry(pair("3 mm", (16, 0.0, {}), (24, 0.5, {}), internal=True))
    return [found["angle"], found["distance"]]


WIND = (
    ("45 mm", (19, 0.617, {"tip_diameter": "978.808 mm"}), (17, 0.802, {"tip_diameter": "905.458 mm"}), "863 mm"),
    ("21 mm", (18, 0.389, {"tip_diameter": "432.838 mm"}), (36, 0.504, {"tip_diameter": "815.668 mm"}), "584 mm"),
)  # fmt: skip
"""Spur stages of the NREL 5 MW gearbox."""


def wind_gearbox() -> Sequence[float]:
    """Contact ratio, working angle and theoretical single stiffness of both spur stages."""
    values = []
    for module, first, second, distance in WIND:
        wide: list[Gear] = [
            (teeth, shift, more | {"facewidth": "300 mm"}) for teeth, shift, more in (first, second)
        ]
        case = pair(module, *wide, center_distance=distance, stiffness=_iso())
        found = geometry(case)
        values += [found["ratio"], found["angle"], _single_stiffness(case) / SINGLE_OVER_THEORETICAL]
    return values


def _iso() -> dict[str, str]:
    return {"kind": "teeth", "method": "iso6336", "line_load": NO_LOAD_FACTOR}


def _single_stiffness(case: gp.Case) -> float:
    """Return the largest stiffness of one pair of teeth per facewidth [N/(mm um)]."""
    found = gp.teeth(case)
    width = float(min(gear["facewidth"] for gear in found.gears.values()))
    return 1e-9 * float(found.ds["pair_stiffness"].max()) / width


def iso_single_stiffness() -> Sequence[float]:
    """20/60 at 14.5, 20, 22.5 and 25 deg, and 20 in a ring of 60."""
    wide, values = {"facewidth": "10 mm"}, []
    for angle, internal in (
        ("14.5 deg", False),
        ("20 deg", False),
        ("22.5 deg", False),
        ("25 deg", False),
        ("20 deg", True),
    ):
        case = pair(
            "4 mm",
            (20, 0.0, wide),
            (60, 0.0, wide),
            internal=internal,
            pressure_angle=angle,
            stiffness=_iso(),
        )
        values.append(_single_stiffness(case))
    return values


def potential_energy() -> Sequence[float]:
    """Contact ratio, and stiffness of one pair of teeth at the middle of the path [N/(mm um)], of three pairs 20 mm wide."""
    values = []
    for module, first, second in (
        ("2 mm", (62, 0.0, {"bore": "35 mm"}), (62, 0.0, {"bore": "35 mm"})),
        ("4 mm", (20, 0.0, {"bore": "30 mm"}), (60, 0.0, {"bore": "60 mm"})),
        ("3 mm", (23, 0.3, {"bore": "25 mm"}), (34, 0.1, {"bore": "30 mm"})),
    ):
        wide: list[Gear] = [
            (teeth, shift, more | {"facewidth": "20 mm"}) for teeth, shift, more in (first, second)
        ]
        found = gp.teeth(pair(module, *wide, stiffness={"kind": "teeth", "method": "potential-energy"}))
        middle = 0.5 * (found.values["path_start"] + found.values["path_end"])
        pitches = (middle - found.values["pitch_point"]) / found.values["base_pitch"]
        at = found.ds["pair_stiffness"].sel(pair=math.floor(pitches)).interp(phase=pitches % 1.0)
        values += [found.values["contact_ratio"], float(at) / 0.02e9]
    return values


def _loaded(force: float) -> Any:
    """Return the pair 20/60 under a normal force [N], 10 mm wide, as drawn."""
    torque = force * 0.04 * math.cos(math.radians(20.0))
    wide = {"facewidth": "10 mm"}
    first = wide | {"drive": {"kind": "torque", "torque": torque}}
    second = wide | {"load": {"torque": 3.0 * torque}}
    return gp.teeth(pair("4 mm", (20, 0.0, first), (60, 0.0, second), stiffness=_iso()))


def load_sharing() -> Sequence[float]:
    """Deflection [um] and share of the leading pair under 2 kN, at five places of the entering pair; swing of the deflection."""
    found = _loaded(2000.0)
    start = (found.values["path_start"] - found.values["pitch_point"]) / found.values["base_pitch"]
    values = []
    for place in (-0.05, 0.0, 0.2, 0.69, 0.8):
        entering = math.floor(start + place)
        at = found.ds.interp(phase=start + place - entering)
        values.append(1e6 * float(at["static_transmission_error"]))
        values.append(float(at["load_sharing_ratio"].sel(pair=entering + 1)))
    for force in (500.0, 2000.0, 8000.0):
        deflection = _loaded(force).ds["static_transmission_error"]
        values.append(1e6 * float(deflection.max() - deflection.min()))
    return values


def over_the_distance() -> Sequence[float]:
    """20/60, module 4, external and internal: contact ratio, working angle, backlash at four centre distances."""
    values = []
    for internal in (False, True):
        for apart in (-0.2, 0.0, 0.1, 0.4):
            distance = f"{(80.0 if internal else 160.0) + apart} mm"
            found = geometry(
                pair("4 mm", (20, 0.0, {}), (60, 0.0, {}), internal=internal, center_distance=distance)
            )
            values += [found["ratio"], found["angle"], found["backlash"]]
    return values


def _gearboxes(allowance: bool) -> list[gp.Case]:
    """Return the pairs of two public gearboxes: sun-planet, planet-ring, and two helical stages."""
    made: dict[str, Any] = {"allowance": "c25"} if allowance else {}
    mesh: dict[str, Any] = {"center_distance_allowance": "js7"} if allowance else {}
    cases = [
        pair("4 mm", (17, 0.0, made), (22, 0.0, made), center_distance="78 mm", **mesh),
        pair("4 mm", (22, 0.0, made), (61, 0.0, {}), internal=True, center_distance="78 mm", **mesh),
    ]
    for module, teeth, shift, helix in (
        ("4.5 mm", (27, 51), 0.231415, "21 deg"),
        ("6.5 mm", (23, 34), 0.15074, "10 deg"),
    ):
        more = made | {"helix_angle": helix}
        first, second = ((each, shift, more) for each in teeth)
        cases.append(pair(module, first, second, center_distance="190 mm", **mesh))
    return cases


def printed_distances() -> Sequence[float]:
    """Centre distances without backlash of four pairs [mm]."""
    return [geometry(case)["tight"] for case in _gearboxes(allowance=False)]


def backlash_from_allowances() -> Sequence[float]:
    """Least, middle and largest normal backlash [um] of the same pairs."""
    found = [geometry(case) for case in _gearboxes(allowance=True)]
    return [each[name] for each in found for name in ("least", "backlash", "largest")]


def planetary_contact_ratios() -> Sequence[float]:
    """Contact ratios of sun and planet, planet and ring of the bundled reducer 17/37/91."""
    meshes = ("stage.sun-stage.planet1", "stage.planet1-stage.ring")
    return [geometry(gp.load_case("planetary-reducer"), mesh)["ratio"] for mesh in meshes]
