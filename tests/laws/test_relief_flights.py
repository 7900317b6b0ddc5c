"""Free motion past an end of the path, where relief and profile slopes end: no touch of a pair of teeth is missed."""

from typing import Any

import numpy as np
import pytest

from building import Document, Floats, Measured, case_of
from depth import sized
from gearplay.integrate import dispatch
from gearplay.integrate.right_hand_side import make_loads
from gearplay.integrate.switches import make_branch
from gearplay.kernels.advancement import RESOLUTION, STAYS_OPEN
from gearplay.kernels.free_motion import propagate
from gearplay.kernels.layout import PENETRATION, RATE
from gearplay.model.pack import Packed, pack
from gearplay.parts.mesh.pairs.record import FLANKS
from gearplay.parts.registry import MESH
from helical_pairs import helical
from tooth_pairs import pairs_at, placed

LOOKS = 40
THETA_2, OMEGA_1, OMEGA_2 = 5, 8, 11


def steep_pair(rng: np.random.Generator, helix: float, contact: str) -> Document:
    """Return two free gears, one with steep linear relief or a profile slope, and tooth 0 of the first ahead, or behind."""
    ring, which = bool(rng.integers(2)), str(rng.choice(["one", "two"]))
    steep: Document = {"tip_relief": {"amount": 2e-5, "length": 1e-3}}
    if rng.random() < 0.4:
        slope = float(rng.choice([-2e-5, 2e-5]))
        steep = {"deviations": {"slope": [slope] * (20 if which == "one" else 60)}}
    rotors: dict[str, Any] = {"one": {}, "two": {}, which: steep}
    ahead = float(rng.choice([-6e-5, 6e-5]))
    deviations = {**rotors["one"].get("deviations", {}), "pitch": [ahead, *[0.0] * 19]}
    rotors["one"] = {**rotors["one"], "deviations": deviations}
    document = helical(helix, 0.02, ring=ring, **rotors)
    document["meshes"][0] |= {"backlash": 1e-3, "contact": contact}
    if contact == "mesh":
        document["meshes"][0]["stiffness"] = {"kind": "harmonic", "mean": 2e8}
    return document


def contacts_at(packed: Packed, y: Floats) -> Floats:
    """Return the contact table of the mesh, all contacts open."""
    loads = make_loads(packed.system)
    assert dispatch.contact_kinematics(packed.system, 0, 0.0, y, make_branch(packed.system), loads) == 0
    return loads.contacts


def start_at_an_end(packed: Packed, rng: np.random.Generator) -> Floats | None:
    """Return a state whose pair of slot 0 is just open and 0.2 mm, or less, before an end of the path; None if another is nearer.

    Its overlap falls, by less than its deviations' steepest slope times the rolling speed.
    """
    (mesh,) = packed.system.records[MESH]
    way = float(rng.choice([-1.0, 1.0]))
    ends = [mesh.path_start, mesh.path_end, mesh.path_start - mesh.oblique, mesh.path_end + mesh.oblique]
    y = placed(packed, float(rng.choice(ends)) - way * float(rng.uniform(0.0, 2e-4)), -1e-4)
    pairs = pairs_at(packed, y)
    if pairs[0].penetration < max(pair.penetration for pair in pairs):
        return None
    k, rolling = 0 if mesh.envelope == 1 else FLANKS, way * float(rng.uniform(0.2, 2.0))
    y[OMEGA_1] = rolling / mesh.base_1
    falling = -mesh.deviation_slope * abs(rolling) * float(rng.uniform(0.0, 1.0))
    gap = 10.0 ** float(rng.uniform(-9.0, -7.0))
    for state, column, wanted in ((THETA_2, PENETRATION, -gap), (OMEGA_2, RATE, falling)):
        for _ in range(3):  # piecewise linear
            at, nudge = contacts_at(packed, y)[k, column], np.zeros(y.size)
            nudge[state] = 1e-7
            slope = (contacts_at(packed, y + nudge)[k, column] - at) / 1e-7
            if slope == 0.0:  # at the hard end of a helical pair's path
                return None
            y[state] += (wanted - at) / slope
    return y


@pytest.mark.parametrize("contact", ["pairs", "mesh"])
@pytest.mark.parametrize(
    "helix", [pytest.param(0.0, id="spur"), pytest.param(0.25, id="helical", marks=pytest.mark.slow)]
)
def test_no_touch_is_missed__at_the_ends_of_relief_and_slopes(
    helix: float, contact: str, measured: Measured
) -> None:
    """Dense looks into the time for which a mesh stays open."""
    flights, grazing, deepest, seed = 0, 0, -1.0, 0
    while flights < sized(300, 40):
        rng = np.random.default_rng([93, seed])
        seed += 1
        packed = pack(case_of(steep_pair(rng, helix, contact)))
        y = start_at_an_end(packed, rng)
        if y is None:
            continue
        system, loads = packed.system, make_loads(packed.system)
        doing, span = dispatch.stay_open(system, 0, 0.0, y, make_branch(system), 1.0, loads.out)
        if doing != STAYS_OPEN:
            continue
        flights += 1
        now, natural = np.array(y), system.contacts[0]["natural"]
        found = -1.0
        for share in np.linspace(0.0, 1.0, LOOKS):
            for i in range(2):
                propagate(system, i, 0.0, share * span, y, now)
            found = max(found, float(np.max(contacts_at(packed, now)[:, PENETRATION]) / natural))
        deepest, grazing = max(deepest, found), grazing + (found > -1e-3)
    name = f"deepest touch missed past ends of relief, {'helical' if helix else 'spur'}, {contact}, natural sizes"
    measured(name, deepest, "1e-10")
    assert deepest < 10.0 * RESOLUTION
    assert grazing > flights // 4
