"""Helical pairs with relief and profile slopes along their lines of contact: documents, brute force over the facewidth."""

from typing import Any

import numpy as np

from building import Document, Floats, case_of
from gearplay.parts.mesh.pairs.overlap import Pair
from gearplay.parts.mesh.teeth_stiffness import stiffness_over_path
from gearplay.parts.mesh.train.geometry import pair_of
from gearplay.toothing.pair import GearPair
from tooth_pairs import document_of

POINTS = 200_000


def helical(
    helix: float, width: float, *, ring: bool = False, ring_drives: bool = False, **rotors: Any
) -> Document:
    """Return a pair 20/60 of module 4 mm with pairs of teeth, helix angle [rad], facewidth [m]; fields of both gears by name."""
    document = document_of(4e-3, (20, 60), (0.0, 0.3 if ring else 0.1), ring, 1e-4, width)
    del document["meshes"][0]["center_distance"]
    if ring_drives:
        document["meshes"][0] |= {"driver": "two", "driven": "one"}
    for name in ("one", "two"):
        del document["rotors"][name]["position"]
        document["rotors"][name] |= {"helix_angle": helix, **rotors.get(name, {})}
    return document


def random_helical(rng: np.random.Generator) -> Document:
    """Return a random helical pair, external or internal, with tip relief and profile slopes of both gears, all teeth alike."""
    ring = bool(rng.integers(2))
    rotors: dict[str, Document] = {}
    for name, teeth in (("one", 20), ("two", 60)):
        relief = {
            "amount": float(rng.uniform(2e-6, 3e-5)),
            "length": float(rng.uniform(1e-3, 9e-3)),
            "shape": str(rng.choice(["linear", "parabolic"])),
        }
        rotors[name] = {"tip_relief": relief}
        if rng.random() < 0.5:
            rotors[name]["deviations"] = {"slope": [float(rng.uniform(-8e-6, 8e-6))] * teeth}
    return helical(
        float(rng.uniform(0.05, 0.45)),
        float(rng.uniform(0.01, 0.06)),
        ring=ring,
        ring_drives=bool(ring and rng.random() < 0.5),
        **rotors,
    )


class Width:
    """Relief, profile slopes and stiffness over the facewidth of a helical pair, point by point."""

    def __init__(self, document: Document) -> None:
        case = case_of(document)
        self.gears = [document["rotors"][name] for name in ("one", "two")]
        self.pair: GearPair = pair_of(case, 0)
        self.peak = stiffness_over_path(case, 0).peak
        self.kappa = 0.75 * (1.0 - 1.0 / self.pair.contact_ratio)
        self.half, path = 0.5 * self.pair.overlap, self.pair.path
        self.middle, self.half_path = 0.5 * (path.start + path.end), 0.5 * path.length
        self.density = self.peak / self.pair.overlap

    def ends(self, place: float) -> tuple[float, float]:
        """Return the ends of the line of contact of a pair at a place [m] along the path, from the middle of the facewidth."""
        path = self.pair.path
        return max(-self.half, path.start - place), min(self.half, path.end - place)

    def relief_starts(self, rho_1: float, rho_2: float) -> list[float]:
        """Return where along the line of contact [m] tip reliefs begin, of flanks at two places in mid-facewidth."""
        found = []
        for k, (gear, drawn) in enumerate(zip(self.gears, (self.pair.first, self.pair.second), strict=True)):
            if relief := gear.get("tip_relief"):
                ring = self.pair.internal and k == 1
                start = drawn.length_to_tip + relief["length"] * (1.0 if ring else -1.0)
                found.append(start - rho_1 if k == 0 else (start - rho_2) * (1.0 if ring else -1.0))
        return found

    def line(self, place: float, points: int = POINTS) -> tuple[Floats, float]:
        """Return the middles of equal parts of the line of contact of a pair at a place [m], and their length."""
        low, high = self.ends(place)
        step = max(high - low, 0.0) / points
        return low + step * (np.arange(points) + 0.5), step

    def missing(self, x: Floats, rho_1: float, rho_2: float) -> Floats:
        """Return the material missing on both flanks [m], their places in the middle of the facewidth given."""
        internal, path = self.pair.internal, self.pair.path
        line, total = self.pair.base_tangent, np.zeros_like(x)
        ends = [(path.start, path.end), (line - path.end, line - path.start)]
        if internal:
            ends[1] = (line + path.end, line + path.start)
        for k, (gear, drawn) in enumerate(zip(self.gears, (self.pair.first, self.pair.second), strict=True)):
            rho = rho_1 + x if k == 0 else rho_2 + (x if internal else -x)
            if relief := gear.get("tip_relief"):
                to_tip = (rho - drawn.length_to_tip) * (-1.0 if internal and k == 1 else 1.0)
                into = np.maximum(1.0 + to_tip / relief["length"], 0.0)
                total += relief["amount"] * into ** (1 if relief.get("shape", "linear") == "linear" else 2)
            if "deviations" in gear:
                height = (rho - ends[k][0]) / (ends[k][1] - ends[k][0])
                total += gear["deviations"]["slope"][0] * (height - 0.5)
        return total

    def stiffness(self, place: float, x: Floats) -> Floats:
        """Return the stiffness per length of the line of contact [N/m per m]."""
        return self.stiffness_at(place + x)

    def stiffness_at(self, place: Any) -> Any:
        """Return it at places on the path [m]."""
        u = (place - self.middle) / self.half_path
        return self.density * (1.0 - self.kappa * u * u)

    def force(self, pair: Pair, overlap: float, power: int = 1) -> float:
        """Return the integral of stiffness times overlap to a power; ``overlap`` [m] is that of the involutes."""
        x, step = self.line(pair.place)
        p = np.maximum(overlap - self.missing(x, pair.rho_1, pair.rho_2), 0.0)
        return float(np.sum(self.stiffness(pair.place, x) * p**power) * step)
