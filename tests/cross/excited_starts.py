"""How random trains start: centres inside their clearances, flanks and ends of play inside their gaps."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross.random_systems import _inside
from cross.reference import Reference
from cross.riding import ridden

Case = dict[str, Any]
Link = tuple[str, int, str, str]
"""Kind of element ("mesh", "coupling"), its place in its list, the rotor known, the rotor that follows."""


def _sign(rng: np.random.Generator) -> float:
    return 1.0 if rng.uniform() < 0.5 else -1.0


def displace(rng: np.random.Generator, case: Case) -> None:
    """Start the free centres inside their clearance, or a little beside the zero of their springs."""
    for name, rotor in case["rotors"].items():
        support, sleeve = case["supports"].get(name, {}), case["sleeves"].get(name)
        if sleeve is None and "stiffness" not in support:
            continue
        reach = 6e-6 if "stiffness" in support else 40e-6
        _inside(rng, min(reach, sleeve["radial_clearance"]) if sleeve else reach, rotor)


def _gap(case: Case, place: int) -> tuple[float, float]:
    """Return the penetration of a mesh's drive flank and its backlash [m] at the start."""
    reference = Reference(ridden(case))
    label = "{driver}-{driven}".format(**case["meshes"][place])
    mesh = reference.forces(0.0, reference.initial_state())["mesh"][label]
    return mesh["p_d"], mesh["b_t"]


def _turn(case: Case, link: Link, share: float) -> None:
    """Turn the rotor that follows to a share, 0 to 1, of the backlash or the play."""
    kind, place, known, follower = link
    start = case["rotors"][follower]["initial"]
    if kind == "coupling":
        coupling = case["couplings"][place]
        twist = (share - 0.5) * coupling.get("play", 4e-4)
        ratio, theta = coupling.get("ratio", 1.0), case["rotors"][known]["initial"].get("theta", 0.0)
        first = coupling["between"][0] == known
        start["theta"] = (theta - twist) / ratio if first else ratio * theta + twist
        return
    for _ in range(3):  # an eccentric toothing moves a little as it turns
        depth, backlash = _gap(case, place)
        start["theta"] += 1e-5
        slope = (_gap(case, place)[0] - depth) / 1e-5
        start["theta"] += (-share * backlash - depth) / slope - 1e-5


def _spin(rng: np.random.Generator, case: Case, link: Link, speeds: dict[str, float]) -> None:
    """Give the rotor that follows its nominal speed, what the one before deviates, and a little more."""
    kind, place, known, follower = link
    before = case["rotors"][known]["initial"].get("omega", speeds[known]) - speeds[known]
    drift = _sign(rng) * float(rng.uniform(0.2, 0.8))
    if kind == "coupling":
        coupling = case["couplings"][place]
        ratio = coupling.get("ratio", 1.0)
        drift += before / ratio if coupling["between"][0] == known else before * ratio
    case["rotors"][follower]["initial"]["omega"] = speeds[follower] + drift


def start_in_gaps(rng: np.random.Generator, case: Case, links: list[Link]) -> None:
    """Start a train in its gaps, link by link from its head, every rotor with a speed of its own."""
    rotors = case["rotors"]
    speeds = {rotor.name: rotor.nominal_speed for rotor in Reference(case).rotors}
    for name, rotor in rotors.items():
        start = rotor.setdefault("initial", {})
        if rotor.get("drive", {}).get("kind") != "speed":
            start["theta"] = 0.0
            start["omega"] = speeds[name]
    head = links[0][2]
    if rotors[head]["drive"]["kind"] != "speed":
        rotors[head]["initial"]["omega"] += 2.0
    if "arm" in rotors:
        _ride(rotors["arm"], {})
    for link in links:
        _spin(rng, case, link, speeds)
        _turn(case, link, float(rng.uniform(0.1, 0.9)))
    if "absorber" in rotors:
        _ride(rotors["absorber"], rotors["output"]["initial"])


def _ride(rotor: dict[str, Any], carrier: dict[str, float]) -> None:
    """Start a rotor a little ahead of what carries it, and a little faster."""
    rotor["initial"]["theta"] = carrier.get("theta", 0.0) + 1e-3
    rotor["initial"]["omega"] = carrier.get("omega", 0.0) + 0.3
